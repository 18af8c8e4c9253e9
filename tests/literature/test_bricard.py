# SPDX-License-Identifier: BSD-3-Clause
"""IFToMM's Bricard mechanism against Newton and Euler in redundant coordinates, all six hinges whole."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import kane as kn
from kane.gallery import bricard
from tests.literature.rods import X, Y, Z, pin, rod
from tests.oracles.loops.motion import simulate
from tests.oracles.loops.records import GROUND, REST

CORNERS = (0 * X, X, X - Y, X - Y + Z, Z - Y, Z)


def held_to_redundant_coordinates(seconds: float) -> None:
    times = np.linspace(0, seconds, 11)
    eom = kn.derive(bricard.system())
    sol = kn.simulate(eom, (0, seconds), samples=times, rtol=1e-11, atol=1e-11, **bricard.START)
    bodies, poses = map(list, zip(*(rod(1.0, p, q, 0.1) for p, q in pairwise(CORNERS)), strict=True))
    chain = [GROUND, 0, 1, 2, 3, 4, GROUND]
    axes = (Y, Z, X, Y, Z, X)
    hinges = [pin(poses, pair, p, axis) for pair, p, axis in zip(pairwise(chain), CORNERS, axes, strict=True)]
    run = simulate(bodies, hinges, poses, [REST] * 5, times, gravity=-9.81 * Y, rtol=1e-11)
    assert {s.redundancies for s in run.solutions} == {1}
    for k, body in enumerate(eom.system.rigid_bodies):
        place = sol[body.mass_center.position(eom.points[0])]
        np.testing.assert_allclose(place, run.r(k), rtol=0, atol=1e-6)
    assert sol.energy_check.relative < 1e-9
    assert max(np.abs(v).max() for v in sol.constraint_residuals.values()) < 1e-10


@pytest.mark.slow
def test_motion() -> None:
    held_to_redundant_coordinates(1)


@pytest.mark.slow
def test_motion_for_ten_seconds() -> None:
    held_to_redundant_coordinates(10)
