# SPDX-License-Identifier: BSD-3-Clause
"""Integrals of the equations of motion: named where they exist, constant along motions."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import load

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
KNOWN = {
    "spinning_top": {"energy", "momentum of psi", "momentum of phi"},
    "spherical_pendulum": {"energy", "momentum of phi"},
    "double_pendulum": {"energy"},
    "four_bar": {"energy"},
    "knife_edge": {"energy", "momentum of theta"},
    "pure_rolling_disk": {"energy"},
    "snakeboard": set(),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", KNOWN)
def test_named_where_they_exist(name):
    eom = kn.derive(load(name).system())
    assert {one.name for one in eom.integrals} == KNOWN[name]


def test_they_stay_along_a_motion():
    """Along a motion of the top each changes by no more than the integration does."""
    eom = kn.derive(load("spinning_top").system())
    motion = kn.simulate(eom, (0, 2), q=[0.1, 0.5, 0.2], u=[0.3, 0.2, 30.0], rtol=1e-11, atol=1e-11)
    for one in eom.integrals:
        values = motion[one.value]
        assert np.ptp(values) < 1e-8 * np.abs(values).max(), one.name


def rotating(spin: kn.Expr, loads: tuple[kn.Load, ...] = ()) -> kn.Equations:
    """A bead on a wire that turns as told."""
    s = kn.coordinate("s")
    W = N.rotate("W", spin, N.z)
    bead = kn.Particle("bead", O.at("B", s * W.x + 0.3 * W.y), 2.0)
    return kn.derive(kn.System(N, bodies=[bead], speeds="rates", loads=[kn.linear_spring(bead.point, O, 5.0), *loads]))


def test_the_hamiltonian_where_the_energy_is_none():
    """H = K₂ − K₀ + V is constant on a wire that turns evenly, K + V is not (Kane & Levinson 1985, sec. 7.2)."""
    (one,) = rotating(0.7 * kn.time).integrals
    assert one.name == "Hamiltonian"
    s, v = 0.4, 1.1
    h = 2.0 * (v**2 - 0.49 * (s**2 + 0.09)) / 2 + 5.0 * (s**2 + 0.09) / 2 + 0.7 * 2.0 * 0.3 * 0
    eom = rotating(0.7 * kn.time)
    assert eom.evaluate(one.value, q=[s], u=[v]) == pytest.approx(h, abs=1e-12)
    assert rotating(0.7 * kn.time**2).integrals == ()


def test_a_potential_that_is_found_counts():
    x = kn.coordinate("x")
    bead = kn.Particle("bead", O.at("B", x * N.x), 2.0)
    load = kn.Force(bead.point, -3 * x**3 * N.x, "hard spring")
    eom = kn.derive(kn.System(N, bodies=[bead], speeds="rates", loads=[load]))
    (one,) = eom.integrals
    assert one.name == "energy"
    assert "hard spring found" in one.why
    assert eom.evaluate(one.value, q=[0.5], u=[2.0]) == pytest.approx(4 + 0.75 * 0.5**4)
    damped = eom.system.replace(loads=[load, kn.Force(bead.point, -1e-6 * x.dt * N.x, "damper")])
    assert kn.derive(damped).integrals == ()


@pytest.mark.slow
def test_speeds_of_symmetric_bodies():
    """The spin of a symmetric free body, and momenta; no unit and no choice of mass changes the verdict."""
    for factor in (1.0, 1e-9, 1e9):
        eom = kn.derive(free_top(factor))
        assert "speed w3" in {one.name for one in eom.integrals}


def free_top(factor: float) -> kn.System:
    e, w = kn.coordinates("e0:4"), kn.speeds("w1:4")
    B = N.rotate_euler_parameters("B", e)
    body = kn.RigidBody(
        "body", frame=B, mass_center=O, mass=factor, inertia=kn.inertia(B, 2 * factor, 2 * factor, factor)
    )
    return kn.System(N, bodies=[body], speeds=dict(zip(w, B.angular_velocity(N).components(B), strict=True)))


def test_integrals_hold_for_all_values_of_parameters():
    """A damper whose coefficient is zero by default, and moments of inertia that are equal by default, make no integrals."""
    x, c = kn.coordinate("x"), kn.parameter("c", 0.0)
    bead = kn.Particle("bead", O.at("B", x * N.x), 2.0)
    damped = kn.System(N, bodies=[bead], speeds="rates", loads=[kn.Force(bead.point, -c * x.dt * N.x, "damper")])
    assert kn.derive(damped).integrals == ()
    I1, I2 = kn.parameter("I1", 2.0), kn.parameter("I2", 2.0)
    e, w = kn.coordinates("e0:4"), kn.speeds("w1:4")
    B = N.rotate_euler_parameters("B", e)
    body = kn.RigidBody("body", frame=B, mass_center=O, mass=1, inertia=kn.inertia(B, I1, I2, 1.0))
    eom = kn.derive(kn.System(N, bodies=[body], speeds=dict(zip(w, B.angular_velocity(N).components(B), strict=True))))
    assert "speed w3" not in {one.name for one in eom.integrals}


@pytest.mark.slow
def test_stiff_systems_have_no_integrals_by_the_size_of_their_terms():
    """Two arms that bend: bounds of the terms of u̇ are astronomic there; only the energy is kept, with that of constant torques."""
    (one,) = kn.derive(load("flexible_arm").system()).integrals
    assert one.name == "energy"
    assert "shoulder, elbow found" in one.why
