# SPDX-License-Identifier: BSD-3-Clause
"""Chains and trees of pins about random axes, with random offsets and inertias, closed by constraints of every kind.

What holds a link is where the link is at the angles `closed_at`, so that each loop closes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

import kane as kn
from benchmarks.random_trees import random_tree

Array = Any


class Place(NamedTuple):
    """A point, and a frame in which it is fixed."""

    point: kn.Point
    frame: kn.Frame


class Held(NamedTuple):
    """The last link of a way from the ground, one halfway, and where both are on the ground, the last one on the other, once."""

    end: Place
    middle: Place
    at_end: Place
    at_middle: Place
    in_middle: Place


def closed_at(tree: kn.System, seed: int) -> Array:
    """The angles at which every loop is closed."""
    return np.random.default_rng(seed).uniform(-1, 1, len(tree.coordinates))


def _seat(place: Place, base: Place, values: dict[Any, float]) -> Place:
    """Fixed in the base, where a place is at the values of coordinates."""
    r = kn.evaluate(list(place.point.position(base.point).components(base.frame)), values)
    axes = [kn.evaluate(list(e.components(base.frame)), values) for e in (place.frame.x, place.frame.y, place.frame.z)]
    name = f"{place.point.name} on {base.frame.name}"
    x, y, z = map(float, r)
    point = base.point.at(name, x * base.frame.x + y * base.frame.y + z * base.frame.z)
    return Place(point, base.frame.rotate_matrix(name, np.array(axes, dtype=float).T.tolist()))


def _beside(place: Place, r: Sequence[object]) -> kn.Point:
    x, y, z = place.frame.x, place.frame.y, place.frame.z
    return place.point.at(f"beside {place.point.name}", r[0] * x + r[1] * y + r[2] * z)


def _path(h: Held) -> tuple[kn.Constraint, ...]:
    t, (_, N) = kn.time, h.at_end
    to = _beside(h.at_end, (0.1 * kn.sin(t), 0.1 * kn.cos(2 * t) - 0.1, -0.1 * kn.sin(2 * t)))
    return kn.coincident(h.end.point, to, along=(N.x, N.y, N.z))


def _blade(h: Held) -> tuple[kn.Constraint, ...]:
    point, frame = h.end
    return kn.no_slip(point.fixed_in(frame, "blade", 0.1 * frame.y), along=frame.x)


HOLDS: dict[str, Callable[[Held], tuple[kn.Constraint, ...]]] = {
    "distance": lambda h: (kn.distance(h.end.point, _beside(h.at_end, (0.3, 0.4, 0.0)), 0.5),),
    "driven distance": lambda h: (
        kn.distance(h.end.point, _beside(h.at_end, (0.3, 0.4, 0.0)), 0.5 + 0.1 * kn.sin(kn.time)),
    ),
    "distance to a link": lambda h: (kn.distance(h.end.point, _beside(h.in_middle, (0.3, 0.4, 0.0)), 0.5),),
    "path": _path,
    "two distances": lambda h: (
        kn.distance(h.middle.point, _beside(h.at_middle, (0.0, 0.3, 0.4)), 0.5),
        kn.distance(h.end.point, _beside(h.at_end, (0.3, 0.4, 0.0)), 0.5),
    ),
    "coincident with a link": lambda h: kn.coincident(
        h.end.point, h.in_middle.point, along=(h.middle.frame.x, h.middle.frame.y)
    ),
    "blade": _blade,
    "ball": lambda h: kn.close_ball("c", *h.at_end, *h.end),
    "pin": lambda h: kn.close_pin("c", *h.at_end, *h.end, axis=h.at_end.frame.z),
    "pin on a link": lambda h: kn.close_pin("c", *h.in_middle, *h.end, axis=h.in_middle.frame.z),
    "slider": lambda h: kn.close_slider("c", *h.at_end, *h.end, axis=h.at_end.frame.z),
    "cylindrical": lambda h: kn.close_cylindrical("c", *h.at_end, *h.end, axis=h.at_end.frame.z),
    "screw": lambda h: kn.close_screw("c", *h.at_end, *h.end, axis=h.at_end.frame.z, pitch=0.2),
    "universal": lambda h: kn.close_universal("c", *h.at_end, *h.end, axes=(h.at_end.frame.z, h.at_end.frame.x)),
    "planar": lambda h: kn.close_planar("c", *h.at_end, *h.end, normal=h.at_end.frame.z),
    "weld": lambda h: kn.close_weld("c", *h.at_end, *h.end),
}
"""What holds a chain: at its end or halfway, on the ground, on a link of its own, or along a path."""


def held_tree(parents: Sequence[int], holds: Sequence[tuple[int, str]], seed: int = 1) -> kn.System:
    """Links on pins, each on the one of `parents`, with the links at the ends of branches held, by number and kind of hold."""
    tree = random_tree(parents, seed)
    values: dict[Any, float] = dict(zip(tree.coordinates, closed_at(tree, seed).tolist(), strict=True))
    ground = Place(tree.joints[0].point.root(), tree.inertial)
    constraints: list[kn.Constraint] = []
    for end, hold in holds:
        way = [end % len(parents)]
        while parents[way[-1]] >= 0:
            way.append(parents[way[-1]])
        last, middle = (Place(j.point, j.frame) for j in (tree.joints[way[0]], tree.joints[way[len(way) // 2]]))
        seats = _seat(last, ground, values), _seat(middle, ground, values), _seat(last, middle, values)
        constraints += HOLDS[hold](Held(last, middle, *seats))
    return tree.replace(
        holonomic=[c for c in constraints if c.kind == "configuration"],
        nonholonomic=[c for c in constraints if c.kind == "motion"],
    )


def held_chain(n: int, hold: str, seed: int = 1) -> kn.System:
    """n links one after the other."""
    return held_tree(range(-1, n - 1), [(-1, hold)], seed)
