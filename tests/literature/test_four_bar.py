# SPDX-License-Identifier: BSD-3-Clause
"""The four-bar linkage against Newton and Euler in redundant coordinates: accelerations, every pin's reaction, the motion."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import four_bar
from tests.literature.rods import Ends, X, Y, between, pin
from tests.oracles.loops.equations import solve
from tests.oracles.loops.motion import simulate
from tests.oracles.loops.records import GROUND

LENGTHS, MASSES, GROUND_LINK = (0.4, 1.0, 0.8), (0.8, 2.0, 1.6), 1.1


@pytest.fixture(scope="module")
def motion() -> kn.Solution:
    eom = kn.derive(four_bar.system())
    return kn.simulate(eom, (0, 2), samples=41, rtol=1e-12, atol=1e-12, **four_bar.START)


def linkage(q, u):
    """Bodies, joints, poses and twists of the oracle; each reaction is that on the rod farther from O along the chain."""
    corners = [Ends(np.zeros(3))]
    for length, angle, rate in zip(LENGTHS, q, u, strict=True):
        corners.append(corners[-1].beyond(length, angle, rate))
    bodies, poses, twists = zip(
        *(between(m, p, n) for m, p, n in zip(MASSES, corners[:-1], corners[1:], strict=True)), strict=True
    )
    pairs = [(GROUND, 0), (0, 1), (1, 2), (GROUND, 2)]
    places = [*(c.p for c in corners[:3]), GROUND_LINK * X]
    held = [pin(list(poses), pair, place) for pair, place in zip(pairs, places, strict=True)]
    return list(bodies), held, list(poses), list(twists)


@pytest.mark.slow
def test_accelerations_and_every_pins_reaction(motion: kn.Solution) -> None:
    named = motion.equations.accelerations
    accelerations = np.array(motion[list(named)]).T
    forces = np.array([motion[r] for r in motion.equations.reactions]).T
    for q, u, a, f in zip(motion.q, motion.u, accelerations, forces, strict=True):
        bodies, held, poses, twists = linkage(q, u)
        found = solve(bodies, held, poses, twists, gravity=-9.81 * Y)
        np.testing.assert_allclose(a, found.alpha[:, 2], rtol=1e-9, atol=1e-9)
        for k, reaction in enumerate(found.reactions):
            assert reaction.determinate[:2].all()
            np.testing.assert_allclose(f[2 * k : 2 * k + 2], reaction.force[:2], rtol=1e-9, atol=1e-9)


@pytest.mark.slow
def test_motion(motion: kn.Solution) -> None:
    bodies, held, poses, twists = linkage(motion.q[0], motion.u[0])
    run = simulate(bodies, held, poses, twists, motion.t, gravity=-9.81 * Y, rtol=1e-12)
    for k, body in enumerate(motion.equations.system.rigid_bodies):
        place = motion[body.mass_center.position(motion.equations.points[0])]
        np.testing.assert_allclose(place, run.r(k), rtol=0, atol=1e-9)
