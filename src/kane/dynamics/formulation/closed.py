# SPDX-License-Identifier: BSD-3-Clause
"""u̇ under constraints by recursion: one more way to the base for each of them, and a block as large as they are many.

With u̇° of the tree without constraints, A u̇ + Ȧ u + ḃ = 0 and M (u̇ − u̇°) = Aᵀ λ,

    A M⁻¹ Aᵀ λ = −(A u̇° + Ȧ u + ḃ),      (A M⁻¹ Aᵀ)_rs = Σ_k e_rk e_sk / D_k,

with the shares e that a row of A, pressing on the freedoms, has of their pivots D on the way to the base. Neither M nor A_n is needed,
and what is divided by vanishes where rows of A depend on each other alone.

Of a constraint with places, Σ F·v + Σ T·ω + … = 0, the forces act where they stand, and the second rate is

    Σ F·a + Σ T·α + Σ Ḟ·v + Σ Ṫ·ω + …

with the accelerations of the segments, in a number of operations that grows as the tree does. Any other is a row of A u + b = 0: the
generalized forces are those of A, the second rate is A u̇ + Ȧ u + ḃ.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from kane.dynamics.constraints.embed import Embedding, embedding
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived
from kane.dynamics.formulation.carried import falling
from kane.dynamics.formulation.equations import evident, holds_reactions
from kane.dynamics.formulation.recursive import (
    NO_MASS,
    WAYS,
    Carrying,
    carrying,
    is_regular,
    with_reactions,
    worth_trying,
)
from kane.dynamics.solved import Solved
from kane.errors import SingularError
from kane.expr.build import add, div, mul, neg, sub
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr
from kane.expr.ops import NEG
from kane.expr.regular import guards
from kane.expr.solve import finish, forward, ldl
from kane.kinematics.freedoms import Unsuited, resolved, transposed
from kane.kinematics.segments import JointTree, Segments
from kane.kinematics.velocity_constraints import Placed, placed_forces, placed_torques, stands, together
from kane.model.bodies import deforming
from kane.model.constraints import Constraint, constraint_of
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.rotation import NOTHING, Triple, cross3
from kane.space.vector import Vector
from kane.tree.articulated import Articulated, Passed, Pressed
from kane.tree.composite import Composite
from kane.tree.sweeps import velocities
from kane.tree.triples import centripetal, summed
from kane.tree.values import SpatialForce


def closings(derived: Derived, partition: Partition) -> Iterator[Solved]:
    """The solutions by the recursions that may be the shortest, as far as the system is a tree that constraints close.

    Of links that turn about parallel axes articulated inertias are shorter than composite ones.
    """
    try:
        carried = carrying(derived, flexible=True, shared=bool(deforming(derived.system.bodies)))
        steps = carried.segments.steps
        planar = any(step.joins for step in steps) and not any(step.modes for step in steps)
        for route in ("recursive",) if planar else worth_trying(derived, carried):
            yield _closed(derived, partition, carried, route)
    except Unsuited:
        return


def closed(derived: Derived, partition: Partition, route: str = "recursive", *, shared: bool = False) -> Solved:
    """u̇ of a tree that constraints close, with the reactions where joints of it transmit these; Unsuited where it is none.

    Joints may share coordinates where these may be `shared`.
    """
    return _closed(derived, partition, carrying(derived, flexible=True, shared=shared), route)


def _closed(derived: Derived, partition: Partition, carried: Carrying, route: str) -> Solved:
    if not (route == "recursive" and carried.crossings is not None):
        if holds_reactions(derived):
            raise Unsuited("loads that hold reactions which no joint transmits")
        carried = carried._replace(crossings=None)
    try:
        whole = _held(derived, partition, carried, route)
    except SingularError:
        raise Unsuited(NO_MASS) from None
    return _solved(derived, partition, carried, whole, route)


class _Held(NamedTuple):
    passed: Passed
    transmitted: Mapping[int, SpatialForce]
    multipliers: Mapping[int, Expr]
    pivots: Sequence[Expr]
    sizes: Sequence[Expr]
    placed: Collection[int]
    """Rows whose forces are among what is transmitted."""


def _held(derived: Derived, partition: Partition, carried: Carrying, route: str) -> _Held:
    """What passes with the multipliers λ of the rows."""
    tree, ground = carried.tree(balanced=route == "recursive", asked=carried.asked), falling(derived)
    freed = WAYS[route](tree.segments, ground, [tree.joint[i] for i in carried.asked])
    if len(freed.free.rows) < len(derived.speeds):
        raise Unsuited(NO_MASS)
    holding = Holding(derived, carried.segments, tree, freed, ground)
    forces, right = zip(*map(holding.row, partition.rows), strict=True)
    matrix = _products(freed.divisors, forces)
    factors = ldl(matrix)
    solution = finish(factors, forward(factors.lower, list(map(neg, right))))
    sizes = [row[k] for k, row in enumerate(matrix)]
    passed = freed.passed(forces, solution)
    return _Held(
        passed,
        {i: passed.transmitted[tree.joint[i]] for i in carried.asked} if passed.transmitted else {},
        dict(zip(partition.rows, solution, strict=True)),
        factors.pivots,
        sizes,
        holding.placed(partition.rows),
    )


def _products(d: Sequence[Expr], forces: Sequence[Pressed]) -> list[list[Expr]]:
    """A M⁻¹ Aᵀ."""
    e = [each.shares for each in forces]
    over = [[x if x is ZERO else div(x, p) for x, p in zip(row, d, strict=True)] for row in e]
    return [[_product(x, y) for y in over] for x in e]


def _product(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    total = ZERO
    for x, y in zip(a, b, strict=True):
        if x is not ZERO and y is not ZERO:
            total = add(total, mul(x, y))
    return total


def _solved(derived: Derived, partition: Partition, carried: Carrying, whole: _Held, route: str) -> Solved:
    if not is_regular(whole.passed.pivots, derived.system.euler_parameters):
        raise Unsuited(NO_MASS)
    values, matrix = resolved(whole.passed.rows, derived.kinematics), evident(derived)
    u_dot = tuple(values[u] for u in derived.speeds)
    own = guards(zip(whole.pivots, whole.sizes, strict=True), (), u_dot)
    e = embedding(derived.constraints, partition).watching(own)
    pivots = tuple(whole.passed.pivots)
    found = Solved(route, derived, e, u_dot, (), pivots, matrix, matrix, of_rows=whole.multipliers)
    if not derived.reactions or carried.crossings is None:
        return found
    return with_reactions(found, _felt(derived, e, carried, whole))


def _felt(derived: Derived, e: Embedding, carried: Carrying, whole: _Held) -> list[Expr]:
    """What G_a R are: what is transmitted, less what the constraints exert on the far side."""
    found = []
    for a, crossing in enumerate(carried.crossings or ()):
        total = ZERO if crossing is None else crossing.measured(whole.transmitted)
        for r, multiplier in whole.multipliers.items():
            if r not in whole.placed or constraint_of(derived.auxiliary_speeds[a]) is not None:
                total = add(total, neg(mul(e.rows.a_auxiliary[r, a], multiplier)))
        found.append(total)
    return found


@dataclass(frozen=True, eq=False)
class Holding:
    """The constraints of a tree that would move without them as what is `freed` does."""

    derived: Derived
    segments: Segments
    tree: JointTree
    freed: Articulated | Composite
    ground: Triple

    def placed(self, rows: Iterable[int]) -> Collection[int]:
        """Those that act where they stand."""
        return {r for r in rows if stands(self.derived.constraints.constraints[r], self.segments)}

    def row(self, r: int) -> tuple[Pressed, Expr]:
        """What the unit of a multiplier presses with, and the second rate with the accelerations that the tree has without it."""
        c = self.derived.constraints.constraints[r]
        return self._standing(c) if stands(c, self.segments) else self._general(r)

    def _standing(self, c: Constraint) -> tuple[Pressed, Expr]:
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
        return self._pressed({}, together(acting)), total

    def _placed(self, forces: Iterable[tuple[Point, Vector]], torques: Iterable[tuple[Frame, Vector]]) -> list[Placed]:
        aligned, found = self.derived.kinematics.aligned, self.segments
        return [*placed_forces(aligned, found, forces), *placed_torques(aligned, found, torques)]

    def _power(self, acting: Iterable[Placed]) -> Expr:
        total = ZERO
        for p in acting:
            w = self._omega(p.segment)
            if p.force is NOTHING:
                total = add(total, dot(p.moment, w))
            else:
                total = add(total, dot(p.force, summed(self._velocity(p.segment), cross3(w, p.r))))
        return total

    def _acceleration(self, p: Placed) -> Triple:
        """a of the point, with that of the ground."""
        home = self.tree.home[p.segment]
        alpha, a = (self.tree.along_b(p.segment, v) for v in self.freed.motion[home])
        swung = centripetal(self._omega(p.segment), p.r, self.freed.moving[home].square)
        return summed(a, summed(cross3(alpha, p.r), swung))

    def _omega(self, step: int) -> Triple:
        """ω along B."""
        return self.tree.along_b(step, self.freed.moving[self.tree.home[step]].w)

    def _velocity(self, step: int) -> Triple:
        """v of the origin along B."""
        return self.tree.along_b(step, self._velocities[self.tree.home[step]])

    @cached_property
    def _velocities(self) -> list[Triple]:
        return velocities(self.tree.segments, self.freed.moving)

    def _pressed(self, forces: Mapping[int, Expr], loads: Mapping[int, SpatialForce]) -> Pressed:
        """What these wrenches, along B, press with."""
        return self.freed.press(forces, {self.tree.home[i]: self.tree.wrench(i, w) for i, w in loads.items()})

    def _general(self, r: int) -> tuple[Pressed, Expr]:
        rows, speeds = self.derived.constraints, self.derived.speeds
        row: dict[Expr, Expr] = {u: c for u, c in zip(speeds, rows.a.rows[r], strict=True) if c is not ZERO}
        own = transposed(row, [x for x, _ in self.freed.free.rows], self.derived.kinematics.speeds)
        rate = add(rows.drift[r], dot(list(row.values()), [self._accelerations[u] for u in row]))
        return self._pressed(own, {}), rate

    @cached_property
    def _accelerations(self) -> dict[Expr, Expr]:
        return resolved(self.freed.free.rows, self.derived.kinematics)


def _known(f: Expr, rate: Expr) -> dict[Expr, Expr]:
    """The rate of a constraint's f, which may stand in what its power leaves of that rate; a sign is no part of what is shared."""
    return {f.args[0]: neg(rate)} if f.op is NEG else {f: rate}
