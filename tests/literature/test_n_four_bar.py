# SPDX-License-Identifier: BSD-3-Clause
"""IFToMM's N four-bar linkages: a physical pendulum of one coordinate, and redundant coordinates up to the first alignment.

All links turn alike, so that K = ½ I q̇² with I = (n + 1) m l²/3 + n m l², and V = ((n + 1)/2 + n) m g l cos q.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kane as kn
from kane.gallery import n_four_bar
from tests.literature.rods import Ends, X, Y, between, pin
from tests.oracles.loops.motion import simulate
from tests.oracles.loops.records import GROUND


def start(n: int) -> dict[str, list[float]]:
    return {"q": [0.0] * (2 * n + 1), "u": [-1.0] * (n + 1) + [0.0] * n}


def held_to_pendulum(n: int, tolerance: float) -> kn.Solution:
    """10 s, through seven alignments; the first top starts at 1 m/s along x."""
    sol = kn.simulate(kn.derive(n_four_bar.system(n)), (0, 10), rtol=tolerance, atol=tolerance, **start(n))
    ratio = 9.81 * ((n + 1) / 2 + n) / ((n + 1) / 3 + n)
    q, u = solve_ivp(
        lambda t, y: [y[1], ratio * np.sin(y[0])], (0, 10), [0, -1], "DOP853", sol.t, rtol=1e-13, atol=1e-13
    ).y
    assert sol.status == "finished"
    assert np.sum(np.diff(np.sign(np.cos(q))) != 0) >= 7
    np.testing.assert_allclose(sol.q[:, : n + 1], np.tile(q, (n + 1, 1)).T, rtol=0, atol=1e-6)
    np.testing.assert_allclose(sol.u[:, : n + 1], np.tile(u, (n + 1, 1)).T, rtol=0, atol=1e-6)
    np.testing.assert_allclose(sol.q[:, n + 1 :], 0, atol=1e-6)
    assert max(np.abs(v).max() for v in sol.constraint_residuals.values()) < 1e-10
    assert sol.energy_check.relative < 1e-8
    return sol


@pytest.mark.slow
def test_it_goes_on_through_alignments() -> None:
    """Small steps come near the alignments, and what they do there is said."""
    sol = held_to_pendulum(2, 1e-11)
    assert "rank of the constraints drops" in {event.name for event, _ in sol.events}


@pytest.mark.slow
@pytest.mark.parametrize(("n", "tolerance"), [(1, 1e-12), (2, 1e-12), (4, 1e-10)])
def test_it_goes_on_however_small_the_steps(n: int, tolerance: float) -> None:
    held_to_pendulum(n, tolerance)


@pytest.mark.slow
def test_redundant_coordinates() -> None:
    """Up to 1 s, short of the first alignment."""
    n = 2
    times = np.linspace(0, 1, 11)
    sol = kn.simulate(kn.derive(n_four_bar.system(n)), (0, 1), samples=times, rtol=1e-11, atol=1e-11, **start(n))
    feet = [Ends(k * X) for k in range(n + 1)]
    tops = [foot.beyond(1.0, np.pi / 2, -1.0) for foot in feet]
    made = [between(1.0, p, q) for p, q in [*zip(feet, tops, strict=True), *pairwise(tops)]]
    bodies, poses, twists = map(list, zip(*made, strict=True))
    held = [pin(poses, (GROUND, k), foot.p) for k, foot in enumerate(feet)]
    for k, (left, right) in enumerate(pairwise(tops)):
        held += [pin(poses, (k, n + 1 + k), left.p), pin(poses, (k + 1, n + 1 + k), right.p)]
    run = simulate(bodies, held, poses, twists, times, gravity=-9.81 * Y, rtol=1e-11)
    for k, body in enumerate(sol.equations.system.rigid_bodies[: n + 1]):
        place = sol[body.mass_center.position(sol.equations.points[0])]
        np.testing.assert_allclose(place, run.r(k), rtol=0, atol=1e-6)
