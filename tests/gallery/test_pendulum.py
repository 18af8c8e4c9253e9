# SPDX-License-Identifier: BSD-3-Clause
"""The physical pendulum: small damped oscillations, and the equation for its angular momentum."""

from __future__ import annotations

import numpy as np

import kane as kn
from kane.gallery import pendulum

m, l, I, c, g = 2.0, 0.4, 0.11, 0.05, 9.81


def test_small_damped_oscillations() -> None:
    eom = kn.derive(pendulum.system())
    start = 1e-4
    sol = kn.simulate(eom, (0, 5), q=[start], u=[0], rtol=1e-10, atol=1e-15)
    about = I + m * l**2
    decay = c / (2 * about)
    w = np.sqrt(m * g * l / about - decay**2)
    expected = np.exp(-decay * sol.t) * (np.cos(w * sol.t) + decay / w * np.sin(w * sol.t))
    np.testing.assert_allclose(sol["theta"] / start, expected, atol=1e-7)


def test_angular_momentum_changes_by_the_moment() -> None:
    """With u the angular momentum about the pivot, u̇ = −m g l sin θ − c θ̇."""
    eom = kn.derive(pendulum.system(speeds="momentum"))
    q, u = np.random.default_rng(2).uniform(-3, 3, (2, 20))
    found = eom.evaluate(eom.accelerations, q=[q], u=[u])[0]
    np.testing.assert_allclose(found, -m * g * l * np.sin(q) - c * u / (I + m * l**2), rtol=1e-12, atol=1e-13)


def test_speed_of_the_mass_center() -> None:
    eom = kn.derive(pendulum.system(speeds="center"))
    np.testing.assert_allclose(eom.evaluate(eom.mass_matrix, q=[0.3], u=[0.1]), [[m + I / l**2]], rtol=1e-15)
