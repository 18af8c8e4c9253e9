# SPDX-License-Identifier: BSD-3-Clause
"""The parts of a drawn scene: meshes, and how the numbers of a pose place them along the inertial axes.

A part is *rigid* (a mesh at a position, along axes, scaled by lengths), *between* two positions (a mesh from 0 to 1 along z), or
placed by three of its *corners*. The thickness of lines is proportional to the scene's size.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from kane.numeric.arrays import Array
from kane.numeric.scale import DECLARED
from kane.present.scene.records import Item, Posed, Scene
from kane.present.viewer.meshes import SIZED, THICK, UNIT, Mesh, flat, read

THIN = 0.016
"""Radius of a link, relative to the scene's size."""
_WIDE = {
    "link": 1.0, "beam": 0.8, "bar": 0.5, "arm": 0.5, "rope": 0.35, "rod": 1.0, "spring": 2.2,
    "damper": 1.6, "particle": 2.2, "ball": 3.0, "pin": 1.5,
    "inertia": 1.0,
}  # fmt: skip
"""Widths of lines and balls relative to a link."""
_THICK = 0.15
"""Thickness of plane shapes, relative to the scene's size."""
_FAR = 4.0
"""Distance, in sizes of the scene, beyond which a motion travels."""
_HALF = ("radius", "base", "top", "tube")
"""Sizes measured from a centre."""
_NO_LENGTHS = ("aa", "bb", "cc", "half_angle")
_BLOCK = 5.0
"""Edge of a sliding block, relative to a link's radius."""

BODIES = ("#2563a8", "#0f766e", "#7c4dbd", "#b45309", "#be3a6e", "#567d0c")
ROLES = {"ground": "#6b7076", "constraint": "#70757a", "load": "#c2410c"}
"""Colours of the page: bodies in turn, other items by role."""

Length = tuple[int, float, bool]
"""A scalar's index (−1 for none), a factor, and whether the root is taken: factor·s, factor·√s, or the factor alone."""


@dataclass(frozen=True, slots=True, eq=False)
class DrawnPart:
    """A mesh by name, and the indices that place it; `kind` is "rigid", "between", "corners" or "plane"."""

    kind: str
    name: str
    role: str
    mesh: str
    at: int = -1
    axes: int = -1
    to: int = -1
    along: int = -1
    scale: tuple[Length, Length, Length] = ((-1, 1.0, False),) * 3
    points: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class DrawnModel:
    """Parts and their meshes.

    `size` is that of the scene at one instant, `middle` and `reach` (a radius) are those of the whole motion, or of its first
    instant if it `travels` too far to be shown whole. `up` is the direction opposite to gravity.
    """

    parts: tuple[DrawnPart, ...]
    meshes: dict[str, Mesh]
    planes: tuple[DrawnPart, ...]
    size: float
    middle: Array
    reach: float
    travels: bool
    up: Array
    arrows: tuple[tuple[str, int, int], ...] = field(default=())
    touching: tuple[int, ...] = ()

    def scales(self) -> list[tuple[int, ...]]:
        """Groups of the directions of arrows with a common scale: those of contacts, to compare normal and friction forces."""
        return [self.touching, *((d,) for _, _, d in self.arrows if d not in self.touching)]


def colour_of(model: DrawnModel, part: DrawnPart) -> str:
    """The colour of a part."""
    if part.role != "body":
        return ROLES.get(part.role, ROLES["ground"])
    bodies = list(dict.fromkeys(p.name for p in model.parts if p.role == "body"))
    return BODIES[bodies.index(part.name) % len(BODIES)]


def model(scene: Scene, poses: Posed, up: Array) -> DrawnModel:
    """The parts of a scene; sizes that are not scaled are those of the first pose."""
    size, middle, reach, travels = _extent(scene, poses, up)
    meshes: dict[str, Mesh] = {}
    parts: list[DrawnPart] = []
    planes: list[DrawnPart] = []
    build = _PartBuilder(poses.scalars[0], size, poses.positions[0], meshes)
    for item in scene.items:
        (planes if item.kind == "plane" else parts).extend(_PARTS[item.kind](item, build))
    arrows = tuple((a.label, a.at, a.direction) for a in scene.actions if a.kind in ("force", "contact"))
    touching = tuple(a.direction for a in scene.actions if a.kind == "contact")
    return DrawnModel(tuple(parts), meshes, tuple(planes), size, middle, reach, travels, up, arrows, touching)


_STANDS = 0.65
"""Reach per height: at this distance a screen shows 0.93 of the reach above and below the middle, less the size of parts."""


def _extent(scene: Scene, poses: Posed, up: Array) -> tuple[float, Array, float, bool]:
    """Size, middle, reach, and whether the motion travels."""
    p = poses.positions[:, scene.seen]
    finite = p[np.isfinite(p).all(axis=(1, 2))]
    sizes = [pair for item in scene.items for pair in item.sizes.items() if pair[0] not in _NO_LENGTHS]
    own = max((abs(float(poses.scalars[0, k])) * (1 + (name in _HALF)) for name, k in sizes), default=0.0)
    if not finite.size:
        return own or 1.0, np.zeros(3), own or 1.0, False
    low, high = finite.min(axis=1), finite.max(axis=1)
    size = max(float(np.median(np.linalg.norm(high - low, axis=1))), own) or 1.0
    whole = float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))
    travels = whole > _FAR * size
    first = (low[0], high[0]) if travels else (low.min(axis=0), high.max(axis=0))
    across = first[1] - first[0]
    height = float(np.abs(across * up).sum())
    reach = max(0.5 * float(np.linalg.norm(across)) + 0.25 * own, 0.72 * size, _STANDS * height)
    return size, np.asarray(first[0] + first[1]) / 2, reach, travels


def _fixed(value: float) -> Length:
    return (-1, float(value), False)


def _size(item: Item, *names: str, root: bool = False) -> tuple[Length, ...]:
    return tuple((item.sizes[k], 1.0, root) for k in names)


@dataclass(frozen=True, slots=True, eq=False)
class _PartBuilder:
    """Data for building parts: sizes and positions in the first pose, the size of the scene, and the meshes, to which builders add."""

    sizes: Array
    size: float
    positions: Array
    meshes: dict[str, Mesh]

    @property
    def thin(self) -> float:
        return THIN * self.size

    def rigid(self, item: Item, mesh: str, *scale: Length, **more: Any) -> DrawnPart:
        """A part at the item's position and along its axes, unless given otherwise."""
        if mesh not in self.meshes:
            self.meshes[mesh] = UNIT[mesh]()
        given = {"kind": "rigid", "at": _or_none(item.at), "axes": _or_none(item.frame), "scale": scale, **more}
        return DrawnPart(name=item.name, role=item.role, mesh=mesh, **given)

    def wide(self, item: Item) -> Length:
        """The width of a line or a ball."""
        return _fixed(self.thin * _WIDE.get(item.kind, 1.0))


def _or_none(number: int | None) -> int:
    return -1 if number is None else number


def _line(item: Item, b: _PartBuilder) -> Iterator[DrawnPart]:
    mesh, wide = item.kind if item.kind in ("spring", "damper") else "tube", b.wide(item)
    for p, q in pairwise(item.points):
        yield b.rigid(item, mesh, wide, wide, _fixed(1.0), kind="between", at=p, to=q)
    for p in item.points if item.kind in ("link", "beam") else ():
        yield b.rigid(item, "ball", wide, wide, wide, at=p, axes=-1)


def _scaled(mesh: str, *names: str) -> Callable[[Item, _PartBuilder], Iterator[DrawnPart]]:
    """A unit mesh, scaled by sizes with these names; "" means thin."""

    def parts(item: Item, b: _PartBuilder) -> Iterator[DrawnPart]:
        yield b.rigid(item, mesh, *(_size(item, k)[0] if k else _fixed(b.thin) for k in names))

    return parts


def _disk(item: Item, b: _PartBuilder) -> Iterator[DrawnPart]:
    thick = _fixed(0.12 * float(b.sizes[item.sizes["radius"]]))
    yield b.rigid(item, "cylinder", *_size(item, "radius", "radius"), thick)


def _inertia(item: Item, b: _PartBuilder) -> Iterator[DrawnPart]:
    yield b.rigid(item, "sphere", *_size(item, "aa", "bb", "cc", root=True))


def _ball(item: Item, b: _PartBuilder) -> Iterator[DrawnPart]:
    yield b.rigid(item, "ball", *3 * [b.wide(item)], axes=-1)


def _block(item: Item, b: _PartBuilder) -> Iterator[DrawnPart]:
    edge, wheel = _fixed(_BLOCK * b.thin), item.kind == "wheel"
    thick = _fixed(2 * b.thin) if wheel else edge
    yield b.rigid(item, "cylinder" if wheel else "box", edge, edge, thick, axes=-1, along=_or_none(item.direction))


def _file(item: Item, b: _PartBuilder) -> Iterator[DrawnPart]:
    yield _baked(item, item.file, b, lambda: read(item.file))


def _plane(item: Item, b: _PartBuilder) -> Iterator[DrawnPart]:
    yield DrawnPart("plane", item.name, item.role, "", _or_none(item.at), along=_or_none(item.direction))


def _ring(item: Item, b: _PartBuilder) -> Iterator[DrawnPart]:
    radius = float(b.sizes[item.sizes["radius"]])
    yield _baked(item, f"ring {radius:.9g}", b, lambda: SIZED["torus"][0](radius, 0.06 * radius))


def _sized(item: Item, b: _PartBuilder) -> Iterator[DrawnPart]:
    make, names = SIZED[item.kind]
    values = [float(b.sizes[item.sizes[k]]) for k in names] + ([2 * b.thin] if item.kind in THICK else [])
    yield _baked(item, " ".join([item.kind, *(f"{x:.9g}" for x in values)]), b, lambda: make(*values))


def _baked(item: Item, name: str, b: _PartBuilder, make: Callable[[], Mesh]) -> DrawnPart:
    if name not in b.meshes:
        b.meshes[name] = make()
    return b.rigid(item, name, *3 * [_fixed(1.0)])


def _hull(item: Item, b: _PartBuilder) -> Iterator[DrawnPart]:
    """The convex hull of points of a body, with a thickness if they are coplanar; a line if they are collinear."""
    p = b.positions[list(item.points)]
    third = _off_line(p)
    if third is None:
        yield from _line(replace(item, kind="link"), b)
        return
    own = axes_of(p[0], p[1], p[third])
    local = (p - p[0]) @ own
    if np.abs(local[:, 2]).max() < DECLARED * b.size:
        thick = np.array([0.0, 0.0, _THICK * b.size / 2])
        local = np.concatenate([local - thick, local + thick])
    name = f"hull {item.name}"
    hull = ConvexHull(local)
    outward = [
        face if n[:3] @ np.cross(*(local[face[1:]] - local[face[0]])) > 0 else face[::-1]
        for face, n in zip(hull.simplices, hull.equations, strict=True)
    ]
    b.meshes[name] = flat(local, [face.tolist() for face in outward])
    yield DrawnPart(
        "corners", item.name, item.role, name, item.points[0], points=tuple(item.points[k] for k in (0, 1, third))
    )


def _off_line(p: Array) -> int | None:
    """The index of a point that is not on the line of the first two; None if all are."""
    size = np.abs(p - p[0]).max(initial=0.0)
    away = [float(np.linalg.norm(np.cross(p[1] - p[0], x - p[0]))) for x in p] if len(p) > 2 else []
    k = int(np.argmax(away)) if away else 0
    return k if away and away[k] > DECLARED * size * size else None


_PARTS: dict[str, Callable[[Item, _PartBuilder], Iterator[DrawnPart]]] = {
    **dict.fromkeys(("link", "beam", "bar", "arm", "rope", "spring", "damper"), _line),
    **dict.fromkeys(("particle", "pin", "ball"), _ball),
    **dict.fromkeys(("block", "slider", "wheel"), _block),
    **dict.fromkeys(SIZED, _sized),
    "box": _scaled("box", "a", "b", "c"),
    "plate": _scaled("box", "a", "b", ""),
    "ellipsoid": _scaled("sphere", "a", "b", "c"),
    "sphere": _scaled("sphere", *3 * ["radius"]),
    "hemisphere": _scaled("hemisphere", *3 * ["radius"]),
    "cylinder": _scaled("cylinder", "radius", "radius", "height"),
    "cone": _scaled("cone", "radius", "radius", "height"),
    "rod": _scaled("cylinder", "", "", "length"),
    "disk": _disk,
    "ring": _ring,
    "inertia": _inertia,
    "hull": _hull,
    "mesh": _file,
    "plane": _plane,
}
"""The builder of each kind of item."""


def towards(way: Array) -> Array:
    """Rotations with the third column along `way` (… × 3), and the first as near as possible to the first axis, or to the second."""
    size = np.linalg.norm(way, axis=-1, keepdims=True)
    z = np.divide(way, size, out=np.zeros_like(way) + np.array([0.0, 0.0, 1.0]), where=size > 0)
    near = np.where(np.abs(z[..., :1]) < 0.9, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    x = near - z * np.sum(near * z, axis=-1, keepdims=True)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=-1)


def axes_of(a: Array, b: Array, c: Array) -> Array:
    """Rotations from three points (… × 3) that are not collinear: the first column from a to b, the third normal to their plane."""
    x = b - a
    z = np.cross(x, c - a)
    x, z = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (x, z))
    return np.stack([x, np.cross(z, x), z], axis=-1)


def transforms(model: DrawnModel, poses: Posed) -> Array:
    """The affine maps from meshes to the scene (instants × parts × 3 × 4): three columns of the matrix, then the translation.

    rigid     x ↦ p + R diag(s) x
    between   x ↦ p + Q diag(w, w, |q − p|) x,    Q e₃ = (q − p)/|q − p|
    corners   x ↦ p + A x,                        A the axes of three points of the body
    """
    positions, count = poses.positions, len(poses.positions)
    out = np.zeros((count, len(model.parts), 3, 4))
    for k, part in enumerate(model.parts):
        scale = np.stack([_length(x, poses.scalars) for x in part.scale], axis=-1)
        start = positions[:, part.at]
        if part.kind == "between":
            way = positions[:, part.to] - start
            size = np.linalg.norm(way, axis=-1)
            turned = towards(way)
            scale = scale * np.stack([np.ones(count), np.ones(count), size], axis=-1)
        elif part.kind == "corners":
            turned = axes_of(*(positions[:, p] for p in part.points))
        elif part.along >= 0:
            turned = towards(poses.directions[:, part.along])
        else:
            turned = poses.rotations[:, part.axes] if part.axes >= 0 else np.broadcast_to(np.eye(3), (count, 3, 3))
        out[:, k, :, :3] = turned * scale[:, None, :]
        out[:, k, :, 3] = start
    return out


def _length(length: Length, scalars: Array) -> Array:
    number, factor, root = length
    if number < 0:
        return np.full(len(scalars), factor)
    value = scalars[:, number]
    if root:  # semi-axes of the ellipsoid of inertia, not a number without mass
        value = np.sqrt(np.where(np.isfinite(value), np.maximum(value, 0.0), 0.0))
    return np.asarray(factor * value)
