# SPDX-License-Identifier: BSD-3-Clause
"""The top: speeds by matching, regular accelerations where the angles are singular, and the inverted pendulum."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import spinning_top

m, l, I, J, g = 0.5, 0.06, 6.0e-4, 8.0e-4, 9.81


def test_without_spin_it_is_an_inverted_pendulum() -> None:
    eom = kn.derive(spinning_top.system())
    theta, rate = np.random.default_rng(9).uniform(0.2, 2.8, (2, 20))
    psi, theta_dot2, phi = eom.evaluate(eom.accelerations, q=[0.4, theta, 0.7], u=[0, rate, 0])
    np.testing.assert_allclose(theta_dot2, m * g * l * np.sin(theta) / (I + m * l**2), rtol=1e-12)
    np.testing.assert_allclose([psi, phi], 0, atol=1e-12)


def test_angular_velocity_reads_in_the_speeds() -> None:
    for speeds, name in (("body", "C"), ("node", "B"), ("inertial", "N")):
        eom = kn.derive(spinning_top.system(speeds=speeds))
        frame = next(f for f in eom.frames if f.name == name)
        body = eom.system.rigid_bodies[0].frame
        assert [str(x) for x in eom.angular_velocities[body].components(frame)] == ["u1", "u2", "u3"]


@pytest.mark.parametrize("speeds", ["body", "inertial"])
def test_upright_the_accelerations_are_regular(speeds: str) -> None:
    """At θ = 0 the Euler angles' rates are infinite, but not ω̇: Euler's equations about the fixed point hold there."""
    eom = kn.derive(spinning_top.system(speeds=speeds))
    psi, phi, w = 0.4, 0.9, np.array([1.5, -2.0, 30.0])
    found = np.array(eom.evaluate(eom.accelerations, q=[psi, 0, phi], u=w))
    about = np.array([I + m * l**2, I + m * l**2, J])
    # The weight has no moment upright, and I is the same along N as along C, which is turned about the axis of symmetry.
    euler = np.cross(about * w, w) / about
    np.testing.assert_allclose(found, euler, rtol=1e-12)
    with pytest.raises(kn.SingularError, match=r"W of q' = W u \+ X divided by sin\(theta\) = 0"):
        eom.evaluate(eom.rates, q=[psi, 0, phi], u=w)
