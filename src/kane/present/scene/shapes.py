# SPDX-License-Identifier: BSD-3-Clause
"""Shapes of bodies: declared, or taken from the solids of inertias. They do not affect equations."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kane import expect
from kane.errors import ArgumentError, ModelError
from kane.expr.node import ZERO, Expr
from kane.expr.ops import Immutable
from kane.interop.imported import Imported
from kane.interop.robots.records import LinkShape
from kane.model.bodies import Body, RigidBody
from kane.model.constraints import check_unit
from kane.model.solids import Inertia
from kane.numeric.sampling import SEED, not_negative, sample
from kane.present.scene.records import Item, Quantities
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

KINDS: dict[str, tuple[str, ...]] = {
    "box": ("a", "b", "c"),
    "plate": ("a", "b"),
    "ellipsoid": ("a", "b", "c"),
    "sphere": ("radius",),
    "hemisphere": ("radius",),
    "disk": ("radius",),
    "ring": ("radius",),
    "cylinder": ("radius", "height"),
    "cone": ("radius", "height"),
    "frustum": ("base", "top", "height"),
    "torus": ("radius", "tube"),
    "capsule": ("radius", "length"),
    "rod": ("length",),
    "sector": ("radius", "half_angle"),
    "triangle": ("a", "b"),
    "link": (),
    "spring": (),
    "damper": (),
    "rope": (),
    "plane": (),
    "mesh": (),
}
"""The names of the sizes of each kind of shape."""
MESHES = (".stl", ".obj")
"""Endings of mesh files."""
_FROM_POINTS = ("link", "spring", "damper", "rope")
_SOLIDS = {
    "thin disk": "disk",
    "solid sphere": "sphere",
    "spherical shell": "sphere",
    "solid cylinder": "cylinder",
    "cylindrical shell": "cylinder",
    "solid cone": "cone",
    "rectangular plate": "plate",
    "right triangle": "triangle",
    "half cylinder": "half cylinder",
    "circular sector": "sector",
    "circular arc": "arc",
    **{kind: kind for kind in ("ring", "rod", "torus", "frustum", "hemisphere", "box", "ellipsoid")},
}
"""The kind of shape for each solid of `kn.solids`."""


@dataclass(frozen=True, slots=True, eq=False)
class BodyShape(Immutable):
    """A declared shape; see `kn.figures.shape`."""

    kind: str
    of: Body | None
    sizes: Mapping[str, Expr]
    frame: Frame | None
    at: Point | None
    axis: Vector | None
    points: tuple[Point, ...]
    file: str
    name: str


def shape(
    kind: str,
    of: Body | None = None,
    *,
    frame: Frame | None = None,
    at: Point | None = None,
    axis: Vector | None = None,
    points: Sequence[Point] = (),
    file: str | Path = "",
    name: str = "",
    **sizes: Any,
) -> BodyShape:
    """The shape of a body, or of another object, for drawings alone; equations do not depend on it.

    Parameters
    ----------
    kind : "box", "cylinder", "sphere", "link", …
    of : the body; declared shapes replace those derived from its inertia
    frame, at : frame and centre of the shape; by default the frame and mass centre of the body
    axis : unit vector along the axis of a body of revolution, or normal to a plane; by default z of the frame
    points : the points that a link, spring, damper or rope connects
    file : STL or OBJ file of a mesh, in metres along the axes of the frame from `at`
    name : by default that of the body
    sizes : dimensions of this kind, by name (m): a, b, c along x, y, z, radius, height, … as in `kn.solids`

    Raises
    ------
    ModelError
        if the kind is unknown, neither body nor place is given, or `sizes` are not those of the kind
    """
    wanted = KINDS[expect.one_of(kind, KINDS, "the kind of a shape,")]
    if set(sizes) != set(wanted):
        said, came = ", ".join(wanted) or "no sizes", ", ".join(sizes) or "none"
        raise ModelError(f"Expected {said} for a {kind}, got {came}. See kn.figures.shape.")
    for given, wanted_type, told in (
        (of, Body, "a body as of="),
        (frame, Frame, "a frame as frame="),
        (at, Point, "a point as at="),
        (file, str | Path, "a path as file="),
    ):
        expect.that(given is None or isinstance(given, wanted_type), f"{told} of the {kind}", given)
    parts = of.parts() if of is not None else ()
    frame = frame or next((p.frame for p in parts if p.frame is not None), None)
    at = at or next((p.mass_center for p in parts), None)
    through = expect.instances(points, Point, f"points of the {kind}", "Write [P, Q].")
    if kind in _FROM_POINTS:
        expect.that(len(through) > 1, f"points=[P, Q, …] of the {kind}", came=f"{len(through)} points")
    elif at is None or (frame is None and kind not in ("sphere", "plane")):
        raise ModelError(f"Expected a position of the {kind}: of=body, or frame= and at=, got neither.")
    if axis is not None:
        check_unit(axis, f"axis of the {kind}")
    if kind == "mesh":
        expect.that(Path(file).suffix.lower() in MESHES, "file= of a mesh as STL or OBJ", str(file))
    label = name or (of.name if of is not None else kind)
    lengths = {k: not_negative(sizes[k], f"{k}= of the {kind}") for k in wanted}
    return BodyShape(kind, of, lengths, frame, at, axis, through, str(file), label)


def shapes_of(given: Iterable[BodyShape]) -> tuple[BodyShape, ...]:
    """Declared shapes, checked."""
    return expect.instances(given, BodyShape, "shapes= as shapes of kn.figures.shape", "Write [kn.figures.shape(…)].")


def declared_item(s: BodyShape, into: Quantities) -> Item:
    """A declared shape as an item."""
    if s.kind in _FROM_POINTS:
        return Item(s.kind, s.name, "body", points=tuple(map(into.position, s.points)))
    assert s.at is not None
    sizes = {k: into.scalar(e) for k, e in s.sizes.items()}
    home, axes = s.frame or into.inertial, None
    if s.frame is not None or s.axis is not None:
        axes = into.frame(home) if s.axis is None else along(into, home, s.axis)
    role = "ground" if s.kind == "plane" and s.of is None else "body"
    normal = None if s.kind != "plane" else into.direction(s.axis or home.z)
    return Item(s.kind, s.name, role, into.position(s.at), axes, (), sizes, normal, s.file)


def along(into: Quantities, frame: Frame, axis: Vector, towards: Vector | None = None) -> int:
    """The index of axes with `axis` third and `towards` first, by default axes of the frame permuted."""
    own = (frame.x, frame.y, frame.z)
    if towards is not None:
        return into.axes(towards, axis.cross(towards), axis)
    for i, e in enumerate(own):
        if all(a is b for a, b in zip(axis.components(frame), e.components(frame), strict=True)):
            return into.axes(own[(i + 1) % 3], own[(i + 2) % 3], own[i])
    e = own[int(np.argmin(np.abs(sample(list(axis.components(frame)), SEED))))]
    first = e.cross(axis).normalized()
    return into.axes(first, axis.cross(first), axis)


def solid_item(body: RigidBody, into: Quantities) -> Item | None:
    """The item for the solid of a body's inertia; None for an inertia that is not that of a solid."""
    solid = body.inertia.shape if isinstance(body.inertia, Inertia) else None
    kind = None if solid is None else _SOLIDS.get(solid.kind)
    if solid is None or kind is None:
        return None
    sizes = {k: into.scalar(e) for k, e in solid.sizes.items()}
    at = into.position(body.mass_center, -solid.centroid)
    towards = solid.centroid.normalized() if kind in ("half cylinder", "sector", "arc") else None
    axes = into.frame(solid.frame) if solid.axis is None else along(into, solid.frame, solid.axis, towards)
    return Item(kind, body.name, "body", at, axes, (), sizes)


def ellipsoid_item(body: RigidBody, into: Quantities) -> Item:
    """The uniform ellipsoid with a body's mass and inertia along its axes: a² = max(0, 5 (I_yy + I_zz − I_xx)/(2 m))."""
    own = body.inertia.frames()
    frame = own[0] if len(own) == 1 and isinstance(own[0], Frame) else body.frame
    rows = body.inertia.components(frame).rows
    moments = [rows[k][k] for k in range(3)]
    total = moments[0] + moments[1] + moments[2]
    mass = body.mass
    sizes = {
        name: into.scalar(ZERO if mass is ZERO else 5 * (total - 2 * i) / (2 * mass))
        for name, i in zip(("aa", "bb", "cc"), moments, strict=True)
    }
    at = into.position(body.mass_center)
    return Item("inertia", body.name, "body", at, into.frame(frame), (), sizes)


_PLAIN = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def link_shapes(model: Imported) -> list[BodyShape]:
    """The shapes of the links in the file of a robot, for `shapes=` of `kn.figures.sketch`, `animate` and `kn.report`.

    Visual shapes are used, or collision shapes for links without them. Meshes are drawn if their files, STL or OBJ in metres,
    exist; shapes of other links are derived from inertias, points and joints.

    Parameters
    ----------
    model : from `kn.exchange.from_urdf` or `from_mjcf`; the list is empty for other models

    Raises
    ------
    ArgumentError
        if `model` is not an imported model
    """
    cure = "kn.from_urdf and kn.from_mjcf give one."
    expect.instance(model, Imported, "the model of an imported robot", cure, error=ArgumentError)
    places: Mapping[str, tuple[Frame, Point]] = model.extras.get("places", {})
    drawn: defaultdict[str, list[LinkShape]] = defaultdict(list)
    for s in model.extras.get("shapes", ()):
        if s.link in places and s.kind in KINDS and s.kind != "plane" and _is_there(s):
            drawn[s.link].append(s)
    result: list[BodyShape] = []
    for link, own in drawn.items():
        seen = [s for s in own if s.use == "visual"] or own
        body = next((b for b in model.system.rigid_bodies if b.name == model.extras["links"].get(link, link)), None)
        result += _placed(seen, body, *places[link])
    return result


def _is_there(s: LinkShape) -> bool:
    """Whether a shape can be drawn: a mesh needs its file, in metres."""
    if s.kind != "mesh":
        return len(s.size) == len(KINDS[s.kind])
    return s.size in ((), (1.0, 1.0, 1.0)) and Path(s.file).suffix.lower() in MESHES and Path(s.file).is_file()


def _placed(seen: list[LinkShape], body: RigidBody | None, frame: Frame, origin: Point) -> Iterator[BodyShape]:
    for k, s in enumerate(seen, 1):
        name = f"{s.link} shape {k}"
        axes = frame if s.rotation == _PLAIN else frame.rotate_matrix(name, s.rotation)
        x, y, z = s.offset
        at = origin.at(name, x * frame.x + y * frame.y + z * frame.z) if any(s.offset) else origin
        sizes: dict[str, Any] = dict(zip(KINDS[s.kind], s.size, strict=False))
        yield shape(s.kind, body, frame=axes, at=at, file=s.file, name=name if body is None else "", **sizes)
