# SPDX-License-Identifier: BSD-3-Clause
"""A system as a tree of links: what moves as one, in its parent by a joint, however frames and points were declared.

A link begins where something turns or slides in the link before: at an origin, with an aligned basis. Its joint is a translation of
the origin in the parent, `offset`, and the rotation of the basis in the parent's. Both are along aligned bases, so that constant
rotations stand in these (`aligned`); neither speaks of coordinates alone, which several joints may share (absolute angles).
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

from kane.expr.differentiation import affine_forms, time_derivative
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import QuasiRate, Rate, Symbol
from kane.kinematics.aligned import Aligned
from kane.model.bodies import Part, deforming, parts_of
from kane.model.joints.joint import Joint, Twist
from kane.model.system import System
from kane.space.frame import Frame, Point
from kane.space.rotation import Basis, turned_beyond
from kane.space.vector import Parts, Vector, angular_velocity


class Carried(NamedTuple):
    """A part of a body, and its mass centre from the link's origin."""

    part: Part
    arm: Vector


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """What moves as one.

    `parent` is the number of the link before, None for the ground. `offset` leads from the parent's origin to this one's, `rotation`
    is the angular velocity in the parent, in rates, those of Euler parameters as quasi-rates. `joint` is the declared one, if it is.
    """

    basis: Basis
    parent: int | None
    offset: Vector
    rotation: Vector
    parts: tuple[Carried, ...]
    joint: Joint | None

    @property
    def rates(self) -> set[Symbol]:
        """The rates that it moves by in the link before."""
        return _rates((*self.rotation.scalars(), *self.offset.map(time_derivative).scalars()))

    def twists(self, rates: Iterable[Expr]) -> dict[Expr, Twist]:
        """The joint's basis of motion: what each rate that it has adds to ω and to the velocity of the origin, seen in the parent."""
        wanted = tuple(rates)
        turns, slides = partials_of(self.rotation, wanted), partials_of(self.offset.map(time_derivative), wanted)
        return {rate: Twist(turns.get(rate, Vector()), slides.get(rate, Vector())) for rate in {**turns, **slides}}


def partials_of(v: Vector, rates: Collection[Expr]) -> dict[Expr, Vector]:
    """What each rate that a vector holds, affine in them, is multiplied by."""
    result: dict[Expr, Vector] = {}
    for frame, numbers in v.parts:
        forms = [form for form, _ in affine_forms(numbers, rates)]
        for s in dict.fromkeys(s for form in forms for s in form):
            x, y, z = (form.get(s, ZERO) for form in forms)
            share = Vector(((frame, (x, y, z)),))
            result[s] = result[s] + share if s in result else share
    return result


class Tree(NamedTuple):
    """The links, parents first, the ground first of all; and where points are that were asked for: a link, and the arm in it."""

    links: tuple[Link, ...]
    places: Mapping[Point, tuple[int, Vector]]


class _Place(NamedTuple):
    """A point, by the number of a link and the vector from its origin; `moving` where that is not fixed in the link."""

    link: int
    arm: Vector
    moving: bool = False


_Begun: TypeAlias = tuple[Basis, int | None, Vector]
"""The basis of a link, the number of the one before, and where it begins there."""


class _Links:
    """The links as they are met, the ground first."""

    def __init__(self, inertial: Basis, aligned: Aligned, split: Collection[Point]) -> None:
        self.aligned, self.split = aligned, split
        self.begun: list[_Begun] = [(inertial, None, Vector())]
        self.numbers: dict[tuple[Basis, int, Parts], int] = {}
        self.places: dict[Point, _Place] = {}

    def attached(self, basis: Basis, place: _Place) -> _Place:
        """What is fixed in `basis` at a place: there already, or the origin of another link."""
        if not place.moving and basis is self.begun[place.link][0]:
            return place
        key = basis, place.link, place.arm.parts
        if key not in self.numbers:
            self.numbers[key] = len(self.begun)
            self.begun.append((basis, place.link, place.arm))
        return _Place(self.numbers[key], Vector())

    def place(self, point: Point) -> _Place:
        """Where a point is: along the offsets from the root, each in a link with its basis."""
        for p in reversed(point.ancestry(self.places)):
            if p.parent is None:
                self.places[p] = _Place(0, Vector())
                continue
            place = self.places[p.parent]
            if p.body is not None:  # a particle moves as its body does, wherever in it it is now
                held = self.attached(self.aligned.rates(p.body)[0], place)
                self.places[p] = _Place(held.link, held.arm + self.aligned.vector(p.offset))
                continue
            for frame, numbers in p.offset.parts:
                basis, r = self.aligned.triple(frame, numbers)
                place = self.attached(basis, place)
                place = _Place(
                    place.link, place.arm + Vector(((basis, r),)), place.moving or not is_constant_in_time(r)
                )
            if p in self.split:  # a link begins there
                self.begun.append((self.begun[place.link][0], place.link, place.arm))
                place = _Place(len(self.begun) - 1, Vector())
            self.places[p] = place
        return self.places[point]

    def within(self, part: Part) -> _Place | None:
        """A part that shares momentum with others, in the link in which they move; None where they are in several."""
        own = self.place(part.mass_center)
        places = [own, *(self.place(p) for p, _ in part.momenta)]
        link = max(place.link for place in places)
        _, parent, offset = self.begun[link]
        for place in places:
            if place.link != link and not (place.link == parent and place.arm.parts in {offset.parts}):
                return None
        return own if own.link == link else _Place(link, Vector())

    def section(self, frame: Frame, place: _Place) -> _Place:
        """Where a section of a flexible body turns: in the link of the frame that it bends from, if that begins at this place."""
        f = frame.parent
        while f is not None:
            basis = self.aligned.rates(f)[0]
            number = self.numbers.get((basis, place.link, place.arm.parts))
            if number is not None:
                return _Place(number, Vector())
            if basis is self.begun[place.link][0]:
                break
            f = f.parent
        return place

    def turning(self, frame: Frame) -> None:
        """The link that a frame turns with, which may begin at the origin of the one that it turns in."""
        f: Frame | None = frame
        numbers = {basis: k for k, (basis, _, _) in reversed(list(enumerate(self.begun)))}
        while f is not None and self.aligned.rates(f)[0] not in numbers:
            f = f.parent
        if f is not None and f is not frame:
            self.attached(self.aligned.rates(frame)[0], _Place(numbers[self.aligned.rates(f)[0]], Vector()))


def tree_of(
    system: System,
    aligned: Aligned,
    points: Iterable[Point] = (),
    split: Collection[Point] = frozenset(),
    frames: Iterable[Frame] = (),
) -> Tree:
    """The links of a system, with the places of `points` and links for `frames` between others.

    Where some points are `split` another link begins, whether it moves or not.
    """
    links = _Links(system.inertial, aligned, split)
    carried: dict[int, list[Carried]] = {}
    bending = {id(part) for part in parts_of(deforming(system.bodies))}
    for part in parts_of(system.bodies):
        moving = links.within(part) if part.momenta else None
        if moving is not None:
            carried.setdefault(moving.link, []).append(Carried(part, moving.arm))
            continue
        place = links.place(part.mass_center)
        if part.frame is not None and id(part) in bending:
            place = links.section(part.frame, place)
        basis = links.begun[place.link][0] if part.frame is None else aligned.rates(part.frame)[0]
        place = links.attached(basis, place)
        carried.setdefault(place.link, []).append(Carried(part, place.arm))
    joints = {links.attached(aligned.rates(j.frame)[0], links.place(j.point)).link: j for j in system.joints}
    places: dict[Point, tuple[int, Vector]] = {}
    for point in points:
        place = links.place(point)
        place = links.attached(links.begun[place.link][0], place)
        places[point] = place.link, place.arm
    for frame in frames:
        links.turning(frame)
    begun, number = _in_turn(links.begun)
    own = {number[k]: tuple(parts) for k, parts in carried.items()}
    of_joint = {number[k]: j for k, j in joints.items()}
    whole = tuple(
        Link(
            basis,
            parent,
            offset,
            Vector() if parent is None else angular_velocity(basis, begun[parent][0]),
            own.get(k, ()),
            of_joint.get(k),
        )
        for k, (basis, parent, offset) in enumerate(begun)
    )
    return Tree(whole, {point: (number[link], arm) for point, (link, arm) in places.items()})


def homes_of(tree: Tree, rates: Collection[Expr]) -> dict[int, tuple[Expr, ...]]:
    """For each of some rates the link that all hangs on which moves by it; by the number of that link."""
    users: dict[Expr, set[int]] = {}
    for k, link in enumerate(tree.links) if rates else ():
        moved = [(link.parent, x) for v in (link.rotation, link.offset.map(time_derivative)) for x in v.scalars()]
        moved += [(k, time_derivative(x)) for part, arm in link.parts if part.momenta for x in arm.scalars()]
        for (home, _), (row, _) in zip(moved, affine_forms([x for _, x in moved], rates), strict=True):
            for b in row:
                users.setdefault(b, set()).add(home or 0)
    homes: dict[int, tuple[Expr, ...]] = {}
    for b in rates:
        if b in users:
            home = _common(sorted(users[b]), tree.links)
            homes[home] = (*homes.get(home, ()), b)
    return homes


def repeated(tree: Tree, rates: Collection[Expr]) -> tuple[Expr, ...]:
    """Of some rates those by which links turn or slide several times, in each frame."""
    users = dict.fromkeys(rates, 0)
    for link in tree.links:
        for _, numbers in (*link.rotation.parts, *link.offset.map(time_derivative).parts):
            for b in {b: None for row, _ in affine_forms(numbers, rates) for b in row}:
                users[b] += 1
    return tuple(b for b, count in users.items() if count > 1)


def without(tree: Tree, links: Collection[int]) -> tuple[Tree, list[int]]:
    """The tree without links on which nothing hangs, and the number that each other link has then."""
    number, kept = [0] * len(tree.links), list[Link]()
    for k, link in enumerate(tree.links):
        number[k] = len(kept)
        if k not in links:
            kept.append(link if link.parent is None else replace(link, parent=number[link.parent]))
    return Tree(tuple(kept), {p: (number[link], arm) for p, (link, arm) in tree.places.items()}), number


def _common(numbers: Sequence[int], links: Sequence[Link]) -> int:
    """The last link that all of these are, or hang on."""
    result, *others = numbers
    for k in others:
        while k != result:
            k, result = (links[k].parent or 0, result) if k > result else (k, links[result].parent or 0)
    return result


def _in_turn(begun: Sequence[_Begun]) -> tuple[list[_Begun], list[int]]:
    """Links that begin at one place, each in the one that its basis turns on from: axes that intersect. Parents first; new numbers."""
    begun = _along_one_axis(begun)
    parents, offsets = [parent for _, parent, _ in begun], [offset for _, _, offset in begun]
    together: dict[tuple[int, Parts], dict[Basis, int]] = {}
    for k, (basis, parent, offset) in enumerate(begun):
        if parent is not None and basis is not begun[parent][0]:
            together.setdefault((parent, offset.parts), {}).setdefault(basis, k)
    for (parent, _), turned in together.items():
        for basis, k in turned.items() if len(turned) > 1 else ():
            before = _nearest(basis, turned, begun[parent][0])
            if before is not None:
                parents[k], offsets[k] = before, Vector()
    order: dict[int, None] = {}
    for k in range(len(begun)):
        way: list[int] = []
        at: int | None = k
        while at is not None and at not in order:
            way.append(at)
            at = parents[at]
        order.update(dict.fromkeys(reversed(way)))
    number = [0] * len(begun)
    for new, k in enumerate(order):
        number[k] = new
    found = [(begun[k][0], None if (p := parents[k]) is None else number[p], offsets[k]) for k in order]
    return found, number


def _along_one_axis(begun: Sequence[_Begun]) -> list[_Begun]:
    """Links that turn alike in one, at places along the axis: the others hang on the first that does not slide.

    So bodies on one shaft are, in whatever order they are listed.
    """
    alike: dict[Basis, list[int]] = {}
    for k, (basis, parent, _) in enumerate(begun):
        if parent is not None and basis is not begun[parent][0]:
            alike.setdefault(basis, []).append(k)
    result = list(begun)
    for basis, numbers in alike.items():
        ways = {k: _from_moving(begun, k) for k in numbers} if len(numbers) > 1 else {}
        for base in dict.fromkeys(base for base, _ in ways.values()):
            offsets = {k: offset for k, (parent, offset) in ways.items() if parent == base}
            first = min(offsets, key=lambda k, of=offsets: not is_constant_in_time(of[k].scalars()))  # type: ignore[misc]
            turning = _rates(angular_velocity(basis, begun[base][0]).scalars())
            for k, offset in offsets.items():
                between = Vector(((basis, (offset - offsets[first]).components(basis)),))
                if k != first and turning.isdisjoint(_rates(between.map(time_derivative).scalars())):
                    result[k] = basis, first, between
    return result


def _from_moving(begun: Sequence[_Begun], k: int) -> tuple[int, Vector]:
    """The number of the link before that moves in its own, or the ground, and where a link begins from there."""
    _, parent, offset = begun[k]
    assert parent is not None
    basis, before, arm = begun[parent]
    while (
        before is not None and is_constant_in_time(arm.scalars()) and angular_velocity(basis, begun[before][0]).is_zero
    ):
        parent, offset = before, arm + offset
        basis, before, arm = begun[parent]
    return parent, offset


def _rates(exprs: Iterable[Expr]) -> set[Symbol]:
    return {s for s in free_symbols(exprs) if isinstance(s, Rate | QuasiRate)}


def _nearest(basis: Basis, among: Mapping[Basis, int], base: Basis) -> int | None:
    """The number of the nearest of some bases that a basis is turned in, short of `base`, or is fixed in, of those before it."""
    for other, number in among.items():
        if other is basis:
            break
        if turn_alike(basis, other):
            return number
    b: Basis | None = basis
    while b is not None and b is not base:
        b = b.orientation.base if b.orientation is not None else None
        if b is not None and b is not base and b in among:
            return among[b]
    return None


def turn_alike(a: Basis, b: Basis) -> bool:
    """Whether two are turned about one axis of one base by angles that differ by a constant."""
    angle = turned_beyond(a, b)
    return angle is not None and is_constant_in_time([angle])
