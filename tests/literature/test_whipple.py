# SPDX-License-Identifier: BSD-3-Clause
"""The Whipple bicycle against Newton and Euler in redundant coordinates: accelerations, and the forces of both contacts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import whipple_bicycle
from tests.oracles.compare import error, tolerance
from tests.oracles.loops import joints
from tests.oracles.loops.contacts import rolling_wheel
from tests.oracles.loops.equations import solve
from tests.oracles.loops.joints import Joint
from tests.oracles.loops.records import GROUND, Body, Mark, Pose, Twist, mark

BIKE = whipple_bicycle.system()
REACTIONS = [kn.reaction(f"f{i}", constraint=c) for i, c in enumerate((*BIKE.nonholonomic, *BIKE.holonomic))]
N = BIKE.inertial
P = BIKE["P"]
assert isinstance(P, kn.Point)
LOAD = kn.reaction(
    "n", at=P, along=N.z
)  # the rear wheel is on the road by its coordinates: no constraint holds it there
EOM = kn.derive(BIKE.replace(reactions=[*REACTIONS, LOAD]))
INERTIA = {
    "rear wheel": (0.0603, 0.12, 0.0603, 0.0),
    "rear frame": (9.2, 11.0, 2.8, 2.4),
    "fork": (0.05892, 0.06, 0.00708, -0.00756),
    "front wheel": (0.1405, 0.28, 0.1405, 0.0),
}
INPUTS = {"T_phi": 3.0, "T_delta": -1.5}


def random_state(rng: np.random.Generator) -> dict[str, Any]:
    names = [q.name for q in EOM.coordinates]
    q: dict[str, Any] = dict(zip(names, rng.uniform(-0.6, 0.6, len(names)), strict=True))
    q["theta"] = kn.guess(0.0)
    given = dict(zip(("u1", "u4", "u5"), rng.uniform(-3, 3, 3), strict=True))
    found = kn.assemble(EOM, q=q, u=given)
    assert found.residual < 1e-12
    return {"q": found.q, "u": found.u}


def vector(v: kn.Vector, state: dict[str, Any]) -> Any:
    return np.array(EOM.evaluate(v.components(N), **state, inputs=INPUTS))


def axes(frame: kn.Frame, state: dict[str, Any]) -> Any:
    return np.column_stack([vector(a, state) for a in (frame.x, frame.y, frame.z)])


def bodies_and_joints() -> tuple[list[Body], list[Joint]]:
    mass = {b.name: kn.evaluate(b.mass, {}) for b in BIKE.rigid_bodies}
    found = []
    for b in BIKE.rigid_bodies:
        xx, yy, zz, xz = INERTIA[b.name]
        found.append(Body(float(mass[b.name]), np.array([[xx, 0, xz], [0, yy, 0], [xz, 0, zz]])))
    tilt, radius, front = np.pi / 10, 0.3, 0.35
    y = np.array([0.0, 1.0, 0.0])
    steer = np.array(
        [np.sin(tilt), 0.0, np.cos(tilt)]
    )  # in the axes of the rear frame; the fork's E axes agree at zero steer
    hub = np.array([0.0, 0.0, -radius]) - np.array([0.3, 0.0, -0.9])
    head = np.array([1.02 + 0.08, 0.0, 0.0])  # a point of the steering axis, at the road
    road = Mark(np.zeros(3), np.diag([1.0, -1.0, -1.0]))  # e3 up
    return found, [
        Joint((1, 0), (mark(hub, y), mark(np.zeros(3), y)), joints.pin),
        Joint((1, 2), (mark(head - [0.3, 0.0, -0.9], steer), mark(head - [0.9, 0.0, -0.7], steer)), joints.pin),
        Joint((2, 3), (mark(np.array([1.02, 0.0, -front]) - [0.9, 0.0, -0.7], y), mark(np.zeros(3), y)), joints.pin),
        Joint((GROUND, 0), (road, mark(np.zeros(3), y)), rolling_wheel(radius)),
        Joint((GROUND, 3), (road, mark(np.zeros(3), y)), rolling_wheel(front)),
    ]


def poses_and_twists(state: dict[str, Any]) -> tuple[list[Pose], list[Twist]]:
    poses, twists = [], []
    for b in BIKE.rigid_bodies:
        frame = b.inertia.frames()[0] if b.name == "fork" else b.frame  # the fork's inertia and marks are in E
        origin = b.mass_center.root()
        poses.append(Pose(vector(b.mass_center.position(origin), state), axes(frame, state)))
        twists.append(
            Twist(vector(EOM.velocities[b.mass_center], state), vector(EOM.angular_velocities[b.frame], state))
        )
    return poses, twists


@pytest.mark.parametrize("seed", range(5))
def test_accelerations_and_contact_forces(seed: int) -> None:
    state = random_state(np.random.default_rng([20, seed]))
    bodies, held = bodies_and_joints()
    poses, twists = poses_and_twists(state)
    frames = {f.name: f for f in EOM.frames}
    roll, steering = vector(frames["L"].x, state), vector(frames["S"].z, state)
    torques = np.zeros((4, 3))
    torques[1] = INPUTS["T_phi"] * roll - INPUTS["T_delta"] * steering
    torques[2] = INPUTS["T_delta"] * steering
    found = solve(bodies, held, poses, twists, torques=torques, gravity=np.array([0.0, 0.0, 9.81]))
    assert found.drift < 1e-10
    limit = tolerance(1e-9, found.condition)
    for i, b in enumerate(BIKE.rigid_bodies):
        assert error(vector(EOM.point_accelerations[b.mass_center], state), found.a[i]) < limit
        assert error(vector(EOM.angular_accelerations[b.frame], state), found.alpha[i]) < limit
    *forces, normal = EOM.evaluate([*REACTIONS, LOAD], **state, inputs=INPUTS)
    directions = [vector(v, state) for c in (*BIKE.nonholonomic, *BIKE.holonomic) for _, v in c.forces[:1]]
    rear = sum(f * d for f, d in zip(forces[:2], directions[:2], strict=True)) + np.array([0.0, 0.0, normal])
    front = sum(f * d for f, d in zip(forces[2:], directions[2:], strict=True))
    assert error(rear, found.reactions[3].force) < limit
    assert error(front, found.reactions[4].force) < limit


def test_power_balance_and_operations() -> None:
    state = random_state(np.random.default_rng(7))
    rate, power = EOM.evaluate([EOM.time_derivative(EOM.energy), EOM.power], **state, inputs=INPUTS)
    assert rate == pytest.approx(power, rel=1e-12)
    assert kn.derive(BIKE).operations.total <= 2000


@pytest.mark.parametrize("seed", range(3))
def test_spins_as_speeds_give_the_same_motion(seed: int) -> None:
    """The second derivatives of the coordinates do not depend on the choice of speeds."""
    state = random_state(np.random.default_rng([21, seed]))
    other = kn.derive(whipple_bicycle.system("spins"))
    q = {s.name: x for s, x in state["q"].items()}
    rates = dict(zip(q, EOM.evaluate(EOM.rates, **state), strict=True))
    at = kn.assemble(other, q=q, rates=rates)
    assert abs(at.u[other.speeds[3]] - state["u"][EOM.speeds[3]]) > 1e-2
    expected = EOM.evaluate([EOM.time_derivative(r) for r in EOM.rates], **state, inputs=INPUTS)
    found = other.evaluate([other.time_derivative(r) for r in other.rates], q=at.q, u=at.u, inputs=INPUTS)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
