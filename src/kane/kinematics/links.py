# SPDX-License-Identifier: BSD-3-Clause
"""The kinematic tree of a system: links and joints found from declared frames and points (Featherstone 2008, ch. 4).

A link is a set of frames and points without relative motion. It has an origin and an aligned basis, and its joint is the translation
`offset` of the origin in the parent and the rotation of the basis relative to the parent's. Both are written along aligned bases,
which contain the constant rotations (`aligned`). A coordinate may occur in several joints (absolute angles).
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
    """A part of a body, and the position `arm` of its mass centre from the link's origin."""

    part: Part
    arm: Vector


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A link of the tree and its joint.

    `parent` is the number of the parent link, None for the ground. `offset` is the position of the origin from the parent's origin,
    `rotation` the angular velocity relative to the parent, in rates, with quasi-rates of Euler parameters. `joint` is the declared
    joint; None if the motion was declared by frames and points alone.
    """

    basis: Basis
    parent: int | None
    offset: Vector
    rotation: Vector
    parts: tuple[Carried, ...]
    joint: Joint | None

    @property
    def rates(self) -> set[Symbol]:
        """The rates of the joint."""
        return _rates((*self.rotation.scalars(), *self.offset.map(time_derivative).scalars()))

    def twists(self, rates: Iterable[Expr]) -> dict[Expr, Twist]:
        """The motion subspace of the joint: for each of `rates`, its coefficient in ω and in the origin's velocity, in the parent."""
        wanted = tuple(rates)
        turns, slides = partials_of(self.rotation, wanted), partials_of(self.offset.map(time_derivative), wanted)
        return {rate: Twist(turns.get(rate, Vector()), slides.get(rate, Vector())) for rate in {**turns, **slides}}


def partials_of(v: Vector, rates: Collection[Expr]) -> dict[Expr, Vector]:
    """The coefficient of each rate in a vector affine in rates; rates that do not occur are left out."""
    result: dict[Expr, Vector] = {}
    for frame, numbers in v.parts:
        forms = [form for form, _ in affine_forms(numbers, rates)]
        for s in dict.fromkeys(s for form in forms for s in form):
            x, y, z = (form.get(s, ZERO) for form in forms)
            share = Vector(((frame, (x, y, z)),))
            result[s] = result[s] + share if s in result else share
    return result


class Tree(NamedTuple):
    """The links, parents first, number 0 the ground; `places` gives the link and the position in it of points asked for."""

    links: tuple[Link, ...]
    places: Mapping[Point, tuple[int, Vector]]


class _Place(NamedTuple):
    """A point, by the number of a link and the position `arm` from its origin; `moving` if that is not constant in the link."""

    link: int
    arm: Vector
    moving: bool = False


_Begun: TypeAlias = tuple[Basis, int | None, Vector]
"""The basis of a link, the number of its parent, and the position of its origin in that."""


class _Links:
    """The links found so far, in the order of discovery, the ground first."""

    def __init__(self, inertial: Basis, aligned: Aligned, split: Collection[Point]) -> None:
        self.aligned, self.split = aligned, split
        self.begun: list[_Begun] = [(inertial, None, Vector())]
        self.numbers: dict[tuple[Basis, int, Parts], int] = {}
        self.places: dict[Point, _Place] = {}

    def attached(self, basis: Basis, place: _Place) -> _Place:
        """The place as a point of a link with `basis`: unchanged if its link has that basis, else the origin of another link."""
        if not place.moving and basis is self.begun[place.link][0]:
            return place
        key = basis, place.link, place.arm.parts
        if key not in self.numbers:
            self.numbers[key] = len(self.begun)
            self.begun.append((basis, place.link, place.arm))
        return _Place(self.numbers[key], Vector())

    def place(self, point: Point) -> _Place:
        """The link and position of a point, by the offsets along its path from the root."""
        for p in reversed(point.ancestry(self.places)):
            if p.parent is None:
                self.places[p] = _Place(0, Vector())
                continue
            place = self.places[p.parent]
            if p.body is not None:  # a particle is fixed in its body, at the position that it has at the instant
                held = self.attached(self.aligned.rates(p.body)[0], place)
                self.places[p] = _Place(held.link, held.arm + self.aligned.vector(p.offset))
                continue
            for frame, numbers in p.offset.parts:
                basis, r = self.aligned.triple(frame, numbers)
                place = self.attached(basis, place)
                place = _Place(
                    place.link, place.arm + Vector(((basis, r),)), place.moving or not is_constant_in_time(r)
                )
            if p in self.split:  # begin another link at this point
                self.begun.append((self.begun[place.link][0], place.link, place.arm))
                place = _Place(len(self.begun) - 1, Vector())
            self.places[p] = place
        return self.places[point]

    def within(self, part: Part) -> _Place | None:
        """The place of a part with momentum of several points, in the link that all of them move in; None if there is no such link."""
        own = self.place(part.mass_center)
        places = [own, *(self.place(p) for p, _ in part.momenta)]
        link = max(place.link for place in places)
        _, parent, offset = self.begun[link]
        for place in places:
            if place.link != link and not (place.link == parent and place.arm.parts in {offset.parts}):
                return None
        return own if own.link == link else _Place(link, Vector())

    def section(self, frame: Frame, place: _Place) -> _Place:
        """The place at which a section of a flexible body rotates: the link of an ancestor frame with its origin there, if any."""
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
        """Adds a link for a frame at the origin of its nearest ancestor's link, unless the frame is fixed in that."""
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
    """The kinematic tree of a system, with the places of `points` and with links for `frames`, even of massless ones.

    At each point of `split` another link begins, whether or not it moves relative to its parent.
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
    """The rates by the number of the nearest common ancestor of the links whose children or parts they move."""
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
    """The rates in more than one part of the tree's rotations and offset rates, where a part is along one frame."""
    users = dict.fromkeys(rates, 0)
    for link in tree.links:
        for _, numbers in (*link.rotation.parts, *link.offset.map(time_derivative).parts):
            for b in {b: None for row, _ in affine_forms(numbers, rates) for b in row}:
                users[b] += 1
    return tuple(b for b, count in users.items() if count > 1)


def without(tree: Tree, links: Collection[int]) -> tuple[Tree, list[int]]:
    """The tree without some links that have no children, and the new number of each link."""
    number, kept = [0] * len(tree.links), list[Link]()
    for k, link in enumerate(tree.links):
        number[k] = len(kept)
        if k not in links:
            kept.append(link if link.parent is None else replace(link, parent=number[link.parent]))
    return Tree(tuple(kept), {p: (number[link], arm) for p, (link, arm) in tree.places.items()}), number


def _common(numbers: Sequence[int], links: Sequence[Link]) -> int:
    """The nearest common ancestor of links, which may be one of them."""
    result, *others = numbers
    for k in others:
        while k != result:
            k, result = (links[k].parent or 0, result) if k > result else (k, links[result].parent or 0)
    return result


def _in_turn(begun: Sequence[_Begun]) -> tuple[list[_Begun], list[int]]:
    """Chains links with a common origin and parent by their bases, as for intersecting axes. The links parents first; new numbers."""
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
    """Attaches links with the same rotation relative to one link, and places along its axis, to the first that does not slide.

    The bodies on one shaft thus turn with its first link, in whatever order they are listed.
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
    """The nearest ancestor that moves relative to its parent, or the ground, and the position of link k in it."""
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
    """The number of an earlier basis in `among` that turns alike, else of the nearest ancestor in it below `base`; else None."""
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
    """Whether two bases are rotated about the same axis of the same base by angles that differ by a constant."""
    angle = turned_beyond(a, b)
    return angle is not None and is_constant_in_time([angle])
