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
from kane.kinematics.freedoms import Stage, Unsuited
from kane.kinematics.motion import Kinematics
from kane.kinematics.segments import Segments, segments
from kane.kinematics.speeds import ScalarForm
from kane.kinematics.travel import arms, in_base
from kane.kinematics.tree import tree_of
from kane.model.constraints import Constraint
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.rotation import NOTHING, Triple, cross3
from kane.space.spatial import summed
from kane.space.vector import Vector

Wrenches = dict[int, tuple[Triple, Triple]]
"""Moments about the origins and forces, along B, on segments."""


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
        before = found.get(number, (NOTHING, NOTHING))
        found[number] = summed(before[0], n), summed(before[1], f)
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


class _Pull:
    def __init__(self, found: Segments, wrenches: Wrenches) -> None:
        self.steps, self.wrenches = found.steps, wrenches
        self.coefficients: dict[Expr, Expr] = {}
        self.rest: Expr = ZERO

    def row(self, own: Expr) -> ScalarForm:
        """The power of the wrenches, and `own` besides."""
        steps = self.steps
        self.rest = own
        base, placed = in_base(steps), arms(steps)
        hung, beside = dict(self.wrenches), Wrenches()
        for i in reversed(range(1, len(steps))):
            if i not in hung and i not in beside:
                continue
            step, turn = steps[i], steps[i].turn
            n, f = hung.get(i, (NOTHING, NOTHING))
            if turn is not None and base[i]:
                n, f = turn.up(n), turn.up(f)
            if i in beside:
                n, f = summed(n, beside[i][0]), summed(f, beside[i][1])
            self._power(step.spin, n)
            if step.late:
                self._power(step.slide, f)
            if turn is not None and not base[i]:
                n, f = turn.up(n), turn.up(f)
            if not step.late:
                before = steps[step.parent].turn if step.joins else None
                self._power(step.slide, f if before is None else before.down(f))
            n = summed(n, cross3(placed[i][0], f))
            for lead in reversed(step.lead):
                n, f = lead.up(n), lead.up(f)
            onto = beside if step.joins else hung
            known = onto.get(step.parent, (NOTHING, NOTHING))
            onto[step.parent] = summed(known[0], n), summed(known[1], f)
        return ScalarForm({u: c for u, c in self.coefficients.items() if c is not ZERO}, self.rest)

    def _power(self, stage: Stage, along: Triple) -> None:
        for form, x in zip(stage.forms, along, strict=False):
            if x is ZERO:
                continue
            self.rest = add(self.rest, mul(x, form.rest))
            for u, c in form.coefficients.items():
                self.coefficients[u] = add(self.coefficients.get(u, ZERO), mul(c, x))
