# SPDX-License-Identifier: BSD-3-Clause
"""All rows of a system as one matrix on the twists of its bodies, and its factors in the metric of mass.

With T T^T the inverse of the mass matrix, A T = U S V^T. The least change of twists, or of poses, that alters
the residuals by b is T V S^-1 U^T b; what of U lies beyond the rank are the combinations of multipliers that
do nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tests.oracles.loops.jets import End
from tests.oracles.loops.joints import Joint, Rows
from tests.oracles.loops.records import GROUND, Body, Carried, Pose, Twist
from tests.oracles.tree import Array

RANK = 1e-8  # of the largest singular value: below this a row is redundant

Poses: TypeAlias = list[Pose]
Twists: TypeAlias = list[Twist]
_FREE = np.zeros(3)


@dataclass(frozen=True, slots=True)
class Stack:
    """Rows of all joints; `c` holds residuals of poses, `held` says which rows are their derivatives."""

    parts: tuple[Rows, ...]
    c: Array
    A: Array
    rate: Array
    bias: Array
    held: Array


def evaluate(joint: Joint, poses: Poses, twists: Twists, t: float) -> Rows:
    def motion(body: int) -> Carried:
        return joint.ground(t) if body == GROUND else Carried(poses[body], twists[body], _FREE, _FREE)

    slots = len(joint.bodies)
    marked = zip(joint.bodies, joint.marks, strict=True)
    return joint.law(tuple(End(mark, motion(body), slot, slots, t) for slot, (body, mark) in enumerate(marked)))


def stack(joints: list[Joint], poses: Poses, twists: Twists, t: float) -> Stack:
    parts = tuple(evaluate(joint, poses, twists, t) for joint in joints)
    A = np.zeros((sum(len(part.J) for part in parts), 6 * len(poses)))
    start = 0
    for joint, part in zip(joints, parts, strict=True):
        for slot, body in enumerate(joint.bodies):
            if body != GROUND:
                A[start : start + len(part.J), 6 * body : 6 * body + 6] += part.J[:, 6 * slot : 6 * slot + 6]
        start += len(part.J)
    none = [np.zeros(0)]
    return Stack(
        parts,
        np.concatenate([part.c for part in parts] + none),
        A,
        np.concatenate([part.rate for part in parts] + none),
        np.concatenate([part.bias for part in parts] + none),
        np.concatenate([np.arange(len(part.J)) < len(part.c) for part in parts] + none).astype(bool),
    )


def inverse_root(bodies: list[Body], poses: Poses) -> Array:
    """T with T T^T the inverse of the mass matrix."""
    T = np.zeros((6 * len(bodies), 6 * len(bodies)))
    for i, (body, pose) in enumerate(zip(bodies, poses, strict=True)):
        k = 6 * i
        T[k : k + 3, k : k + 3] = np.eye(3) / np.sqrt(body.mass)
        T[k + 3 : k + 6, k + 3 : k + 6] = pose.R @ np.linalg.inv(np.linalg.cholesky(body.inertia)).T
    return T


@dataclass(frozen=True, slots=True)
class Factors:
    T: Array
    U: Array  # all columns
    S: Array
    Vt: Array
    rank: int

    def change(self, b: Array) -> Array:
        """Least change of twists that alters the residuals by b, as nearly as they can be altered."""
        r = self.rank
        return np.asarray(self.T @ (self.Vt[:r].T @ ((self.U[:, :r].T @ b) / self.S[:r])))

    def multipliers(self, b: Array) -> Array:
        """The shortest ones that do it."""
        r = self.rank
        return np.asarray(self.U[:, :r] @ ((self.U[:, :r].T @ b) / self.S[:r] ** 2))

    def idle(self) -> Array:
        """Combinations of multipliers that do nothing, as columns."""
        return self.U[:, self.rank :]

    def condition(self) -> float:
        return float(self.S[0] / self.S[self.rank - 1]) if self.rank else 1.0


def factors(bodies: list[Body], poses: Poses, A: Array, rank: int | None = None) -> Factors:
    """Of the rank given, or of that which is found."""
    T = inverse_root(bodies, poses)
    U, values, Vt = np.linalg.svd(A @ T)
    found = int(np.sum(values > RANK * values.max(initial=0.0)))
    return Factors(T, U, values, Vt, found if rank is None else rank)
