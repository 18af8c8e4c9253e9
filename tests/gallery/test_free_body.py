# SPDX-License-Identifier: BSD-3-Clause
"""The free body: its attitude in closed form, momentum as speeds, free fall, and no singular attitude."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import free_body
from tests.gallery.cases import euler_rates

m, I, g = 3.0, np.array([0.04, 0.07, 0.09]), 9.81


def attitudes(count: int = 20) -> Any:
    e = np.random.default_rng(10).normal(size=(4, count))
    return e / np.linalg.norm(e, axis=0)


def turned(e: Any, v: Any) -> Any:
    """Components along N of a vector with components v along the body: e v e*, by Rodrigues."""
    cross = np.cross(e[1:], v, axis=0)
    return v + 2 * e[0] * cross + 2 * np.cross(e[1:], cross, axis=0)


def test_rates_of_the_euler_parameters_are_a_quaternion_product() -> None:
    eom = kn.derive(free_body.system())
    e, w = attitudes(), np.random.default_rng(11).uniform(-3, 3, (3, 20))
    zero = np.zeros((3, 20))
    found = np.array(eom.evaluate(eom.rates[:4], q=[*e, *zero], u=[*w, *zero]))
    np.testing.assert_allclose(found, euler_rates(e, w), rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose((e * found).sum(axis=0), 0, atol=1e-14)


def test_axes_of_the_body() -> None:
    eom = kn.derive(free_body.system())
    e, frame = attitudes(), eom.system.rigid_bodies[0].frame
    for axis, unit in zip((frame.x, frame.y, frame.z), np.eye(3), strict=True):
        found = eom.evaluate(axis.components(eom.system.inertial), q=[*e, 0, 0, 0])
        np.testing.assert_allclose(found, turned(e, np.broadcast_to(unit[:, None], (3, 20))), atol=1e-14)


@pytest.mark.parametrize("speeds", free_body.SPEEDS)
def test_turn_about_a_principal_axis(speeds: str) -> None:
    """e(t) = (cos wt/2, n sin wt/2), through every attitude."""
    eom = kn.derive(free_body.system(speeds=speeds))
    w = 2.5
    spin = w * I[2] if speeds == "momentum" else w
    sol = kn.simulate(eom, (0, 5), q=[1, 0, 0, 0, 0, 0, 0], u=[0, 0, spin, 0, 0, 0], rtol=1e-11, atol=1e-12)
    half = w * sol.t / 2
    zero = np.zeros_like(half)
    np.testing.assert_allclose(sol.q[:, :4], np.stack([np.cos(half), zero, zero, np.sin(half)], axis=1), atol=1e-9)


def test_momentum_as_speeds() -> None:
    """ḣ = h × ω along the body, ṗ = m g along N."""
    eom = kn.derive(free_body.system(gravity=True, speeds="momentum"))
    h, p = np.random.default_rng(12).uniform(-2, 2, (2, 3, 20))
    found = np.array(np.broadcast_arrays(*eom.evaluate(eom.accelerations, q=[*attitudes(), *p], u=[*h, *p])))
    np.testing.assert_allclose(found[:3], np.cross(h, h / I[:, None], axis=0), rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(found[3:], np.broadcast_to([[0], [0], [-m * g]], (3, 20)), atol=1e-13)


@pytest.mark.parametrize("speeds", free_body.SPEEDS)
def test_parabola(speeds: str) -> None:
    eom = kn.derive(free_body.system(gravity=True, speeds=speeds))
    factors = np.array([*I, m, m, m]) if speeds == "momentum" else np.ones(6)
    u = factors * np.array([0.4, 3.0, -0.2, 1.0, -2.0, 4.0])
    sol = kn.simulate(eom, (0, 1.5), q=[1, 0, 0, 0, 0.1, 0.2, 0.3], u=u, rtol=1e-11, atol=1e-12)
    expected = np.array([[0.1], [0.2], [0.3]]) + np.outer([1, -2, 4], sol.t)
    expected[2] -= g * sol.t**2 / 2
    np.testing.assert_allclose(sol.q[:, 4:].T, expected, atol=1e-8)


def test_euler_parameters_must_be_of_unit_length() -> None:
    eom = kn.derive(free_body.system())
    with pytest.raises(kn.SimulationError, match="length 1\\.1"):
        kn.simulate(eom, (0, 1), q=[1.1, 0, 0, 0, 0, 0, 0], u=[0] * 6)
