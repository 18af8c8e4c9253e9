# SPDX-License-Identifier: BSD-3-Clause
"""Energy, momentum and the mass matrix of every system of the gallery, for every choice of speeds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kane as kn
from kane.gallery import free_body, gimbal_gyroscope, particle_on_spring, spherical_pendulum, spinning_top
from tests.gallery.cases import CASES, Case, States, case_of, equations, random_states
from tests.oracles.compare import tolerance

STATES = 25
ALL = [pytest.param(c, s, id=f"{c.name}, {s}") for c in CASES for s in c.speeds]
HOMOGENEOUS = [pytest.param(c, s, id=f"{c.name}, {s}") for c in CASES for s in c.speeds if s != "scrambled"]


@pytest.mark.slow
@pytest.mark.parametrize(("case", "speeds"), ALL)
def test_power_balance(case: Case, speeds: str) -> None:
    eom, states = equations(case, speeds), random_states(case, STATES)
    derivative, power = states.evaluate(eom, [eom.time_derivative(eom.energy), eom.power])
    M = states.matrix(eom, eom.mass_matrix)
    u = np.array(list(states.speeds(eom.system).values()))
    u_dot = states.evaluate(eom, eom.accelerations)
    # What flows within the sum, |u| . (|M| |u'|), sets the scale of the rounding.
    flow = np.einsum("ik,kij,jk->k", np.abs(u), np.abs(M), np.abs(u_dot))
    limit = [tolerance(1e-10, c) for c in np.linalg.cond(M)]
    off = np.abs(derivative - power) / np.maximum(1.0, flow)
    assert np.all(off <= limit), f"dE/dt - P: {off.max():.1e}"


@pytest.mark.parametrize(("case", "speeds"), ALL)
def test_mass_matrix_is_symmetric_and_positive_definite(case: Case, speeds: str) -> None:
    eom, states = equations(case, speeds), random_states(case, STATES)
    M = states.matrix(eom, eom.mass_matrix)
    np.testing.assert_array_equal(M, np.swapaxes(M, 1, 2))
    assert np.linalg.eigvalsh(M).min() > 0.0


@pytest.mark.parametrize(("case", "speeds"), HOMOGENEOUS)
def test_kinetic_energy_is_that_of_the_mass_matrix(case: Case, speeds: str) -> None:
    """K = u·M u/2 where no velocity has a part without speeds."""
    eom, states = equations(case, speeds), random_states(case, STATES)
    M, u = states.matrix(eom, eom.mass_matrix), np.array(list(states.speeds(eom.system).values()))
    (kinetic,) = states.evaluate(eom, [eom.kinetic_energy])
    np.testing.assert_allclose(0.5 * np.einsum("ik,kij,jk->k", u, M, u), kinetic, rtol=1e-11)


@pytest.mark.parametrize("speeds", free_body.SPEEDS)
@pytest.mark.parametrize("name", ["free body", "free body that falls"])
def test_momentum_of_a_free_body(name: str, speeds: str) -> None:
    """ṗ = m g and Ḣ = r × m g about a fixed point."""
    case = case_of(name)
    eom, states = equations(case, speeds), random_states(case, STATES)
    N, O = eom.system.inertial, eom.points[0]
    rates = [eom.time_derivative(x) for x in eom.linear_momentum().components(N)]
    rates += [eom.time_derivative(x) for x in eom.angular_momentum(O).components(N)]
    x, y = (states.q[q] for q in eom.coordinates[4:6])
    weight = 3.0 * 9.81 if eom.system.gravities else 0.0
    zero = np.zeros(STATES)
    expected = np.array([zero, zero, zero - weight, -weight * y, weight * x, zero])
    np.testing.assert_allclose(states.evaluate(eom, rates), expected, atol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("speeds", free_body.SPEEDS)
def test_simulated_free_body_keeps_its_momentum_and_energy(speeds: str) -> None:
    case = case_of("free body")
    eom, start = equations(case, speeds), random_states(case, 1, seed=4)
    sol = simulated(eom, start, 2.0)
    for conserved in (sol[eom.linear_momentum()], sol[eom.angular_momentum(eom.points[0])], sol.energy):
        np.testing.assert_allclose(conserved, np.broadcast_to(conserved[0], conserved.shape), rtol=1e-8, atol=1e-8)
    lengths = np.linalg.norm(sol.q[:, :4], axis=1)
    np.testing.assert_allclose(lengths, 1.0, atol=1e-8)


VERTICAL = [
    *(("spherical pendulum", s) for s in spherical_pendulum.SPEEDS),
    *(("top", s) for s in spinning_top.SPEEDS),
    *(("particle on a spring in space", s) for s in particle_on_spring.SPEEDS),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "speeds"), VERTICAL)
def test_angular_momentum_about_the_vertical(name: str, speeds: str) -> None:
    """Gravity, and a spring and damper from a point on the vertical, have no moment about it."""
    case = case_of(name)
    eom, states = equations(case, speeds), random_states(case, STATES)
    vertical = eom.angular_momentum(eom.points[0]).dot(eom.system.inertial.z)
    value, rate = states.evaluate(eom, [vertical, eom.time_derivative(vertical)])
    assert np.all(np.abs(value) > 1e-6)
    np.testing.assert_allclose(rate, 0.0, atol=1e-10)
    sol = simulated(eom, random_states(case, 1, seed=case.start), 0.5)
    momentum = sol[vertical]
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-8)


@pytest.mark.parametrize("speeds", ["rates", "node", "body", "inertial"])
def test_angular_momentum_of_a_top_about_its_axis(speeds: str) -> None:
    """The weight has no moment about the axis of symmetry: J ω₃ is constant."""
    case = case_of("top")
    eom, states = equations(case, speeds), random_states(case, STATES)
    C = eom.system.rigid_bodies[0].frame
    spin = eom.time_derivative(eom.angular_velocities[C].dot(C.z))
    np.testing.assert_allclose(states.evaluate(eom, [spin]), 0.0, atol=1e-10)


@pytest.mark.parametrize("speeds", gimbal_gyroscope.SPEEDS)
def test_gyroscope_without_friction_keeps_its_energy_and_spin_momentum(speeds: str) -> None:
    case = case_of("gyroscope")
    eom, start = equations(case, speeds), random_states(case, 1, seed=2)
    sol = simulated(eom, start, 0.5, parameters={"c": 0.0})
    rotor = eom.system.rigid_bodies[2].frame
    for conserved in (sol.energy, sol[rotor.angular_velocity(eom.system.inertial).dot(rotor.y)]):
        np.testing.assert_allclose(conserved, conserved[0], rtol=1e-8)


def simulated(eom: kn.Equations, start: States, span: float, **more: Any) -> kn.Solution:
    q = {x: float(v[0]) for x, v in start.q.items()}
    u = {x: float(v[0]) for x, v in start.speeds(eom.system).items()}
    t = float(start.t[0])
    sol = kn.simulate(eom, (t, t + span), q=q, u=u, rtol=1e-10, atol=1e-11, samples=21, **more)
    assert sol.status == "finished", sol.message
    assert sol.energy_check.relative < 1e-7
    return sol
