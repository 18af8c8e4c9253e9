# SPDX-License-Identifier: BSD-3-Clause
"""Lagrange's equations: of the second kind without multipliers, and with the multipliers of all constraints.

    d/dt(∂T/∂q̇_s) − ∂T/∂q_s = Q_s + Σ_k A_ks λ_k                (Whittaker 1937, ch. II and VIII)

T is differentiated as a function of q and q̇. Where constraints are left, the equations without multipliers are those of Maggi, the
same multiplied by a basis B of the motions that the constraints admit, Σ_s B_sr (… )_s = 0.
"""

from functools import cache

from kane.dynamics.methods.base import Exprs, Formulation, constrained, on_constraints, solved_for, told
from kane.dynamics.methods.in_rates import InRates
from kane.expr.build import sub
from kane.expr.differentiation import gradient, time_derivative
from kane.expr.matrix import dot
from kane.expr.symbols import Reaction


def second_kind(s: InRates) -> Formulation:
    """Without multipliers."""
    return _formulation(s, "Lagrange, second kind", (), told(s.held))


def first_kind(s: InRates) -> Formulation:
    """With a multiplier for each constraint, which is solved for, too."""
    return _formulation(s, "Lagrange, first kind", multipliers_of(s), ())


def multipliers_of(s: InRates) -> tuple[Reaction, ...]:
    """λ of each constraint."""
    names = s.held.names if s.held is not None else ()
    return tuple(Reaction.declare(f"lambda{k}", None, "", f"multiplier of {name}") for k, name in enumerate(names, 1))


def _formulation(s: InRates, name: str, multipliers: tuple[Reaction, ...], gone: tuple[str, ...]) -> Formulation:
    left = cache(lambda: tuple(sub(e, q) for e, q in zip(inertia(s), s.forces, strict=True)))
    solution = cache(lambda: solved_for(s.accelerations, left(), s.held, bool(multipliers)))

    def equations() -> Exprs:
        if s.held is None or not multipliers:
            return on_constraints(left(), s.held, s.accelerations)
        with_forces = (sub(e, dot(column, multipliers)) for e, column in zip(left(), s.held.a.T, strict=True))
        return (*with_forces, *constrained(s.held, s.accelerations))

    return Formulation(
        name,
        "Lagrange 1788; Whittaker 1937, ch. II and VIII",
        (*s.coordinates, *s.rates),
        (*s.accelerations, *multipliers),
        gone,
        equations,
        lambda: (*s.rates, *solution().x, *solution().multipliers),
        lambda: s.speeds_rates(solution().x),
    )


def inertia(s: InRates) -> Exprs:
    """d/dt(∂T/∂q̇) − ∂T/∂q."""
    n = len(s.rates)
    slopes = gradient(s.kinetic_energy, (*s.rates, *s.coordinates))
    return tuple(sub(time_derivative(p), f) for p, f in zip(slopes[:n], slopes[n:], strict=True))
