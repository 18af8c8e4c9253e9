# SPDX-License-Identifier: BSD-3-Clause
"""The four-bar linkage: its closure, what its reactions add up to, and that it keeps energy and constraints for long."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import four_bar


@pytest.fixture(scope="module")
def eom() -> kn.Equations:
    return kn.derive(four_bar.system())


def test_it_is_a_crank_and_rocker(eom: kn.Equations) -> None:
    """Grashof: shortest and longest together are shorter than the other two, so that the crank turns round and the rocker not."""
    a, b, c, d = (float(p.default or 0) for p in eom.parameters if p.name in "abcd")
    assert min(a, b, c, d) == a
    assert a + max(b, c, d) < a + b + c + d - a - max(b, c, d)
    sol = kn.simulate(eom, (0, 3), **four_bar.START)
    assert np.ptp(sol["q1"]) > 2 * np.pi
    assert np.ptp(sol["q3"]) < np.pi


def test_ground_pins_carry_weight_and_inertia(eom: kn.Equations) -> None:
    """O + G = m a* − m g: the forces on the whole linkage."""
    sol = kn.simulate(eom, (0, 1), samples=21, **four_bar.START)
    mass = sum(float(p.default or 0) for p in eom.parameters if p.name.startswith("m"))
    center = eom.mass_center(eom.points[0])
    momentum = eom.time_derivative(eom.linear_momentum().dot(eom.system.inertial.x))
    carried = np.array([sol["O_x"] + sol["G_x"], sol["O_y"] + sol["G_y"]])
    upward = eom.time_derivative(eom.linear_momentum().dot(eom.system.inertial.y))
    np.testing.assert_allclose(carried, [sol[momentum], sol[upward] + mass * 9.81], atol=1e-9)
    assert np.ptp(sol[center][:, 1]) > 0.1


def held(seconds: float) -> None:
    """Residual and drift of a motion of some length."""
    eom = kn.derive(four_bar.system())
    sol = kn.simulate(eom, (0, seconds), rtol=1e-11, atol=1e-11, **four_bar.START)
    assert sol.status == "finished"
    assert max(np.abs(v).max() for v in sol.constraint_residuals.values()) < 1e-10
    assert sol.energy_check.relative < 1e-8


def test_energy_and_constraints_hold() -> None:
    held(5)


@pytest.mark.slow
def test_energy_and_constraints_hold_for_long() -> None:
    held(100)
