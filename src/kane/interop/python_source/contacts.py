# SPDX-License-Identifier: BSD-3-Clause
"""Constraints and contacts as calls of the functions that make them: of contacts first the geometry, then the laws.

A system does not record which function made a group of constraints, a contact or a law: each candidate is called, and accepted if its
result is identical, field by field. Others are written as records.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise, product
from types import MappingProxyType
from typing import Any, NamedTuple

from kane.errors import KaneError
from kane.expr.evaluation import free_symbols
from kane.expr.node import ONE, ZERO, Expr, postorder
from kane.expr.ops import DIV, MUL, NEG, SUB
from kane.expr.symbols import Coordinate, Parameter, Rate, Speed
from kane.expr.visit import substituted
from kane.interop.python_source.expressions import literal, same, same_vectors
from kane.model.constraints import (
    ClosureBranch,
    Constraint,
    Constraints,
    coincident,
    distance,
    no_slip,
    perpendicular,
    rolling,
)
from kane.model.contacts import LAWS, ContactLaw, clutch, drilling_resistance, rolling_resistance, rope, stiction, stop
from kane.model.joints.closing import close_cylindrical, close_pin, close_planar, close_slider, close_weld
from kane.model.joints.contact import Contact, disk_on_plane, point_on_plane, sphere_on_plane, sphere_on_sphere
from kane.model.joints.joint import Joint
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

_CLOSURES: tuple[tuple[Callable[..., Constraints], str | None], ...] = (
    (close_weld, None),
    (close_pin, "axis"),
    (close_slider, "axis"),
    (close_cylindrical, "axis"),
    (close_planar, "normal"),
)
"""Functions that close a loop on one branch, with the keyword of their axis."""
_LONGEST = 6
"""The maximum number of constraints of a closure."""


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """The constraints that one call makes: the function, its points and frames, and its further arguments."""

    function: str
    constraints: Constraints
    places: tuple[Point | Frame, ...] = ()
    arguments: tuple[Expr | Sequence[Vector], ...] = ()
    keywords: Mapping[str, Sequence[Vector]] = field(default_factory=dict)
    first: tuple[str, ...] = ()
    named: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """A name for the group."""
        return _stem(self.constraints[0].name, len(self.constraints))

    @property
    def single(self) -> bool:
        """Whether the call returns one constraint instead of a tuple."""
        return self.function in (
            "Constraint",
            "distance",
            "perpendicular",
            "configuration_constraint",
            "motion_constraint",
        )


def groups(constraints: Sequence[Constraint]) -> Iterator[Group]:
    """The constraints, in order, as calls."""
    rest = list(constraints)
    while rest:
        group = next(_candidates(rest))
        yield group
        del rest[: len(group.constraints)]


def _candidates(rest: Sequence[Constraint]) -> Iterator[Group]:
    yield from _closures(rest)
    for size in (3, 2, 1):
        some = tuple(rest[:size])
        if len(some) == size:
            yield from _called(some)
    c = rest[0]
    plain = not (c.forces or c.torques or c.unit or c.normal or c.own is not ZERO)
    if plain:
        yield Group(f"{c.kind}_constraint", (c,), (), (c.expr,), first=(literal(c.name),))
    yield Group("Constraint", (c,))


def _called(some: Constraints) -> Iterator[Group]:
    """Candidate calls, other than closures, that make exactly these constraints."""
    name = _stem(some[0].name, len(some))
    if not all(c.forces or c.torques for c in some) or any(a.kind != b.kind for a, b in pairwise(some)):
        return
    points, along = tuple(p for p, _ in some[0].forces), tuple(c.forces[0][1] for c in some if c.forces)
    named = (f"name={literal(name)}",)
    tries: list[tuple[Callable[[], Any], Group]] = []
    if len(along) == len(some) and some[0].kind == "configuration" and len(points) == 2:
        p, q = points
        made = Group("coincident", some, points, keywords={"along": along}, named=named)
        tries.append((lambda: coincident(p, q, along, name=name), made))
        if len(some) == 1 and (length := _divisor(along[0])) is not None:
            tries.append(
                (lambda: distance(p, q, length, name=name), Group("distance", some, points, (length,), named=named))
            )
    elif len(along) == len(some) and some[0].kind == "motion":
        normal = some[0].normal
        if normal is not None and len(some) == 2:
            keywords = {"normal": (normal,), "along": along[:1]}
            group = Group("rolling", some, points, keywords=keywords, named=named)
            tries.append((lambda: rolling(*points, normal=normal, along=along[0], name=name), group))
        tries.append(
            (
                lambda: no_slip(*points, along=along, name=name),
                Group("no_slip", some, points, keywords={"along": along}, named=named),
            )
        )
    elif len(some) == 1 and len(some[0].torques) == 2:
        pair = _factors(some[0])
        if pair is not None:
            group = Group("perpendicular", some, (), tuple((v,) for v in pair), named=named)
            tries.append((lambda: perpendicular(*pair, name=name), group))
    yield from (group for make, group in tries if _makes(make, some))


def _closures(rest: Sequence[Constraint]) -> Iterator[Group]:
    """Calls of `kn.close_…` that make the first constraints of `rest`, with an axis of the parent where needed."""
    turned = next((c for c in rest[:_LONGEST] if c.branch is not None), None)
    if turned is None or turned.branch is None or not rest[0].forces:
        return
    name = turned.branch.name
    (point, _), (at, _) = rest[0].forces
    (frame, _), (parent, _) = turned.torques
    places = (at, parent, point, frame)
    axes = [v for e in (parent.x, parent.y, parent.z) for v in (e, -e)]
    for close, key in _CLOSURES:
        for keywords in [{}] if key is None else [{key: v} for v in axes]:
            make = partial(close, name, *places, **keywords)
            for size in range(3, min(_LONGEST, len(rest)) + 1):
                if _makes(make, some := tuple(rest[:size])):
                    shown = {k: (v,) for k, v in keywords.items()}
                    yield Group(close.__name__, some, places, keywords=shown, first=(literal(name),))


def _makes(make: Callable[[], Any], wanted: Constraints) -> bool:
    try:
        made = make()
    except KaneError:
        return False
    kept = (made,) if isinstance(made, Constraint) else tuple(made)
    return len(kept) == len(wanted) and all(map(same_constraint, kept, wanted))


def same_constraint(a: Constraint, b: Constraint, partner: Mapping[Point, Point] = MappingProxyType({})) -> bool:
    """Whether two constraints are identical, field by field, if `partner` maps points of the first to those of the second."""
    plain = a.name == b.name and a.kind == b.kind and a.unit == b.unit and a.expr is b.expr and a.own is b.own
    normals = ([] if c.normal is None else [c.normal] for c in (a, b))
    acting: tuple[list[tuple[Point | Frame, Vector]], ...] = tuple([*c.forces, *c.torques] for c in (a, b))
    first, second = ([x for x, _ in pairs] for pairs in acting)
    alike = same([partner.get(x, x) if isinstance(x, Point) else x for x in first], second) and same_vectors(
        *([v for _, v in pairs] for pairs in acting)
    )
    return plain and _same_branch(a.branch, b.branch) and same_vectors(*normals) and alike


def _same_branch(a: ClosureBranch | None, b: ClosureBranch | None) -> bool:
    if a is None or b is None:
        return a is b
    return (a.name, a.what) == (b.name, b.what) and same([a.cosine, *a.rows], [b.cosine, *b.rows])


def _stem(name: str, count: int) -> str:
    """The name of a group, from that of its first constraint."""
    mark = {1: "", 3: " x"}.get(count, " 1")
    return name.removesuffix(mark) if mark else name


def _divisor(v: Vector) -> Expr | None:
    """L of a vector of the form r/L."""
    return next((x.args[1] for _, triple in v.parts for x in triple if x.op is DIV), None)


def _factors(c: Constraint) -> tuple[Vector, Vector] | None:
    """Axes a and b of frames with a·b and torques along a × b, if they are unit vectors of the frames."""
    (left, _), (right, _) = c.torques
    for a in (left.x, left.y, left.z):
        for b in (right.x, right.y, right.z):
            for first, second in ((a, b), (-a, b)):
                if first.dot(second) is c.expr:
                    return first, second
    return None


class Made(NamedTuple):
    """A call: the function, its positional and its keyword arguments."""

    function: str
    given: tuple[Any, ...]
    named: Mapping[str, Any]


class OfSpeed(NamedTuple):
    """A friction coefficient as a function of the slip speed."""

    speed: Parameter
    size: Expr

    def __call__(self, v: Any) -> Expr:
        """Its value at a speed."""
        return substituted(self.size, {self.speed: v})


# ----------------------------------------------------------------------------------------------------------------- places


def place_call(place: Contact) -> Made:
    """The call that makes a contact, or its record."""
    for make, given, named in _place_constructors(place):
        for more in _directions(place) if "normal" in named else [{}]:
            try:
                made = make(place.name, *given, **named, **more)
            except KaneError:
                continue
            if _alike(made, place):
                return Made(make.__name__, (place.name, *given), {**named, **more})
    fields = ("point", "particle", "ground", "normal", "height", "rolling")
    return Made("Contact", (place.name,), {key: getattr(place, key) for key in fields})


def new_points(place: Contact) -> Iterator[tuple[Point, str]]:
    """The points that a contact's call creates, with the names of its attributes for them."""
    made = place_call(place)
    if made.function == "Contact":
        return
    for name in ("point", "particle", "ground"):
        point = getattr(place, name)
        if point is not None and all(point is not x for x in made.given):
            yield point, name


Try = tuple[Callable[..., Contact], tuple[Any, ...], dict[str, Any]]


def _place_constructors(place: Contact) -> Iterator[Try]:
    """Candidate calls of a contact, without directions in the plane."""
    particle, ground, (_, (plane, _)) = place.particle, place.ground, place.height.forces
    flat = {"normal": place.normal}
    if place.point is particle:
        yield point_on_plane, (particle, plane), flat
        return
    center, wheel = particle.parent, particle.body
    if center is None or wheel is None:
        return
    lengths = _lengths([x for _, triple in particle.offset.parts for x in triple])
    for radius in lengths:
        yield sphere_on_plane, (wheel, center, plane), {"radius": radius, **flat}
    axes = [v for e in (wheel.x, wheel.y, wheel.z) for v in (e, -e)]
    for radius, axis in product(lengths, axes):
        named = {"axis": axis, "radius": radius, **flat}
        yield disk_on_plane, (wheel, center, plane), named
        down = _over(particle.offset, radius)
        if down is not None:
            yield disk_on_plane, (wheel, center, plane), {**named, "down": down}
    if ground is not None and ground.body is not None and ground.parent is not None:
        for own, other in product(_lengths([place.height.expr]), repeat=2):
            sizes = {"radius": own, "other_radius": other}
            for inside in ({}, {"inside": True}):
                yield sphere_on_sphere, (wheel, center, ground.body, ground.parent), {**sizes, **inside}


def _lengths(among: Sequence[Expr]) -> list[Expr]:
    """Constant subexpressions (of parameters and numbers) of expressions, and zero."""
    moving = (Coordinate, Rate, Speed)
    kept = [e for e in postorder(tuple(among)) if not any(isinstance(s, moving) for s in free_symbols([e]))]
    return [*dict.fromkeys(reversed(kept)), ZERO]


def _over(v: Vector, length: Expr) -> Vector | None:
    """The vector that gives `v` when multiplied by a length; None if `v` is not such a product."""
    frames = ((f, triple) for f, triple in v.parts if isinstance(f, Frame))
    terms = [(unit, x) for f, triple in frames for unit, x in zip((f.x, f.y, f.z), triple, strict=True)]
    result = Vector()
    for unit, x in terms:
        size, sign = (x.args[0], -1) if x.op is NEG else (x, 1)
        pairs = [(ONE, size)] if size is length else [size.args, size.args[::-1]] if size.op is MUL else []
        factor = next((a for a, b in pairs if b is length), None)
        if factor is None and x is not ZERO:
            return None
        result = result if factor is None else result + unit * (factor * sign)
    return result


def _directions(place: Contact) -> Iterator[dict[str, Vector]]:
    """Candidate directions in the contact plane and velocities of its surface, which include that of the ground."""
    ways = [c.forces[0][1] for c in place.rolling]
    running = sum((way * -c.own for c, way in zip(place.rolling, ways, strict=True)), start=Vector())
    yield from ({}, {"surface": running}, *({"along": w} for w in ways[:1]))
    yield from ({"along": w, "surface": running} for w in ways[:1])


def _alike(made: Contact, place: Contact) -> bool:
    """Whether two contacts are identical, except for the points that their functions create."""
    points = [(made.point, place.point), (made.particle, place.particle), (made.ground, place.ground)]
    partner = {a: b for a, b in points if a is not None and b is not None}
    rows = [(made.height, place.height), *zip(made.rolling, place.rolling, strict=False)]
    return (
        len(made.rolling) == len(place.rolling)
        and all(_alike_points(a, b) for a, b in points)
        and same_vectors([made.normal], [place.normal])
        and all(same_constraint(a, b, partner) for a, b in rows)
    )


def _alike_points(a: Point | None, b: Point | None) -> bool:
    if a is None or b is None or a is b:
        return a is b
    born = a.name == b.name and a.parent is b.parent and a.body is b.body and a.frame is b.frame
    return born and same_vectors([a.offset], [b.offset])


# ------------------------------------------------------------------------------------------------------------------- laws


def law_call(c: ContactLaw, joints: Sequence[Joint]) -> Made | None:
    """The call that makes a law, with its parameters; None if no function makes it."""
    if c.place is not None:
        mu = () if c.kinetic is ZERO else (_kinetic(c),)
        return Made("contact", (c.place, *mu), {**_numbers(c), **_pressed(c), **_name(c, c.place.name)})
    for make, given, named in _laws(c, joints):
        try:
            made = make(*given, **named)
        except KaneError:
            continue
        if c.rows and len(made.rows) == len(c.rows) and all(map(same_constraint, made.rows, c.rows)):
            return Made(make.__name__, given, named)
    return None


LawTry = tuple[Callable[..., ContactLaw], tuple[Any, ...], dict[str, Any]]


def _laws(c: ContactLaw, joints: Sequence[Joint]) -> Iterator[LawTry]:
    """Candidate calls of a law, without the contact."""
    row, numbers = next(iter(c.rows), None), _numbers(c)
    if row is None or (c.gap is not None and c.slips):
        return
    if c.gap is not None:
        if row.forces and row.expr.op is SUB:
            yield rope, (c.name, tuple(p for p, _ in row.forces), row.expr.args[0]), numbers
        yield stop, (c.name, row.expr), numbers
        yield stop, (c.name, row), numbers
    elif c.pressed_by is not None:
        for make, stem in ((rolling_resistance, "rolling"), (drilling_resistance, "drilling")):
            yield make, (c.pressed_by, _kinetic(c)), {**numbers, **_name(c, f"{stem} of {c.pressed_by.name}")}
    else:
        rubs = {**numbers, **_pressed(c)}
        for j in joints:
            if j.kind in ("pin", "slider"):
                yield stiction, (j, _kinetic(c)), {**rubs, **_name(c, f"stiction in {j.name}")}
        if len(row.torques) == 2:
            (frame, axis), (other, _) = row.torques
            yield clutch, (c.name, frame, other, axis, _kinetic(c)), rubs


def _kinetic(c: ContactLaw) -> Expr | OfSpeed:
    return OfSpeed(c.speed, c.kinetic) if c.speed in free_symbols([c.kinetic]) else c.kinetic


def _numbers(c: ContactLaw) -> dict[str, Any]:
    """The keyword arguments of a law that differ from their defaults."""
    usual = {
        "static": (c.static, c.kinetic_at(ZERO)),
        "viscous": (c.viscous, ZERO),
        "restitution": (c.restitution, ZERO),
    }
    told = {key: value for key, (value, plain) in usual.items() if value is not plain}
    return {**told, **({} if c.law == LAWS[0] else {"law": c.law})}


def _pressed(c: ContactLaw) -> dict[str, Any]:
    return {} if c.gap is not None or c.normal_force is None else {"normal": c.normal_force}


def _name(c: ContactLaw, usual: str) -> dict[str, str]:
    return {} if c.name == usual else {"name": c.name}
