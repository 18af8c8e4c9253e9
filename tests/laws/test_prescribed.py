# SPDX-License-Identifier: BSD-3-Clause
"""Prescribed motions, given as functions of time: closed forms, and dE/dt = P with the power of what moves them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import kane as kn

m = kn.parameter("m", 1.3, "kg", "mass")
l = kn.parameter("l", 0.6, "m", "length")
I = kn.parameter("I", 0.07, "kg*m^2", "central moment of inertia")
g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")
a = kn.parameter("a", 0.2, "m", "amplitude")
b = kn.parameter("b", 0.2, "rad", "amplitude of the turning")
w = kn.parameter("w", 3.0, "rad/s", "angular frequency")
c = kn.parameter("c", 0.15, "N*m*s/rad", "damping")
theta = kn.coordinate("theta", "rad", "angle from the downward vertical")
r = kn.coordinate("r", "m", "distance along the tube")
u = kn.speed("u1")
VALUES = {"m": 1.3, "l": 0.6, "I": 0.07, "g": 9.81, "a": 0.2, "b": 0.2, "w": 3.0, "c": 0.15}


@dataclass(frozen=True, eq=False)
class Driven:
    """Random states of a driven system with one coordinate, and the equations for one choice of its speed."""

    eom: kn.Equations
    q: Any
    rate: Any
    t: Any

    def evaluate(self, *exprs: kn.Expr) -> Any:
        (q,) = self.eom.coordinates
        values = {q: self.q, q.dt: self.rate, kn.time: self.t}
        speed = kn.evaluate(self.eom.system.speeds[self.eom.speeds[0]], values)
        return self.eom.evaluate(exprs, q=[self.q], u=[speed], t=self.t)

    @property
    def acceleration(self) -> Any:
        """q̈ found."""
        return self.evaluate(self.eom.time_derivative(self.eom.rates[0]))[0]


def at_random_states(system: kn.System) -> Driven:
    rng = np.random.default_rng(11)
    q, rate, t = rng.uniform(0.2, 1.3, 30), rng.uniform(-3, 3, 30), rng.uniform(0, 5, 30)
    return Driven(kn.derive(system), q, rate, t)


def pendulum_on_shaken_pivot(direction: str, speeds: str) -> kn.System:
    """The pivot moves by a sin wt along x or y."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    A = O.at("A", a * kn.sin(w * kn.time) * getattr(N, direction))
    B = N.rotate("B", theta, N.z)
    Bs = A.at("B*", -l * B.y)
    body = kn.RigidBody("pendulum", frame=B, mass_center=Bs, mass=m, inertia=kn.inertia(B, I, 0, I))
    choices: dict[str, Any] = {
        "rates": "rates",
        "center": {u: Bs.velocity(N).dot(B.x)},
        "scrambled": {u: (2 + kn.cos(theta)) * theta.dt + w * kn.sin(w * kn.time)},
    }
    return kn.System(
        N,
        bodies=[body],
        speeds=choices[speeds],
        loads=[kn.gravity(-g * N.y), kn.torsional_damper(B, N, c, N.z)],
    )


SPEEDS = ("rates", "center", "scrambled")


@pytest.mark.parametrize("speeds", SPEEDS)
@pytest.mark.parametrize("direction", ["x", "y"])
def test_pendulum_on_a_shaken_pivot(direction: str, speeds: str) -> None:
    """(I + m l²) θ̈ = −m g l sin θ − c θ̇ − m l (ẍ_A cos θ + ÿ_A sin θ)."""
    driven = at_random_states(pendulum_on_shaken_pivot(direction, speeds))
    p, q = VALUES, driven.q
    jerked = -p["a"] * p["w"] ** 2 * np.sin(p["w"] * driven.t)
    arm = np.cos(q) if direction == "x" else np.sin(q)
    moment = -p["m"] * p["l"] * (p["g"] * np.sin(q) + jerked * arm) - p["c"] * driven.rate
    expected = moment / (p["I"] + p["m"] * p["l"] ** 2)
    np.testing.assert_allclose(driven.acceleration, expected, rtol=1e-12)


@pytest.mark.parametrize("speeds", SPEEDS)
@pytest.mark.parametrize("direction", ["x", "y"])
def test_power_of_a_shaken_pivot(direction: str, speeds: str) -> None:
    """P is the pivot force's, (m a* + m g y)·v_A by Newton, less the damper's c θ̇²."""
    driven = at_random_states(pendulum_on_shaken_pivot(direction, speeds))
    eom, N = driven.eom, driven.eom.system.inertial
    derivative, power = driven.evaluate(eom.time_derivative(eom.energy), eom.power)
    np.testing.assert_allclose(derivative, power, rtol=1e-11, atol=1e-11)

    p, q, qd = VALUES, driven.q, driven.rate
    qdd = driven.acceleration
    shake_v = p["a"] * p["w"] * np.cos(p["w"] * driven.t)
    shake_a = -p["a"] * p["w"] ** 2 * np.sin(p["w"] * driven.t)
    center = p["l"] * np.array([qdd * np.cos(q) - qd**2 * np.sin(q), qdd * np.sin(q) + qd**2 * np.cos(q)])
    axis = "xy".index(direction)
    force = p["m"] * (center[axis] + shake_a + (p["g"] if direction == "y" else 0.0))
    np.testing.assert_allclose(power, force * shake_v - p["c"] * qd**2, rtol=1e-11, atol=1e-11)
    found = driven.evaluate(*eom.point_accelerations[eom.bodies[0].part.mass_center].components(N))
    np.testing.assert_allclose(found[axis], center[axis] + shake_a, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("speeds", SPEEDS)
def test_simulated_energy_with_a_shaken_pivot(speeds: str) -> None:
    system = pendulum_on_shaken_pivot("x", speeds)
    eom = kn.derive(system)
    values = {theta: 0.9, theta.dt: 0.0, kn.time: 0.0}
    start = kn.evaluate(system.speeds[eom.speeds[0]], values)
    sol = kn.simulate(eom, (0, 3), q={theta: 0.9}, u=[start], rtol=1e-10, atol=1e-12)
    assert np.ptp(sol.energy) > 0.5  # the pivot does work
    assert sol.energy_check.relative < 1e-8


def bead_on_turning_hoop(turns: kn.Expr, speeds: str) -> kn.System:
    """A bead on a hoop of radius l that turns about its vertical diameter by the angle `turns`."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    A = N.rotate("A", turns, N.z)
    B = A.rotate("B", -theta, A.y)
    P = O.at("P", -l * B.z)
    choices: dict[str, Any] = {
        "rates": "rates",
        "velocity": {u: P.velocity(N).dot(B.x)},
        "scrambled": {u: (2 + kn.cos(theta)) * theta.dt + w * kn.sin(w * kn.time)},
    }
    return kn.System(N, bodies=[kn.Particle("bead", P, m)], speeds=choices[speeds], loads=[kn.gravity(-g * N.z)])


@pytest.mark.parametrize("speeds", ["rates", "velocity", "scrambled"])
@pytest.mark.parametrize("steady", [True, False])
def test_bead_on_a_turning_hoop(steady: bool, speeds: str) -> None:
    """θ̈ = sin θ (Ω² cos θ − g/l)  (Goldstein, Classical Mechanics); the hoop's torque is d/dt(m l² sin²θ Ω)."""
    turns = w * kn.time if steady else b * kn.sin(w * kn.time)
    driven = at_random_states(bead_on_turning_hoop(turns, speeds))
    p, q, t = VALUES, driven.q, driven.t
    spin = np.full_like(t, p["w"]) if steady else p["b"] * p["w"] * np.cos(p["w"] * t)
    spin_rate = np.zeros_like(t) if steady else -p["b"] * p["w"] ** 2 * np.sin(p["w"] * t)
    expected = np.sin(q) * (spin**2 * np.cos(q) - p["g"] / p["l"])
    np.testing.assert_allclose(driven.acceleration, expected, rtol=1e-11, atol=1e-12)

    eom = driven.eom
    derivative, power = driven.evaluate(eom.time_derivative(eom.energy), eom.power)
    square = p["m"] * p["l"] ** 2
    torque = square * (2 * np.sin(q) * np.cos(q) * driven.rate * spin + np.sin(q) ** 2 * spin_rate)
    np.testing.assert_allclose(power, torque * spin, rtol=1e-10, atol=1e-11)
    np.testing.assert_allclose(derivative, power, rtol=1e-10, atol=1e-11)


@pytest.mark.parametrize("speeds", ["rates", "velocity", "scrambled"])
def test_bead_in_a_turning_tube(speeds: str) -> None:
    """r̈ = Ω² r in a horizontal plane; the torque on the tube is m (2 r ṙ Ω + r² Ω̇), with the angle b sin wt."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    A = N.rotate("A", b * kn.sin(w * kn.time), N.z)
    P = O.at("P", r * A.x)
    v = P.velocity(N)
    choices: dict[str, Any] = {
        "rates": "rates",
        "velocity": {u: v.dot(N.x)},
        "scrambled": {u: (2 + kn.cos(r / l)) * r.dt + a * w * kn.sin(w * kn.time)},
    }
    driven = at_random_states(kn.System(N, bodies=[kn.Particle("bead", P, m)], speeds=choices[speeds]))
    p, q, rate, t = VALUES, driven.q, driven.rate, driven.t
    spin = p["b"] * p["w"] * np.cos(p["w"] * t)
    spin_rate = -p["b"] * p["w"] ** 2 * np.sin(p["w"] * t)
    np.testing.assert_allclose(driven.acceleration, spin**2 * q, rtol=1e-10, atol=1e-11)
    across = 2 * rate * spin + q * spin_rate
    eom = driven.eom
    found, power, derivative = driven.evaluate(
        eom.point_accelerations[P].dot(A.y), eom.power, eom.time_derivative(eom.energy)
    )
    np.testing.assert_allclose(found, across, rtol=1e-10, atol=1e-11)
    np.testing.assert_allclose(power, p["m"] * q * across * spin, rtol=1e-10, atol=1e-11)
    np.testing.assert_allclose(derivative, power, rtol=1e-10, atol=1e-11)
