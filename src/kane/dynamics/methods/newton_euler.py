# SPDX-License-Identifier: BSD-3-Clause
"""Newton's and Euler's equations of every body, with all constraint forces unknown, in the rates of the coordinates.

    m a − F − R = 0,   I·α + ω × I·ω − T − S = 0     for each body, and R = −F, S = −T where loads act elsewhere
    Σ R·∂v/∂q̇_s + Σ S·∂ω/∂q̇_s = Σ_k A_ks λ_k        constraint forces of ideal joints do no work in admitted motions

R and S, six for each rigid body, are what Kane's method never brings in (Schiehlen 1990, *Advanced Multibody System Dynamics*).

Virtual work and virtual power in generalized coordinates.

Σ (F − m a)·∂r/∂q_s = 0           work: rigid bodies as sets of particles with the same mass, mass centre and inertia,
                                  for an orientation has no r (Yoo 2004, eq. 5)
Σ (F − m a)·∂v/∂q̇_s + Σ (T − I·α − ω × I·ω)·∂ω/∂q̇_s = 0     power (Yoo 2004, eq. 6; Jourdain 1909)
"""

from collections.abc import Iterator
from dataclasses import dataclass

from kane.dynamics.in_rates import InRates
from kane.dynamics.lazy import read
from kane.dynamics.methods.base import Formulation, in_accelerations, on_constraints, solved_for
from kane.errors import ModelError
from kane.expr.build import add, mul, neg, sub
from kane.expr.differentiation import jacobian, time_derivative
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr, Exprs, as_expr, constant
from kane.expr.symbols import Reaction, word
from kane.expr.visit import substituting
from kane.model.bodies import Part
from kane.space.frame import Frame, Point
from kane.space.rotation import Triple
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
        return tuple(map(substituting(values), self.measured))


def virtual_power(s: InRates) -> Formulation:
    """By partial velocities and partial angular velocities for q̇."""
    return in_accelerations(s, "virtual power", "Jourdain 1909; Yoo 2004, eq. 6", lambda: s.power_by(s.inertia()))


def virtual_work(s: InRates) -> Formulation:
    """By positions of particles."""
    count = sum(1 for part in s.parts for _ in _particles(part))
    gone = (f"rigid bodies, by {count} particles that move as they do",)
    return in_accelerations(s, "virtual work", "d'Alembert 1743; Yoo 2004, eq. 5", lambda: _works(s), gone)


def _particles(part: Part) -> Iterator[tuple[Expr, Vector]]:
    """Masses and places from the mass centre of particles a metre off, with the same mass, mass centre and central inertia.

    With E = ½ tr(I) 1 − I: E_ii/2 at ± e_i, E_ij/4 at ±(e_i + e_j), −E_ij/4 at ±(e_i − e_j), the rest of the mass at the centre.
    """
    left = part.mass
    if part.frame is not None and part.inertia is not None:
        axes = (part.frame.x, part.frame.y, part.frame.z)
        rows = [[a.dot(part.inertia.dot(b)) for b in axes] for a in axes]
        half = mul(constant(0.5), add(add(rows[0][0], rows[1][1]), rows[2][2]))
        for i in range(3):
            e = sub(half, rows[i][i])
            left = sub(left, e)
            for sign in (1, -1):
                yield e / 2, axes[i] * as_expr(sign)
            for j in range(i):
                if rows[i][j] is not ZERO:
                    e = neg(rows[i][j])
                    for sign in (1, -1):
                        yield e / 4, (axes[i] + axes[j]) * as_expr(sign)
                        yield neg(e / 4), (axes[i] - axes[j]) * as_expr(sign)
    yield left, Vector()


def _works(s: InRates) -> Exprs:
    """Σ m a·∂r/∂q."""
    total = [ZERO] * len(s.coordinates)
    for part in s.parts:
        for r, carried in _carried(s, part):
            columns = jacobian(list(r), s.coordinates).T
            for mass, x in carried:
                a = [s.own(time_derivative(s.own(time_derivative(c)))) for c in x]
                for k, column in enumerate(columns):
                    total[k] = add(total[k], mul(mass, dot(column, a)))
    return tuple(total)


def _carried(s: InRates, part: Part) -> Iterator[tuple[Triple, list[tuple[Expr, Triple]]]]:
    """Places of particles, each with the masses and places that its m a is a sum of."""
    if part.momenta:
        yield _position(s, part.mass_center), [(mass, _position(s, p)) for p, mass in part.momenta]
        return
    for mass, arm in _particles(part):
        r = _position(s, part.mass_center, arm)
        yield r, [(mass, r)]


def _position(s: InRates, point: Point, arm: Vector = Vector()) -> Triple:  # noqa: B008, vectors are frozen
    inertial, root = s.derived.system.inertial, point.root()
    if root.frame is not inertial:
        raise ModelError(
            f"Expected positions from a point of {inertial.name}, got {point.name} placed from {root.name} of {root.frame}."
        )
    return (point.position(root) + arm).components(inertial)
