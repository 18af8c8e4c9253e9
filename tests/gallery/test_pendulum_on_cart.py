# SPDX-License-Identifier: BSD-3-Clause
"""The pendulum on a cart: momentum, the force as an input, and the limits of a heavy and a free cart."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import pendulum_on_cart

M, m, l, I, c, g = 1.2, 0.4, 0.5, 0.03, 0.2, 9.81
Q, U = np.random.default_rng(6).uniform(-1.5, 1.5, (2, 2, 20))


def test_momentum_as_a_speed_changes_by_force_and_friction() -> None:
    """With u1 the horizontal momentum, u̇1 = F − c ẋ."""
    eom = kn.derive(pendulum_on_cart.system(force=True, speeds="momentum"))
    assert [s.name for s in eom.inputs] == ["F"]
    u1_dot, x_rate = eom.evaluate([eom.accelerations[0], eom.rates[0]], q=Q, u=U, inputs={"F": 0.7})
    np.testing.assert_allclose(u1_dot, 0.7 - c * x_rate, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("speeds", pendulum_on_cart.SPEEDS)
def test_without_a_force_there_is_no_input(speeds: str) -> None:
    without = kn.derive(pendulum_on_cart.system(speeds=speeds))
    with_force = kn.derive(pendulum_on_cart.system(force=True, speeds=speeds))
    assert without.inputs == ()
    found = with_force.evaluate(with_force.accelerations, q=Q, u=U, inputs={"F": 0})
    np.testing.assert_allclose(found, without.evaluate(without.accelerations, q=Q, u=U), rtol=1e-13, atol=1e-14)


def test_a_heavy_cart_stands_still() -> None:
    eom = kn.derive(pendulum_on_cart.system())
    x, theta = eom.evaluate(eom.accelerations, q=Q, u=U, parameters={"M": 1e14})
    np.testing.assert_allclose(x, 0, atol=1e-12)
    np.testing.assert_allclose(theta, -m * g * l * np.sin(Q[1]) / (I + m * l**2), rtol=1e-11)


def test_small_oscillations_on_a_free_cart() -> None:
    """ω² = (M + m) m g l/((M + m)(I + m l²) − m² l²)."""
    eom = kn.derive(pendulum_on_cart.system())
    w = np.sqrt((M + m) * m * g * l / ((M + m) * (I + m * l**2) - (m * l) ** 2))
    start, free = 1e-5, {"c": 0.0}
    sol = kn.simulate(eom, (0, 6), q=[0, start], u=[0, 0], parameters=free, rtol=1e-10, atol=1e-16)
    np.testing.assert_allclose(sol["theta"] / start, np.cos(w * sol.t), atol=1e-7)
    center = sol[eom.mass_center(eom.points[0]).dot(eom.system.inertial.x)]
    np.testing.assert_allclose(center, center[0], atol=1e-14)


def test_simulated_with_a_force() -> None:
    """Momentum is the integral of force and friction: p(t) = ∫F dt − c (x − x0)."""
    eom = kn.derive(pendulum_on_cart.system(force=True))
    sol = kn.simulate(
        eom, (0, 3), q=[0, 0.4], u=[0, 0], inputs={"F": lambda t: 2 * np.cos(3 * t)}, rtol=1e-10, atol=1e-12
    )
    momentum = sol[eom.linear_momentum().dot(eom.system.inertial.x)]
    np.testing.assert_allclose(momentum, 2 / 3 * np.sin(3 * sol.t) - c * sol["x"], atol=1e-8)
    assert sol.energy_check.relative < 1e-8
