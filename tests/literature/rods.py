# SPDX-License-Identifier: BSD-3-Clause
"""Mechanisms of uniform rods for the oracle of loops, from where their ends are."""

from __future__ import annotations

import numpy as np

from tests.oracles.loops import joints
from tests.oracles.loops.joints import Joint
from tests.oracles.loops.records import Body, Pose, Twist, mark, marks_at
from tests.oracles.loops.rows import Poses
from tests.oracles.tree import Array

X, Y, Z = np.eye(3)


def rod(mass: float, p: Array, q: Array, width: float = 0.0) -> tuple[Body, Pose]:
    """A prism of square section from p to q, along its own x; a thin one has some inertia about x, which no plane motion feels."""
    length = float(np.linalg.norm(q - p))
    across = mass * (length**2 + width**2) / 12
    about = mass * width**2 / 6 if width else across
    return Body(mass, np.diag([about, across, across])), Pose((p + q) / 2, mark(np.zeros(3), q - p).axes[:, [2, 0, 1]])


def pin(poses: Poses, pair: tuple[int, int], place: Array, axis: Array = Z) -> Joint:
    """A hinge between two bodies, at a place and along an axis of the inertial frame."""
    return Joint(pair, marks_at(poses, pair, place, axis), joints.pin)


class Ends:
    """Ends of rods in the plane with their velocities, from absolute angles and rates."""

    def __init__(self, p: Array, v: Array | None = None) -> None:
        self.p, self.v = np.asarray(p, dtype=float), np.zeros(3) if v is None else v

    def beyond(self, length: float, angle: float, rate: float) -> Ends:
        """The other end of a rod at `angle` from x."""
        way = length * np.array([np.cos(angle), np.sin(angle), 0.0])
        return Ends(self.p + way, self.v + rate * np.cross(Z, way))


def between(mass: float, p: Ends, q: Ends) -> tuple[Body, Pose, Twist]:
    """A rod in the plane with its motion."""
    body, pose = rod(mass, p.p, q.p)
    way = q.p - p.p
    spin = np.cross(way, q.v - p.v) / (way @ way)
    return body, pose, Twist((p.v + q.v) / 2, spin)
