# SPDX-License-Identifier: BSD-3-Clause
"""Loads that contribute nothing, with the reason; inertia forces and inertia torques."""

from __future__ import annotations

import numpy as np

import kane as kn


def test_reasons():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1, q2 = kn.coordinates("q1 q2")
    F = kn.parameter("F", 1.0)
    A = N.rotate("A", q1, N.z)
    P, Q = O.at("P", A.x), O.at("Q", 2 * A.x)
    S = O.at("S", q2 * N.z)
    loads = [
        kn.Force(O, F * N.x, "at the pin"),
        kn.Force(P, F * A.x, "along the rod"),
        kn.action_reaction(P, Q, F * A.y, "no pair along the line"),
        kn.Torque(A, F * N.z, "motor"),
        kn.linear_spring(P, Q, 3, 0.5, "inner spring"),
    ]
    bodies = [kn.Particle("a", P, 1), kn.Particle("b", Q, 1), kn.Particle("c", S, 1)]
    body = kn.RigidBody("rod", frame=A, mass_center=P, mass=1, inertia=kn.rod(A, 1, 2, A.x))
    eom = kn.derive(kn.System(N, bodies=[*bodies, body], speeds="rates", loads=loads))
    found = {x.load.name: x.reason for x in eom.noncontributing}
    assert found.keys() == {"at the pin", "along the rod", "inner spring"}
    assert found["at the pin"].startswith("no speed moves O")
    assert found["along the rod"].startswith("perpendicular")
    assert found["inner spring"].startswith("perpendicular")
    assert "at the pin: no speed" in repr(eom.noncontributing)


def test_pairs_that_cancel_and_rolling():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, q = kn.coordinates("x y q")
    F, R = kn.parameter("F", 1.0), kn.parameter("R", 0.3)
    P, Q = O.at("P", x * N.x), O.at("Q", x * N.x + y * N.y)
    W = N.rotate("W", q, N.z)
    K = P.fixed_in(W, "K", -R * N.y)
    wheel = kn.RigidBody("wheel", frame=W, mass_center=P, mass=1, inertia=kn.ring(W, 1, R, W.z))
    pair = kn.action_reaction(P, Q, F * N.x, "pair")
    friction = kn.Force(K, F * N.x, "friction")
    common = {"bodies": [wheel, kn.Particle("b", Q, 1)], "speeds": "rates", "loads": [pair, friction]}
    slides = kn.derive(kn.System(N, **common))
    assert {n.load.name for n in slides.noncontributing} == {"pair"}
    assert "add up to zero" in slides.noncontributing[0].reason
    rolls = kn.derive(kn.System(N, **common, nonholonomic=kn.no_slip(K, along=N.x)))
    assert {n.load.name for n in rolls.noncontributing} == {"pair", "friction"}


def test_inertia_forces_are_newtons_and_eulers():
    """R* = −m a, T* = −dH/dt about the mass centre; Σ v_r·R* + ω_r·T* is F*_r (sec. 4.11)."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinates("q1:4")
    B = N.rotate_body("B", q, "zxz")
    P = O.at("P", B.x + 2 * B.z)
    body = kn.RigidBody("top", frame=B, mass_center=P, mass=2, inertia=kn.inertia(B, 1, 2, 2.5))
    eom = kn.derive(kn.System(N, bodies=[body], speeds="rates"))
    found = eom.inertia_forces["top"]
    rates = dict(zip(eom.speeds, (0.3, -0.8, 1.1), strict=True)) | {
        u.dt: v for u, v in zip(eom.speeds, (0.5, 0.2, -0.4), strict=True)
    }
    values = dict(zip(q, (0.4, 0.7, -0.3), strict=True)) | rates
    values |= {x.dt: rates[u] for x, u in zip(q, eom.speeds, strict=True)}
    values |= {x.dt.dt: rates[u.dt] for x, u in zip(q, eom.speeds, strict=True)}

    def same(a, b):
        np.testing.assert_allclose(*(kn.evaluate(v.components(N), values) for v in (a, b)), rtol=1e-11, atol=1e-12)

    same(found.resultant, -2 * P.acceleration(N))
    H = body.inertia.dot(B.angular_velocity(N))
    same(found.moment(P), -H.dt(N))
    for u, star in zip(eom.speeds, eom.Fr_star, strict=True):
        v, w = eom.partial_velocities[P][u], eom.partial_angular_velocities[B][u]
        share = v.dot(found.resultant) + w.dot(found.moment(P))
        np.testing.assert_allclose(kn.evaluate(share, values), kn.evaluate(star, values), rtol=1e-12)
