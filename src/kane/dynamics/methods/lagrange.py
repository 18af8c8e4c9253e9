# SPDX-License-Identifier: BSD-3-Clause
"""Lagrange's equations: of the second kind without multipliers, and with the multipliers of all constraints.

    d/dt(∂T/∂q̇_s) − ∂T/∂q_s = Q_s + Σ_k A_ks λ_k                (Whittaker 1937, ch. II and VIII)

T is differentiated as a function of q and q̇. Where constraints are left, the equations without multipliers are those of Maggi, the
same multiplied by a basis B of the motions that the constraints admit, Σ_s B_sr (… )_s = 0.

Hamilton's canonical equations, with forces that have no potential, and constraints.

    p = ∂T/∂q̇ = M q̇ + g,  H(q, p) = ½ (p − g)ᵀ M⁻¹ (p − g) − T₀,  q̇ = ∂H/∂p,  ṗ = −∂H/∂q + Q + Aᵀ λ

(Hamilton 1835; Whittaker 1937, ch. X). All forces are in Q, those with a potential too: H is that of the kinetic energy. λ follows
from A q̈ + c = 0, with q̈ the derivative of ∂H/∂p.

The equations of Boltzmann and Hamel: Lagrange's, for the declared generalized speeds as rates of quasi-coordinates.

    d/dt(∂T*/∂u_r) + Σ_a (∂T*/∂u_a) Σ_s W_sr (d/dt(∂u_a/∂q̇_s) − ∂u_a/∂q_s) − Σ_s W_sr ∂T*/∂q_s = F_r + Σ_k A_kr λ_k

with T*(q, u); what is in brackets gives Hamel's coefficients γ (Hamel 1904; Neimark & Fufaev 1972, ch. III, sec. 5).
"""

from dataclasses import dataclass, replace
from functools import cache

from kane.dynamics.in_rates import InRates, LinearConstraints
from kane.dynamics.lazy import read
from kane.dynamics.methods.base import (
    Formulation,
    definite,
    elimination_notes,
    in_accelerations,
    on_constraints,
    solved,
    solved_for,
)
from kane.dynamics.readings.energy import kinetic_energy_in_speeds
from kane.errors import ModelError
from kane.expr.build import add, mul, neg, sub
from kane.expr.differentiation import affine_forms, gradient, time_derivative
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO, Expr, Exprs, constant
from kane.expr.symbols import Reaction, Speed, rate
from kane.expr.visit import substituted, substituting

_SOURCE = "Lagrange 1788; Whittaker 1937, ch. II and VIII"


def second_kind(s: InRates) -> Formulation:
    """Without multipliers."""
    return in_accelerations(s, "Lagrange, second kind", _SOURCE, lambda: s.lagrange_terms(s.kinetic_energy))


def first_kind(s: InRates) -> Formulation:
    """With a multiplier for each constraint, which is solved for, too."""
    return in_accelerations(
        s, "Lagrange, first kind", _SOURCE, lambda: s.lagrange_terms(s.kinetic_energy), (), multipliers_of(s)
    )


def multipliers_of(s: InRates) -> tuple[Reaction, ...]:
    """λ of each constraint."""
    names = s.held.names if s.held is not None else ()
    return tuple(Reaction.declare(f"lambda{k}", None, "", f"multiplier of {name}") for k, name in enumerate(names, 1))


def canonical(s: InRates) -> Formulation:
    """q̇ and ṗ by q and p."""
    h = _Canonical(s)
    gone = ("q̇, by p = ∂T/∂q̇", *elimination_notes(s.held, "derivatives of the constraints"))
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
        return tuple(map(substituting(values), exprs))


def boltzmann_hamel(s: InRates) -> Formulation:
    """By the declared speeds."""
    d, p = s.derived, s.partition
    if d.system.euler_parameters:
        raise ModelError(
            "Expected independent coordinates, got Euler parameters: Hamel's coefficients are defined for independent ones. Orient "
            "the frame by three angles, or use eom.by('lagrange')."
        )
    u_dot = tuple(map(rate, d.speeds))
    held = None
    gone = ("Hamel's coefficients γ, from derivatives of Y",)
    if p is not None and p.rows:
        own = sorted(p.rows)
        rows = d.constraints
        held = LinearConstraints(
            rows.a.take(own),
            tuple(rows.drift[r] for r in own),
            tuple(p.dependent),
            tuple(rows.constraints[r].name for r in own),
            tuple(d.constraint_rates[r] for r in own),
        )

    left = cache(lambda: _left(s))
    solution = cache(lambda: solved_for(u_dot, left(), held).x)
    return Formulation(
        "Boltzmann–Hamel",
        "Hamel 1904; Neimark & Fufaev 1972, ch. III",
        (*s.coordinates, *d.speeds),
        u_dot,
        (*gone, *elimination_notes(held)),
        lambda: on_constraints(left(), held, u_dot),
        lambda: (*d.rates, *solution()),
        solution,
    )


def _left(s: InRates) -> Exprs:
    """The left sides less F_r, in u̇."""
    d = s.derived
    energy = kinetic_energy_in_speeds(d.bodies)
    n = len(d.speeds)
    slopes = gradient(energy, (*d.speeds, *s.coordinates))
    momenta, sideways = slopes[:n], slopes[n:]
    by_speeds = substituting(s.by_speeds)
    brackets = [list(map(by_speeds, s.lagrange_terms(definition))) for definition in d.system.speeds.values()]
    found = []
    for r, (p, force) in enumerate(zip(momenta, d.Fr[:n], strict=True)):
        column = [row[r] for row in d.W.rows]
        total = sub(by_speeds(time_derivative(p)), dot(column, sideways))
        for a, bracket in zip(momenta, brackets, strict=True):
            total = add(total, mul(a, dot(column, bracket)))
        found.append(sub(total, force))
    return tuple(found)
