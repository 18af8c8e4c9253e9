# SPDX-License-Identifier: BSD-3-Clause
"""A motion as glTF 2.0, in one binary file: one node for each part, with animated translation, rotation and scale.

The upward direction of the scene is rotated to +y, that of glTF. Lengths are those of the model.
"""

import json
import struct
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from kane.numeric.arrays import Array
from kane.present.viewer.page import PosedMotion
from kane.present.viewer.parts import DrawnModel, colour_of, towards, transforms

_FLOAT, _UINT = 5126, 5125
_VERTICES, _INDICES = 34962, 34963


class _Buffer:
    """Binary data with accessors."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, values: Any, kind: str, target: int | None = None, bounds: bool = False) -> int:
        """Append an array, and return the index of its accessor."""
        array = np.ascontiguousarray(values, dtype="<u4" if kind == "SCALAR" and target == _INDICES else "<f4")
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes}
        self.views.append(view | ({"target": target} if target else {}))
        self.data += array.tobytes()
        accessor: dict[str, Any] = {
            "bufferView": len(self.views) - 1,
            "componentType": _UINT if array.dtype.kind == "u" else _FLOAT,
            "count": len(array),
            "type": kind,
        }
        if bounds:
            columns = array.reshape(len(array), -1)
            accessor |= {"min": columns.min(axis=0).tolist(), "max": columns.max(axis=0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def binary(model: DrawnModel, course: PosedMotion) -> bytes:
    """The content of the file for a motion."""
    buffer = _Buffer()
    names = list(model.meshes)
    shapes = {name: _attributes(model, name, buffer) for name in names}
    used = list(dict.fromkeys((p.mesh, colour_of(model, p)) for p in model.parts))
    colours = list(dict.fromkeys(c for _, c in used))
    meshes = [
        {"name": mesh, "primitives": [{**shapes[mesh], "material": colours.index(colour)}]} for mesh, colour in used
    ]
    places = transforms(model, course.poses)
    times = buffer.add(course.times - course.times[0], "SCALAR", bounds=True) if len(course.times) > 1 else None
    nodes: list[dict[str, Any]] = []
    samplers: list[dict[str, Any]] = []
    channels: list[dict[str, Any]] = []
    for k, part in enumerate(model.parts):
        moves = dict(zip(("translation", "rotation", "scale"), _decomposed(places[:, k]), strict=True))
        node: dict[str, Any] = {"name": part.name, "mesh": used.index((part.mesh, colour_of(model, part)))}
        node |= {key: values[0].tolist() for key, values in moves.items()}
        for path, values in moves.items():
            if times is not None and np.ptp(values, axis=0).max() > 0:
                output = buffer.add(values, "VEC4" if path == "rotation" else "VEC3")
                samplers.append({"input": times, "output": output, "interpolation": "LINEAR"})
                channels.append({"sampler": len(samplers) - 1, "target": {"node": k, "path": path}})
        nodes.append(node)
    turned = Rotation.from_matrix(towards(model.up[None])[0].T).as_matrix()
    upright = Rotation.from_matrix(np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]) @ turned).as_quat()
    nodes.append({"name": "scene", "children": list(range(len(model.parts))), "rotation": upright.tolist()})
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "kane"},
        "scene": 0,
        "scenes": [{"nodes": [len(nodes) - 1]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [_material(c) for c in colours],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.data)}],
    }
    if channels:
        document["animations"] = [{"name": "motion", "samplers": samplers, "channels": channels}]
    return _chunks(document, bytes(buffer.data))


def _attributes(model: DrawnModel, name: str, buffer: _Buffer) -> dict[str, Any]:
    mesh = model.meshes[name]
    shade = np.repeat((0.72 + 0.28 * mesh.tones)[:, None], 3, axis=1)
    return {
        "attributes": {
            "POSITION": buffer.add(mesh.vertices, "VEC3", _VERTICES, bounds=True),
            "NORMAL": buffer.add(mesh.normals, "VEC3", _VERTICES),
            "COLOR_0": buffer.add(shade, "VEC3", _VERTICES),
        },
        "indices": buffer.add(mesh.triangles.reshape(-1), "SCALAR", _INDICES),
    }


def _material(colour: str) -> dict[str, Any]:
    rgb = [(int(colour[k : k + 2], 16) / 255) ** 2.2 for k in (1, 3, 5)]
    return {"pbrMetallicRoughness": {"baseColorFactor": [*rgb, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.55}}


def _decomposed(places: Array) -> tuple[Array, Array, Array]:
    """Translations, rotations as quaternions (x, y, z, w) of continuous sign, and scales."""
    columns, shift = places[:, :, :3], places[:, :, 3]
    scale = np.linalg.norm(columns, axis=1)
    axes = np.divide(
        columns, scale[:, None, :], out=np.broadcast_to(np.eye(3), columns.shape).copy(), where=scale[:, None, :] > 0
    )
    quaternions = Rotation.from_matrix(axes).as_quat()
    turns = np.sign(np.sum(quaternions[1:] * quaternions[:-1], axis=1))
    quaternions[1:] *= np.cumprod(np.where(turns < 0, -1.0, 1.0))[:, None]
    return shift, quaternions, scale


def _chunks(document: dict[str, Any], data: bytes) -> bytes:
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body
