# SPDX-License-Identifier: BSD-3-Clause
"""The data of a page with a scene in motion: plain data, packed arrays, and the markup of the canvas."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.present.pages import deflated
from kane.present.scene.records import Posed, Scene
from kane.present.viewer.meshes import UNIT, Mesh
from kane.present.viewer.parts import DrawnModel, DrawnPart


@dataclass(frozen=True, slots=True, eq=False)
class PosedMotion:
    """A motion at the displayed instants, its poses, and further columns of data, `extra`."""

    motion: Solution
    poses: Posed
    extra: Array | None = None

    @property
    def times(self) -> Array:
        """The instants (s)."""
        return self.motion.t

    def rows(self) -> Array:
        """One row for each instant: positions, axes of frames, directions, scalars, extra data."""
        p, n = self.poses, len(self.times)
        parts = [
            x.reshape(n, -1) for x in (p.positions, p.rotations.swapaxes(-1, -2), p.directions, p.scalars) if x.size
        ]
        return np.concatenate([*parts, *([] if self.extra is None else [self.extra])], axis=1)


def packed(values: Any, kind: str) -> str:
    """Numbers as text: little-endian, deflated, in base64."""
    return deflated(np.ascontiguousarray(values, dtype=kind).tobytes())


def packed_rows(rows: Array) -> str:
    """Rows of floats as text: bit differences of each column between rows, lowest bytes first, which deflate well."""
    bits = np.ascontiguousarray(rows.T, dtype="<f4").view("<u4")
    steps = np.diff(bits, axis=1, prepend=np.zeros((len(bits), 1), dtype="<u4"))
    return deflated(steps.reshape(-1, 1).view("u1").T.tobytes())


def _mesh(mesh: Mesh) -> dict[str, str]:
    return {
        "v": packed(mesh.vertices, "<f4"),
        "n": packed(mesh.normals, "<f4"),
        "t": packed(mesh.tones, "<f4"),
        "i": packed(mesh.triangles, "<u4"),
    }


def _part(part: DrawnPart, meshes: Sequence[str], bodies: Sequence[str]) -> dict[str, Any]:
    return {
        "k": part.kind, "n": part.name, "c": part.role, "m": meshes.index(part.mesh), "a": part.at, "x": part.axes, "q": part.to,
        "d": part.along, "s": [list(x) for x in part.scale], "p": list(part.points),
        "b": bodies.index(part.name) if part.name in bodies else 0,
    }  # fmt: skip


def page_data(
    scene: Scene, model: DrawnModel, courses: Sequence[PosedMotion], traces: Sequence[int], camera: Mapping[str, Any]
) -> dict[str, Any]:
    """The data of a page; `camera` has azimuth and elevation, and the direction `front` of azimuth 0."""
    names = list(model.meshes)
    bodies = list(dict.fromkeys(p.name for p in model.parts if p.role == "body"))
    meshes = [_mesh(model.meshes[name]) for name in names] + [_mesh(UNIT[name]()) for name in ("arrow", "tube")]
    largest = {d: max(_largest(courses, d) for d in beside) for beside in model.scales() for d in beside}
    return {
        "size": model.size, "middle": model.middle.tolist(), "up": model.up.tolist(), "front": list(camera["front"]),
        "camera": [camera["azimuth"], camera["height"]], "reach": model.reach, "travels": model.travels,
        "low": lowest(scene, model, courses),
        "counts": [len(scene.positions), len(scene.rotations), len(scene.directions), len(scene.scalars)],
        "extra": 0 if courses[0].extra is None else courses[0].extra.shape[1],
        "meshes": meshes, "arrow": len(names), "tube": len(names) + 1,
        "parts": [_part(p, names, bodies) for p in model.parts],
        "planes": [[p.at, p.along] for p in model.planes],
        "arrows": [[label, at, d, largest[d]] for label, at, d in model.arrows],
        "triads": [[t.frame, t.at, int(t.inertial)] for t in scene.triads], "traces": list(traces),
        "runs": [{"t": packed(c.times, "<f8"), "rows": packed_rows(c.rows())} for c in courses],
    }  # fmt: skip


def _largest(courses: Sequence[PosedMotion], direction: int) -> float:
    found = float(np.nanmax([np.nanmax(np.linalg.norm(c.poses.directions[:, direction], axis=-1)) for c in courses]))
    return found if np.isfinite(found) and found > 0 else 1.0


def lowest(scene: Scene, model: DrawnModel, courses: Sequence[PosedMotion]) -> float:
    """The height of the first declared plane at the start, or of a floor below all parts."""
    if model.planes:
        return float(courses[0].poses.positions[0, model.planes[0].at] @ model.up)
    return float(min(np.nanmin(c.poses.positions[:, scene.seen] @ model.up) for c in courses)) - 0.12 * model.size
