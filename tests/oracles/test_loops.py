# SPDX-License-Identifier: BSD-3-Clause
"""The oracle of loops at one state: against closed forms and by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.oracles.loops import contacts, joints
from tests.oracles.loops.equations import solve
from tests.oracles.loops.joints import Joint
from tests.oracles.loops.records import (
    GROUND,
    ORIGIN,
    REST,
    Body,
    Carried,
    Mark,
    Pose,
    Twist,
    exponential,
    marks_at,
)
from tests.oracles.loops.states import assemble, project_velocity, random_state
from tests.oracles.tree import Array

Z = np.array([0.0, 0.0, 1.0])


def _sine(t: float) -> tuple[float, float, float]:
    return 0.4 + 0.3 * math.sin(2.0 * t), 0.6 * math.cos(2.0 * t), -1.2 * math.sin(2.0 * t)


def test_a_free_body_obeys_euler() -> None:
    inertia, w = np.diag([0.1, 0.2, 0.25]), np.array([1.0, -2.0, 3.0])
    solution = solve([Body(2.0, inertia)], [], [Pose(np.zeros(3), np.eye(3))], [Twist(Z, w)], gravity=-9.81 * Z)
    np.testing.assert_allclose(solution.a[0], -9.81 * Z)
    np.testing.assert_allclose(inertia @ solution.alpha[0], -np.cross(w, inertia @ w), atol=1e-14)
    assert solution.freedom == 6


def _pendulum(angle: float, rate: float, length: float) -> tuple[list[Body], list[Joint], list[Pose], list[Twist]]:
    """Pinned at the origin about z, hanging along -y."""
    bodies = [Body(2.0, np.diag([0.1, 0.2, 0.25]))]
    R = exponential(angle * Z)
    pose = Pose(R @ [0.0, -length, 0.0], R)
    joint = Joint((GROUND, 0), (Mark(), Mark(np.array([0.0, length, 0.0]))), joints.pin)
    return bodies, [joint], [pose], [Twist(np.cross(rate * Z, pose.r), rate * Z)]


def test_compound_pendulum_and_the_force_of_its_pin() -> None:
    angle, rate, length, g = 0.7, 1.3, 0.4, 9.81
    solution = solve(*_pendulum(angle, rate, length), gravity=np.array([0.0, -g, 0.0]))
    second = -2.0 * g * length * math.sin(angle) / (0.25 + 2.0 * length**2)
    np.testing.assert_allclose(solution.alpha[0], second * Z, atol=1e-13)
    along, across = (
        np.array([-math.sin(angle), math.cos(angle), 0.0]),
        np.array([math.cos(angle), math.sin(angle), 0.0]),
    )
    (pin,) = solution.reactions
    assert pin.force @ along == pytest.approx(2.0 * (length * rate**2 + g * math.cos(angle)), rel=1e-13)
    assert pin.force @ across == pytest.approx(2.0 * (length * second + g * math.sin(angle)), rel=1e-13)
    np.testing.assert_allclose(pin.torque, 0.0, atol=1e-13)
    assert pin.determinate.all()
    assert solution.redundancies == 0


def test_a_driven_pin_tells_its_torque() -> None:
    """About the pin: the whole moment of momentum's rate, less gravity's moment."""
    angle, rate, second = _sine(0.7)
    bodies, held, poses, twists = _pendulum(angle, rate, 0.4)
    drive = Joint((GROUND, 0), held[0].marks, joints.turn(_sine))
    solution = solve(bodies, [*held, drive], poses, twists, gravity=np.array([0.0, -9.81, 0.0]), t=0.7)
    assert solution.drift < 1e-13
    np.testing.assert_allclose(solution.alpha[0], second * Z, atol=1e-13)
    expected = (0.25 + 2.0 * 0.16) * second + 2.0 * 9.81 * 0.4 * math.sin(angle)
    np.testing.assert_allclose(solution.reactions[1].torque, expected * Z, atol=1e-12)


def test_an_accelerated_pivot_is_gravity() -> None:
    """The pin on a support that accelerates by b at rest: as with gravity less b, and b on top."""
    bodies, held, poses, twists = _pendulum(0.7, 1.3, 0.4)
    g, b = np.array([0.0, -9.81, 0.0]), np.array([3.0, -2.0, 1.0])
    pushed = Joint((GROUND, 0), held[0].marks, joints.pin, lambda t: Carried(ORIGIN, REST, b, np.zeros(3)))
    one, two = solve(bodies, [pushed], poses, twists, gravity=g), solve(bodies, held, poses, twists, gravity=g - b)
    np.testing.assert_allclose(one.a, two.a + b, atol=1e-13)
    np.testing.assert_allclose(one.alpha, two.alpha, atol=1e-13)
    np.testing.assert_allclose(one.reactions[0].force, two.reactions[0].force, atol=1e-12)


def _four_bar(kinds: tuple[joints.Law, ...]) -> tuple[list[Body], list[Joint], list[Pose]]:
    """Crank 1, coupler 2.5, rocker 2, frame 2.4, in the plane x y; not assembled exactly."""
    corners = np.array([[0.0, 0.0, 0.0], [0.6, 0.8, 0.0], [2.85, 1.88, 0.0], [2.4, 0.0, 0.0]])
    poses, bodies = [], []
    for mass, p, q in zip((1.0, 2.0, 1.5), corners[:-1], corners[1:], strict=True):
        length = np.linalg.norm(q - p)
        poses.append(Pose((p + q) / 2.0, exponential(math.atan2(*(q - p)[1::-1]) * Z)))
        bodies.append(Body(mass, mass * length**2 / 12.0 * np.diag([0.01, 1.0, 1.0])))
    pairs = ((GROUND, 0), (0, 1), (1, 2), (2, GROUND))
    return (
        bodies,
        [
            Joint(pair, marks_at(poses, pair, corner, Z), law)
            for pair, corner, law in zip(pairs, corners, kinds, strict=True)
        ],
        poses,
    )


PINS = (joints.pin,) * 4
ISOSTATIC = (joints.pin, joints.pin, joints.ball, joints.cylindrical)


def _planar_by_hand(bodies, held, poses, twists, g: float) -> tuple[Array, Array]:
    """Multipliers on (x, y, theta) of the three bars; the forces are those of the pins on the second body."""
    J, bias = np.zeros((8, 9)), np.zeros(8)
    for k, joint in enumerate(held):
        for sign, body, frame in zip((-1.0, 1.0), joint.bodies, joint.marks, strict=True):
            if body != GROUND:
                x, y, _ = poses[body].R @ frame.point
                J[2 * k : 2 * k + 2, 3 * body : 3 * body + 3] = sign * np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
                bias[2 * k : 2 * k + 2] -= sign * twists[body].w[2] ** 2 * np.array([x, y])
    M = np.diag([m for b in bodies for m in (b.mass, b.mass, b.inertia[2, 2])])
    f = np.array([x for b in bodies for x in (0.0, -b.mass * g, 0.0)])
    x = np.linalg.solve(np.block([[M, -J.T], [J, np.zeros((8, 8))]]), np.concatenate([f, -bias]))
    return x[:9].reshape(3, 3), x[9:].reshape(4, 2)


@pytest.mark.parametrize("kinds", [PINS, ISOSTATIC])
def test_four_bar_as_by_hand_in_the_plane(kinds: tuple[joints.Law, ...]) -> None:
    bodies, held, guess = _four_bar(kinds)
    poses = assemble(bodies, held, guess)
    twists = project_velocity(bodies, held, poses, [Twist(np.zeros(3), 3.0 * Z), REST, REST])
    solution = solve(bodies, held, poses, twists, gravity=np.array([0.0, -9.81, 0.0]))
    motion, forces = _planar_by_hand(bodies, held, poses, twists, 9.81)
    np.testing.assert_allclose(np.column_stack([solution.a[:, :2], solution.alpha[:, 2]]), motion, atol=1e-10)
    np.testing.assert_allclose(solution.a[:, 2], 0.0, atol=1e-12)
    for reaction, force in zip(solution.reactions, forces, strict=True):
        np.testing.assert_allclose(reaction.force[:2], force, atol=1e-10)
    assert solution.freedom == 1


def test_redundant_four_bar_says_what_is_indeterminate() -> None:
    """Four pins hold the plane three times too often: across it, forces and tilting torques are anyone's."""
    bodies, held, guess = _four_bar(PINS)
    poses = assemble(bodies, held, guess)
    solution = solve(bodies, held, poses, [REST] * 3, gravity=np.array([0.0, -9.81, 0.0]))
    assert (solution.redundancies, solution.rank) == (3, 17)
    for reaction in solution.reactions:
        assert reaction.determinate.tolist() == [True, True, False, False, False, True]
    bodies, held, _ = _four_bar(ISOSTATIC)
    solution = solve(bodies, held, poses, [REST] * 3, gravity=np.array([0.0, -9.81, 0.0]))
    assert solution.redundancies == 0
    assert all(reaction.determinate.all() for reaction in solution.reactions)


def test_reactions_balance_each_body() -> None:
    """Newton's and Euler's equations with nothing but the told forces and torques."""
    bodies, held, guess = _four_bar(ISOSTATIC)
    rng = np.random.default_rng(2)
    poses, twists = random_state(rng, bodies, held, guess, spread=0.05)
    outer, moments = rng.normal(size=(2, 3, 3))
    solution = solve(bodies, held, poses, twists, outer, moments)
    for i, (body, pose, twist) in enumerate(zip(bodies, poses, twists, strict=True)):
        force, torque = outer[i].copy(), moments[i].copy()
        for joint, reaction in zip(held, solution.reactions, strict=True):
            sign = (joint.bodies[1] == i) - (joint.bodies[0] == i)
            force += sign * reaction.force
            torque += sign * (reaction.torque + np.cross(reaction.point - pose.r, reaction.force))
        inertia = pose.R @ body.inertia @ pose.R.T
        np.testing.assert_allclose(force, body.mass * solution.a[i], atol=1e-11)
        np.testing.assert_allclose(
            torque, inertia @ solution.alpha[i] + np.cross(twist.w, inertia @ twist.w), atol=1e-11
        )


def test_gears_share_a_torque_by_their_ratio() -> None:
    """Wheels on fixed axles, 17 teeth driving 23: I1 / 17^2 + I2 / 23^2 seen by the mesh."""
    bodies = [Body(1.0, np.diag([1.0, 1.0, 0.3])), Body(1.0, np.diag([1.0, 1.0, 0.8]))]
    poses = [Pose(np.zeros(3), np.eye(3)), Pose(np.array([1.0, 0.0, 0.0]), np.eye(3))]
    held = [Joint((GROUND, i), marks_at(poses, (GROUND, i), poses[i].r, Z), joints.pin) for i in (0, 1)]
    mesh = Joint((GROUND, 0, 1), (Mark(), Mark(), Mark()), contacts.gears((17.0, 23.0)))
    torques = np.array([2.0 * Z, 0.0 * Z])
    solution = solve(bodies, [*held, mesh], poses, [REST, REST], torques=torques)
    first = 2.0 / (0.3 + 0.8 * (17.0 / 23.0) ** 2)
    np.testing.assert_allclose(solution.alpha[:, 2], [first, -17.0 / 23.0 * first], rtol=1e-12)
    np.testing.assert_allclose(solution.reactions[2].torque, -0.8 * 17.0 / 23.0 * first * Z, atol=1e-12)


def test_contradicting_rates_are_refused() -> None:
    bodies, held, poses, twists = _pendulum(0.4, 0.0, 0.4)

    def drive(rate: float) -> Joint:
        return Joint((GROUND, 0), held[0].marks, joints.turn(lambda t: (0.4, rate, 0.0)))

    drives = [drive(1.0), drive(2.0)]
    with pytest.raises(ValueError, match="rows that contradict each other by"):
        project_velocity(bodies, [*held, *drives], poses, twists)
