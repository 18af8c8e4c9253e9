# SPDX-License-Identifier: BSD-3-Clause
"""Joint accelerations by composite inertias: M of the joint speeds, factored along the branches, and forces at trial accelerations.

What hangs on a segment moves as one body at the acceleration of one freedom: I s of the composite inertia I is its wrench, and
M_rs = s·(I s_r) along the way to the ground (Featherstone 2008, ch. 6). M is eliminated from the tips, without fill. What is left of
Kane's equations, M (ẇ − ẇ°) = −b(ẇ°), holds at any trial ẇ°: that one is taken at which the accelerations have no component along
freedoms that are unit vectors. Shorter than articulated inertias along short branches.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

from kane.dynamics.routes.articulated import Passed, Wrenches, parts, unit
from kane.dynamics.routes.flexible import RIGID, Bent
from kane.dynamics.routes.order import sparse_order
from kane.dynamics.routes.sharing import shares_of
from kane.expr.build import add, mul, neg, sub
from kane.expr.matrix import dot
from kane.expr.node import ONE, TWO, ZERO, Expr
from kane.expr.solve import finish, forward, ldl
from kane.kinematics.freedoms import Freedom
from kane.kinematics.segments import Segment
from kane.kinematics.travel import Travel, travel
from kane.space.rotation import NOTHING, Triple, cross3, product
from kane.space.spatial import Inertia, Rigid, negative, summed, times, to_rigid, triple


class Wrench(NamedTuple):
    """A moment and a force."""

    n: Triple
    f: Triple

    def plus(self, other: "Wrench") -> "Wrench":
        """Both together."""
        return Wrench(summed(self.n, other.n), summed(self.f, other.f))

    def along(self, freedom: Freedom, turning: bool) -> Expr:
        """The generalized force of a freedom."""
        spin, slide = parts(freedom, turning)
        return add(dot(spin, self.n), dot(slide, self.f))


class Place(NamedTuple):
    """A freedom: its segment, its number among all, and whether it turns."""

    freedom: Freedom
    number: int
    turning: bool


@dataclass(frozen=True, eq=False)
class Way:
    """The freedoms of each segment along the basis it works in, those along A before its turn, and those that it shares."""

    on: Travel
    inner: Sequence[Sequence[Place]]
    outer: Sequence[Sequence[Place]]
    shared: Sequence[Sequence[Place]]
    """What moves other segments, too, along A: one number for all of these."""
    modes: Mapping[Expr, int]
    """The numbers of the rates of those."""

    def up(self, i: int, w: Wrench) -> Iterator[tuple[Place, Expr]]:
        """What a wrench on a segment, along the basis it works in, makes of the freedoms from there to the ground."""
        while i:
            for place in self.inner[i]:
                yield place, w.along(place.freedom, place.turning)
            w = self.entered(i, w)
            yield from self.along_a(i, w)
            i, w = self.on.steps[i].parent, self.left(i, w)

    def along_a(self, i: int, w: Wrench) -> Iterator[tuple[Place, Expr]]:
        """What it makes of the freedoms along A."""
        for place in (*self.outer[i], *self.shared[i]):
            yield place, w.along(place.freedom, place.turning)

    def from_outer(self, i: int, w: Wrench) -> Iterator[tuple[Place, Expr]]:
        """The same from A on."""
        yield from self.along_a(i, w)
        yield from self.up(self.on.steps[i].parent, self.left(i, w))

    def entered(self, i: int, w: Wrench) -> Wrench:
        """Along A."""
        turn = self.on.steps[i].turn
        return w if turn is None or self.on.base[i] else Wrench(turn.up(w.n), turn.up(w.f))

    def left(self, i: int, w: Wrench) -> Wrench:
        """From A to the basis in which the parent works."""
        step = self.on.steps[i]
        w = Wrench(summed(w.n, cross3(self.on.placed[i][0], w.f)), w.f)
        if step.joins or not step.parent:
            return w
        for turn in reversed(step.lead):
            w = Wrench(turn.up(w.n), turn.up(w.f))
        own = self.on.steps[step.parent].turn
        return Wrench(own.up(w.n), own.up(w.f)) if own is not None and self.on.base[step.parent] else w

    def left_rigid(self, i: int, body: Rigid) -> Rigid:
        """The same of a body."""
        step = self.on.steps[i]
        body = body.moved(self.on.placed[i][0])
        if step.joins:
            return body
        for turn in reversed(step.lead):
            body = body.before(turn)
        own = self.on.steps[step.parent].turn
        return body if own is None or not self.on.base[step.parent] else body.before(own)


def accelerations(
    steps: Sequence[Segment],
    bodies: Sequence[Rigid],
    loads: Wrenches,
    ground: Triple,
    asked: Iterable[int] = (),
    bent: Bent = RIGID,
) -> Passed:
    """ẇ of all freedoms; a SingularError where a pivot is zero whatever the state. What is transmitted is not found on this way."""
    on = travel(steps)
    way = way_along(on)
    places = sorted((p for of in (way.inner, way.outer) for own in of for p in own), key=lambda p: p.number)
    bodies = [working(on, i, body) for i, body in enumerate(bodies)]
    bending = _bending(on, bent)
    count = len(places) + len(way.modes)
    trial, right = _left(way, bodies, loads, ground, count, bending)
    mass = freedom_mass(way, bodies, count, bending)
    order = sparse_order(mass)
    factors = ldl([[mass[i][j] for j in order] for i in order])
    solved = finish(factors, forward(factors.lower, [right[i] for i in order]))
    value = dict(zip(order, solved, strict=True))
    rows = [(p.freedom.row, add(trial[k], value[k])) for k, p in enumerate(places)]
    rows += [({b: ONE}, value[k]) for b, k in way.modes.items()]
    return Passed(rows, list(factors.pivots), {})


def way_along(on: Travel) -> Way:
    """The freedoms of segments, numbered from the ground."""
    inner: list[list[Place]] = []
    outer: list[list[Place]] = []
    number = 0
    for step, (_, slide) in zip(on.steps, on.placed, strict=True):
        inner.append([])
        outer.append([])
        for freedoms, turning in ((slide.freedoms, False), (step.spin.freedoms, True)):
            where = inner if turning or step.late else outer
            for freedom in freedoms:
                where[-1].append(Place(freedom, number, turning))
                number += 1
    modes = {b: number + k for k, b in enumerate(b for step in on.steps for b in step.modes)}
    shared = [
        [Place(Freedom(spin, {b: ONE}, slide), modes[b], True) for b, spin, slide in shares_of(step, slides)]
        for step, (_, slides) in zip(on.steps, on.placed, strict=True)
    ]
    return Way(on, inner, outer, shared, modes)


def working(on: Travel, i: int, body: Rigid) -> Rigid:
    """A body along the basis that its segment works in."""
    turn = on.steps[i].turn
    return body.before(turn) if turn is not None and on.base[i] else body


def _bending(on: Travel, bent: Bent) -> dict[int, Inertia]:
    """What segments feel of their flexible parts alone, along the basis they work in."""
    found = {}
    for i, (step, w) in enumerate(zip(on.steps, on.rates, strict=True)):
        if step.modes or i in bent.bodies:
            own = bent.felt(i, step.modes, w)
            found[i] = own.before(step.turn) if step.turn is not None and on.base[i] else own
    return found


def freedom_mass(
    way: Way, bodies: Sequence[Rigid], count: int, bending: Mapping[int, Inertia] = MappingProxyType({})
) -> list[list[Expr]]:
    """M of the freedoms."""
    rows = [[ZERO] * count for _ in range(count)]
    whole = list(bodies)
    on = way.on
    for i, felt in bending.items():
        whole[i] = whole[i].plus(to_rigid(felt))
        for b, column in felt.columns.items():
            for other, x in column.row.items():
                rows[way.modes[b]][way.modes[other]] = x
            mode = Place(Freedom(NOTHING, {b: ONE}), way.modes[b], True)
            _entries(rows, mode, (), way.up(i, Wrench(column.n, column.f)))
    for i in reversed(range(1, len(on.steps))):
        body = whole[i]
        for place in way.inner[i]:
            _entries(rows, place, way.inner[i], way.up(i, _moved(body, place)))
        turn = on.steps[i].turn
        if turn is not None and not on.base[i]:
            body = body.before(turn)
        along_a = (*way.outer[i], *way.shared[i])
        for place in along_a:
            _entries(rows, place, along_a, way.from_outer(i, _moved(body, place)))
        if on.steps[i].parent:
            parent = on.steps[i].parent
            whole[parent] = whole[parent].plus(way.left_rigid(i, body))
    return rows


def _entries(
    rows: list[list[Expr]], place: Place, beside: Sequence[Place], found: Iterator[tuple[Place, Expr]]
) -> None:
    """What the wrench at one place adds to M; of the places `beside` it each pair comes twice."""
    before = {id(p) for p in beside[: [p is place for p in beside].index(True)]} if beside else ()
    for other, value in found:
        if id(other) in before:
            continue
        r, s = place.number, other.number
        if r == s and place is not other:
            value = mul(TWO, value)
        rows[r][s] = rows[s][r] = add(rows[r][s], value)


def _moved(body: Rigid, place: Place) -> Wrench:
    """The wrench of a body at the acceleration 1 of a freedom."""
    spin, slide = parts(place.freedom, place.turning)
    turned = Wrench(product(body.j, spin), cross3(spin, body.h))
    return turned.plus(Wrench(cross3(body.h, slide), times(body.m, slide)))


def _left(
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
    moving = _tried(way, ground, trial)
    pressing = list(_wrenches(way, bodies, loads, moving))
    for i, felt in bending.items():
        at = felt.at(*moving[i])
        pressing[i] = pressing[i].plus(Wrench(at.n, at.f))
        for b, column in at.columns.items():
            right[way.modes[b]] = neg(column.force)
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


def _tried(way: Way, ground: Triple, trial: list[Expr]) -> list[tuple[Triple, Triple]]:
    """α and a of each segment at the trial accelerations, along the basis it works in."""
    on = way.on
    own = [(NOTHING, ground)]  # along B
    work = [(NOTHING, ground)]
    for i, step in enumerate(on.steps):
        if i == 0:
            continue
        alpha, a = work[step.parent] if step.joins else own[step.parent]
        for turn in step.lead:
            alpha, a = turn.down(alpha), turn.down(a)
        a = summed(a, summed(cross3(alpha, on.placed[i][0]), on.known[i].shift))
        alpha, a = _without(way.outer[i], alpha, a, trial)
        turned = step.turn is not None and not on.base[i]
        if step.turn is not None and turned:
            alpha, a = step.turn.down(alpha), step.turn.down(a)
        alpha, a = summed(alpha, on.known[i].spin), summed(a, on.known[i].sliding)
        work.append(_without(way.inner[i], alpha, a, trial))
        own.append(work[i] if turned or step.turn is None else (step.turn.down(work[i][0]), step.turn.down(work[i][1])))
    return work


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


def _wrenches(
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
