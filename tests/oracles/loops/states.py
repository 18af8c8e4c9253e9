# SPDX-License-Identifier: BSD-3-Clause
"""States that satisfy all joints and contacts, by the least change in the metric of mass."""

from __future__ import annotations

import numpy as np

from tests.oracles.loops.joints import Joint
from tests.oracles.loops.records import REST, Body, Twist
from tests.oracles.loops.rows import Poses, Twists, factors, stack

CLOSED = 1e-11  # largest residual that counts as closed, over the largest distance from the origin or 1
EXACT = 1e-14  # where to stop


def assemble(bodies: list[Body], joints: list[Joint], guess: Poses, t: float = 0.0, rank: int | None = None) -> Poses:
    """Poses near the guess that close every joint: Gauss and Newton's steps, halved until they help.

    `rank` is that of the rows that are derivatives of residuals of poses.
    """
    rest = [REST] * len(bodies)

    def residuals(poses: Poses):
        rows = stack(joints, poses, rest, t)
        return rows, float(np.abs(rows.c).max(initial=0.0))

    poses = guess
    scale = max(1.0, *(float(np.abs(pose.r).max()) for pose in poses))
    rows, worst = residuals(poses)
    for _ in range(50):
        if worst <= EXACT * scale:
            break
        step = factors(bodies, poses, rows.A[rows.held], rank).change(-rows.c).reshape(-1, 2, 3)
        for halvings in range(20):
            part = step / 2**halvings
            trial = [pose.moved(*change) for pose, change in zip(poses, part, strict=True)]
            trial_rows, trial_worst = residuals(trial)
            if trial_worst < worst:
                break
        else:
            break
        poses, rows, worst = trial, trial_rows, trial_worst
    if worst > CLOSED * scale:
        raise ValueError(f"Expected joints that close, got a residual of {worst:.3g}. Give a nearer guess.")
    return poses


def project_velocity(
    bodies: list[Body], joints: list[Joint], poses: Poses, twists: Twists, t: float = 0.0, rank: int | None = None
) -> Twists:
    """The nearest twists that satisfy every row."""
    rows = stack(joints, poses, twists, t)
    change = factors(bodies, poses, rows.A, rank).change(-rows.rate).reshape(-1, 2, 3)
    result = [Twist(twist.v + dv, twist.w + dw) for twist, (dv, dw) in zip(twists, change, strict=True)]
    left = float(np.abs(rows.rate + rows.A @ change.reshape(-1)).max(initial=0.0))
    if left > 1e-9 * max(1.0, float(np.abs(change).max(initial=0.0))):
        raise ValueError(f"Expected velocities that can be, got rows that contradict each other by {left:.3g}.")
    return result


def random_state(
    rng: np.random.Generator,
    bodies: list[Body],
    joints: list[Joint],
    guess: Poses,
    spread: float = 0.2,
    speed: float = 1.0,
    t: float = 0.0,
) -> tuple[Poses, Twists]:
    """Poses about `spread` away from the guess, and twists of about `speed`."""
    away = [pose.moved(*(spread * rng.normal(size=(2, 3)))) for pose in guess]
    poses = assemble(bodies, joints, away, t)
    twists = [Twist(*(speed * rng.normal(size=(2, 3)))) for _ in bodies]
    return poses, project_velocity(bodies, joints, poses, twists, t)
