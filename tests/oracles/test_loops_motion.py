# SPDX-License-Identifier: BSD-3-Clause
"""The oracle of loops in time, against closed forms and its own energy."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from tests.oracles.loops import contacts, joints
from tests.oracles.loops.equations import solve
from tests.oracles.loops.joints import Joint
from tests.oracles.loops.motion import simulate
from tests.oracles.loops.quaternions import quaternion, turned
from tests.oracles.loops.records import (
    GROUND,
    ORIGIN,
    REST,
    Body,
    Mark,
    Pose,
    Twist,
    exponential,
    mark,
    marks_at,
    turning,
)
from tests.oracles.loops.rows import Poses
from tests.oracles.loops.states import assemble, project_velocity, random_state
from tests.oracles.tree import Array

X, Y, Z = np.eye(3)
DOWN = -9.81 * Z


def _rod(mass: float, p: Array, q: Array, thickness: float = 0.05) -> tuple[Body, Pose]:
    """A slender rod from p to q, along its own x."""
    way = q - p
    length = float(np.linalg.norm(way))
    inertia = mass * length**2 / 12.0 * np.diag([thickness, 1.0, 1.0])
    return Body(mass, inertia), Pose((p + q) / 2.0, mark(np.zeros(3), way).axes[:, [2, 0, 1]])


def _closed_chain(corners: Array, axes: Array, masses: Array) -> tuple[list[Body], list[Joint], Poses]:
    """Rods from corner to corner, pinned to each other and the last corner and the first to the ground."""
    bodies, poses = map(
        list, zip(*(_rod(m, *ends) for m, ends in zip(masses, itertools.pairwise(corners), strict=True)), strict=True)
    )
    chain = [GROUND, *range(len(bodies)), GROUND]
    return (
        bodies,
        [
            Joint(pair, marks_at(poses, pair, corner, axis), joints.pin)
            for pair, corner, axis in zip(itertools.pairwise(chain), corners, axes, strict=True)
        ],
        poses,
    )


def test_quaternions_turn_and_return() -> None:
    for turn in [*np.random.default_rng(0).normal(size=(20, 3)), *(math.pi * np.eye(3)), np.zeros(3)]:
        R = exponential(turn)
        np.testing.assert_allclose(turned(quaternion(R)), R, atol=1e-14)
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-14)


def test_a_free_body_on_a_damped_spring() -> None:
    bodies, w, d = [Body(2.0, np.eye(3))], 3.0, 0.2
    times = np.linspace(0.0, 4.0, 5)

    def spring(t, poses, twists):
        return -2.0 * (w**2 * poses[0].r + 2.0 * d * twists[0].v)[None], np.zeros((1, 3))

    run = simulate(bodies, [], [Pose(X, np.eye(3))], [Twist(-d * X, Z)], times, load=spring, rtol=1e-11)
    expected = np.exp(-d * times) * np.cos(math.sqrt(w**2 - d**2) * times)
    np.testing.assert_allclose(run.r(0), np.outer(expected, X), atol=1e-9)
    np.testing.assert_allclose(run.poses[-1][0].R, exponential(times[-1] * Z), atol=1e-9)


def test_a_driven_pin_follows_its_drive() -> None:
    """A rod turned by prescription: angle t^2, about a pivot that circles."""
    body, pose = _rod(1.0, np.zeros(3), X)
    (across, along) = marks_at([pose], (GROUND, 0), np.zeros(3), Z)
    held = [
        Joint((GROUND, 0), (across, along), law, turning(Z, 2.0))
        for law in (joints.pin, joints.turn(lambda t: (t**2, 2.0 * t, 2.0)))
    ]
    times = np.linspace(0.0, 2.0, 5)
    run = simulate([body], held, [pose], [REST], times, rtol=1e-11)
    angles = times**2 + 2.0 * times
    np.testing.assert_allclose(
        run.r(0), np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles]) / 2.0, atol=1e-12
    )
    np.testing.assert_allclose([s.reactions[1].torque[2] for s in run.solutions], 2.0 / 3.0, atol=1e-11)


def test_pendulum_swings_as_jacobi_says() -> None:
    """sin(angle / 2) = k cd(w t | k^2) from rest at the amplitude."""
    bodies, amplitude, length = [Body(2.0, np.diag([0.1, 0.2, 0.25]))], 2.0, 0.4
    R = exponential(amplitude * Z)
    joint = Joint((GROUND, 0), (Mark(), Mark(length * Y)), joints.pin)
    w, k = math.sqrt(2.0 * 9.81 * length / (0.25 + 2.0 * length**2)), math.sin(amplitude / 2.0)
    times = np.linspace(0.0, 4.0 * float(ellipk(k**2)) / w, 9)
    run = simulate(bodies, [joint], [Pose(-length * R @ Y, R)], [REST], times, gravity=-9.81 * Y, rtol=1e-11)
    _, cn, dn, _ = ellipj(w * times, k**2)
    angle = 2.0 * np.arcsin(k * cn / dn)
    np.testing.assert_allclose(
        run.r(0), length * np.column_stack([np.sin(angle), -np.cos(angle), 0.0 * angle]), atol=1e-8
    )


def _disk(mass: float, radius: float, axial: float, diametral: float) -> tuple[list[Body], list[Joint]]:
    """Thin, about its own z, on the plane z = 0."""
    wheel = Joint((GROUND, 0), (Mark(), Mark()), contacts.rolling_wheel(radius))
    return [Body(mass, np.diag([diametral, diametral, axial]))], [wheel]


@pytest.mark.slow
@pytest.mark.parametrize(("axial", "diametral"), [(0.5, 0.25), (0.8, 0.4), (0.3, 0.2)])
def test_disk_rolls_in_circles(axial: float, diametral: float) -> None:
    """Leaning by `lean`, turning at W about the vertical, with angular velocity w3 about its axle:

    W cos(lean) (I1 W sin(lean) - I3 w3) = m R^2 w3 W cos(lean) + m g R sin(lean); the uniform one is (1/2, 1/4) m R^2.
    """
    m, R, g, lean, W = 1.2, 0.3, 9.81, 0.4, 5.0
    I3, I1 = axial * m * R**2, diametral * m * R**2
    w3 = (I1 * W**2 * math.sin(lean) * math.cos(lean) - m * g * R * math.sin(lean)) / (
        W * math.cos(lean) * (I3 + m * R**2)
    )
    bodies, held = _disk(m, R, I3, I1)
    axle, up = math.cos(lean) * X + math.sin(lean) * Z, math.cos(lean) * Z - math.sin(lean) * X
    w, aside = w3 * axle + W * math.cos(lean) * up, np.cross(axle, up)
    pose, twist = Pose(R * up, np.column_stack([up, aside, axle])), Twist(R * w3 * aside, w)
    solution = solve(bodies, held, [pose], [twist], gravity=DOWN)
    assert solution.drift < 1e-14
    np.testing.assert_allclose(solution.a[0], R * w3 * W * X, atol=1e-12)
    np.testing.assert_allclose(solution.alpha[0], W * np.cross(Z, w), atol=1e-12)
    np.testing.assert_allclose(solution.reactions[0].force, m * (R * w3 * W * X + g * Z), atol=1e-12)
    np.testing.assert_allclose(solution.reactions[0].torque, 0.0, atol=1e-13)
    times = np.linspace(0.0, 1.0, 6)
    run = simulate(bodies, held, [pose], [twist], times, gravity=DOWN, rtol=1e-12)
    middle = pose.r + R * w3 / W * X
    expected = middle + np.array([exponential(W * t * Z) @ (pose.r - middle) for t in times])
    np.testing.assert_allclose(run.r(0), expected, atol=1e-8)


@pytest.mark.slow
def test_sphere_on_a_turntable_circles_at_two_sevenths() -> None:
    """A homogeneous one, from any velocity: v turns at 2/7 of the table's rate."""
    m, R, rate = 1.3, 0.2, 3.0
    bodies = [Body(m, 0.4 * m * R**2 * np.eye(3))]
    held = [Joint((GROUND, 0), (Mark(), Mark()), contacts.rolling_sphere(R), turning(Z, rate))]
    start = [Pose(np.array([0.5, 0.1, R]), np.eye(3))]
    (twist,) = project_velocity(bodies, held, start, [Twist(np.array([0.4, -0.7, 0.0]), 2.0 * Z)])
    slow, times = 2.0 / 7.0 * rate, np.linspace(0.0, 5.0, 6)
    run = simulate(bodies, held, start, [twist], times, gravity=DOWN, rtol=1e-11)
    middle = start[0].r + np.cross(Z, twist.v) / slow
    expected = middle + np.array([exponential(slow * t * Z) @ (start[0].r - middle) for t in times])
    np.testing.assert_allclose(run.r(0), expected, atol=1e-8)


def test_chaplygin_sleigh_turns_about() -> None:
    """With its blade a way b behind the mass centre: u = A tanh(b m A t / J + C), w by what energy is left."""
    m, axial, b, u, w = 1.5, 0.3, 0.4, -0.8, 0.6
    J = axial + m * b**2
    bodies = [Body(m, np.diag([1.0, 1.0, axial]))]
    blade = Mark(-b * X, np.column_stack([Y, -X, Z]))
    held = [
        Joint((GROUND, 0), (Mark(), Mark()), joints.planar),
        Joint((GROUND, 0), (Mark(), blade), contacts.knife_edge),
    ]
    times = np.linspace(0.0, 6.0, 13)
    run = simulate(bodies, held, [ORIGIN], [Twist(u * X + b * w * Y, w * Z)], times, rtol=1e-11)
    A = math.sqrt(u**2 + J / m * w**2)
    forward = A * np.tanh(b * m * A * times / J + math.atanh(u / A))
    told = [twist.v @ pose.R[:, 0] for (pose,), (twist,) in zip(run.poses, run.twists, strict=True)]
    np.testing.assert_allclose(told, forward, atol=1e-9)
    spins = np.array([twist.w[2] for (twist,) in run.twists])
    np.testing.assert_allclose(spins, np.sqrt(m / J * (A**2 - forward**2)), atol=1e-8)
    sideways = [s.reactions[1].force @ p.R[:, 1] for s, (p,) in zip(run.solutions, run.poses, strict=True)]
    np.testing.assert_allclose(sideways, m * (forward * spins * (1.0 - m * b**2 / J)), atol=1e-8)


CORNERS = np.array([[0.0, 0.0, 0.0], [0.6, 0.8, 0.0], [2.85, 1.88, 0.0], [2.4, 0.0, 0.0]])
MASSES = np.array([1.0, 2.0, 1.5])


@pytest.mark.slow
def test_redundant_pins_do_not_change_the_motion() -> None:
    """A four-bar linkage by four pins, and by as few rows as hold it: the same places, the same energy."""
    bodies, held, guess = _closed_chain(CORNERS, np.tile(Z, (4, 1)), MASSES)
    few = [
        Joint(j.bodies, j.marks, law)
        for j, law in zip(held, (joints.pin, joints.pin, joints.ball, joints.cylindrical), strict=True)
    ]
    poses = assemble(bodies, held, guess)
    twists = project_velocity(bodies, held, poses, [Twist(np.zeros(3), 6.0 * Z), REST, REST])
    times = np.linspace(0.0, 0.6, 3)
    one, two = (simulate(bodies, k, poses, twists, times, gravity=-9.81 * Y, rtol=1e-10) for k in (held, few))
    assert (one.solutions[-1].redundancies, two.solutions[-1].redundancies) == (3, 0)
    for run in (one, two):
        np.testing.assert_allclose(run.energy, run.energy[0], rtol=1e-9)
        assert max(s.drift for s in run.solutions) < 1e-11
    for body in range(3):
        np.testing.assert_allclose(one.r(body), two.r(body), atol=1e-7)
    for p, q in zip(one.solutions[-1].reactions, two.solutions[-1].reactions, strict=True):
        np.testing.assert_allclose(p.force[:2], q.force[:2], atol=1e-5)


@pytest.mark.slow
def test_bricard_linkage_moves() -> None:
    """Six equal rods along edges of a cube, pinned across their planes: by count rigid, in truth of one freedom."""
    corners = np.array([X, X + Y, Y, Y + Z, Z, Z + X])
    ways = np.diff(np.vstack([corners[-1], corners, corners[0]]), axis=0)
    axes = np.cross(ways[:-1], ways[1:])
    bodies, held, poses = _closed_chain(corners, axes, np.ones(5))
    twists = project_velocity(bodies, held, poses, [Twist(np.zeros(3), axes[0]), *[REST] * 4])
    run = simulate(bodies, held, poses, twists, np.linspace(0.0, 2.0, 9), gravity=-9.81 * Y, rtol=1e-10)
    solution = run.solutions[0]
    assert (solution.freedom, solution.redundancies) == (1, 1)
    np.testing.assert_allclose(run.energy, run.energy[0], rtol=0.0, atol=1e-8)
    assert max(s.drift for s in run.solutions) < 1e-10
    turned_by = [math.acos(np.clip((np.trace(p[0].R @ poses[0].R.T) - 1.0) / 2.0, -1.0, 1.0)) for p in run.poses]
    assert max(turned_by) > 1.0


@pytest.mark.slow
def test_rolling_torus_keeps_its_energy() -> None:
    body = [Body(1.2, np.diag([0.03, 0.03, 0.055]))]
    wheel = [Joint((GROUND, 0), (Mark(), Mark()), contacts.rolling_wheel(0.25, 0.05))]
    guess = [Pose(np.array([0.0, 0.0, 0.3]), exponential(1.2 * X))]
    poses, twists = random_state(np.random.default_rng(4), body, wheel, guess, spread=0.1, speed=3.0)
    run = simulate(body, wheel, poses, twists, np.linspace(0.0, 0.5, 3), gravity=DOWN, rtol=1e-11)
    np.testing.assert_allclose(run.energy, run.energy[0], rtol=1e-9)
    assert max(s.drift for s in run.solutions) < 1e-11


def test_a_singular_position_is_refused() -> None:
    """A parallelogram laid flat may open either way: there its rows have lost rank, which they regain."""
    square, flat = ([[0.0, 0.0, 0.0], corner, corner + 2.0 * X, 2.0 * X] for corner in (Y, X))
    bodies, held, poses = _closed_chain(np.array(square), np.tile(Z, (4, 1)), np.ones(3))
    laid = [_rod(1.0, *ends)[1] for ends in itertools.pairwise(np.array(flat))]
    assert solve(bodies, held, poses, [REST] * 3).freedom == 1
    assert solve(bodies, held, laid, [REST] * 3).freedom == 2
    twists = project_velocity(bodies, held, laid, [Twist(np.zeros(3), Z), REST, REST])
    with pytest.raises(RuntimeError, match=r"At t = .*, with rows of rank 16: Expected joints that close"):
        simulate(bodies, held, laid, twists, np.array([0.0, 1.0]))


def test_a_mirrored_pose_is_refused() -> None:
    with pytest.raises(ValueError, match="Expected a rotation matrix, got one of determinant -1"):
        simulate([Body(1.0, np.eye(3))], [], [Pose(np.zeros(3), -np.eye(3))], [REST], np.array([0.0, 1.0]))
