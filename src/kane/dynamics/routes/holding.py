# SPDX-License-Identifier: BSD-3-Clause
"""Constraints along a tree of segments: what the force of each presses with, and what is left of its second rate.

Of a constraint with places, Σ F·v + Σ T·ω + … = 0, the forces act where they stand, and the second rate is

    Σ F·a + Σ T·α + Σ Ḟ·v + Σ Ṫ·ω + …

with the accelerations of the segments, in a number of operations that grows as the tree does. Any other is a row of A u + b = 0: the
generalized forces are those of A, the second rate is A u̇ + Ȧ u + ḃ.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import cached_property

from kane.dynamics.derived import Derived
from kane.dynamics.routes.freed import Freed
from kane.dynamics.routes.pressed import Pressed
from kane.expr.build import add, sub
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr
from kane.kinematics.pulls import Placed, placed_forces, placed_torques, stands, together
from kane.kinematics.resolved import resolved, transposed
from kane.kinematics.segments import Segments
from kane.kinematics.travel import velocities
from kane.model.constraints import Constraint
from kane.space.rotation import Triple, cross3
from kane.space.spatial import centripetal, summed
from kane.space.vector import Vector


@dataclass(frozen=True, eq=False)
class Holding:
    """The constraints of a tree that would move without them as what is `freed` does."""

    derived: Derived
    segments: Segments
    freed: Freed
    ground: Triple

    def placed(self, rows: Iterable[int]) -> Collection[int]:
        """Those that act where they stand."""
        return {r for r in rows if stands(self.derived.constraints.constraints[r], self.segments)}

    def row(self, r: int) -> tuple[Pressed, Expr]:
        """What the unit of a multiplier presses with, and the second rate with the accelerations that the tree has without it."""
        c = self.derived.constraints.constraints[r]
        return self._standing(c) if stands(c, self.segments) else self._general(r)

    def _standing(self, c: Constraint) -> tuple[Pressed, Expr]:
        kinematics, inertial, segments = self.derived.kinematics, self.derived.system.inertial, self.segments
        aligned, turning = kinematics.aligned, kinematics.turning
        pulls, twists = ([(at, aligned.vector(v)) for at, v in pairs] for pairs in (c.forces, c.torques))
        forces, torques = list(placed_forces(aligned, segments, pulls)), list(placed_torques(aligned, segments, twists))
        total = kinematics.drift(c.own)
        for p in forces:
            total = add(total, dot(p.force, self._acceleration(p)))
        for p in torques:
            total = add(total, dot(p.moment, self.freed.free.moving[p.segment][0]))
        for p in placed_forces(aligned, segments, [(at, turning(v)) for at, v in pulls]):
            total = add(total, dot(p.force, self._velocity(p)))
        for p in placed_torques(aligned, segments, [(at, turning(v)) for at, v in twists]):
            total = add(total, dot(p.moment, self.freed.on.rates[p.segment].own))
        fall = sum((v for at, v in pulls if segments.place(at)[0]), start=Vector())
        total = sub(total, dot(fall.gathered().components(inertial), self.ground))
        return self.freed.press({}, together((*forces, *torques))), total

    def _acceleration(self, p: Placed) -> Triple:
        """a of the point, with that of the ground."""
        (alpha, a), w = self.freed.free.moving[p.segment], self.freed.on.rates[p.segment]
        return summed(a, summed(cross3(alpha, p.r), centripetal(w.own, p.r, w.square)))

    def _velocity(self, p: Placed) -> Triple:
        return summed(self._velocities[p.segment], cross3(self.freed.on.rates[p.segment].own, p.r))

    @cached_property
    def _velocities(self) -> list[Triple]:
        return velocities(self.freed.on)

    def _general(self, r: int) -> tuple[Pressed, Expr]:
        rows, speeds = self.derived.constraints, self.derived.speeds
        row: dict[Expr, Expr] = {u: c for u, c in zip(speeds, rows.a.rows[r], strict=True) if c is not ZERO}
        own = transposed(row, [x for x, _ in self.freed.free.rows], self.derived.kinematics.speeds)
        rate = add(rows.drift[r], dot(list(row.values()), [self._accelerations[u] for u in row]))
        return self.freed.press(own, {}), rate

    @cached_property
    def _accelerations(self) -> dict[Expr, Expr]:
        return resolved(self.freed.free.rows, self.derived.kinematics)
