# SPDX-License-Identifier: BSD-3-Clause
"""The oracles against each other, against closed forms and against their own energy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.oracles import disk, newton_euler
from tests.oracles.compare import error, tolerance
from tests.oracles.tree import Body, Step, Tree, random_states, random_tree
from tests.peer import require


@pytest.mark.parametrize("seed", range(20))
def test_newton_euler_agrees_with_pinocchio(seed: int) -> None:
    require("pinocchio")
    from tests.oracles import pinocchio_tree

    rng = np.random.default_rng(seed)
    tree = random_tree(rng, seed % 6 + 1)
    q, qdot = random_states(rng, tree, 1)
    one = newton_euler.solve(tree, q[:, 0], qdot[:, 0])
    two = pinocchio_tree.solve(tree, q[:, 0], qdot[:, 0])
    for name in ("qddot", "mass_matrix", "force", "torque"):
        limit = tolerance(1e-9, two.condition)
        assert error(getattr(one, name), getattr(two, name)) <= limit, (name, two.condition)


def test_newton_euler_gives_the_compound_pendulum() -> None:
    angle, rate, length, g = 0.7, 1.3, 0.4, 9.81
    inertia = ((0.1, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.25))
    identity = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    steps = (Step("turn", (0.0, 0.0, 1.0)),)
    body = Body(-1, (0.0, 0.0, 0.0), identity, steps, 2.0, (0.0, -length, 0.0), inertia)
    motion = newton_euler.solve(Tree((body,), (0.0, -g, 0.0)), np.array([angle]), np.array([rate]))
    expected = -2.0 * g * length * math.sin(angle) / (0.25 + 2.0 * length**2)
    assert motion.qddot[0] == pytest.approx(expected, rel=1e-14)
    along = np.array([-math.sin(angle), math.cos(angle), 0.0])  # from the mass centre to the pin
    assert motion.force[0] @ along == pytest.approx(2.0 * (length * rate**2 + g * math.cos(angle)), rel=1e-14)


def _states(disk_: disk.Disk, q: np.ndarray, qdot: np.ndarray, until: float, times: int) -> np.ndarray:
    """Rows q, qdot, work of friction at equally spaced times."""

    def slope(_: float, y: np.ndarray) -> np.ndarray:
        motion = disk.solve(disk_, y[:5], y[5:10])
        return np.concatenate([y[5:10], motion.qddot, [motion.friction_power]])

    run = solve_ivp(
        slope,
        (0.0, until),
        np.concatenate([q, qdot, [0.0]]),
        method="DOP853",
        t_eval=np.linspace(0.0, until, times),
        rtol=1e-12,
        atol=1e-12,
    )
    assert run.success
    return np.asarray(run.y.T)


@pytest.mark.parametrize("thin", [True, False])
def test_disk_loses_the_work_of_friction(thin: bool) -> None:
    rng = np.random.default_rng(7)
    body = disk.random_disk(rng, thin)
    start = np.array([0.3, 0.2, -0.4, 0.1, 0.5]), np.array([0.5, -0.3, 4.0, 3.0, -2.0])
    rows = _states(body, *start, until=0.2, times=21)
    energies = np.array([disk.solve(body, row[:5], row[5:10]).energy for row in rows])
    assert energies[-1] < energies[0] - 0.1
    np.testing.assert_allclose(energies - rows[:, 10], energies[0], rtol=1e-10)
    slips = np.array([disk.solve(body, row[:5], row[5:10]).slip for row in rows])
    assert np.abs(slips[:, 2]).max() < 1e-13
    assert np.linalg.norm(slips, axis=1).min() > 0.1


def test_disk_accelerations_are_the_derivatives_of_velocities() -> None:
    """Central differences of the speeds along the motion against their derivatives from alpha."""
    rng = np.random.default_rng(3)
    body = disk.random_disk(rng, thin=False)
    q, qdot = (x[:, 0] for x in disk.random_states(rng, 1))
    motion = disk.solve(body, q, qdot)
    h = 1e-4
    ends = []
    for step in (-h, h):
        later = q + step * qdot + step**2 / 2.0 * motion.qddot, qdot + step * motion.qddot
        ends.append(disk.solve(body, *later).speeds)
    np.testing.assert_allclose((ends[1] - ends[0]) / (2.0 * h), motion.accelerations, rtol=1e-6, atol=1e-6)


def test_upright_disk_sliding_without_spin() -> None:
    body = disk.Disk(m=1.2, R=0.3, g=9.81, mu=0.25, axial=0.06, diametral=0.03)
    motion = disk.solve(body, np.zeros(5), np.array([0.0, 0.0, 0.0, 2.0, 0.0]))
    assert motion.normal == pytest.approx(1.2 * 9.81, rel=1e-14)
    np.testing.assert_allclose(motion.a, [-0.25 * 9.81, 0.0, 0.0], atol=1e-14)
    spin = -0.25 * 1.2 * 9.81 * 0.3 / 0.06  # friction about the axis b3 = -y
    np.testing.assert_allclose(motion.qddot, [0.0, 0.0, spin, -0.25 * 9.81, 0.0], atol=1e-13)


def test_steady_precession_without_friction() -> None:
    """Centre at rest, turning rate W, axial speed w3: W cos q2 (J w3 - I W sin q2) = -m g R sin q2."""
    body = disk.Disk(m=1.2, R=0.3, g=9.81, mu=0.0, axial=0.05, diametral=0.04)
    lean, turning = 0.4, 2.5
    across = body.diametral * turning * math.sin(lean)
    axial = (across - body.m * body.g * body.R * math.tan(lean) / turning) / body.axial
    rates = np.array([turning, 0.0, axial - turning * math.sin(lean), 0.0, 0.0])
    yaw = 0.6  # the trace circles so that the centre, R sin(lean) aside of it, does not move
    rates[3:] = body.R * turning * math.sin(lean) * np.array([math.cos(yaw), math.sin(yaw)])
    motion = disk.solve(body, np.array([yaw, lean, 0.2, 0.0, 0.0]), rates)
    assert motion.normal == pytest.approx(body.m * body.g, rel=1e-13)
    np.testing.assert_allclose(motion.a, 0.0, atol=1e-13)
    np.testing.assert_allclose(motion.qddot[:3], 0.0, atol=1e-12)
