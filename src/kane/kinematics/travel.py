# SPDX-License-Identifier: BSD-3-Clause
"""What recursions along segments need of their motion: angular velocities, arms, and accelerations at no ẇ, from the parent on.

α = α_p + Σ s ẇ + ω × ω_rel + …        a = a_p + α_p × r + ω_p × (ω_p × r) + 2 ω_p × ṙ + Σ s ẇ + …
"""

from collections.abc import Sequence
from typing import NamedTuple

from kane.expr.matrix import dot
from kane.expr.node import TWO, ZERO, Expr
from kane.kinematics.freedoms import Freedom, Stage
from kane.kinematics.segments import Segment
from kane.space.rotation import NOTHING, Triple, cross3
from kane.space.spatial import along, centripetal, summed, times


class Rates(NamedTuple):
    """Angular velocities: of the parent along A, `before`; of the segment along B, `own`, and along the basis it works in, `work`."""

    before: Triple
    own: Triple
    work: Triple
    ground: Triple
    """That of the common base of turns about parallel axes, along A."""
    square: Expr = ZERO
    """ω · ω of the segment."""


class Biases(NamedTuple):
    """What the accelerations have beside ẇ: of the origin along A, and along B where the slide is; of ω along the basis of work.

    `coriolis` is what of the first a slide along A adds.
    """

    arm: Triple
    shift: Triple
    sliding: Triple
    spin: Triple
    coriolis: Triple = NOTHING


class Travel(NamedTuple):
    """The segments with their motion; `base` says which work in the basis that they turn in."""

    steps: Sequence[Segment]
    base: Sequence[bool]
    rates: Sequence[Rates]
    placed: Sequence[tuple[Triple, Stage]]
    known: Sequence[Biases]


def travel(steps: Sequence[Segment]) -> Travel:
    """The motion along segments."""
    base = in_base(steps)
    rates, placed = angular_velocities(steps, base), arms(steps)
    return Travel(steps, base, rates, placed, biases(steps, base, rates, placed))


def in_base(steps: Sequence[Segment]) -> list[bool]:
    """Whether a segment works in the basis that it turns in: where what follows does, what comes before did, or it screws."""
    found = [step.joins or any(f.slide is not NOTHING for f in step.spin.freedoms) for step in steps]
    for step in steps:
        if step.joins:
            found[step.parent] = True
    return found


def angular_velocities(steps: Sequence[Segment], base: Sequence[bool]) -> list[Rates]:
    """ω of every segment."""
    found: list[Rates] = []
    for i, step in enumerate(steps):
        if i == 0:
            found.append(Rates(NOTHING, NOTHING, NOTHING, NOTHING))
            continue
        parent = found[step.parent]
        before = parent.work if step.joins else parent.own
        for turn in step.lead:
            before = turn.down(before)
        ground = parent.ground if step.joins else before
        if step.turn is None:
            found.append(Rates(before, before, before, ground, parent.square))
            continue
        relative = step.spin.total
        axis = step.turn.axis
        if base[i] and axis is not None:
            work = summed(before, relative)
            if step.swift is not None:
                work = summed(ground, along(axis, step.swift))
            found.append(Rates(before, step.turn.down(work), work, ground, dot(work, work)))
        else:
            own = summed(step.turn.down(before), relative)
            found.append(Rates(before, own, own, ground, dot(own, own)))
    return found


def arms(steps: Sequence[Segment]) -> list[tuple[Triple, Stage]]:
    """The arm and the slide of each segment along the basis before its turn; a late slide stays along B."""
    found = []
    for step in steps:
        arm, slide = step.arm, step.slide
        if step.joins:
            turn = steps[step.parent].turn
            assert turn is not None
            arm = turn.up(arm)
            slide = Stage(
                tuple(Freedom(turn.up(f.axis), f.row) for f in slide.freedoms),
                turn.up(slide.total),
                turn.up(slide.drift),
                shared=tuple((b, turn.up(v)) for b, v in slide.shared),
            )
        found.append((arm, slide))
    return found


def velocities(on: Travel) -> list[Triple]:
    """Velocities of the segments' origins, along B."""
    before: list[Triple] = [NOTHING]  # along A
    after: list[Triple] = [NOTHING]
    for i, step in enumerate(on.steps):
        if i == 0:
            continue
        arm, slide = on.placed[i]
        v = before[step.parent] if step.joins else after[step.parent]
        for turn in step.lead:
            v = turn.down(v)
        v = summed(v, cross3(on.rates[i].before, arm))
        own = NOTHING if step.late else slide.total
        before.append(summed(v, own))
        turned = before[i] if step.turn is None else step.turn.down(before[i])
        after.append(summed(turned, slide.total) if step.late else turned)
    return after


def biases(
    steps: Sequence[Segment], base: Sequence[bool], rates: Sequence[Rates], placed: Sequence[tuple[Triple, Stage]]
) -> list[Biases]:
    """What is left of the accelerations of each segment relative to the one before at ẇ = 0."""
    found = []
    for i, (step, w, (arm, slide)) in enumerate(zip(steps, rates, placed, strict=True)):
        entered = step.turn.down(w.before) if step.turn is not None and not base[i] else w.before
        spin = summed(step.spin.drift, cross3(entered, step.spin.total))
        at = w.before
        square = rates[step.parent].square
        swing = slide.drift
        if step.late:
            doubled = summed(times(TWO, entered), step.spin.total)
            sliding = summed(swing, cross3(doubled, slide.total))
            found.append(Biases(arm, centripetal(at, arm, square), sliding, spin))
        else:
            doubled = times(TWO, cross3(at, slide.total))
            shift = summed(summed(centripetal(at, arm, square), doubled), swing)
            found.append(Biases(arm, shift, NOTHING, spin, summed(doubled, swing)))
    return found
