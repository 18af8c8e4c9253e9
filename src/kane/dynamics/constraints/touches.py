# SPDX-License-Identifier: BSD-3-Clause
"""Particles of bodies that constraints hold, and of which of them the whole velocity is known."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from kane.expr.evaluation import is_constant_in_time
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import AuxiliarySpeed, Speed
from kane.kinematics.matching import Sample
from kane.kinematics.motion import Contact, Kinematics
from kane.model.constraints import Constraint
from kane.numeric.sampling import SEEDS
from kane.numeric.scale import ROUNDED_CHAIN
from kane.space.point import Point
from kane.space.rotation import Basis
from kane.space.vector import Vector


class Touch(NamedTuple):
    """Constraints, by their rows, that hold one point (None: it is not told which) along one direction each."""

    rows: tuple[int, ...]
    point: Point | None
    other: Point | None
    directions: tuple[Vector, ...]


def touches(constraints: Sequence[Constraint], rows: Iterable[int], kinematics: Kinematics) -> list[Touch]:
    """The constraints among `rows` that hold points, those of one point together, and motion constraints without one."""
    found: dict[tuple[Point | int, Point | None], list[tuple[int, Vector]]] = {}
    for r in sorted(rows):
        c = constraints[r]
        if c.torques or c.own is not ZERO or len(c.forces) > 2 or not (c.forces or c.kind == "motion"):
            continue
        points = [p for p, _ in c.forces]
        other = points[1] if len(points) == 2 and not _rests(points[1], kinematics) else None
        key = (points[0] if points else r, other)
        found.setdefault(key, []).append((r, c.forces[0][1] if points else Vector()))
    return [
        Touch(tuple(r for r, _ in held), p if isinstance(p, Point) else None, other, tuple(n for _, n in held))
        for (p, other), held in found.items()
    ]


def _rests(point: Point, kinematics: Kinematics) -> bool:
    motion = kinematics.point(point)
    return motion.rest.is_zero and all(isinstance(s, AuxiliarySpeed) for s in motion.partials)


def contacts(held: Iterable[Touch], w: Mapping[int, Speed], kinematics: Kinematics) -> dict[Point, Contact]:
    """Points of bodies with the particles through which their velocities go; `w` are the rates of rows that vanish but are speeds."""
    found: dict[Point, Contact] = {}
    for t in held:
        body = None if t.point is None else _body(t.point)
        if t.point is None or t.point.parent is None or body is None:
            continue
        start = t.point.parent
        if start.parent is None or start in found:
            continue
        if start not in _needed(t.other, found) and _is_known(t, t.point, kinematics):
            directions = {w[r]: n for r, n in zip(t.rows, t.directions, strict=True) if r in w}
            found[start] = Contact(t.point, body, t.other, directions)
    return found


def _body(point: Point) -> Basis | None:
    """The frame in which the particle at a point is fixed, as its point before is; None where there is none."""
    if point.body is not None:
        return point.body
    frames = [f for f, _ in point.offset.parts]
    return frames[0] if len(frames) == 1 and is_constant_in_time(point.offset.scalars()) else None


def _needed(point: Point | None, found: Mapping[Point, Contact]) -> set[Point]:
    """The points from whose velocities that of a point is taken."""
    needed: set[Point] = set()
    waiting = [point]
    while waiting:
        p = waiting.pop()
        if p is None:
            continue
        for x in p.ancestry():
            if x not in needed:
                needed.add(x)
                waiting.append(found[x].other if x in found else None)
    return needed


def _is_known(t: Touch, point: Point, kinematics: Kinematics) -> bool:
    """Whether the directions are perpendicular, and what the velocity has across them vanishes."""
    if len(t.rows) not in (2, 3) or any(a.dot(b) is not ZERO for a, b in combinations(t.directions, 2)):
        return False
    if len(t.rows) == 3:
        return True
    across = t.directions[0].cross(t.directions[1])
    motion = kinematics.point(point)
    apart: dict[Expr, Vector] = {ONE: motion.rest, **motion.partials}
    if t.other is not None:
        touched = kinematics.point(t.other)
        for s, v in {ONE: touched.rest, **touched.partials}.items():
            apart[s] = apart.get(s, Vector()) - v
    pairs = [(v.dot(across), v.dot(v)) for s, v in apart.items() if not isinstance(s, AuxiliarySpeed)]
    open_ = [(x, square) for x, square in pairs if x is not ZERO]
    return all(_vanishes(open_, Sample(kinematics.speeds, seed)) for seed in SEEDS) if open_ else True


def _vanishes(pairs: Sequence[tuple[Expr, Expr]], sample: Sample) -> bool:
    """Whether measure numbers vanish beside the lengths, given squared, at a sample."""
    numbers = sample.numbers([x for pair in pairs for x in pair])
    return all(
        bool(np.all(np.abs(x) <= ROUNDED_CHAIN * np.sqrt(np.abs(square))))
        for x, square in zip(numbers[::2], numbers[1::2], strict=True)
    )
