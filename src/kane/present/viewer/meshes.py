# SPDX-License-Identifier: BSD-3-Clause
"""Triangle meshes of shapes: unit meshes, which are scaled along their axes, those of given sizes, and those of files (STL, OBJ).

A body of revolution has its axis along z. The tone of a vertex, 0 or 1, alternates between quarters of round shapes, to show spin.
"""

import re
import struct
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import pairwise
from math import pi
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from kane.errors import ArgumentError, ModelError, cut
from kane.numeric.arrays import Array

ROUND = 40
"""Number of sides of round shapes."""


class Mesh(NamedTuple):
    """Vertices (n × 3), their normals, tones (n), and triangles (m × 3), counterclockwise as seen from outside."""

    vertices: Array
    normals: Array
    tones: Array
    triangles: npt.NDArray[np.intp]


def unit_rows(v: Array) -> Array:
    """Vectors (… × n) scaled to unit length; zero vectors remain zero."""
    size = np.linalg.norm(v, axis=-1, keepdims=True)
    return np.asarray(np.divide(v, size, out=np.zeros_like(v), where=size > 0))


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])[:-1]
    moved = [m._replace(triangles=m.triangles + k) for m, k in zip(meshes, starts, strict=True)]
    return Mesh(*map(np.concatenate, zip(*moved, strict=True)))


def flat(corners: Array, faces: Iterable[Sequence[int]]) -> Mesh:
    """Plane faces, each with its own normal."""
    vertices: list[Array] = []
    normals: list[Array] = []
    triangles: list[tuple[int, int, int]] = []
    for face in faces:
        p = corners[list(face)]
        n = unit_rows(np.cross(p[1] - p[0], p[2] - p[0]))
        start = len(vertices)
        vertices += list(p)
        normals += [n] * len(p)
        triangles += [(start, start + k, start + k + 1) for k in range(1, len(p) - 1)]
    return Mesh(np.array(vertices, float), np.array(normals, float), np.zeros(len(vertices)), np.array(triangles, int))


def box() -> Mesh:
    """The unit cube, centred at the origin."""
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return flat(corners, faces)


def lathe(profile: Sequence[tuple[float, float]], smooth: bool = False, sides: int = ROUND) -> Mesh:
    """The surface of revolution about z of a line (radius, z) that leads upward on the outside.

    Each segment of the line has its own normals unless it is `smooth`.
    """
    line = np.asarray(profile, dtype=float)
    steps = np.diff(line, axis=0)
    across = unit_rows(np.column_stack([steps[:, 1], -steps[:, 0]]))
    angles = np.arange(sides + 1) * 2 * pi / sides
    c, s = np.cos(angles), np.sin(angles)
    tones = (np.floor(4 * (np.arange(sides + 1) + 0.5) / sides) % 2).astype(float)
    meshes = []
    for k, ((r0, z0), (r1, z1)) in enumerate(pairwise(line)):
        n0 = n1 = across[k]
        if smooth:
            n0, n1 = unit_rows(n0 + across[[max(k - 1, 0), min(k + 1, len(across) - 1)]])
        rows = [np.column_stack([r * c, r * s, np.full_like(c, z)]) for r, z in ((r0, z0), (r1, z1))]
        normals = [np.column_stack([n[0] * c, n[0] * s, np.full_like(c, n[1])]) for n in (n0, n1)]
        vertices, normal = _quads(rows), _quads(normals)
        tone = np.repeat(tones[:-1], 4)
        first = 4 * np.arange(sides)[:, None]
        lower, upper = first + np.array([0, 1, 2]), first + np.array([0, 2, 3])
        triangles = np.concatenate([lower[: sides * (r0 > 0)], upper[: sides * (r1 > 0)]])
        meshes.append(Mesh(vertices, normal, tone, triangles))
    return joined(meshes)


def _quads(rows: Sequence[Array]) -> Array:
    """The corners of each side between two rings: (0, k), (0, k + 1), (1, k + 1), (1, k)."""
    a, b = rows
    return np.stack([a[:-1], a[1:], b[1:], b[:-1]], axis=1).reshape(-1, 3)


def cylinder(bottom: float = -0.5, top: float = 0.5) -> Mesh:
    """A cylinder of radius 1 between two heights."""
    return lathe([(0, bottom), (1, bottom), (1, top), (0, top)])


def _above(steps: int) -> list[tuple[float, float]]:
    """(radius, z) of the upper half of a unit sphere, upward."""
    return [*((float(np.cos(x)), float(np.sin(x))) for x in np.linspace(0, pi / 2, steps + 1)[:-1]), (0.0, 1.0)]


def _below(steps: int) -> list[tuple[float, float]]:
    return [(r, -z) for r, z in reversed(_above(steps))]


def sphere(sides: int = ROUND) -> Mesh:
    """The unit sphere."""
    return lathe([*_below(sides // 4), *_above(sides // 4)[1:]], True, sides)


def hemisphere() -> Mesh:
    """Half of the unit sphere, with the round side upward."""
    return joined([lathe(_above(ROUND // 4), smooth=True), lathe([(0, 0), (1, 0)])])


def cone() -> Mesh:
    """A cone of radius 1 and height 1, with its base at the origin."""
    return lathe([(0, 0), (1, 0), (0, 1)])


def frustum(base: float, top: float, height: float) -> Mesh:
    """A truncated cone with its base at the origin."""
    return lathe([(0, 0), (base, 0), (top, height), (0, height)])


def torus(radius: float, tube: float) -> Mesh:
    """A torus with the radii of its centre line and of its tube."""
    a = np.linspace(-pi, pi, ROUND // 2 + 1)
    return lathe([(radius + tube * float(np.cos(x)), tube * float(np.sin(x))) for x in a], smooth=True)


def capsule(radius: float, length: float) -> Mesh:
    """A cylinder of the given length with half spheres on its ends."""
    low = [(radius * r, radius * z - length / 2) for r, z in _below(ROUND // 4)]
    return lathe([*low, *((r, -z) for r, z in reversed(low))], smooth=True)


def spring() -> Mesh:
    """A wire along a helix of radius 1, from z = 0 to 1, to be stretched; its ends are on the axis."""
    turns, wire, sides = 8, 0.14, 8
    steps = turns * 16
    t = np.linspace(0, 1, steps + 1)
    angle, z = 2 * pi * turns * t, 0.06 + 0.88 * t
    line = np.column_stack([np.cos(angle), np.sin(angle), z])
    line = np.concatenate([[(0, 0, 0), (0, 0, 0.06)], line, [(0, 0, 0.94), (0, 0, 1)]])
    ahead = np.gradient(line, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    out = np.column_stack([line[:, 0], line[:, 1], np.zeros(len(line))]) + np.array([1e-3, 0, 0])
    out -= ahead * np.sum(out * ahead, axis=1, keepdims=True)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    side = np.cross(ahead, out)
    a = np.arange(sides + 1) * 2 * pi / sides
    rings = out[:, None] * np.cos(a)[None, :, None] + side[:, None] * np.sin(a)[None, :, None]
    flattened = rings * [wire, wire, wire / 6]  # stretching along z restores the round section
    vertices = (line[:, None] + flattened).reshape(-1, 3)
    n, m = len(line), sides + 1
    k = (np.arange(n - 1)[:, None] * m + np.arange(sides)).ravel()
    triangles = np.concatenate([np.column_stack([k, k + m + 1, k + 1]), np.column_stack([k, k + m, k + m + 1])])
    return Mesh(vertices, rings.reshape(-1, 3), np.zeros(len(vertices)), triangles[:, ::-1])


def damper() -> Mesh:
    """A rod in a cylinder, from z = 0 to 1."""
    pot = lathe([(0, 0.25), (1, 0.25), (1, 0.7), (0.35, 0.7)])
    return joined([pot, lathe([(0, 0), (0.3, 0), (0.3, 0.25)]), lathe([(0.3, 0.5), (0.3, 1), (0, 1)])])


def arrow() -> Mesh:
    """An arrow from z = 0 to 1; stretching scales the head too."""
    return lathe([(0, 0), (0.35, 0), (0.35, 0.78), (1, 0.78), (0, 1)], sides=20)


def prism(outline: Array, thickness: float) -> Mesh:
    """A plane outline (n × 2), counterclockwise, with a thickness about z = 0."""
    n = len(outline)
    low = np.column_stack([outline, np.full(n, -thickness / 2)])
    corners = np.concatenate([low, low + np.array([0, 0, thickness])])
    sides = [(k, (k + 1) % n, n + (k + 1) % n, n + k) for k in range(n)]
    return flat(corners, [tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides])


def _bow(half_angle: float) -> Array:
    """Points of an arc of radius 1, symmetric about x."""
    a = np.linspace(-half_angle, half_angle, 1 + max(4, int(ROUND * half_angle / pi)))
    return np.column_stack([np.cos(a), np.sin(a)])


def sector(radius: float, half_angle: float, thickness: float) -> Mesh:
    """A sector, symmetric about x."""
    return prism(np.concatenate([[(0, 0)], radius * _bow(half_angle)]), thickness)


def arc(radius: float, half_angle: float, thickness: float) -> Mesh:
    """A bent wire, symmetric about x, as wide as it is thick."""
    e = _bow(half_angle)
    return prism(np.concatenate([e * (radius + thickness / 2), e[::-1] * (radius - thickness / 2)]), thickness)


def triangle(a: float, b: float, thickness: float) -> Mesh:
    """A right triangle with legs along x and y."""
    return prism(np.array([(0, 0), (a, 0), (0, b)], float), thickness)


UNIT: dict[str, Callable[[], Mesh]] = {
    "box": box, "sphere": sphere, "ball": partial(sphere, 16), "hemisphere": hemisphere, "cylinder": cylinder, "cone": cone,
    "tube": partial(cylinder, 0.0, 1.0), "spring": spring, "damper": damper, "arrow": arrow,
}  # fmt: skip
"""Unit meshes, which are scaled along their axes."""
SIZED: dict[str, tuple[Callable[..., Mesh], tuple[str, ...]]] = {
    "frustum": (frustum, ("base", "top", "height")),
    "torus": (torus, ("radius", "tube")),
    "capsule": (capsule, ("radius", "length")),
    "sector": (sector, ("radius", "half_angle")),
    "arc": (arc, ("radius", "half_angle")),
    "triangle": (triangle, ("a", "b")),
    "half cylinder": (lambda radius, height, thickness=0.0: sector(radius, pi / 2, height), ("radius", "height")),
}
"""Meshes of given sizes, as scaling would distort them; plates also have a thickness."""
THICK = ("sector", "arc", "triangle")


_MOST = 200_000
"""Largest number of triangles of a file."""
_NAMES = re.compile(r"^\s*(?:end)?solid\b(?!.*\bfacet\b).*$", re.MULTILINE)
"""Lines of an STL that contain its name, unless facets follow on the same line."""


def read(path: str) -> Mesh:
    """The triangles of a file, each with its own normal."""
    corners = _read(path, _obj_corners)
    if not 0 < len(corners) <= _MOST:
        raise ArgumentError(f"Expected 1 to {_MOST} triangles in {path}, got {len(corners)}.")
    n = unit_rows(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    count = 3 * len(corners)
    return Mesh(corners.reshape(-1, 3), np.repeat(n, 3, axis=0), np.zeros(count), np.arange(count).reshape(-1, 3))


def vertices_of(path: str) -> Array:
    """The vertices of a file (n × 3), those of an OBJ without its faces."""
    return _read(path, _obj_vertices).reshape(-1, 3)


def _read(path: str, obj: Callable[[str], Array]) -> Array:
    """The content of a file: of an STL the corners of triangles, of an OBJ the result of `obj`."""
    file = Path(path)
    try:
        data = file.read_bytes()
        return obj(data.decode(errors="replace")) if file.suffix.lower() == ".obj" else _stl_corners(data)
    except OSError as error:
        raise ModelError(f"Expected a mesh that can be read, got {path}: {error.strerror}.") from error
    except (ValueError, IndexError) as error:
        raise ModelError(
            f"Expected a mesh as STL or OBJ, got {path}, where something is wrong: {cut(error)}."
        ) from error


def _stl_corners(data: bytes) -> Array:
    """The corners of the triangles of an STL (n × 3 × 3)."""
    count = struct.unpack_from("<I", data, 80)[0] if len(data) >= 84 else 0
    if len(data) == 84 + 50 * count and count:
        record = np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
        return np.asarray(np.frombuffer(data, record, count, 84)["v"], dtype=float)
    words = _NAMES.sub("", data.decode("ascii", "replace")).split()
    rows = [words[k + 1 : k + 4] for k, word in enumerate(words) if word == "vertex"]
    return np.array(rows, dtype=float).reshape(-1, 3, 3)


def _obj_corners(text: str) -> Array:
    faces: list[tuple[int, int, int]] = []
    count = 0
    for line in text.splitlines():
        key, *words = line.split() or [""]
        count += key == "v"
        if key == "f":
            k = [int(w.split("/")[0]) for w in words]
            k = [i - 1 if i > 0 else count + i for i in k]
            faces += [(k[0], k[j], k[j + 1]) for j in range(1, len(k) - 1)]
    corners: Array = _obj_vertices(text)[np.array(faces, dtype=int).reshape(-1, 3)]
    return corners


def _obj_vertices(text: str) -> Array:
    lines = map(str.split, text.splitlines())
    return np.array([words[1:4] for words in lines if words[:1] == ["v"]], dtype=float).reshape(-1, 3)
