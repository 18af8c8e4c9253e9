# SPDX-License-Identifier: BSD-3-Clause
"""The equations of Boltzmann and Hamel: Lagrange's, for the declared generalized speeds as rates of quasi-coordinates.

    d/dt(∂T*/∂u_r) + Σ_a (∂T*/∂u_a) Σ_s W_sr (d/dt(∂u_a/∂q̇_s) − ∂u_a/∂q_s) − Σ_s W_sr ∂T*/∂q_s = F_r + Σ_k A_kr λ_k

with T*(q, u); what is in brackets gives Hamel's coefficients γ (Hamel 1904; Neimark & Fufaev 1972, ch. III, sec. 5).
"""

from functools import cache

from kane.dynamics.methods.base import Exprs, Formulation, on_constraints, solved_for, told
from kane.dynamics.methods.in_rates import InRates, LinearConstraints
from kane.dynamics.readings.energy import kinetic_energy_in_speeds
from kane.errors import ModelError
from kane.expr.build import add, mul, sub
from kane.expr.differentiation import gradient, time_derivative
from kane.expr.matrix import dot
from kane.expr.node import Expr
from kane.expr.symbols import rate
from kane.expr.visit import substituted


def boltzmann_hamel(s: InRates) -> Formulation:
    """By the declared speeds."""
    d, p = s.derived, s.partition
    if d.system.euler_parameters:
        raise ModelError(
            "Expected coordinates of which none depend on each other, got Euler parameters: Hamel's coefficients are defined by "
            "independent ones. Orient the frame by three angles, or read eom.by('lagrange')."
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
        (*gone, *told(held)),
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
    memo: dict[Expr, Expr] = {}

    def by_speeds(e: Expr) -> Expr:
        return substituted(e, s.by_speeds, memo)

    brackets: list[list[Expr]] = []
    for definition in d.system.speeds.values():
        own = gradient(definition, (*s.rates, *s.coordinates))
        brackets.append(
            [
                by_speeds(sub(time_derivative(y), x))
                for y, x in zip(own[: len(s.rates)], own[len(s.rates) :], strict=True)
            ]
        )
    found = []
    for r, (p, force) in enumerate(zip(momenta, d.Fr[:n], strict=True)):
        column = [row[r] for row in d.W.rows]
        total = sub(by_speeds(time_derivative(p)), dot(column, sideways))
        for a, bracket in zip(momenta, brackets, strict=True):
            total = add(total, mul(a, dot(column, bracket)))
        found.append(sub(total, force))
    return tuple(found)
