# SPDX-License-Identifier: BSD-3-Clause
"""How the motion of each segment of a tree changes relative to the one before with one symbol."""

from collections.abc import Sequence

from kane.dynamics.derivatives.stages import Stage, total
from kane.dynamics.derivatives.wholes import Change, primed
from kane.dynamics.trees.line import Line, Motion, Vectors, entered
from kane.expr.differentiation import tangent
from kane.expr.node import ONE, TWO, ZERO
from kane.expr.symbols import Symbol
from kane.space.rotation import NOTHING, Triple, cross3
from kane.space.spatial import summed, times, triple

Changes = dict[Symbol, Change]


def changes(line: Line, moving: Sequence[Motion], symbols: Sequence[Symbol]) -> list[Changes]:
    """How the motion of each segment changes with each symbol, that of the one before held."""
    falls = {x: triple(tangent(e, {x: ONE}) for e in line.ground) for x in symbols}
    found: list[Changes] = [{x: Change(NOTHING, NOTHING, v) for x, v in falls.items() if any(e is not ZERO for e in v)}]
    for i in range(1, len(moving)):
        stages = _stages(line, i, moving[line.parent(i)].work, moving[i])
        found.append({})
        for x in symbols:
            change: Vectors | None = None
            for stage, freedoms in zip(stages, ((), line.way.outer[i], line.way.inner[i]), strict=True):
                alpha, a = line.driven(freedoms, lambda e, x=x: tangent(e, {x: ONE}))  # type: ignore[misc]
                own = (NOTHING, alpha, a) if any(e is not ZERO for e in (*alpha, *a)) else None
                change = total([None if change is None else stage.along(change), stage.slope(x), own])
            if change is not None:
                found[i][x] = primed(moving[i].work[0], *change)
    return found


def _stages(line: Line, i: int, before: Vectors, own: Motion) -> list[Stage]:
    """From the motion of the parent to that of a segment, at λ = 0."""
    step, slide, turn = line.step(i), line.way.on.placed[i][1], line.own_turn(i)

    def moved(w: Triple, alpha: Triple, a: Triple) -> Vectors:
        r = line.arm(i)
        a = summed(a, summed(cross3(alpha, r), cross3(w, cross3(w, r))))
        if not step.late:
            a = summed(summed(a, slide.drift), times(TWO, cross3(w, slide.total)))
        return w, alpha, a

    def turned(w: Triple, alpha: Triple, a: Triple) -> Vectors:
        if turn is not None:
            w, alpha, a = map(turn.down, (w, alpha, a))
        if step.late:
            doubled = summed(times(TWO, w), step.spin.total)
            a = summed(summed(a, slide.drift), cross3(doubled, slide.total))
        alpha = summed(alpha, summed(step.spin.drift, cross3(w, step.spin.total)))
        return summed(w, step.spin.total), alpha, a

    def turned_to(*vectors: Triple) -> Vectors:
        return entered(line, i, *vectors)

    return [Stage(turned_to, before), Stage(moved, own.entered), Stage(turned, own.placed)]
