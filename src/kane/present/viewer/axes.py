# SPDX-License-Identifier: BSD-3-Clause
"""Axes along a direction, and axes of three points."""

from __future__ import annotations

import numpy as np

from kane.numeric.arrays import Array


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
