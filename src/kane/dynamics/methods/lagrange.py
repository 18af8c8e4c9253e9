# SPDX-License-Identifier: BSD-3-Clause
"""Lagrange's equations: of the second kind without multipliers, and with the multipliers of all constraints.

    d/dt(∂T/∂q̇_s) − ∂T/∂q_s = Q_s + Σ_k A_ks λ_k                (Whittaker 1937, ch. II and VIII)

T is differentiated as a function of q and q̇. Where constraints are left, the equations without multipliers are those of Maggi, the
same multiplied by a basis B of the motions that the constraints admit, Σ_s B_sr (… )_s = 0.
"""

from kane.dynamics.methods.formulation import Exprs, Formulation
from kane.dynamics.methods.in_rates import InRates
from kane.dynamics.methods.solving import constrained, on_constraints, solved, told
from kane.expr.affine import affine_forms
from kane.expr.build import sub
from kane.expr.diff import gradient, time_derivative
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO
from kane.expr.symbols import Reaction


def second_kind(s: InRates) -> Formulation:
    """Without multipliers."""
    return _formulation(s, "Lagrange, second kind", (), told(s.held))


def first_kind(s: InRates) -> Formulation:
    """With a multiplier for each constraint, which is solved for, too."""
    names = () if s.held is None else tuple(multiplier(k, name) for k, name in enumerate(s.held.names))
    return _formulation(s, "Lagrange, first kind", names, ())


def multiplier(k: int, name: str) -> Reaction:
    """λ of a constraint."""
    return Reaction.declare(f"lambda{k + 1}", None, "", f"multiplier of {name}")


def _formulation(s: InRates, name: str, multipliers: tuple[Reaction, ...], gone: tuple[str, ...]) -> Formulation:
    def equations() -> Exprs:
        left = [sub(e, q) for e, q in zip(inertia(s), s.forces, strict=True)]
        if s.held is None or not multipliers:
            return on_constraints(left, s.held, s.accelerations)
        left = [sub(e, dot(column, multipliers)) for e, column in zip(left, s.held.a.T, strict=True)]
        return (*left, *constrained(s.held, s.accelerations))

    def solution() -> tuple[Exprs, Exprs]:
        forms = affine_forms(inertia(s), s.accelerations)
        mass = Matrix([[form.get(x, ZERO) for x in s.accelerations] for form, _ in forms])
        right = [sub(q, rest) for q, (_, rest) in zip(s.forces, forms, strict=True)]
        return solved(mass, right, s.held, bool(multipliers))

    return Formulation(
        name,
        "Lagrange 1788; Whittaker 1937, ch. II and VIII",
        (*s.coordinates, *s.rates),
        (*s.accelerations, *multipliers),
        gone,
        equations,
        lambda: (*s.rates, *solution()[0], *solution()[1]),
        lambda: s.speeds_rates(solution()[0]),
    )


def inertia(s: InRates) -> Exprs:
    """d/dt(∂T/∂q̇) − ∂T/∂q."""
    n = len(s.rates)
    slopes = gradient(s.kinetic_energy, (*s.rates, *s.coordinates))
    return tuple(sub(time_derivative(p), f) for p, f in zip(slopes[:n], slopes[n:], strict=True))
