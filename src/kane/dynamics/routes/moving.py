# SPDX-License-Identifier: BSD-3-Clause
"""The accelerations of segments, from body to body, with what freedoms add on the way."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from kane.dynamics.routes.articulated import parts
from kane.dynamics.routes.places import Place, Way
from kane.expr.node import Expr
from kane.space.rotation import NOTHING, Triple, cross3
from kane.space.spatial import summed, times

Driven = Callable[[Sequence[Place], Triple, Triple], tuple[Triple, Triple]]
"""α and a with what freedoms make of them."""


class Moving(NamedTuple):
    """α and a of each segment along B, `own`, and along the basis that it works in."""

    own: Sequence[tuple[Triple, Triple]]
    work: Sequence[tuple[Triple, Triple]]


def moving(way: Way, ground: Triple, values: Sequence[Expr]) -> Moving:
    """The accelerations of all segments at ẇ of all freedoms, by number."""

    def driven(places: Sequence[Place], alpha: Triple, a: Triple) -> tuple[Triple, Triple]:
        for p in places:
            spin, slide = parts(p.freedom, p.turning)
            alpha, a = summed(alpha, times(values[p.number], spin)), summed(a, times(values[p.number], slide))
        return alpha, a

    return passed_outward(way, ground, driven, [(*s, *o) for s, o in zip(way.shared, way.outer, strict=True)])


def passed_outward(way: Way, ground: Triple, driven: Driven, outer: Sequence[Sequence[Place]]) -> Moving:
    """The accelerations of all segments; `driven` is asked for the `outer` freedoms of each, then for its inner ones."""
    on, still = way.on, (NOTHING, ground)
    own, work = [still], [still]
    for i, step in enumerate(on.steps):
        if i == 0:
            continue
        alpha, a = work[step.parent] if step.joins else own[step.parent]
        for lead in step.lead:
            alpha, a = lead.down(alpha), lead.down(a)
        a = summed(a, summed(cross3(alpha, on.placed[i][0]), on.known[i].shift))
        alpha, a = driven(outer[i], alpha, a)
        turn, in_a = step.turn, on.base[i]
        if turn is not None and not in_a:
            alpha, a = turn.down(alpha), turn.down(a)
        alpha, a = driven(way.inner[i], summed(alpha, on.known[i].spin), summed(a, on.known[i].sliding))
        work.append((alpha, a))
        own.append((turn.down(alpha), turn.down(a)) if turn is not None and in_a else (alpha, a))
    return Moving(own, work)
