# SPDX-License-Identifier: BSD-3-Clause
"""Closed forms that textbooks give for the systems of the gallery."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import kane as kn
from kane.gallery import (
    double_pendulum,
    free_body,
    gimbal_gyroscope,
    pendulum,
    pendulum_on_cart,
    spherical_pendulum,
    spinning_top,
)

Array = Any


def defaults(eom: kn.Equations) -> Mapping[str, float]:
    """Parameters by name."""
    return {p.name: float(p.default or 0) for p in eom.parameters}


def accelerations(eom: kn.Equations, q: Array, rates: Array, **more: Any) -> Array:
    """q'' for speeds that are the rates, (coordinates, states)."""
    return np.array(eom.evaluate(eom.accelerations, q=list(q), u=list(rates), **more))


def states(n: int, low: float = -3.0, high: float = 3.0) -> tuple[Array, Array]:
    rng = np.random.default_rng([1985, n])
    return rng.uniform(low, high, (n, 30)), rng.uniform(-4, 4, (n, 30))


@cache
def equations(module: Any, **options: Any) -> kn.Equations:
    return kn.derive(module.system(**options))


# Pendulum -----------------------------------------------------------------------------------------------------------


def test_physical_pendulum() -> None:
    """θ̈ = −(m g l sin θ + c θ̇)/(I + m l²)  (any textbook, e.g. Greenwood, Principles of Dynamics, 1988)."""
    eom = equations(pendulum)
    p, (q, v) = defaults(eom), states(1)
    expected = -(p["m"] * p["g"] * p["l"] * np.sin(q) + p["c"] * v) / (p["I"] + p["m"] * p["l"] ** 2)
    np.testing.assert_allclose(accelerations(eom, q, v), expected, rtol=1e-12)


@pytest.mark.parametrize("amplitude", [0.1, 1.0, 2.5, 3.0])
def test_period_of_a_pendulum(amplitude: float) -> None:
    """T = 4 K(sin²(θ₀/2)) √((I + m l²)/(m g l)), K the complete elliptic integral (Landau & Lifshitz, Mechanics, § 11)."""
    eom = equations(pendulum)
    p = defaults(eom)
    base = np.sqrt((p["I"] + p["m"] * p["l"] ** 2) / (p["m"] * p["g"] * p["l"]))
    period = 4 * ellipk(np.sin(amplitude / 2) ** 2) * base
    times = [0, period / 4, period / 2, period]
    sol = kn.simulate(
        eom, (0, period), q=[amplitude], u=[0], parameters={"c": 0}, rtol=1e-11, atol=1e-12, samples=times
    )
    np.testing.assert_allclose(sol["theta"], [amplitude, 0, -amplitude, amplitude], atol=1e-7)


# Double pendulum ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("speeds", double_pendulum.SPEEDS)
def test_double_pendulum_of_particles(speeds: str) -> None:
    """Lagrange's equations of the coplanar double pendulum, from L in Landau & Lifshitz, Mechanics, § 5, problem 1:

    (m₁+m₂) l₁ θ̈₁ + m₂ l₂ θ̈₂ cos δ + m₂ l₂ θ̇₂² sin δ + (m₁+m₂) g sin θ₁ = 0
    l₂ θ̈₂ + l₁ θ̈₁ cos δ − l₁ θ̇₁² sin δ + g sin θ₂ = 0,   δ = θ₁ − θ₂
    """
    eom = equations(double_pendulum, bobs=True, speeds=speeds)
    (q1, q2), (v1, v2) = states(2)
    m1, m2, l1, l2, g = 1.3, 0.4, 0.9, 0.6, 9.81
    values = {"m1": m1, "m2": m2, "l1": l1, "l2": l2, "g": g}
    x1, x2 = eom.coordinates
    leaves: dict[Any, Any] = {x1: q1, x2: q2, x1.dt: v1, x2.dt: v2}
    leaves |= {p: values.get(p.name, p.default) for p in eom.parameters}
    u = kn.evaluate(list(eom.system.speeds.values()), leaves)
    found = eom.evaluate([eom.time_derivative(r) for r in eom.rates], q=[q1, q2], u=u, parameters=values)
    a1, a2 = found
    d = q1 - q2
    first = (m1 + m2) * l1 * a1 + m2 * l2 * (a2 * np.cos(d) + v2**2 * np.sin(d)) + (m1 + m2) * g * np.sin(q1)
    second = l2 * a2 + l1 * a1 * np.cos(d) - l1 * v1**2 * np.sin(d) + g * np.sin(q2)
    np.testing.assert_allclose(first, 0, atol=1e-10)
    np.testing.assert_allclose(second, 0, atol=1e-10)


def test_double_pendulum_of_rods() -> None:
    """Two equal uniform rods of mass m and length l, angles from the downward vertical (Lagrange's equations):

    (4/3) θ̈₁ + (1/2) θ̈₂ cos δ + (1/2) θ̇₂² sin δ + (3/2)(g/l) sin θ₁ = 0
    (1/3) θ̈₂ + (1/2) θ̈₁ cos δ − (1/2) θ̇₁² sin δ + (1/2)(g/l) sin θ₂ = 0
    """
    eom = equations(double_pendulum)
    q, v = states(2)
    a = accelerations(eom, q, v)
    d = q[0] - q[1]
    first = 4 / 3 * a[0] + (a[1] * np.cos(d) + v[1] ** 2 * np.sin(d)) / 2 + 1.5 * 9.81 * np.sin(q[0])
    second = a[1] / 3 + (a[0] * np.cos(d) - v[0] ** 2 * np.sin(d)) / 2 + 0.5 * 9.81 * np.sin(q[1])
    np.testing.assert_allclose(first, 0, atol=1e-11)
    np.testing.assert_allclose(second, 0, atol=1e-11)


# Pendulum on a cart ---------------------------------------------------------------------------------------------------


def test_pendulum_on_a_cart() -> None:
    """Åström & Murray, Feedback Systems (2008), balance systems, with θ from the downward vertical:

    (M+m) ẍ + m l θ̈ cos θ − m l θ̇² sin θ + c ẋ = F
    (I + m l²) θ̈ + m l ẍ cos θ + m g l sin θ = 0
    """
    eom = equations(pendulum_on_cart, force=True)
    p, (q, v) = defaults(eom), states(2)
    F = np.linspace(-5, 5, 30)
    x, t = accelerations(eom, q, v, inputs={"F": F})
    c, s = np.cos(q[1]), np.sin(q[1])
    ml = p["m"] * p["l"]
    first = (p["M"] + p["m"]) * x + ml * (t * c - v[1] ** 2 * s) + p["c"] * v[0] - F
    second = (p["I"] + ml * p["l"]) * t + ml * (x * c + p["g"] * s)
    np.testing.assert_allclose(first, 0, atol=1e-11)
    np.testing.assert_allclose(second, 0, atol=1e-11)


# Spherical pendulum ---------------------------------------------------------------------------------------------------


def test_spherical_pendulum() -> None:
    """θ̈ = φ̇² sin θ cos θ − (g/l) sin θ and φ̈ = −2 θ̇ φ̇ cot θ  (Goldstein; Greenwood)."""
    eom = equations(spherical_pendulum)
    p, (q, v) = defaults(eom), states(2, 0.3, 2.8)
    a = accelerations(eom, q, v)
    np.testing.assert_allclose(a[0], -2 * v[0] * v[1] / np.tan(q[1]), rtol=1e-11)
    expected = v[0] ** 2 * np.sin(q[1]) * np.cos(q[1]) - p["g"] / p["l"] * np.sin(q[1])
    np.testing.assert_allclose(a[1], expected, rtol=1e-11, atol=1e-11)


def test_conical_pendulum() -> None:
    """φ̇² = g/(l cos θ) keeps θ."""
    eom = equations(spherical_pendulum)
    p, theta = defaults(eom), np.linspace(0.1, 1.4, 14)
    turn = np.sqrt(p["g"] / (p["l"] * np.cos(theta)))
    a = accelerations(eom, [0 * theta, theta], [turn, 0 * theta])
    np.testing.assert_allclose(a, 0, atol=1e-11)


# Top ------------------------------------------------------------------------------------------------------------------


def top_constants() -> tuple[float, float, float]:
    """Moments of inertia about the fixed point, across the axis and along it, and m g l."""
    p = defaults(equations(spinning_top))
    return p["I"] + p["m"] * p["l"] ** 2, p["J"], p["m"] * p["g"] * p["l"]


def test_equations_of_a_top() -> None:
    """Goldstein, Classical Mechanics, the heavy symmetrical top with one point fixed, from p_φ, p_ψ constant and L:

    I₁ θ̈ = I₁ ψ̇² sin θ cos θ − I₃ ω₃ ψ̇ sin θ + m g l sin θ
    d/dt(I₁ ψ̇ sin²θ + I₃ ω₃ cos θ) = 0,   ω₃ = φ̇ + ψ̇ cos θ constant
    """
    I1, I3, mgl = top_constants()
    q, v = states(3, 0.4, 2.7)
    v[2] *= 10
    a = accelerations(equations(spinning_top), q, v)
    c, s = np.cos(q[1]), np.sin(q[1])
    spin = v[2] + v[0] * c
    np.testing.assert_allclose(a[2] + a[0] * c - v[0] * v[1] * s, 0, atol=1e-9)
    nutation = v[0] ** 2 * s * c - I3 / I1 * spin * v[0] * s + mgl / I1 * s
    np.testing.assert_allclose(a[1], nutation, rtol=1e-11, atol=1e-9)
    vertical = I1 * (a[0] * s**2 + 2 * v[0] * v[1] * s * c) - I3 * spin * v[1] * s
    np.testing.assert_allclose(vertical / I1, 0, atol=1e-9)


@pytest.mark.parametrize("slow", [True, False])
@pytest.mark.parametrize("theta", [0.3, 1.0, 2.0])
def test_regular_precession(theta: float, slow: bool) -> None:
    """I₁ ψ̇² cos θ − I₃ ω₃ ψ̇ + m g l = 0 has two roots: slow and fast precession (Goldstein, ch. 5)."""
    I1, I3, mgl = top_constants()
    spin = 90.0
    roots = sorted(np.roots([I1 * np.cos(theta), -I3 * spin, mgl]), key=abs)
    assert np.isreal(roots).all()
    psi = roots[0] if slow else roots[1]
    eom = equations(spinning_top)
    rates = [psi, 0.0, spin - psi * np.cos(theta)]
    scale = max(1.0, psi**2)
    np.testing.assert_allclose(accelerations(eom, [0.2, theta, 0.5], rates), 0, atol=1e-11 * scale)

    node = equations(spinning_top, speeds="node")
    span = 2 * np.pi / abs(psi)
    sol = kn.simulate(
        node, (0, span), q=[0.2, theta, 0.5], u=[0.0, psi * np.sin(theta), spin], rtol=1e-10, atol=1e-11, samples=5
    )
    np.testing.assert_allclose(sol["theta"], theta, atol=1e-6)
    np.testing.assert_allclose(sol["psi"] - 0.2, psi * sol.t, atol=1e-5)


def test_precession_of_a_level_top() -> None:
    """At θ = π/2 the precession is ψ̇ = m g l/(I₃ ω₃), whatever the spin."""
    _, I3, mgl = top_constants()
    spin = np.linspace(5, 200, 20)
    level = np.full(20, np.pi / 2)
    a = accelerations(equations(spinning_top), [0 * spin, level, 0 * spin], [mgl / (I3 * spin), 0 * spin, spin])
    np.testing.assert_allclose(a, 0, atol=1e-10)


@pytest.mark.parametrize("margin", [0.99, 1.01])
def test_sleeping_top(margin: float) -> None:
    """Upright, the spin is stable from ω₃² = 4 I₁ m g l/I₃² on: two roots of I₁ s² − I₃ ω₃ s + m g l = 0 are real.

    Below that a top that is put up nearly upright falls, above it stays (Goldstein, ch. 5).
    """
    I1, I3, mgl = top_constants()
    spin = margin * np.sqrt(4 * I1 * mgl) / I3
    stable = (I3 * spin) ** 2 > 4 * I1 * mgl
    assert stable == (margin > 1)
    eom = equations(spinning_top, speeds="node")
    small = 1e-4
    sol = kn.simulate(eom, (0, 10), q=[0, small, 0], u=[0, small, spin], rtol=1e-10, atol=1e-13, samples=400)
    assert (sol["theta"].max() < 50 * small) == stable


# Free body ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gravity", [False, True])
def test_euler_equations(gravity: bool) -> None:
    """I₁ ω̇₁ = (I₂ − I₃) ω₂ ω₃ and cyclic (Euler); the mass centre moves like a particle."""
    eom = equations(free_body, gravity=gravity)
    p = defaults(eom)
    e, u = states(4)[0], states(6)[1]
    e /= np.linalg.norm(e, axis=0)
    found = np.broadcast_arrays(*eom.evaluate(eom.accelerations, q=[*e, *u[:3]], u=list(u)))
    I, w = np.array([p["I1"], p["I2"], p["I3"]])[:, None], u[:3]
    np.testing.assert_allclose(found[:3], np.cross(I * w, w, axis=0) / I, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found[3:5], 0, atol=1e-14)
    np.testing.assert_allclose(found[5], -9.81 if gravity else 0.0, rtol=1e-14)


def test_torque_free_motion_in_elliptic_functions() -> None:
    """ω(t) in Jacobi's functions for I₁ < I₂ < I₃ and H² > 2 K I₂ (Landau & Lifshitz, Mechanics, § 37)."""
    eom = equations(free_body)
    p = defaults(eom)
    I1, I2, I3 = p["I1"], p["I2"], p["I3"]
    w1, w3 = 0.8, 2.5
    K2 = I1 * w1**2 + I3 * w3**2
    H2 = (I1 * w1) ** 2 + (I3 * w3) ** 2
    assert H2 > K2 * I2
    rate = np.sqrt((I3 - I2) * (H2 - K2 * I1) / (I1 * I2 * I3))
    modulus = (I2 - I1) * (K2 * I3 - H2) / ((I3 - I2) * (H2 - K2 * I1))
    start = {"e0": 1, "e1": 0, "e2": 0, "e3": 0, "x": 0, "y": 0, "z": 0}
    sol = kn.simulate(eom, (0, 8), q=start, u=[w1, 0, w3, 0, 0, 0], rtol=1e-11, atol=1e-12, samples=100)
    sn, cn, dn, _ = ellipj(rate * sol.t, modulus)
    amplitude = np.sqrt((K2 * I3 - H2) / (I2 * (I3 - I2)))
    np.testing.assert_allclose(sol.u[:, 0], w1 * cn, atol=1e-8)
    np.testing.assert_allclose(sol.u[:, 1], amplitude * sn, atol=1e-8)
    np.testing.assert_allclose(sol.u[:, 2], w3 * dn, atol=1e-8)


def test_symmetrical_free_body() -> None:
    """With I₁ = I₂ the transverse ω turns in the body at (I₃ − I₁) ω₃/I₁ (Goldstein, ch. 5)."""
    eom = equations(free_body)
    inertia = {"I1": 0.05, "I2": 0.05, "I3": 0.08}
    turn = 0.03 / 0.05 * 2.0
    q = [1, 0, 0, 0, 0, 0, 0]
    u = [0.7, 0, 2, 0, 0, 0]
    sol = kn.simulate(eom, (0, 5), q=q, u=u, parameters=inertia, rtol=1e-11, atol=1e-12, samples=50)
    expected = np.stack([0.7 * np.cos(turn * sol.t), 0.7 * np.sin(turn * sol.t), np.full(50, 2.0)], axis=1)
    np.testing.assert_allclose(sol.u[:, :3], expected, atol=1e-9)


# Gyroscope ------------------------------------------------------------------------------------------------------------


def gyro_precession(q2: float, spin: float) -> tuple[Array, Mapping[str, float]]:
    """Roots Ω of J s Ω − m g l + (B_y − B_z − I − m l²) Ω² sin q2 = 0, from ∂L/∂q2 = 0 at steady q2 with s the total spin."""
    p = defaults(equations(gimbal_gyroscope))
    square = (p["By"] - p["Bz"] - p["I"] - p["m"] * p["l"] ** 2) * np.sin(q2)
    return np.roots([square, p["J"] * spin, -p["m"] * p["g"] * p["l"]]), p


@pytest.mark.parametrize("q2", [-0.8, 0.0, 0.5])
def test_steady_precession_of_a_gyroscope(q2: float) -> None:
    """A heavy gyroscope in frictionless gimbals precesses steadily; level, at Ω = m g l/(J s), the elementary formula."""
    spin = 120.0
    roots, p = gyro_precession(q2, spin)
    eom = equations(gimbal_gyroscope, speeds="spin")
    for turn in np.atleast_1d(roots):
        found = eom.evaluate(eom.accelerations, q=[0.3, q2, 0.1], u=[turn, 0, spin], parameters={"c": 0})
        np.testing.assert_allclose(found, 0, atol=1e-11 * max(1.0, turn**2))
    if q2 == 0:
        np.testing.assert_allclose(roots, p["m"] * p["g"] * p["l"] / (p["J"] * spin), rtol=1e-12)


def test_nutation_of_a_balanced_gyroscope() -> None:
    """Level and balanced, small motions: C_z q̈1 = −J s q̇2 and C_x q̈2 = J s q̇1 with the gimbals' inertia in C (Magnus, Kreisel).

    So it nutates with the angular frequency J s/√(C_x C_z).
    """
    eom = equations(gimbal_gyroscope, speeds="spin")
    p, spin, small = defaults(eom), 150.0, 1e-6
    outer, inner = p["Az"] + p["Bz"] + p["I"], p["Bx"] + p["I"]
    still = {"c": 0, "l": 0}
    a1, a2, a3 = eom.evaluate(eom.accelerations, q=[0, 0, 0], u=[0.7 * small, -0.4 * small, spin], parameters=still)
    np.testing.assert_allclose(a1 / small, -p["J"] * spin * -0.4 / outer, rtol=1e-6)
    np.testing.assert_allclose(a2 / small, p["J"] * spin * 0.7 / inner, rtol=1e-6)
    np.testing.assert_allclose(a3, 0, atol=1e-12)

    frequency = p["J"] * spin / np.sqrt(outer * inner)
    half = np.pi / frequency
    sol = kn.simulate(
        eom, (0, 2 * half), q=[0, 0, 0], u=[0, small, spin], parameters=still, rtol=1e-11, atol=1e-16,
        samples=[0, half, 2 * half],
    )  # fmt: skip
    np.testing.assert_allclose(sol.u[:, 1] / small, [1, -1, 1], atol=1e-5)
