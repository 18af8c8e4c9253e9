# SPDX-License-Identifier: BSD-3-Clause
"""The placement of parts at each instant: for each an affine map from its mesh to the scene, along the inertial axes.

rigid     x ↦ p + R diag(s) x
between   x ↦ p + Q diag(w, w, |q − p|) x,    Q e₃ = (q − p)/|q − p|
corners   x ↦ p + A x,                        A the axes of three points of the body
"""

from __future__ import annotations

import numpy as np

from kane.numeric.arrays import Array
from kane.present.scene.records import Posed
from kane.present.viewer.axes import axes_of, towards
from kane.present.viewer.parts import DrawnModel, Length


def transforms(model: DrawnModel, poses: Posed) -> Array:
    """The maps (instants × parts × 3 × 4): three columns of the matrix, then the translation."""
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
