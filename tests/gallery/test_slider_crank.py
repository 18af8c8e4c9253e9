# SPDX-License-Identifier: BSD-3-Clause
"""The slider-crank against its closed form, x = r cos q + √(l² − r² sin² q), and one equation of motion in q alone."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

import kane as kn
from kane.gallery import slider_crank

r, l, J, m2, m3, T, c = 0.08, 0.24, 0.02, 0.6, 0.9, 2.0, 20.0


def shape(q):
    """(Rod's angle, x), and their first and second derivatives by q."""
    s, k = r / l * np.sin(q), r / l * np.cos(q)
    w = np.sqrt(1 - s**2)
    b1 = -k / w
    b2 = s / w - k * k * s / w**3  # of −k/w, with s' = k and k' = −s
    x1 = -r * np.sin(q) - l * s * k / w
    x2 = -r * np.cos(q) - l * ((k * k - s * s) / w + (s * k) ** 2 / w**3)
    return (-np.arcsin(s), b1, b2), (r * np.cos(q) + l * w, x1, x2)


def inertia(q):
    """I of K = ½ I(q) q̇², and dI/dq; the rod's mass centre is at A + l/2 (cos b, sin b)."""
    (b, b1, b2), (_, x1, x2) = shape(q)
    u1 = -r * np.sin(q) - l / 2 * np.sin(b) * b1
    v1 = r * np.cos(q) + l / 2 * np.cos(b) * b1
    u2 = -r * np.cos(q) - l / 2 * (np.cos(b) * b1**2 + np.sin(b) * b2)
    v2 = -r * np.sin(q) + l / 2 * (-np.sin(b) * b1**2 + np.cos(b) * b2)
    rod = m2 * l * l / 12
    return J + m3 * x1**2 + m2 * (u1**2 + v1**2) + rod * b1**2, 2 * (
        m3 * x1 * x2 + m2 * (u1 * u2 + v1 * v2) + rod * b1 * b2
    )


def acceleration(q, w):
    I, dI = inertia(q)
    return (T - c * shape(q)[1][1] ** 2 * w - dI * w * w / 2) / I


def test_motion_and_forces_against_the_closed_form() -> None:
    eom = kn.derive(slider_crank.system())
    sol = kn.simulate(eom, (0, 1), rtol=1e-11, atol=1e-11, **slider_crank.START)
    ours = solve_ivp(
        lambda t, y: [y[1], acceleration(*y)], (0, 1), [np.pi / 4, 30.0], "DOP853", sol.t, rtol=1e-12, atol=1e-12
    ).y
    np.testing.assert_allclose(sol["q1"], ours[0], atol=1e-7)
    np.testing.assert_allclose(sol["u1"], ours[1], atol=1e-6)
    q, w = sol["q1"], sol["u1"]
    (b, b1, b2), (x, x1, x2) = shape(q)
    np.testing.assert_allclose(sol["q2"], b, atol=1e-12)
    np.testing.assert_allclose(sol["x"], x, atol=1e-12)
    a = acceleration(q, w)
    # On the piston along x: the pin's force on it is −pin_x (the multiplier acts on the rod).
    np.testing.assert_allclose(-sol["pin_x"] - c * x1 * w, m3 * (x1 * a + x2 * w * w), rtol=1e-9, atol=1e-8)
    np.testing.assert_allclose(sol["wall"], sol["pin_y"], atol=1e-9)  # nothing else acts on the piston across
    # Moments on the rod about its mass centre, with the force at the crank pin from its motion.
    v2 = -r * np.sin(q) * w**2 + r * np.cos(q) * a
    u2 = -r * np.cos(q) * w**2 - r * np.sin(q) * a
    spin, turn = b1 * w, b1 * a + b2 * w**2
    ax = u2 - l / 2 * (np.cos(b) * spin**2 + np.sin(b) * turn)
    ay = v2 - l / 2 * (np.sin(b) * spin**2 - np.cos(b) * turn)
    fx, fy = m2 * ax - sol["pin_x"], m2 * ay - sol["pin_y"]
    moment = l / 2 * (np.cos(b) * (sol["pin_y"] - fy) - np.sin(b) * (sol["pin_x"] - fx))
    np.testing.assert_allclose(moment, m2 * l * l / 12 * turn, rtol=1e-8, atol=1e-8)


def test_at_rest_the_torque_moves_the_reduced_inertia() -> None:
    """I(q) q̈ = T."""
    eom = kn.derive(slider_crank.system())
    start = kn.assemble(eom, q={"q1": 1.0, "q2": kn.guess(-0.2), "x": kn.guess(0.3)})
    found = eom.evaluate(eom.accelerations[0], q=start.q, u=start.u)
    np.testing.assert_allclose(found * inertia(1.0)[0], T, rtol=1e-12)
