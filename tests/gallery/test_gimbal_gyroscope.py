# SPDX-License-Identifier: BSD-3-Clause
"""The gyroscope in gimbals: massless gimbals leave a heavy top, the spin is conserved, gimbal lock is regular in "spin"."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import gimbal_gyroscope

I, J, m, l, g = 3.0e-4, 5.0e-4, 0.6, 0.01, 9.81
STILL = {"c": 0.0}
RNG_STATES = np.random.default_rng(13).uniform(-1.1, 1.1, (6, 20))


def rotor_frame(eom: kn.Equations) -> kn.Frame:
    return next(b.frame for b in eom.system.rigid_bodies if b.name == "rotor")


@pytest.mark.parametrize("speeds", gimbal_gyroscope.SPEEDS)
def test_massless_gimbals_leave_a_heavy_top(speeds: str) -> None:
    """I·α + ω × I·ω = r × m g about the fixed centre, along the axes of the inner gimbal."""
    eom = kn.derive(gimbal_gyroscope.system(speeds=speeds))
    q, u = RNG_STATES[:3], 20 * RNG_STATES[3:]
    massless = {**STILL, "Az": 0, "Bx": 0, "By": 0, "Bz": 0}
    C = rotor_frame(eom)
    B = C.parent
    assert B is not None
    wanted = [*C.angular_velocity(eom.system.inertial).components(B), *eom.angular_accelerations[C].components(B)]
    values = np.array(np.broadcast_arrays(*eom.evaluate(wanted, q=q, u=u, parameters=massless)))
    w, alpha = values[:3], values[3:]
    about = np.array([[I + m * l**2], [J], [I + m * l**2]])
    left = about * alpha + np.cross(w, about * w, axis=0)
    weight = -m * g * np.array([0 * q[1], np.sin(q[1]), np.cos(q[1])])
    arm = np.broadcast_to([[0], [l], [0]], (3, 20))
    np.testing.assert_allclose(left, np.cross(arm, weight, axis=0), atol=1e-11)


def test_spin_is_conserved_with_friction_in_the_gimbals() -> None:
    """No moment acts on the rotor about its own axis."""
    eom = kn.derive(gimbal_gyroscope.system(speeds="spin"))
    found = eom.evaluate(eom.accelerations[2], q=RNG_STATES[:3], u=RNG_STATES[3:])
    np.testing.assert_allclose(found, 0, atol=1e-12)


def test_gimbal_lock() -> None:
    """At q2 = π/2 the outer and the rotor axis coincide: "spin" stays regular, "inner" does not."""
    lock: dict[str, Any] = {"q": [0.2, np.pi / 2, 0.3], "u": [1.0, 2.0, 50.0]}
    regular = kn.derive(gimbal_gyroscope.system(speeds="spin"))
    assert np.all(np.isfinite(regular.evaluate(regular.right_hand_side, **lock)))
    inner = kn.derive(gimbal_gyroscope.system(speeds="inner"))
    with pytest.raises(kn.SingularError, match=r"W of q' = W u \+ X divided by cos\(q2\)"):
        inner.evaluate(inner.rates, **lock)
    sol = kn.simulate(regular, (0, 0.2), q=[0.2, 1.4, 0.3], u=[0.5, 3.0, 50.0], rtol=1e-10, atol=1e-11)
    assert sol["q2"].max() > np.pi / 2
    assert sol.energy_check.relative < 1e-8


@pytest.mark.parametrize("speeds", gimbal_gyroscope.SPEEDS)
def test_friction_takes_energy(speeds: str) -> None:
    """P = −c (q̇1² + q̇2²)."""
    eom = kn.derive(gimbal_gyroscope.system(speeds=speeds))
    q1, q2, _ = eom.coordinates
    power, first, second = eom.evaluate([eom.power, q1.dt, q2.dt], q=RNG_STATES[:3], u=RNG_STATES[3:])
    np.testing.assert_allclose(power, -1e-4 * (first**2 + second**2), rtol=1e-12)
