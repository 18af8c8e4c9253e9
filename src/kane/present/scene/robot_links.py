# SPDX-License-Identifier: BSD-3-Clause
"""The shapes of links of an imported robot, as shapes of bodies."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from kane import expect
from kane.errors import ArgumentError
from kane.interop.imported import Imported
from kane.interop.robots.records import LinkShape
from kane.model.bodies import RigidBody
from kane.present.scene.shapes import KINDS, MESHES, BodyShape, shape
from kane.space.frame import Frame, Point

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
