# SPDX-License-Identifier: BSD-3-Clause
"""The implicit midpoint rule: order 2, energy bounded for ever, and steps that are told."""

import numpy as np
import pytest

import kane as kn
from kane.errors import SimulationError
from kane.gallery import pendulums
from tests.motion.steppers.runs import spring


def test_the_order_is_2_at_the_ends_and_between():
    eom = spring()
    at = np.arange(1, 81) / 10 + 0.013

    def error(h):
        sol = kn.simulate(eom, (0, 8.2), q=[1], u=[0], method="midpoint", max_step=h, samples=at)
        return np.abs(sol.q[:, 0] - np.cos(sol.t)).max()

    assert np.log2(error(0.04) / error(0.02)) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize(("steps", "size"), [(20_000, 0.005), pytest.param(1_000_000, 0.005, marks=pytest.mark.slow)])
def test_the_energy_of_a_chain_stays_bounded(steps, size):
    """Three rods from 0.3, 0.5 and −0.2 rad: the error of the second half of the motion is that of the first, where RK4's grows."""
    eom = kn.derive(pendulums.system(3))
    start = {
        "q": [0.3, 0.5, -0.2],
        "u": [0.0, 0.0, 0.0],
        "samples": 2001,
        "max_steps": 2 * steps,
        "max_step": size,
        "rtol": 1e-5,
    }
    sol = kn.simulate(eom, (0, steps * size), method="midpoint", **start)
    assert sol.steps == pytest.approx(steps, abs=1)
    change = np.abs(sol.energy - sol.energy[0])
    assert change[1001:].max() < 1.5 * change[:1000].max()
    assert change.max() < 1e-3 * np.ptp(sol[eom.kinetic_energy])


@pytest.mark.parametrize("method", ["midpoint", "rk4"])
def test_the_length_of_steps_is_told(method):
    eom = spring()
    with pytest.raises(SimulationError, match=f'max_step=, the fixed step length of method="{method}", got none'):
        kn.simulate(eom, (0, 1), q=[1], u=[0], method=method)
    sol = kn.simulate(eom, (0, 1), q=[1], u=[0], method=method, max_step=1 / 128)
    assert (sol.method, sol.steps) == (method, 128)
    assert sol.q[-1, 0] == pytest.approx(np.cos(1), abs=1e-5)


def test_a_step_that_iteration_does_not_find_is_named():
    sol = kn.simulate(spring(), (0, 10), q=[1], u=[0], method="midpoint", max_step=5)
    assert sol.status == "stopped"
    assert (
        "the iteration for a step of max_step=5 from t = 0 does not converge: give a shorter max_step=" in sol.message
    )
