# SPDX-License-Identifier: BSD-3-Clause
"""K₂, K₁, K₀, Gibbs's function, F*_r by the kinetic energy, power load by load."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from kane.gallery import load
from tests.systems.beams import spinning

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q1, q2, q3 = Q = kn.coordinates("q1:4")
u1, u2, u3 = U = kn.speeds("u1:4")
T = N.rotate("T", 0.7 * kn.time + kn.sin(q3), N.z)
A = T.rotate("A", q1, T.y)
P = O.at("P", (1 + kn.time**2) * T.x + q2 * A.z)
BODY = kn.RigidBody("body", frame=A, mass_center=P, mass=1.7, inertia=kn.inertia(A, 1.0, 2.0, 2.5, 0.1, 0.2))
STATE = {"q": [0.4, -0.3, 0.8], "u": [0.7, 1.1, -0.6], "t": 0.35}


def moving() -> kn.Equations:
    speeds = {u1: q1.dt + kn.cos(q2) * q3.dt + kn.time, u2: q2.dt - q1.dt * q2, u3: 2 * q3.dt + kn.sin(q1)}
    loads = [kn.gravity(-9.81 * N.z), kn.linear_spring(P, O, 7.0, 0.2), kn.Force(P, kn.time * N.x, "push")]
    return kn.derive(kn.System(N, bodies=[BODY], speeds=speeds, loads=loads))


def gallery(name: str) -> kn.Equations:
    return kn.derive(load(name).system())


def drawn(eom: kn.Equations, seed: int = 3) -> dict[str, object]:
    """A state; Euler parameters have unit length."""
    rng = np.random.default_rng(seed)
    q = dict(zip(eom.coordinates, rng.uniform(0.1, 0.9, len(eom.coordinates)), strict=True))
    for s in eom.system.euler_parameters:
        length = np.linalg.norm([q[e] for e in s.coordinates])
        q.update((e, q[e] / length) for e in s.coordinates)
    inputs = dict.fromkeys(eom.inputs, 0.4)
    return {"q": q, "u": dict(zip(eom.speeds, rng.uniform(-1, 1, len(eom.speeds)), strict=True)), "inputs": inputs}


def test_parts_are_of_degree_two_one_and_none():
    """K(λ u) = λ² K₂ + λ K₁ + K₀ (Kane & Levinson 1985, sec. 5.5), and K₂ = ½ Σ M_rs u_r u_s."""
    eom = moving()
    two, one, none = np.array(eom.evaluate(list(eom.kinetic_energy_parts), **STATE))
    for factor in (1.0, -2.0, 0.5):
        faster = STATE | {"u": [factor * u for u in STATE["u"]]}
        assert eom.evaluate(eom.kinetic_energy, **faster) == pytest.approx(
            factor**2 * two + factor * one + none, rel=1e-13
        )
    u, m = np.array(STATE["u"]), eom.evaluate(eom.mass_matrix, **STATE)
    assert two == pytest.approx(u @ m @ u / 2, rel=1e-13)
    assert min(abs(one), none) > 0.1


@pytest.mark.parametrize(
    "name", ["spinning_top", "free_body", "gimbal_gyroscope", "sphere_on_turntable", "rolling_disk"]
)
def test_three_ways_to_inertia_forces(name):
    """−∂G/∂u̇_r, Kane's sum, and −Σ (d/dt ∂K/∂q̇_s − ∂K/∂q_s) W_sr (sec. 5.6) are one."""
    eom = gallery(name)
    at = drawn(eom)
    rates = [eom.time_derivative(u) for u in eom.speeds]
    memo = {r: kn.Rational(k + 2, 7) for k, r in enumerate(rates)}
    n = len(eom.speeds)
    gibbs = [-kn.diff(eom.gibbs_function, r) for r in rates]
    ways = [[kn.substitute(e, memo) for e in way[:n]] for way in (eom.Fr_star, gibbs, eom.Fr_star_by_energy)]
    state = {**at["q"], **at["u"], **at["inputs"]}
    numbers = [np.array(kn.evaluate(way, {**{p: p.default for p in eom.parameters}, **state})) for way in ways]
    assert numbers[1] == pytest.approx(numbers[0], rel=1e-11, abs=1e-12)
    assert numbers[2] == pytest.approx(numbers[0], rel=1e-11, abs=1e-12)


def test_with_prescribed_motion_too():
    eom = moving()
    found = eom.evaluate([*eom.Fr_star, *eom.Fr_star_by_energy], **STATE)
    assert np.array(found[3:]) == pytest.approx(np.array(found[:3]), rel=1e-11)


def test_power_load_by_load():
    """The sum of F·v is Σ F_r u_r and what prescribed motion adds; of a load with a potential it is −dV/dt."""
    eom = moving()
    spring = eom.system.loads[0]
    assert eom.evaluate(eom.load_powers[spring], **STATE) == pytest.approx(
        -eom.evaluate(eom.time_derivative(spring.potential), **STATE), rel=1e-12
    )
    assert eom.evaluate(eom.load_powers["push"], **STATE) == pytest.approx(
        eom.evaluate(0.35 * P.velocity(N).dot(N.x), **STATE), rel=1e-12
    )
    assert len(eom.load_powers) == 3


def test_units():
    eom = gallery("spinning_top")
    assert eom.unit(eom.kinetic_energy_parts.K2) == "J"


def test_flexible_bodies_too():
    """Parts whose momenta hang together: K by degrees and p_r = ∂K/∂u_r."""
    eom = kn.derive(spinning(angle=1.3 * kn.time, modes=2)[1])
    at = drawn(eom)
    parts, whole = eom.evaluate([sum(eom.kinetic_energy_parts), eom.kinetic_energy], **at)
    assert parts == pytest.approx(whole, rel=1e-11)
    own, slopes = eom.evaluate([list(eom.generalized_momenta), list(kn.gradient(eom.kinetic_energy, eom.speeds))], **at)
    assert np.array(own) == pytest.approx(np.array(slopes), rel=1e-10, abs=1e-12)
