# SPDX-License-Identifier: BSD-3-Clause
"""Outlines of solids: clouds of points whose convex hull is the outline, and lines on them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from kane.errors import ModelError
from kane.numeric.arrays import Array
from kane.present.scene.records import Item, Posed
from kane.present.viewer.meshes import vertices_of

_ROUND = np.linspace(0.0, 2 * np.pi, 49)
_HALF = np.linspace(-np.pi / 2, np.pi / 2, 25)


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Points (n × 3) whose hull is filled, or separate `faces`; lines on it, and holes in it."""

    cloud: Array
    lines: tuple[Array, ...] = ()
    faces: tuple[Array, ...] = ()
    holes: tuple[Array, ...] = ()


def circle(radius: float, height: float = 0.0, turn: Array = _ROUND) -> Array:
    """Points of a circle about the third axis."""
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full_like(turn, height)], axis=-1)


def _ball(a: float, b: float, c: float) -> Array:
    points = [circle(np.cos(t), np.sin(t)) for t in np.linspace(-np.pi / 2, np.pi / 2, 17)]
    return np.concatenate(points) * (a, b, c)


def _ellipsoid(a: float, b: float, c: float) -> Outline:
    ring = circle(1.0)
    return Outline(_ball(a, b, c), (ring * (a, b, c), ring[:, [0, 2, 1]] * (a, b, c)))


def _box(a: float, b: float, c: float) -> Outline:
    corner = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * (a / 2, b / 2, c / 2)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return Outline(corner, (), tuple(corner[f] for f in faces))


def _frustum(base: float, top: float, height: float, middle: float) -> Outline:
    low, high = circle(base, -middle * height), circle(top, (1 - middle) * height)
    return Outline(np.concatenate([low, high]), (low, high) if top else (low,))


def _torus(radius: float, tube: float) -> Outline:
    around = [circle(radius + tube * np.cos(t), tube * np.sin(t)) for t in np.linspace(0, 2 * np.pi, 17)]
    return Outline(np.concatenate(around), holes=(circle(max(radius - tube, 0.0)),))


def _capsule(radius: float, length: float) -> Outline:
    ball = _ball(radius, radius, radius)
    shift = np.array([0, 0, length / 2])
    return Outline(
        np.concatenate([ball - shift, ball + shift]), (circle(radius, -length / 2), circle(radius, length / 2))
    )


def _hemisphere(radius: float) -> Outline:
    half = [circle(radius * np.cos(t), radius * np.sin(t)) for t in np.linspace(0, np.pi / 2, 10)]
    return Outline(np.concatenate(half), (circle(radius),))


def _half_cylinder(radius: float, height: float) -> Outline:
    ends = [circle(radius, h, _HALF) for h in (-height / 2, height / 2)]
    return Outline(np.concatenate(ends), tuple(ends))


def _sector(radius: float, half_angle: float) -> Outline:
    arc = circle(radius, 0.0, np.linspace(-half_angle, half_angle, 25))
    return Outline(np.concatenate([np.zeros((1, 3)), arc]))


def semi_axes(aa: float, bb: float, cc: float) -> Array:
    """Semi-axes of the ellipsoid with squares a² = 5 (…)/(2 m), at least a fifth of the largest, for flat bodies."""
    axes = np.sqrt(np.clip(np.nan_to_num([aa, bb, cc]), 0.0, None))
    return np.asarray(np.maximum(axes, 0.2 * float(axes.max())))


def _inertia(aa: float, bb: float, cc: float, most: float) -> Outline:
    axes = semi_axes(aa, bb, cc)
    return _ellipsoid(*(axes * min(1.0, most / max(float(axes.max()), 1e-300))))


_MAKE: Mapping[str, Callable[..., Outline]] = {
    "box": _box,
    "plate": lambda a, b: Outline(np.array([[-a, -b, 0], [a, -b, 0], [a, b, 0], [-a, b, 0]]) / 2),
    "ellipsoid": _ellipsoid,
    "inertia": _inertia,
    "sphere": lambda radius: _ellipsoid(radius, radius, radius),
    "hemisphere": _hemisphere,
    "disk": lambda radius: Outline(circle(radius), (np.array([[0, 0, 0], [radius, 0, 0]]),)),
    "ring": lambda radius: Outline(circle(radius), holes=(circle(0.86 * radius),)),
    "cylinder": lambda radius, height: _frustum(radius, radius, height, 0.5),
    "cone": lambda radius, height: _frustum(radius, 0.0, height, 0.0),
    "frustum": lambda base, top, height: _frustum(base, top, height, 0.0),
    "torus": _torus,
    "capsule": _capsule,
    "sector": _sector,
    "arc": _sector,
    "triangle": lambda a, b: Outline(np.array([[0, 0, 0], [a, 0, 0], [0, b, 0]], dtype=float)),
    "half cylinder": _half_cylinder,
}
"""Outlines of each kind along the shape's own axes."""


def outline(item: Item, posed: Posed, most: float) -> Outline | None:
    """The outline of a solid at its position; None for other items. Ellipsoids of inertia have semi-axes of `most` at most."""
    if item.at is None or item.frame is None:
        return None
    if item.kind == "mesh":
        own = mesh(item.file)
    elif item.kind in _MAKE:
        sizes = {k: float(posed.scalars[n]) for k, n in item.sizes.items()}
        own = _MAKE[item.kind](**sizes, **({"most": most} if item.kind == "inertia" else {}))
    else:
        return None
    turn, at = posed.rotations[item.frame], posed.positions[item.at]

    def moved(points: tuple[Array, ...]) -> tuple[Array, ...]:
        return tuple(p @ turn.T + at for p in points)

    return Outline(own.cloud @ turn.T + at, moved(own.lines), moved(own.faces), moved(own.holes))


def hull(points: Array) -> Array:
    """The convex hull of points in the plane, in order."""
    order = points[np.lexsort((points[:, 1], points[:, 0]))]

    def half(line: Array) -> list[Array]:
        kept: list[Array] = []
        for p in line:
            while len(kept) > 1 and _left(kept[-2], kept[-1], p) <= 0:
                kept.pop()
            kept.append(p)
        return kept

    return np.array([*half(order)[:-1], *half(order[::-1])[:-1]])


def within(p: Array, border: Array) -> bool:
    """Whether a point of the plane is inside a convex border of either orientation."""
    ahead, off = np.roll(border, -1, axis=0) - border, p - border
    sides = ahead[:, 0] * off[:, 1] - ahead[:, 1] * off[:, 0]
    return bool((sides >= -1e-9).all() or (sides <= 1e-9).all())


def _left(a: Array, b: Array, c: Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def mesh(file: str) -> Outline:
    """The vertices of an STL or OBJ mesh; raises ModelError if there are none."""
    points = vertices_of(file)
    if not len(points):
        raise ModelError(f"Expected a mesh with vertices, got {file}, which has none that STL or OBJ would tell.")
    return Outline(np.unique(points, axis=0))
