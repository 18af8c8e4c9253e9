# SPDX-License-Identifier: BSD-3-Clause
"""Poses and twists as one vector, for integrators: r, quaternion (scalar first), v and w of each body."""

from __future__ import annotations

import math

import numpy as np

from tests.oracles.loops.records import Pose, Twist
from tests.oracles.loops.rows import Poses, Twists
from tests.oracles.tree import Array


def pack(poses: Poses, twists: Twists, near: Array | None = None) -> Array:
    """r, quaternion, v, w of each body; quaternions of the sign of those in `near`."""
    rows = [np.concatenate([p.r, quaternion(p.R), w.v, w.w]) for p, w in zip(poses, twists, strict=True)]
    y = np.array(rows)
    if near is not None:
        flip = np.sum(y[:, 3:7] * near.reshape(-1, 13)[:, 3:7], axis=1) < 0.0
        y[flip, 3:7] *= -1.0
    return y.reshape(-1)


def unpack(y: Array) -> tuple[Poses, Twists]:
    rows = y.reshape(-1, 13)
    return [Pose(row[:3], turned(row[3:7])) for row in rows], [Twist(row[7:10], row[10:]) for row in rows]


def turned(q: Array) -> Array:
    """Rotation matrix of a quaternion, scalar first, of any length."""
    w, x, y, z = q / math.sqrt(float(q @ q))
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def quaternion(R: Array) -> Array:
    """The inverse, through the largest of its four squares."""
    if (volume := float(np.linalg.det(R))) < 0.5:
        raise ValueError(
            f"Expected a rotation matrix, got one of determinant {volume:.3g}. Make its axes right-handed."
        )
    squares = np.array([np.trace(R), *np.diag(R)])
    k = int(np.argmax(squares))
    if k == 0:
        q = np.array([1.0 + squares[0], R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    else:
        i, j, m = k - 1, k % 3, (k + 1) % 3
        q = np.zeros(4)
        q[0] = R[m, j] - R[j, m]
        q[1 + i] = 1.0 + 2.0 * R[i, i] - np.trace(R)
        q[1 + j], q[1 + m] = R[i, j] + R[j, i], R[i, m] + R[m, i]
    return np.asarray(q / math.sqrt(float(q @ q)))
