# SPDX-License-Identifier: BSD-3-Clause
"""Trees closed by constraints (Featherstone 2008, ch. 8): u̇ by recursion on the tree, and m × m equations for m multipliers λ.

With u̇° of the tree without constraints, A u̇ + Ȧ u + ḃ = 0 and M (u̇ − u̇°) = Aᵀ λ,

    A M⁻¹ Aᵀ λ = −(A u̇° + Ȧ u + ḃ),      (A M⁻¹ Aᵀ)_rs = Σ_k e_rk e_sk / D_k,

where e_r are the right-hand sides after an inward sweep with row r of A as force, and D the pivots of the joint speeds. Neither M nor
A_n is formed, and the determinant of the equations vanishes only if rows of A are linearly dependent.

For a constraint with known points of application, Σ F·v + Σ T·ω + … = 0, the forces act at these, and its second derivative is

    Σ F·a + Σ T·α + Σ Ḟ·v + Σ Ṫ·ω + …

with the accelerations of the segments, in O(n) operations. Any other constraint is a row of A u + b = 0, with generalized forces Aᵀ
and the second derivative A u̇ + Ȧ u + ḃ.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from kane.dynamics.derivation import Derived
from kane.expr.build import add, div, neg, sub
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr
from kane.expr.ops import NEG
from kane.kinematics.freedoms import resolved, transposed
from kane.kinematics.segments import JointTree, Segments
from kane.kinematics.velocity_constraints import Placed, placed, stands, together
from kane.model.constraints import Constraint
from kane.space.frame import Frame, Point
from kane.space.rotation import NOTHING, Triple, cross3
from kane.space.vector import Vector
from kane.tree.articulated import Articulated, PropagatedForce
from kane.tree.composite import Composite
from kane.tree.sweeps import velocities
from kane.tree.triples import centripetal, summed
from kane.tree.values import SpatialForce


@dataclass(frozen=True, eq=False)
class TreeConstraints:
    """The constraints of a tree; `freed` is the tree without them, by the ABA or the CRBA."""

    derived: Derived
    segments: Segments
    tree: JointTree
    freed: Articulated | Composite
    ground: Triple

    def placed(self, rows: Iterable[int]) -> Collection[int]:
        """The rows whose forces act at points fixed in segments."""
        return {r for r in rows if stands(self.derived.constraints.constraints[r], self.segments)}

    def row(self, r: int) -> tuple[PropagatedForce, Expr]:
        """The effect of a unit multiplier on the elimination, and the second derivative of the constraint at u̇° of the free tree."""
        c = self.derived.constraints.constraints[r]
        return self._standing(c) if stands(c, self.segments) else self._general(r)

    def _standing(self, c: Constraint) -> tuple[PropagatedForce, Expr]:
        kinematics, inertial = self.derived.kinematics, self.derived.system.inertial
        aligned, turning = kinematics.aligned.vector, kinematics.turning
        pulls, twists = [(at, aligned(v)) for at, v in c.forces], [(at, aligned(v)) for at, v in c.torques]
        acting = self._placed(pulls, twists)
        total = ZERO if c.own is ZERO else kinematics.drift(c.own, _known(c.expr, add(self._power(acting), c.own)))
        for p in acting:
            if p.force is NOTHING:
                alpha = self.freed.motion[self.tree.home[p.segment]].alpha
                total = add(total, dot(p.moment, self.tree.along_b(p.segment, alpha)))
            else:
                total = add(total, dot(p.force, self._acceleration(p)))
        changes = self._placed([(at, turning(v)) for at, v in pulls], [(at, turning(v)) for at, v in twists])
        fall = sum((v for at, v in pulls if self.segments.place(at)[0]), start=Vector())
        total = sub(add(total, self._power(changes)), dot(fall.gathered().components(inertial), self.ground))
        return self._propagated({}, together(acting)), total

    def _placed(self, forces: Iterable[tuple[Point, Vector]], torques: Iterable[tuple[Frame, Vector]]) -> list[Placed]:
        return list(placed(self.derived.kinematics.aligned, self.segments, forces, torques))

    def _power(self, acting: Iterable[Placed]) -> Expr:
        total = ZERO
        for p in acting:
            w = self._omega(p.segment)
            if p.force is NOTHING:
                total = add(total, dot(p.moment, w))
            else:
                total = add(total, dot(p.force, summed(self._velocities[p.segment], cross3(w, p.r))))
        return total

    def _acceleration(self, p: Placed) -> Triple:
        """The acceleration of the point, with that of the ground included."""
        home = self.tree.home[p.segment]
        alpha, a = (self.tree.along_b(p.segment, v) for v in self.freed.motion[home])
        swung = centripetal(self._omega(p.segment), p.r, self.freed.moving[home].square)
        return summed(a, summed(cross3(alpha, p.r), swung))

    def _omega(self, step: int) -> Triple:
        """ω of a step, along B."""
        return self.tree.along_b(step, self.freed.moving[self.tree.home[step]].w)

    @cached_property
    def _velocities(self) -> list[Triple]:
        """The velocities of the origins, along B, by step."""
        found = velocities(self.tree.segments, self.freed.moving)
        return [self.tree.along_b(step, found[home]) for step, home in enumerate(self.tree.home)]

    def _propagated(self, forces: Mapping[int, Expr], loads: Mapping[int, SpatialForce]) -> PropagatedForce:
        """The effect of generalized forces and of wrenches, along B, on the elimination."""
        return self.freed.propagate(forces, {self.tree.home[i]: self.tree.wrench(i, w) for i, w in loads.items()})

    def _general(self, r: int) -> tuple[PropagatedForce, Expr]:
        rows, speeds = self.derived.constraints, self.derived.speeds
        row: dict[Expr, Expr] = {u: c for u, c in zip(speeds, rows.a.rows[r], strict=True) if c is not ZERO}
        own = transposed(row, [x for x, _ in self.freed.free.rows], self.derived.kinematics.speeds)
        rate = add(rows.drift[r], dot(list(row.values()), [self._accelerations[u] for u in row]))
        return self._propagated(own, {}), rate

    @cached_property
    def _accelerations(self) -> dict[Expr, Expr]:
        return resolved(self.freed.free.rows, self.derived.kinematics)


def _known(f: Expr, rate: Expr) -> dict[Expr, Expr]:
    """f, or −f if f is a negation, with its derivative, to be reused where f occurs in the constraint's own rate."""
    return {f.args[0]: neg(rate)} if f.op is NEG else {f: rate}


def products(d: Sequence[Expr], forces: Sequence[PropagatedForce]) -> list[list[Expr]]:
    """A M⁻¹ Aᵀ (m × m), from the pivots D and the effects of unit multipliers."""
    over = [[x if x is ZERO else div(x, p) for x, p in zip(each.shares, d, strict=True)] for each in forces]
    return [[dot(each.shares, y) for y in over] for each in forces]
