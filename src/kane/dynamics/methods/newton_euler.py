# SPDX-License-Identifier: BSD-3-Clause
"""Newton's and Euler's equations of every body, with all constraint forces unknown, in the rates of the coordinates.

    m a − F − R = 0,   I·α + ω × I·ω − T − S = 0     for each body, and R = −F, S = −T where loads act elsewhere
    Σ R·∂v/∂q̇_s + Σ S·∂ω/∂q̇_s = Σ_k A_ks λ_k        constraint forces of ideal joints do no work in admitted motions

R and S, six for each rigid body, are what Kane's method never brings in (Schiehlen 1990, *Advanced Multibody System Dynamics*).
"""

from dataclasses import dataclass

from kane.dynamics.lazy import read
from kane.dynamics.methods.base import Exprs, Formulation, on_constraints, solved_for
from kane.dynamics.methods.in_rates import InRates
from kane.expr.build import sub
from kane.expr.node import Expr
from kane.expr.symbols import Reaction, word
from kane.expr.visit import substituted
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def newton_euler(s: InRates) -> Formulation:
    """With the constraint force at every place."""
    e = _Everywhere(s)
    count = 3 * len(e.balances)
    return Formulation(
        "Newton–Euler",
        "Newton 1687; Euler 1776; Schiehlen 1990",
        (*s.coordinates, *s.rates),
        (*s.accelerations, *e.unknown),
        (f"{count} measure numbers of constraint forces and torques, by their power",),
        lambda: e.equations,
        lambda: (*s.rates, *e.accelerations, *e.forces),
        lambda: s.speeds_rates(e.accelerations),
    )


@dataclass(frozen=True, eq=False)
class _Everywhere:
    """Inertia less loads at every place: mass centres and frames of bodies, and where else loads act."""

    s: InRates

    @read
    def balances(self) -> dict[Point | Frame, Vector]:
        """m a − F, I·α + ω × I·ω − T by place, in q̈."""
        found: dict[Point | Frame, Vector] = {}
        for place, v in self.s.inertia():
            found[place] = found.get(place, Vector()) + v
        for place, v in self.s.acting():
            found[place] = found.get(place, Vector()) - v
        return {place: v.gathered() for place, v in found.items()}

    @read
    def measured(self) -> Exprs:
        """The balances along the axes of the inertial frame, of torques along those of their frame."""
        inertial = self.s.derived.system.inertial
        return tuple(
            x
            for place, v in self.balances.items()
            for x in v.components(place if isinstance(place, Frame) else inertial)
        )

    @read
    def unknown(self) -> tuple[Reaction, ...]:
        """R and S by place and axis."""
        return tuple(
            Reaction.declare(
                f"{'S' if isinstance(place, Frame) else 'R'}_{word(place.name)}_{axis}", None, "", "of the constraints"
            )
            for place in self.balances
            for axis in "xyz"
        )

    @read
    def _works(self) -> Exprs:
        """What balances do for each rate."""
        return self.s.power_by(iter(self.balances.items()))

    @read
    def equations(self) -> Exprs:
        """The balances, and that constraint forces do no work."""
        own = [sub(b, r) for b, r in zip(self.measured, self.unknown, strict=True)]
        inertial, places = self.s.derived.system.inertial, list(self.balances)
        vectors = []
        for k, place in enumerate(places):
            x, y, z = self.unknown[3 * k : 3 * k + 3]
            vectors.append((place, Vector(((place if isinstance(place, Frame) else inertial, (x, y, z)),))))
        return (*own, *on_constraints(self.s.power_by(iter(vectors)), self.s.held, self.s.accelerations))

    @read
    def accelerations(self) -> Exprs:
        """q̈."""
        return solved_for(self.s.accelerations, self._works, self.s.held).x

    @read
    def forces(self) -> Exprs:
        """R and S."""
        values: dict[Expr, Expr] = dict(zip(self.s.accelerations, self.accelerations, strict=True))
        memo: dict[Expr, Expr] = {}
        return tuple(substituted(b, values, memo) for b in self.measured)
