# SPDX-License-Identifier: BSD-3-Clause
"""The spherical pendulum: swings in a plane, its conserved speed, its singularity, and small ellipses."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import spherical_pendulum

l, g = 0.7, 9.81


def test_in_a_plane_it_is_a_pendulum() -> None:
    eom = kn.derive(spherical_pendulum.system())
    theta, rate = np.random.default_rng(7).uniform(0.2, 2.8, (2, 20))
    phi, theta_dot2 = eom.evaluate(eom.accelerations, q=[0.4, theta], u=[0, rate])
    np.testing.assert_allclose(phi, 0, atol=1e-14)
    np.testing.assert_allclose(theta_dot2, -g / l * np.sin(theta), rtol=1e-13)


def test_angular_momentum_as_a_speed_is_constant() -> None:
    eom = kn.derive(spherical_pendulum.system(speeds="momentum"))
    q, u = np.random.default_rng(8).uniform(0.3, 2.5, (2, 2, 20))
    np.testing.assert_allclose(eom.evaluate(eom.accelerations[0], q=q, u=u), 0, atol=1e-12)


@pytest.mark.parametrize("speeds", spherical_pendulum.SPEEDS)
def test_hanging_straight_down_is_named_as_singular(speeds: str) -> None:
    eom = kn.derive(spherical_pendulum.system(speeds=speeds))
    with pytest.raises(kn.SimulationError, match=r"singular|mass matrix"):
        kn.simulate(eom, (0, 1), q={"phi": 0.3, "theta": 0}, u=[0.1, 0.2])


def test_small_motions_are_ellipses() -> None:
    """x = a cos wt, y = b sin wt with w² = g/l, up to the square of the amplitude."""
    eom = kn.derive(spherical_pendulum.system(speeds="velocity"))
    w, a, b = np.sqrt(g / l), 2e-4, 1e-4
    sol = kn.simulate(eom, (0, 2), q=[0.0, a / l], u=[0.0, b * w], rtol=1e-10, atol=1e-14)
    place = sol[eom.bodies[0].part.mass_center.position(eom.points[0])]
    np.testing.assert_allclose(place[:, 0], a * np.cos(w * sol.t), atol=1e-6 * a)
    np.testing.assert_allclose(place[:, 1], b * np.sin(w * sol.t), atol=1e-6 * a)
