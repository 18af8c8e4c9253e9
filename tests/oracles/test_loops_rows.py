# SPDX-License-Identifier: BSD-3-Clause
"""The rows of the oracle of loops against differences, and states made from them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.oracles.loops import contacts, joints
from tests.oracles.loops.equations import solve
from tests.oracles.loops.jets import constant
from tests.oracles.loops.joints import Joint
from tests.oracles.loops.records import GROUND, REST, Body, Carried, Mark, Pose, Twist, exponential, mark
from tests.oracles.loops.rows import evaluate
from tests.oracles.loops.states import assemble, project_velocity, random_state
from tests.oracles.tree import Array

Z = np.array([0.0, 0.0, 1.0])


def _sine(t: float) -> tuple[float, float, float]:
    return 0.4 + 0.3 * math.sin(2.0 * t), 0.6 * math.cos(2.0 * t), -1.2 * math.sin(2.0 * t)


LAWS = {
    "ball": (joints.ball, 3, 3),
    "pin": (joints.pin, 5, 5),
    "weld": (joints.weld, 6, 6),
    "slider": (joints.slider, 5, 5),
    "cylindrical": (joints.cylindrical, 4, 4),
    "planar": (joints.planar, 3, 3),
    "universal": (joints.universal, 4, 4),
    "screw": (joints.screw(0.3), 5, 5),
    "point on line": (joints.point_on_line, 2, 2),
    "point on plane": (joints.point_on_plane, 1, 1),
    "rod": (joints.distance(constant(0.8)), 1, 1),
    "rod of changing length": (joints.distance(_sine), 1, 1),
    "driven turn": (joints.turn(_sine), 1, 1),
    "driven slide": (joints.slide(_sine), 1, 1),
    "sphere": (contacts.rolling_sphere(0.3), 1, 3),
    "disk": (contacts.rolling_wheel(0.4), 1, 3),
    "torus": (contacts.rolling_wheel(0.4, 0.1), 1, 3),
    "knife edge": (contacts.knife_edge, 0, 1),
    "groove": (contacts.groove, 0, 1),
    "gears": (contacts.gears((17.0, -23.0)), 0, 1),
}  # law, rows that are derivatives of residuals, all rows


def _carried(t: float) -> Carried:
    """A wall that sways and turns about a fixed direction at a changing rate."""
    axis, (angle, rate, second) = np.array([2.0, -1.0, 2.0]) / 3.0, _sine(t)
    way = np.array([math.sin(t), math.cos(t), t])
    pose, twist = Pose(way, exponential(axis * angle)), Twist(np.array([way[1], -way[0], 1.0]), axis * rate)
    return Carried(pose, twist, np.array([-way[0], -way[1], 0.0]), axis * second)


def _random_mark(rng: np.random.Generator) -> Mark:
    return mark(rng.normal(size=3), rng.normal(size=3), rng.normal(size=3))


@pytest.mark.parametrize("grounded", [True, False])
@pytest.mark.parametrize("name", LAWS)
def test_rows_are_derivatives(name: str, grounded: bool) -> None:
    """Off the constraints, too: c, its rate J nu + ..., and J nu' + bias, by central differences in time."""
    law, held, count = LAWS[name]
    rng, h, now = np.random.default_rng(sum(name.encode())), 1e-5, 0.7
    bodies = (GROUND if grounded else 2, 0, 1)[: 3 if name == "gears" else 2]
    joint = Joint(bodies, tuple(_random_mark(rng) for _ in bodies), law, _carried)
    poses = [Pose(rng.normal(size=3), exponential(rng.normal(size=3))) for _ in range(3)]
    twists = [Twist(*rng.normal(size=(2, 3))) for _ in range(3)]
    a, alpha = rng.normal(size=(2, 3, 3))

    def at(s: float, t: float):
        later = [
            p.moved(s * x.v + s**2 / 2 * b, s * x.w + s**2 / 2 * c)
            for p, x, b, c in zip(poses, twists, a, alpha, strict=True)
        ]
        return evaluate(
            joint, later, [Twist(x.v + s * b, x.w + s * c) for x, b, c in zip(twists, a, alpha, strict=True)], t + s
        )

    rows, before, after = at(0.0, now), at(-h, now), at(h, now)
    assert (len(rows.c), len(rows.rate)) == (held, count)

    def column(linear: Array, angular: Array) -> Array:
        own = [np.zeros(6) if i == GROUND else np.concatenate([linear[i], angular[i]]) for i in bodies]
        return np.asarray(rows.J @ np.concatenate(own))

    nu = np.array([[x.v, x.w] for x in twists])
    resting = evaluate(joint, poses, [REST] * 3, now).rate
    np.testing.assert_allclose(rows.rate, column(nu[:, 0], nu[:, 1]) + resting, atol=1e-12)
    np.testing.assert_allclose(rows.rate[:held], (after.c - before.c) / (2 * h), atol=1e-6, rtol=1e-6)
    np.testing.assert_allclose(column(a, alpha) + rows.bias, (after.rate - before.rate) / (2 * h), atol=1e-6, rtol=1e-6)


def _free(*ways: tuple[float, ...]) -> Array:
    return np.array(ways, dtype=float).reshape(-1, 6)


VX, VY, VZ, WX, WY, WZ = (tuple(row) for row in np.eye(6))
FREE = {
    "ball": _free(WX, WY, WZ),
    "pin": _free(WZ),
    "weld": _free(),
    "slider": _free(VZ),
    "cylindrical": _free(VZ, WZ),
    "planar": _free(VX, VY, WZ),
    "universal": _free(WX, WZ),
    "screw": _free((0.0, 0.0, 0.3, 0.0, 0.0, 1.0)),
    "point on line": _free(VZ, WX, WY, WZ),
    "point on plane": _free(VX, VY, WX, WY, WZ),
    "knife edge": _free(VY, VZ, WX, WY, WZ),
    "groove": _free(VY, VZ, WX, WY, WZ),
    "sphere": _free((0.0, -0.3, 0.0, 1.0, 0.0, 0.0), (0.3, 0.0, 0.0, 0.0, 1.0, 0.0), WZ),
}


@pytest.mark.parametrize("name", FREE)
def test_joints_leave_the_twists_they_are_named_for(name: str) -> None:
    """Marks at the mass centre along common axes: the twists with J nu = 0 are just these."""
    joint = Joint((GROUND, 0), (Mark(), Mark()), LAWS[name][0])
    J, free = evaluate(joint, [Pose(np.zeros(3), np.eye(3))], [REST], 0.0).J[:, 6:], FREE[name]
    np.testing.assert_allclose(J @ free.T, 0.0, atol=1e-15)
    assert np.linalg.matrix_rank(J) == len(J) == 6 - len(free)


@pytest.mark.parametrize("name", [name for name, (_, held, _) in LAWS.items() if held])
def test_states_are_consistent(name: str) -> None:
    """Assembled poses close, projected twists fit, and the change of the twists is the least in kinetic energy."""
    law, _, count = LAWS[name]
    rng = np.random.default_rng(5)
    bodies = [Body(1.0, np.diag([0.2, 0.3, 0.4])), Body(2.0, np.diag([0.5, 0.3, 0.4]))]
    guess = [Pose(np.array([0.0, 0.0, 0.1]), np.eye(3)), Pose(np.array([0.7, 0.2, 0.3]), exponential(0.9 * Z))]
    joint = Joint((0, 1), (Mark(), mark([-0.2, 0.1, 0.2], [0.2, 0.1, 1.0])), law)
    poses, twists = random_state(rng, bodies, [joint], guess)
    solution = solve(bodies, [joint], poses, twists, gravity=-9.81 * Z)
    assert solution.drift < 1e-11
    assert solution.inconsistency < 1e-10
    assert (solution.rank, solution.freedom) == (count, 12 - count)
    other = [Twist(*rng.normal(size=(2, 3))) for _ in bodies]
    nearest = project_velocity(bodies, [joint], poses, other)
    moved = sum(
        b.mass * (x.v - y.v) @ (y.v - z.v) + (x.w - y.w) @ p.R @ b.inertia @ p.R.T @ (y.w - z.w)
        for b, p, x, y, z in zip(bodies, poses, other, nearest, twists, strict=True)
    )
    assert abs(moved) < 1e-11


def test_assembly_says_when_it_cannot_close() -> None:
    bodies = [Body(1.0, np.eye(3))]
    ends = (Mark(), Mark())
    held = [Joint((GROUND, 0), ends, joints.distance(constant(length))) for length in (1.0, 2.0)]
    with pytest.raises(ValueError, match=r"Expected joints that close, got a residual of .* Give a nearer guess\."):
        assemble(bodies, held, [Pose(Z, np.eye(3))])
