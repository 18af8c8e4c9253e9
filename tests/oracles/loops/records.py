# SPDX-License-Identifier: BSD-3-Clause
"""What is given: bodies, their poses and twists, and the frames on them that joints hold.

Every point on a body counts from its mass centre, in its own axes; ``R`` turns body axes into inertial ones.
The inertial frame is body -1. A joint that holds it may say how it is carried, for walls and floors that move.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tests.oracles.tree import Array, skew

GROUND = -1


@dataclass(frozen=True, slots=True)
class Body:
    """Mass and inertia about the mass centre; both positive, as maximal coordinates invert them."""

    mass: float
    inertia: Array


@dataclass(frozen=True, slots=True)
class Pose:
    r: Array
    R: Array

    def at(self, point: Array) -> Array:
        """A point of the body in the inertial frame."""
        return self.r + self.R @ point

    def moved(self, shift: Array, turn: Array) -> Pose:
        """Shifted, and turned by a rotation vector; both in inertial axes."""
        return Pose(self.r + shift, exponential(turn) @ self.R)


@dataclass(frozen=True, slots=True)
class Twist:
    v: Array
    w: Array


@dataclass(frozen=True, slots=True)
class Carried:
    """Prescribed motion of a frame at one time."""

    pose: Pose
    twist: Twist
    a: Array
    alpha: Array


ORIGIN = Pose(np.zeros(3), np.eye(3))
REST = Twist(np.zeros(3), np.zeros(3))


def still(t: float) -> Carried:
    return Carried(ORIGIN, REST, np.zeros(3), np.zeros(3))


Ground = Callable[[float], Carried]


def turning(axis: Array, rate: float) -> Ground:
    """A turntable: about an axis through the inertial origin, at a constant rate."""
    w = rate * np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    return lambda t: Carried(Pose(np.zeros(3), exponential(w * t)), Twist(np.zeros(3), w), np.zeros(3), np.zeros(3))


@dataclass(frozen=True, slots=True)
class Mark:
    """A frame on a body: origin, and axes e1, e2, e3 as columns."""

    point: Array = field(default_factory=lambda: np.zeros(3))
    axes: Array = field(default_factory=lambda: np.eye(3))


def mark(point: Array, axis: Array, across: Array | None = None) -> Mark:
    """The frame with e3 along `axis` and e1 along what of `across` is perpendicular to it."""
    e3 = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    e1 = np.asarray(np.eye(3)[np.argmin(np.abs(e3))] if across is None else across, dtype=float)
    e1 = e1 - (e1 @ e3) * e3
    e1 = e1 / np.linalg.norm(e1)
    return Mark(np.asarray(point, dtype=float), np.column_stack([e1, np.cross(e3, e1), e3]))


def marks_at(poses: list[Pose], bodies: tuple[int, ...], point: Array, axis: Array) -> tuple[Mark, ...]:
    """The same frame, given in the inertial frame, as each of the bodies has it; its axes agree."""
    there = mark(point, axis)

    def on(body: int) -> Mark:
        pose = ORIGIN if body == GROUND else poses[body]
        return Mark(pose.R.T @ (there.point - pose.r), pose.R.T @ there.axes)

    return tuple(on(body) for body in bodies)


def cross(a: Array, b: Array) -> Array:
    """Of two single vectors, without what NumPy's own spends on shapes."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def exponential(turn: Array) -> Array:
    """Rotation matrix of a rotation vector."""
    angle, k = math.sqrt(float(turn @ turn)), skew(turn)
    half = np.sinc(angle / (2.0 * math.pi)) ** 2 / 2.0
    return np.asarray(np.eye(3) + np.sinc(angle / math.pi) * k + half * k @ k)
