# SPDX-License-Identifier: BSD-3-Clause
"""Triangles from files: STL, as text or binary, and the faces of OBJ."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np

from kane.errors import ArgumentError, ModelError, cut
from kane.numeric.arrays import Array
from kane.present.viewer.meshes import Mesh, unit_rows

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
