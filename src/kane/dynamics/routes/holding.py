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
        aligned = self.derived.kinematics.aligned
        forces = list(placed_forces(aligned, self.segments, c.forces))
        torques = list(placed_torques(aligned, self.segments, c.torques))
        loads = together((*forces, *torques))
        total = self._along(c)
        for p in forces:
            total = add(total, dot(p.force, self._acceleration(p)))
        for p in torques:
            total = add(total, dot(p.moment, self.freed.free.moving[p.segment][0]))
        return self.freed.press({}, loads), total

    def _acceleration(self, p: Placed) -> Triple:
        """a of the point, with that of the ground."""
        (alpha, a), w = self.freed.free.moving[p.segment], self.freed.on.rates[p.segment]
        return summed(a, summed(cross3(alpha, p.r), centripetal(w.own, p.r, w.square)))

    def _along(self, c: Constraint) -> Expr:
        """Σ Ḟ·v + Σ Ṫ·ω + …, less what the forces would have of the ground's acceleration."""
        kinematics, inertial = self.derived.kinematics, self.derived.system.inertial
        total = kinematics.drift(c.own)
        on_tree = Vector()
        for p, f in c.forces:
            if self.segments.place(p)[0]:
                on_tree = on_tree + f
            turning = kinematics.turning(f)
            if not turning.is_zero:
                total = add(total, kinematics.point(p).total.dot(turning))
        for frame, t in c.torques:
            turning = kinematics.turning(t)
            if not turning.is_zero:
                total = add(total, kinematics.frame(frame).total.dot(turning))
        fall = on_tree.gathered().components(inertial)
        return sub(total, dot(fall, self.ground))

    def _general(self, r: int) -> tuple[Pressed, Expr]:
        rows, speeds = self.derived.constraints, self.derived.speeds
        row: dict[Expr, Expr] = {u: c for u, c in zip(speeds, rows.a.rows[r], strict=True) if c is not ZERO}
        own = transposed(row, [x for x, _ in self.freed.free.rows], self.derived.kinematics.speeds)
        rate = add(rows.drift[r], dot(list(row.values()), [self._accelerations[u] for u in row]))
        return self.freed.press(own, {}), rate

    @cached_property
    def _accelerations(self) -> dict[Expr, Expr]:
        return resolved(self.freed.free.rows, self.derived.kinematics)
