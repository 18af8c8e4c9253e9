# SPDX-License-Identifier: BSD-3-Clause
"""The freedoms of segments with their places on the way to the ground, and how moments and forces are carried along it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

from kane.dynamics.routes.articulated import parts
from kane.dynamics.routes.sharing import shares_of
from kane.expr.build import add
from kane.expr.matrix import dot
from kane.expr.node import ONE, Expr
from kane.kinematics.freedoms import Freedom
from kane.kinematics.travel import Travel
from kane.space.mass_moments import Moments
from kane.space.rotation import Triple, cross3
from kane.space.spatial import Rigid, summed

Body = TypeVar("Body", Rigid, Moments)


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

    @property
    def places(self) -> list[Place]:
        """Those that move one segment, by number."""
        return sorted((p for of in (self.inner, self.outer) for own in of for p in own), key=lambda p: p.number)

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

    def left_body(self, i: int, body: Body) -> Body:
        """The same of a body."""
        step = self.on.steps[i]
        body = body.moved(self.on.placed[i][0])
        if step.joins:
            return body
        for turn in reversed(step.lead):
            body = body.before(turn)
        own = self.on.steps[step.parent].turn
        return body if own is None or not self.on.base[step.parent] else body.before(own)


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


def working(on: Travel, i: int, body: Body) -> Body:
    """A body along the basis that its segment works in."""
    turn = on.steps[i].turn
    return body.before(turn) if turn is not None and on.base[i] else body


class Composite(NamedTuple, Generic[Body]):
    """All that hangs on a segment as one body, about its origin: along the basis that it works in, and along A."""

    work: Body
    along_a: Body


def composites(way: Way, bodies: Sequence[Body]) -> list[Composite[Body]]:
    """Those of all segments, of what each carries along the basis that it works in."""
    on, whole = way.on, list(bodies)
    found: list[Composite[Body]] = []
    for i in reversed(range(len(whole))):
        turn = on.steps[i].turn
        along_a = whole[i] if turn is None or on.base[i] else whole[i].before(turn)
        found.append(Composite(whole[i], along_a))
        if on.steps[i].parent:
            parent = on.steps[i].parent
            whole[parent] = whole[parent].plus(way.left_body(i, along_a))
    return found[::-1]
