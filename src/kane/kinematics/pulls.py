# SPDX-License-Identifier: BSD-3-Clause
"""Rows of constraints along a tree: Σ F·v + Σ T·ω as the power that forces have from the tips to the ground, segment by segment.

What hangs on a segment presses on it with a moment and a force, and these have the power n·ω + f·ṙ of its turn and slide in the one
before, which are forms in speeds. A row of n entries takes a number of operations that grows as n, where partial velocities, each
along its own way to the point, take n².
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from kane.expr.build import add, mul
from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import ZERO, Expr
from kane.kinematics.aligned import Aligned
from kane.kinematics.freedoms import Shift, Unsuited
from kane.kinematics.motion import Kinematics
from kane.kinematics.segments import Segments, joint_tree, segments
from kane.kinematics.speeds import ScalarForm
from kane.kinematics.tree import tree_of
from kane.model.constraints import Constraint
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.rotation import NOTHING, Triple, cross3
from kane.space.vector import Vector
from kane.tree.sweeps import Carry, inward
from kane.tree.triples import summed
from kane.tree.values import NO_WRENCH, Wrench

Wrenches = dict[int, Wrench]
"""Wrenches on segments, along B."""


class Placed(NamedTuple):
    """A force on a segment at r from its origin, or a torque (`moment`), along B."""

    segment: int
    r: Triple
    moment: Triple
    force: Triple


def placed_forces(aligned: Aligned, found: Segments, forces: Iterable[tuple[Point, Vector]]) -> Iterator[Placed]:
    """Forces at points; not those on the ground."""
    for point, force in forces:
        number, arm = found.place(point)
        if number == 0 or force.is_zero:
            continue
        f = aligned.vector(force).components(found.basis[number])
        r = summed(arm.components(found.basis[number]), found.steps[number].shift)
        yield Placed(number, r, cross3(r, f), f)


def placed_torques(aligned: Aligned, found: Segments, torques: Iterable[tuple[Frame, Vector]]) -> Iterator[Placed]:
    """Torques on frames; not those on the ground."""
    for frame, torque in torques:
        number = found.of(aligned.rates(frame)[0])
        if number and not torque.is_zero:
            yield Placed(number, NOTHING, aligned.vector(torque).components(found.basis[number]), NOTHING)


def together(placed: Iterable[Placed]) -> Wrenches:
    """The sums by segment."""
    found: Wrenches = {}
    for number, _, n, f in placed:
        found[number] = found.get(number, NO_WRENCH).plus(Wrench(n, f))
    return found


def stands(c: Constraint, found: Segments) -> bool:
    """Whether forces are known to act at points and particles fixed in segments, or on the ground."""
    return c.placed and all(_is_fixed(p, found) for p, _ in c.forces)


def _is_fixed(point: Point, found: Segments) -> bool:
    """Of a particle, measure numbers along another basis change as its body turns."""
    number, arm = found.place(point)
    fixed = point.body is None or all(f is found.basis[number] for f, _ in arm.parts)
    return fixed and is_constant_in_time(arm.scalars())


def rows_along_tree(constraints: Sequence[Constraint], kinematics: Kinematics) -> dict[Constraint, ScalarForm]:
    """The rows of constraints that stand on a tree of segments, without auxiliary speeds; none where there is no such tree."""
    aligned = kinematics.aligned
    try:
        tree = tree_of(kinematics.speeds.system, aligned, [p for c in constraints for p, _ in c.forces])
        found = segments(tree, kinematics)
        placed = {
            c: together((*placed_forces(aligned, found, c.forces), *placed_torques(aligned, found, c.torques)))
            for c in constraints
            if stands(c, found)
        }
    except Unsuited:
        return {}
    return {c: _Pull(found, wrenches).row(c.own) for c, wrenches in placed.items()}


class _Pull(Carry[Wrench]):
    """The power of wrenches on segments, as a form in speeds."""

    def __init__(self, found: Segments, wrenches: Wrenches) -> None:
        tree = joint_tree(found.steps)
        super().__init__(tree.segments)
        self.steps = found.steps
        self.number = {k: i for i, k in enumerate(tree.joint)}
        self.wrenches = {tree.home[i]: tree.wrench(i, w) for i, w in wrenches.items()}
        self.coefficients: dict[Expr, Expr] = {}
        self.rest: Expr = ZERO

    def row(self, own: Expr) -> ScalarForm:
        """The power of the wrenches, and `own` besides."""
        self.rest = own
        inward(self.tree, self)
        return ScalarForm({u: c for u, c in self.coefficients.items() if c is not ZERO}, self.rest)

    def own(self, i: int) -> Wrench | None:
        return self.wrenches.get(i)

    def inner(self, i: int, v: Wrench) -> Wrench:
        if i in self.number:
            step = self.steps[self.number[i]]
            self.power(step.spin, v.n)
            if step.late:
                self.power(step.slide, v.f)
        return v

    def outer(self, i: int, v: Wrench) -> Wrench:
        step = self.steps[self.number[i]] if i in self.number else None
        if step is not None and not step.late:
            before = self.steps[step.parent].turn if step.joins else None
            self.power(step.slide, v.f if before is None else before.down(v.f))
        return v

    def power(self, shift: Shift, along: Triple) -> None:
        """What a turn or a slide adds."""
        for form, x in zip(shift.forms, along, strict=False):
            if x is ZERO:
                continue
            self.rest = add(self.rest, mul(x, form.rest))
            for u, c in form.coefficients.items():
                self.coefficients[u] = add(self.coefficients.get(u, ZERO), mul(c, x))
