# SPDX-License-Identifier: BSD-3-Clause
"""Accelerations and reactions at one state.

    M nu' = f + A^T lambda,   A nu' + bias = 0

Where rows are redundant, the multipliers are the shortest that do, and each reaction says which of its
components are the same for all that do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.oracles.loops.joints import Joint, Rows
from tests.oracles.loops.records import GROUND, Body, cross
from tests.oracles.loops.rows import Factors, Poses, Stack, Twists, factors, stack
from tests.oracles.tree import Array, skew

DETERMINATE = 1e-7  # of the joint's largest row


@dataclass(frozen=True, slots=True)
class Reaction:
    """What a joint exerts on the last of its bodies, in inertial axes.

    `doubt` has a column for each redundancy: force and torque may be off by any of their combinations, so a
    component d @ (force, torque) is determinate where d @ doubt vanishes.
    """

    force: Array
    torque: Array  # about the point
    point: Array
    doubt: Array  # (6, redundancies)
    determinate: Array  # (6,) of the components of force, then of torque


@dataclass(frozen=True, slots=True)
class Solution:
    a: Array  # (bodies, 3) of the mass centres
    alpha: Array  # (bodies, 3)
    multipliers: Array  # row by row, joint by joint
    determinate: Array  # which of the multipliers
    reactions: tuple[Reaction, ...]  # joint by joint
    rank: int
    redundancies: int
    freedom: int  # of the accelerations
    condition: float  # of the rows in the metric of mass, redundant ones apart
    inconsistency: float  # what of A nu' + bias cannot be made to vanish; rounding, if poses and twists fit
    drift: float  # largest residual of poses or rate


def solve(
    bodies: list[Body],
    joints: list[Joint],
    poses: Poses,
    twists: Twists,
    forces: Array | None = None,
    torques: Array | None = None,
    gravity: Array | None = None,
    t: float = 0.0,
    rank: int | None = None,
) -> Solution:
    """Accelerations and reactions; forces and torques (bodies, 3) act at and about the mass centres."""
    rows, split, wanted, rates = _accelerated(
        bodies, joints, poses, twists, loads(bodies, poses, twists, forces, torques, gravity), t, rank
    )
    multipliers, idle = split.multipliers(wanted), split.idle()
    reactions, start = [], 0
    for joint, part in zip(joints, rows.parts, strict=True):
        own = slice(start, start + len(part.J))
        reactions.append(_reaction(joint, part, poses, t, multipliers[own], idle[own]))
        start = own.stop
    pairs = rates.reshape(-1, 2, 3)
    return Solution(
        a=pairs[:, 0],
        alpha=pairs[:, 1],
        multipliers=multipliers,
        determinate=np.abs(idle).max(axis=1, initial=0.0) < DETERMINATE,
        reactions=tuple(reactions),
        rank=split.rank,
        redundancies=len(rows.A) - split.rank,
        freedom=6 * len(bodies) - split.rank,
        condition=split.condition(),
        inconsistency=float(np.abs(rows.A @ rates + rows.bias).max(initial=0.0)),
        drift=float(np.abs(np.concatenate([rows.c, rows.rate])).max(initial=0.0)),
    )


def accelerations(
    bodies: list[Body], joints: list[Joint], poses: Poses, twists: Twists, load: Array, t: float, rank: int | None
) -> Array:
    """(bodies, 2, 3): a and alpha alone, from what `loads` gives."""
    return _accelerated(bodies, joints, poses, twists, load, t, rank)[-1].reshape(-1, 2, 3)


def _accelerated(
    bodies: list[Body], joints: list[Joint], poses: Poses, twists: Twists, load: Array, t: float, rank: int | None
) -> tuple[Stack, Factors, Array, Array]:
    """Rows, their factors, by how much the rows ask the free accelerations to change, and accelerations."""
    rows = stack(joints, poses, twists, t)
    split = factors(bodies, poses, rows.A, rank)
    free = split.T @ (split.T.T @ load)
    wanted = -rows.bias - rows.A @ free
    return rows, split, wanted, free + split.change(wanted)


def loads(
    bodies: list[Body],
    poses: Poses,
    twists: Twists,
    forces: Array | None,
    torques: Array | None,
    gravity: Array | None,
) -> Array:
    """Forces and torques on the bodies, the gyroscopic ones among them."""
    result = np.zeros((len(bodies), 2, 3))
    result[:, 0] += 0.0 if forces is None else forces
    result[:, 1] += 0.0 if torques is None else torques
    for i, (body, pose, twist) in enumerate(zip(bodies, poses, twists, strict=True)):
        result[i, 0] += 0.0 if gravity is None else body.mass * np.asarray(gravity)
        result[i, 1] -= cross(twist.w, pose.R @ body.inertia @ pose.R.T @ twist.w)
    return result.reshape(-1)


def _reaction(joint: Joint, part: Rows, poses: Poses, t: float, multipliers: Array, idle: Array) -> Reaction:
    body = joint.bodies[-1]
    center = (joint.ground(t).pose if body == GROUND else poses[body]).r
    wrenches = part.J[:, -6:].T.copy()
    wrenches[3:] += skew(center - part.point) @ wrenches[:3]
    wrench, doubt = wrenches @ multipliers, wrenches @ idle
    determinate = np.abs(doubt).max(axis=1, initial=0.0) < DETERMINATE * np.abs(wrenches).max()
    return Reaction(wrench[:3], wrench[3:], part.point, doubt, determinate)
