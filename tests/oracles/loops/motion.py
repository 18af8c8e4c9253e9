# SPDX-License-Identifier: BSD-3-Clause
"""Motion in time: DOP853 on positions, quaternions and twists, put back on the constraints after every step.

The rank of the rows is that of the start and must stay. Between steps poses are a little off, where redundant
rows no longer are: taking them for independent would divide rounding by rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853

from tests.oracles.loops.equations import Solution, accelerations, loads, solve
from tests.oracles.loops.joints import Joint
from tests.oracles.loops.quaternions import pack, unpack
from tests.oracles.loops.records import Body, cross
from tests.oracles.loops.rows import Poses, Twists, factors, stack
from tests.oracles.loops.states import assemble, project_velocity
from tests.oracles.tree import Array

# forces and torques, each (bodies, 3), at and about the mass centres
Loads = Callable[[float, Poses, Twists], tuple[Array, Array]]


@dataclass(frozen=True, slots=True)
class Trajectory:
    times: Array
    poses: list[Poses]
    twists: list[Twists]
    solutions: list[Solution]
    kinetic: Array
    potential: Array  # of gravity, from the inertial origin
    steps: int
    condition: float  # the worst after a step; where it is large, a singular position was near

    @property
    def energy(self) -> Array:
        return self.kinetic + self.potential

    def r(self, body: int) -> Array:
        """(times, 3) positions of a mass centre."""
        return np.array([poses[body].r for poses in self.poses])


def energies(bodies: list[Body], poses: Poses, twists: Twists, gravity: Array | None = None) -> tuple[float, float]:
    """Kinetic, and potential of gravity."""
    kinetic, potential = 0.0, 0.0
    for body, pose, twist in zip(bodies, poses, twists, strict=True):
        spin = pose.R.T @ twist.w
        kinetic += float(body.mass * twist.v @ twist.v + spin @ body.inertia @ spin) / 2.0
        potential -= 0.0 if gravity is None else float(body.mass * np.asarray(gravity) @ pose.r)
    return kinetic, potential


def simulate(
    bodies: list[Body],
    joints: list[Joint],
    poses: Poses,
    twists: Twists,
    times: Array,
    *,
    load: Loads | None = None,
    gravity: Array | None = None,
    rtol: float = 1e-10,
) -> Trajectory:
    """States at the given times, the first of which is the start; the start is projected, too."""

    def outer(t: float, poses: Poses, twists: Twists) -> tuple[Array | None, Array | None, Array | None]:
        return *((None, None) if load is None else load(t, poses, twists)), gravity

    def slope(t: float, y: Array) -> Array:
        poses, twists = unpack(y)
        total = loads(bodies, poses, twists, *outer(t, poses, twists))
        rates = np.zeros((len(bodies), 13))
        for row, twist, quaternion in zip(rates, twists, y.reshape(-1, 13)[:, 3:7], strict=True):
            row[:3] = twist.v
            row[3] = -twist.w @ quaternion[1:] / 2.0
            row[4:7] = (quaternion[0] * twist.w + cross(twist.w, quaternion[1:])) / 2.0
        rates[:, 7:] = accelerations(bodies, joints, poses, twists, total, t, ranks[1]).reshape(-1, 6)
        return rates.reshape(-1)

    def put_back(t: float, poses: Poses, twists: Twists, ranks: tuple[int | None, int | None] = (None, None)):
        poses = assemble(bodies, joints, poses, t, ranks[0])
        return poses, project_velocity(bodies, joints, poses, twists, t, ranks[1])

    t = float(times[0])
    poses, twists = put_back(t, poses, twists)
    ranks, worst = _ranks(bodies, joints, poses, twists, t)
    y, h, steps = pack(poses, twists), None, 0
    states = [(t, poses, twists)]
    for end in times[1:]:
        solver = DOP853(slope, t, y, float(end), rtol=rtol, atol=rtol, first_step=h and min(h, float(end) - t))
        while solver.status == "running":
            message = solver.step()
            if message is not None:
                raise RuntimeError(f"Expected a motion until t = {end}, got {message} at t = {solver.t}.")
            t, steps = solver.t, steps + 1
            try:
                poses, twists = put_back(t, *unpack(solver.y), ranks)
            except ValueError as failure:
                raise RuntimeError(f"At t = {t:.6g}, with rows of rank {ranks[1]}: {failure}") from failure
            now, condition = _ranks(bodies, joints, poses, twists, t)
            if now != ranks:
                raise RuntimeError(f"Expected rows of rank {ranks}, got {now} at t = {t:.6g}: a singular position.")
            worst = max(worst, condition)
            y = pack(poses, twists, y)
            if solver.status == "running":
                solver.y, solver.f = y, slope(t, y)
        h = max(solver.h_abs, h or 0.0) if steps else None
        states.append((t, poses, twists))
    kinetic, potential = np.array([energies(bodies, p, w, gravity) for _, p, w in states]).T
    solutions = [solve(bodies, joints, p, w, *outer(t, p, w), t, ranks[1]) for t, p, w in states]
    return Trajectory(
        np.asarray(times, dtype=float),
        [state[1] for state in states],
        [state[2] for state in states],
        solutions,
        kinetic,
        potential,
        steps,
        worst,
    )


def _ranks(
    bodies: list[Body], joints: list[Joint], poses: Poses, twists: Twists, t: float
) -> tuple[tuple[int, int], float]:
    """Of the rows on poses, and of all rows; and the condition of these."""
    rows = stack(joints, poses, twists, t)
    every = factors(bodies, poses, rows.A)
    held = every if rows.held.all() else factors(bodies, poses, rows.A[rows.held])
    return (held.rank, every.rank), every.condition()
