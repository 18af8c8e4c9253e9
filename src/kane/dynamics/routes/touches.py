# SPDX-License-Identifier: BSD-3-Clause
"""Particles of bodies that constraints hold, and of which of them the whole velocity is known."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from kane.dynamics.derived import Derived
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import AuxiliarySpeed, Speed
from kane.kinematics.motion import Contact, Kinematics
from kane.kinematics.sample import Sample
from kane.model.constraints import Constraint
from kane.space.point import Point
from kane.space.vector import Vector

_SEEDS = range(20501, 20506)
_NOTHING = 1e-12
"""Share of a partial velocity's length below which a measure number of it counts as zero, where it does at all samples."""


class Touch(NamedTuple):
    """Constraints, by their rows, that hold one point (None: it is not told which) along one direction each."""

    rows: tuple[int, ...]
    point: Point | None
    other: Point | None
    directions: tuple[Vector, ...]


def touches(constraints: Sequence[Constraint], rows: Iterable[int], kinematics: Kinematics) -> list[Touch]:
    """The motion constraints among `rows`, and what else keeps their points, those of one point together."""
    found: dict[tuple[Point | int, Point | None], list[tuple[int, Vector]]] = {}
    moving = set()
    for r in sorted(rows):
        c = constraints[r]
        if c.torques or c.own is not ZERO or len(c.forces) > 2 or not (c.forces or c.kind == "motion"):
            continue
        points = [p for p, _ in c.forces]
        other = points[1] if len(points) == 2 and not _rests(points[1], kinematics) else None
        key = (points[0] if points else r, other)
        found.setdefault(key, []).append((r, c.forces[0][1] if points else Vector()))
        if c.kind == "motion":
            moving.add(key)
    return [
        Touch(tuple(r for r, _ in held), p if isinstance(p, Point) else None, other, tuple(n for _, n in held))
        for (p, other), held in found.items()
        if (p, other) in moving
    ]


def _rests(point: Point, kinematics: Kinematics) -> bool:
    motion = kinematics.point(point)
    return motion.rest.is_zero and all(isinstance(s, AuxiliarySpeed) for s in motion.partials)


def contacts(held: Iterable[Touch], w: Mapping[int, Speed], derived: Derived) -> dict[Point, Contact]:
    """Points of bodies with the particles through which their velocities go."""
    found: dict[Point, Contact] = {}
    for t in held:
        if t.point is None or t.point.body is None or t.point.parent is None:
            continue
        start = t.point.parent
        if start.parent is None or start in found:
            continue
        if (t.other is None or start not in t.other.ancestry()) and _is_known(t, t.point, derived):
            found[start] = Contact(
                t.point, t.point.body, t.other, {w[r]: n for r, n in zip(t.rows, t.directions, strict=True)}
            )
    return found


def _is_known(t: Touch, point: Point, derived: Derived) -> bool:
    """Whether the directions are perpendicular, and what the velocity has across them vanishes."""
    if len(t.rows) not in (2, 3) or any(a.dot(b) is not ZERO for a, b in combinations(t.directions, 2)):
        return False
    if len(t.rows) == 3:
        return True
    across = t.directions[0].cross(t.directions[1])
    motion = derived.kinematics.point(point)
    apart: dict[Expr, Vector] = {ONE: motion.rest, **motion.partials}
    if t.other is not None:
        touched = derived.kinematics.point(t.other)
        for s, v in {ONE: touched.rest, **touched.partials}.items():
            apart[s] = apart.get(s, Vector()) - v
    pairs = [(v.dot(across), v.dot(v)) for s, v in apart.items() if not isinstance(s, AuxiliarySpeed)]
    open_ = [(x, square) for x, square in pairs if x is not ZERO]
    return all(_vanishes(open_, Sample(derived.kinematical, seed)) for seed in _SEEDS) if open_ else True


def _vanishes(pairs: Sequence[tuple[Expr, Expr]], sample: Sample) -> bool:
    """Whether measure numbers vanish beside the lengths, given squared, at a sample."""
    numbers = sample.numbers([x for pair in pairs for x in pair])
    return all(
        bool(np.all(np.abs(x) <= _NOTHING * np.sqrt(np.abs(square))))
        for x, square in zip(numbers[::2], numbers[1::2], strict=True)
    )
