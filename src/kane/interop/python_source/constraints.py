# SPDX-License-Identifier: BSD-3-Clause
"""Constraints as calls of the functions that make them.

A system does not record which function made a group of constraints: each candidate is called, and accepted if its result is identical,
field by field. Other constraints are written as records.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from types import MappingProxyType
from typing import Any

from kane.errors import KaneError
from kane.expr.node import ZERO, Expr
from kane.expr.ops import DIV
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
from kane.model.joints.closing import close_cylindrical, close_pin, close_planar, close_slider, close_weld
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
