# SPDX-License-Identifier: BSD-3-Clause
"""Triangles from files: STL, in text and binary, and the faces of OBJ."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from kane.errors import ArgumentError
from kane.numeric.arrays import Array
from kane.present.viewer.meshes import Mesh

_MOST = 200_000
"""Triangles of a file."""


def read(path: str) -> Mesh:
    """The triangles of a file, each with its own normal."""
    file = Path(path)
    if not file.is_file():
        raise ArgumentError(f"Expected a mesh file, got {path}, which is not there.")
    corners = (
        stl_corners(file.read_bytes()) if file.suffix.lower() == ".stl" else _obj(file.read_text("utf-8", "replace"))
    )
    if not 0 < len(corners) <= _MOST:
        raise ArgumentError(f"Expected 1 to {_MOST} triangles in {path}, got {len(corners)}.")
    n = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(n, axis=1, keepdims=True)
    n = np.divide(n, size, out=np.zeros_like(n), where=size > 0)
    count = 3 * len(corners)
    return Mesh(corners.reshape(-1, 3), np.repeat(n, 3, axis=0), np.zeros(count), np.arange(count).reshape(-1, 3))


def stl_corners(data: bytes) -> Array:
    """The corners of the triangles of an STL (n × 3 × 3)."""
    count = struct.unpack_from("<I", data, 80)[0] if len(data) >= 84 else 0
    if len(data) == 84 + 50 * count and count:
        record = np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
        return np.asarray(np.frombuffer(data, record, count, 84)["v"], dtype=float)
    words = data.decode("ascii", "replace").split()
    places = [k for k, w in enumerate(words) if w == "vertex"]
    numbers = [[float(x) for x in words[k + 1 : k + 4]] for k in places]
    return np.array(numbers, dtype=float).reshape(-1, 3, 3)


def _obj(text: str) -> Array:
    faces: list[tuple[int, int, int]] = []
    count = 0
    for line in text.splitlines():
        key, *words = line.split() or [""]
        count += key == "v"
        if key == "f":
            k = [int(w.split("/")[0]) for w in words]
            k = [i - 1 if i > 0 else count + i for i in k]
            faces += [(k[0], k[j], k[j + 1]) for j in range(1, len(k) - 1)]
    corners: Array = obj_vertices(text)[np.array(faces, dtype=int).reshape(-1, 3)]
    return corners


def obj_vertices(text: str) -> Array:
    """The vertices of an OBJ (n × 3)."""
    rows = [line.split()[1:4] for line in text.splitlines() if line.split()[:1] == ["v"]]
    return np.array(rows, dtype=float).reshape(-1, 3)
