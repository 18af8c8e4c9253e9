# SPDX-License-Identifier: BSD-3-Clause
"""IFToMM's flyball governor, with rods and with stiff springs, against Newton and Euler in redundant coordinates."""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import flyball_governor
from tests.literature.rods import X, Y, Z, pin
from tests.oracles.loops import joints
from tests.oracles.loops.jets import constant
from tests.oracles.loops.joints import Joint
from tests.oracles.loops.motion import Loads, simulate
from tests.oracles.loops.records import GROUND, Body, Pose, Twist, mark, marks_at

RATE, ALPHA, ROD, BALL, WIDTH = 2 * pi, pi / 6, 0.3, 5.0, 0.01
SHAFT, SLIDER, ARMS = 0, 1, (2, 3)


def box(mass: float, a: float, b: float, c: float) -> Any:
    return mass / 12 * np.diag([b * b + c * c, c * c + a * a, a * a + b * b])


def governor() -> tuple[list[Body], list[Joint], list[Pose], list[Twist], list[Joint]]:
    """The benchmark at its start, each ball one body with its rod; last the couplers, rigid."""
    bodies = [Body(ROD, box(ROD, WIDTH, WIDTH, 1.0)), Body(3.0, box(3.0, 0.1, 0.1, 0.1))]
    poses = [Pose(0.5 * Z, np.eye(3)), Pose(0.5 * Z, np.eye(3))]
    arm = (ROD * 0.5 + BALL) / (ROD + BALL)  # of the common mass centre, from the hinge
    across = ROD * (arm - 0.5) ** 2 + BALL * (1 - arm) ** 2
    inertia = box(ROD, 1.0, WIDTH, WIDTH) + np.diag([0.0, across, across])
    hinges = []
    for side in (1, -1):
        way = side * cos(ALPHA) * X - sin(ALPHA) * Z
        hinge = Z + side * 0.05 * X
        bodies.append(Body(ROD + BALL, inertia))
        poses.append(Pose(hinge + arm * way, np.column_stack([way, Y, np.cross(way, Y)])))
        hinges.append(hinge)
    spin = RATE * Z
    twists = [Twist(np.cross(spin, pose.r), spin) for pose in poses]
    held = [
        pin(poses, (GROUND, SHAFT), np.zeros(3)),
        Joint((SHAFT, SLIDER), marks_at(poses, (SHAFT, SLIDER), 0.5 * Z, Z), joints.slider),
    ]
    held += [pin(poses, (SHAFT, k), hinge, Y) for k, hinge in zip(ARMS, hinges, strict=True)]
    couplers = [
        Joint((k, SLIDER), (mark((0.5 - arm) * X, Z), mark(side * 0.05 * X, Z)), joints.distance(constant(0.5)))
        for k, side in zip(ARMS, (1, -1), strict=True)
    ]
    return bodies, held, poses, twists, couplers


def springs(couplers: list[Joint]) -> Loads:
    """8e5 N/m and 4e4 N s/m between the couplers' ends."""

    def load(t: float, poses: Any, twists: Any) -> tuple[Any, Any]:
        force, torque = np.zeros((4, 3)), np.zeros((4, 3))
        for joint in couplers:
            arms = [poses[b].R @ m.point for b, m in zip(joint.bodies, joint.marks, strict=True)]
            ends = [poses[b].r + arm for b, arm in zip(joint.bodies, arms, strict=True)]
            rates = [twists[b].v + np.cross(twists[b].w, arm) for b, arm in zip(joint.bodies, arms, strict=True)]
            way = ends[1] - ends[0]
            length = np.linalg.norm(way)
            along = way / length
            pull = (8e5 * (length - 0.5) + 4e4 * (rates[1] - rates[0]) @ along) * along
            for b, arm, f in zip(joint.bodies, arms, (pull, -pull), strict=True):
                force[b] += f
                torque[b] += np.cross(arm, f)
        return force, torque

    return load


def held_to_redundant_coordinates(couplers: Any, seconds: float) -> None:
    times = np.linspace(0, seconds, 6)
    eom = kn.derive(flyball_governor.system(couplers=couplers))
    sol = kn.simulate(eom, (0, seconds), samples=times, rtol=1e-10, atol=1e-10, **flyball_governor.START)
    bodies, held, poses, twists, rods = governor()
    joints_there, load = (held + rods, None) if couplers == "rods" else (held, springs(rods))
    run = simulate(bodies, joints_there, poses, twists, times, load=load, gravity=-9.81 * Z, rtol=1e-10)
    np.testing.assert_allclose(sol["s"], run.r(SLIDER)[:, 2], rtol=0, atol=1e-6)
    turned = np.array([[pose[SHAFT].R[1, 0], pose[SHAFT].R[0, 0]] for pose in run.poses])
    np.testing.assert_allclose(np.sin(sol["psi"] - np.arctan2(*turned.T)), 0, atol=1e-6)


@pytest.mark.slow
def test_with_rods() -> None:
    held_to_redundant_coordinates("rods", 1)


@pytest.mark.slow
def test_with_stiff_springs() -> None:
    held_to_redundant_coordinates("springs", 0.01)


@pytest.mark.slow
@pytest.mark.parametrize(("couplers", "seconds"), [("rods", 10), ("springs", 0.1)])
def test_for_long(couplers: str, seconds: float) -> None:
    held_to_redundant_coordinates(couplers, seconds)
