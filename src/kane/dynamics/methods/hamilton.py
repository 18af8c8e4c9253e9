# SPDX-License-Identifier: BSD-3-Clause
"""Hamilton's canonical equations, with forces that have no potential, and constraints.

    p = ∂T/∂q̇ = M q̇ + g,  H(q, p) = ½ (p − g)ᵀ M⁻¹ (p − g) − T₀,  q̇ = ∂H/∂p,  ṗ = −∂H/∂q + Q + Aᵀ λ

(Hamilton 1835; Whittaker 1937, ch. X). All forces are in Q, those with a potential too: H is that of the kinetic energy. λ follows
from A q̈ + c = 0, with q̈ the derivative of ∂H/∂p.
"""

from dataclasses import dataclass, replace

from kane.dynamics.lazy import read
from kane.dynamics.methods.base import Exprs, Formulation, definite, solved, told
from kane.dynamics.methods.in_rates import InRates
from kane.dynamics.methods.lagrange import multipliers_of
from kane.expr.build import add, mul, neg, sub
from kane.expr.differentiation import affine_forms, gradient, time_derivative
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO, Expr, constant
from kane.expr.symbols import Speed, rate
from kane.expr.visit import substituted


def canonical(s: InRates) -> Formulation:
    """q̇ and ṗ by q and p."""
    h = _Canonical(s)
    gone = ("q̇, by p = ∂T/∂q̇", *told(s.held, "derivatives of the constraints"))
    multipliers = multipliers_of(s)

    def equations() -> Exprs:
        left = [sub(rate(p), x) for p, x in zip(h.p, h.active, strict=True)]
        rates = tuple(sub(q, v) for q, v in zip(s.rates, h.velocities, strict=True))
        if s.held is None:
            return (*rates, *left)
        left = [sub(e, dot(column, multipliers)) for e, column in zip(left, s.held.a.T, strict=True)]
        return (*rates, *left, *s.held.rates)

    return Formulation(
        "Hamilton",
        "Hamilton 1835; Whittaker 1937, ch. X",
        (*s.coordinates, *h.p),
        (*s.rates, *map(rate, h.p), *multipliers),
        gone,
        equations,
        lambda: (*h.velocities, *h.forces),
        lambda: s.speeds_rates(h.in_rates(h.accelerations)),
    )


@dataclass(frozen=True, eq=False)
class _Canonical:
    """What is written in q and p."""

    s: InRates

    p = read[tuple[Speed, ...]](
        lambda h: tuple(
            Speed.declare(f"p_{q.name}", None, "", f"generalized momentum of {q.name}") for q in h.s.coordinates
        ),
        "p.",
    )
    momenta = read[Exprs](lambda h: gradient(h.s.kinetic_energy, h.s.rates), "∂T/∂q̇ in q and q̇.")

    @read
    def mass(self) -> tuple[Matrix, Exprs]:
        """M and g of p = M q̇ + g."""
        forms = affine_forms(self.momenta, self.s.rates)
        rows = [[form.get(r, ZERO) for r in self.s.rates] for form, _ in forms]
        return Matrix(rows), tuple(rest for _, rest in forms)

    @read
    def velocities(self) -> Exprs:
        """q̇ = M⁻¹ (p − g)."""
        m, g = self.mass
        return tuple(definite(m.rows, [sub(p, x) for p, x in zip(self.p, g, strict=True)]))

    @read
    def hamiltonian(self) -> Expr:
        """½ (p − g)·q̇ − T₀."""
        _, g = self.mass
        still = substituted(self.s.kinetic_energy, dict.fromkeys(self.s.rates, ZERO))
        return sub(mul(constant(0.5), dot([sub(p, x) for p, x in zip(self.p, g, strict=True)], self.velocities)), still)

    @read
    def by_momenta(self) -> dict[Expr, Expr]:
        """q̇ by q and p."""
        return dict(zip(self.s.rates, self.velocities, strict=True))

    @read
    def active(self) -> Exprs:
        """−∂H/∂q + Q."""
        slopes = gradient(self.hamiltonian, self.s.coordinates)
        own = [substituted(q, self.by_momenta) for q in self.s.forces]
        return tuple(add(neg(h), q) for h, q in zip(slopes, own, strict=True))

    @read
    def _solution(self) -> tuple[Exprs, Exprs]:
        """q̈ and λ of M q̈ = −∂H/∂q + Q + Aᵀλ + M (what is left of d/dt M⁻¹(p − g) at ṗ = 0)."""
        m, _ = self.mass
        still: dict[Expr, Expr] = dict.fromkeys(map(rate, self.p), ZERO)
        changes = [substituted(substituted(time_derivative(v), still), self.by_momenta) for v in self.velocities]
        right = [add(f, x) for f, x in zip(self.active, m @ changes, strict=True)]
        held = self.s.held
        if held is not None:
            held = replace(
                held,
                a=held.a.map(lambda e: substituted(e, self.by_momenta)),
                drift=tuple(substituted(e, self.by_momenta) for e in held.drift),
            )
        x, multipliers = solved(m, right, held, with_multipliers=True)
        return x, multipliers

    accelerations = read[Exprs](lambda h: h._solution[0], "q̈.")

    @read
    def forces(self) -> Exprs:
        """ṗ."""
        held = self.s.held
        if held is None:
            return self.active
        return tuple(add(f, dot(column, self._solution[1])) for f, column in zip(self.active, held.a.T, strict=True))

    def in_rates(self, exprs: Exprs) -> Exprs:
        """Expressions in q and q̇."""
        values: dict[Expr, Expr] = dict(zip(self.p, self.momenta, strict=True))
        memo: dict[Expr, Expr] = {}
        return tuple(substituted(e, values, memo) for e in exprs)
