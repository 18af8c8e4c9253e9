# SPDX-License-Identifier: BSD-3-Clause
"""Forces at trial accelerations of the joint speeds, from body to body.

What is left of Kane's equations, M (ẇ − ẇ°) = −b(ẇ°), holds at any trial ẇ°: that one is taken at which the accelerations have no
component along freedoms that are unit vectors. Each body presses with its own ω × J ω and J α: a few operations where J is diagonal
and its mass centre on the axis of its joint, and then shorter than what composite bodies leave (`gyroscopic`), which have neither.
"""

from collections.abc import Iterator, Mapping, Sequence

from kane.dynamics.routes.articulated import Wrenches, unit
from kane.dynamics.routes.moving import passed_outward
from kane.dynamics.routes.places import Place, Way, Wrench
from kane.expr.build import neg, sub
from kane.expr.node import ZERO, Expr
from kane.space.rotation import NOTHING, Triple, cross3, product
from kane.space.spatial import Inertia, Rigid, negative, summed, times, triple


def are_slender(bodies: Sequence[Rigid]) -> bool:
    """Whether most bodies that are carried have diagonal J and no m r*, as rods along their axes and rotors."""
    carried = [body for body in bodies if not body.is_nothing]
    slender = [b for b in carried if all(x is ZERO for x in (*b.h, b.j[0][1], b.j[0][2], b.j[1][2]))]
    return 2 * len(slender) > len(carried)


def forces_at_trial(
    way: Way,
    bodies: Sequence[Rigid],
    loads: Wrenches,
    ground: Triple,
    count: int,
    bending: Mapping[int, Inertia],
) -> tuple[list[Expr], list[Expr]]:
    """Trial accelerations of the freedoms, and −b there."""
    on = way.on
    trial, right = [ZERO] * count, [ZERO] * count
    # freedoms that several segments share are left as they are
    moving = passed_outward(way, ground, lambda places, alpha, a: _without(places, alpha, a, trial), way.outer).work
    pressing = list(wrenches(way, bodies, loads, moving))
    for i, felt in bending.items():
        at = felt.at(*moving[i])
        pressing[i] = pressing[i].plus(Wrench(at.n, at.f))
        for b, column in at.columns.items():
            right[way.modes[b]] = sub(right[way.modes[b]], column.force)
    for i in reversed(range(1, len(on.steps))):
        w = pressing[i]
        for place in way.inner[i]:
            right[place.number] = neg(w.along(place.freedom, place.turning))
        w = way.entered(i, w)
        for place in way.outer[i]:
            right[place.number] = neg(w.along(place.freedom, place.turning))
        for place in way.shared[i]:
            right[place.number] = sub(right[place.number], w.along(place.freedom, place.turning))
        parent = on.steps[i].parent
        if parent:
            pressing[parent] = pressing[parent].plus(way.left(i, w))
    return trial, right


def _without(places: Sequence[Place], alpha: Triple, a: Triple, trial: list[Expr]) -> tuple[Triple, Triple]:
    """The accelerations without their components along unit freedoms, which the trial takes off."""
    for place in places:
        k = unit(place.freedom.axis)
        if k is None or place.freedom.slide is not NOTHING:
            continue
        known = alpha if place.turning else a
        trial[place.number] = neg(known[k])
        known = triple(ZERO if j == k else x for j, x in enumerate(known))
        alpha, a = (known, a) if place.turning else (alpha, known)
    return alpha, a


def wrenches(
    way: Way, bodies: Sequence[Rigid], loads: Wrenches, moving: Sequence[tuple[Triple, Triple]]
) -> Iterator[Wrench]:
    """What each segment alone presses on its origin with."""
    on = way.on
    for i, (body, (alpha, a)) in enumerate(zip(bodies, moving, strict=True)):
        n, f = body.bias(on.rates[i].work, on.rates[i].square)
        n = summed(n, summed(product(body.j, alpha), cross3(body.h, a)))
        f = summed(f, summed(cross3(alpha, body.h), times(body.m, a)))
        if i in loads:
            own = Wrench(*map(negative, loads[i]))
            turn = on.steps[i].turn
            if turn is not None and on.base[i]:
                own = Wrench(turn.up(own.n), turn.up(own.f))
            n, f = summed(n, own.n), summed(f, own.f)
        yield Wrench(n, f)
