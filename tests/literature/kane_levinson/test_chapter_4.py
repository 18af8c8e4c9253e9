# SPDX-License-Identifier: BSD-3-Clause
"""Kane & Levinson 1985, chapter 4: sets of forces, generalized active forces, generalized inertia forces.

Each problem is of the kind of its section; what is expected is in closed form, or computed in NumPy without `kane`.
"""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)


def numbers(v, values=None):
    return np.asarray(kn.evaluate(v.components(N), values or {}), dtype=float)


# 4.1 to 4.3 Moments, couples, equivalence ---------------------------------------------------------------------------------------


def test_three_forces_along_skew_edges_of_a_cube():
    """Equal forces along three edges that do not meet: R = F (1, 1, 1), the axis is the diagonal, the pitch the moment over R."""
    F, a = kn.parameter("F", 2.0, "N"), kn.parameter("a", 0.5, "m")
    s = kn.force_system([(O.at("A", a * N.y), F * N.x), (O.at("B", a * N.z), F * N.y), (O.at("C", a * N.x), F * N.z)])
    assert str(s.resultant) == "F N.x + F N.y + F N.z"
    wrench = s.wrench(O)
    moment = np.cross([0, 0.5, 0], [2, 0, 0]) + np.cross([0, 0, 0.5], [0, 2, 0]) + np.cross([0.5, 0, 0], [0, 0, 2])
    np.testing.assert_allclose(numbers(s.moment(O)), moment)
    assert float(kn.evaluate(wrench.pitch, {})) == pytest.approx(moment.sum() / 6)
    np.testing.assert_allclose(numbers(wrench.position), np.cross([2, 2, 2], moment) / 12, atol=1e-15)


def test_forces_around_a_triangle_are_a_couple():
    """Forces along the sides, as long as the sides: the moment is twice the area, about every point."""
    corners = np.array([[0, 0, 0], [3.0, 0, 0], [1.0, 2.0, 0]])
    pairs = []
    for k in range(3):
        p, f = corners[k], corners[(k + 1) % 3] - corners[k]
        pairs.append((O.at(f"P{k}", float(p[0]) * N.x + float(p[1]) * N.y), float(f[0]) * N.x + float(f[1]) * N.y))
    s = kn.force_system(pairs)
    assert s.is_couple
    np.testing.assert_allclose(numbers(s.torque), [0, 0, 2 * 3.0])
    np.testing.assert_allclose(numbers(s.moment(O.at("far", 7 * N.x - 5 * N.z))), [0, 0, 6.0], atol=1e-13)


def test_a_beam_under_a_triangular_load():
    """w x/L over L is equivalent to w L/2 at 2 L/3."""
    w, L = kn.parameter("w", 4.0, "N/m"), kn.parameter("L", 3.0, "m")
    load = kn.line_load(N, O, L * N.x, lambda s: -w * s * N.y)
    one = kn.force_system((O.at("R", 2 * L / 3 * N.x), -w * L / 2 * N.y))
    assert kn.force_system(load).is_equivalent(one)
    assert not kn.force_system(load).is_equivalent(kn.force_system((O.at("M", L / 2 * N.x), -w * L / 2 * N.y)))


def test_a_sluice_gate():
    """Water of depth h on a hinged gate of breadth b: the moment about the foot is ρ g b h³/6."""
    h, b = 2.0, 3.0
    gate = kn.pressure_on_rectangle(N, O, h * N.z, b * N.y, lambda s, t: 1000 * 9.81 * h * (1 - s))
    s = kn.force_system(gate)
    np.testing.assert_allclose(numbers(s.resultant), [1000 * 9.81 * b * h**2 / 2, 0, 0], rtol=1e-13)
    assert numbers(s.moment(O))[1] == pytest.approx(1000 * 9.81 * b * h**3 / 6)


# 4.4 to 4.8 Generalized active forces -------------------------------------------------------------------------------------------


def arm():
    """Two rods with motors at the shoulder and the elbow, in a vertical plane, by absolute angular speeds."""
    q, u = kn.coordinates("q1 q2"), kn.speeds("u1 u2")
    T = (kn.parameter("T1", 3.0, "N*m"), kn.parameter("T2", 1.0, "N*m"))
    A = N.rotate("A", q[0], N.z)
    B = N.rotate("B", q[1], N.z)
    elbow = O.at("E", 1.2 * A.x)
    a, b = O.at("A*", 0.6 * A.x), elbow.at("B*", 0.5 * B.x)
    bodies = [
        kn.RigidBody("a", frame=A, mass_center=a, mass=2, inertia=kn.rod(A, 2, kn.Rational(6, 5), axis=A.x)),
        kn.RigidBody("b", frame=B, mass_center=b, mass=1, inertia=kn.rod(B, 1, 1, axis=B.x)),
    ]
    loads = [
        kn.Torque(A, T[0] * N.z, "shoulder"),
        kn.torque_pair(B, A, T[1] * N.z, "elbow"),
        kn.gravity(-9.81 * N.y),
        kn.Force(O, 5 * N.x, "at the shoulder"),
        kn.action_reaction(elbow, elbow.at("E'", 0), 7 * N.x, "within the elbow"),
    ]
    return (
        q,
        u,
        T,
        kn.derive(kn.System(N, bodies=bodies, speeds=dict(zip(u, (x.dt for x in q), strict=True)), loads=loads)),
    )


def test_generalized_active_forces_of_an_arm():
    """F₁ = T₁ − T₂ − (m₁ L/2 + m₂ L) g cos q₁, F₂ = T₂ − m₂ (l/2) g cos q₂."""
    q, _, T, eom = arm()
    found = [float(x) for x in eom.evaluate(eom.Fr, q=[0.4, 1.1], u=[0, 0])]
    wanted = [3 - 1 - (2 * 0.6 + 1 * 1.2) * 9.81 * np.cos(0.4), 1 - 0.5 * 9.81 * np.cos(1.1)]
    assert found == pytest.approx(wanted, rel=1e-13)
    assert len(q) == len(T) == 2


def test_noncontributing_forces_of_an_arm():
    """The force at the fixed shoulder, and the pair between particles that stay together (sec. 4.5)."""
    *_, eom = arm()
    assert {x.load.name for x in eom.noncontributing} == {"at the shoulder", "within the elbow"}


def test_forces_on_a_rigid_body_by_resultant_and_moment():
    """F_r = ω_r·M + v_r^Q·R for any point Q of the body (sec. 4.6)."""
    q, u = kn.coordinates("q1:5"), kn.speeds("u1:5")
    B = N.rotate_body("B", q[:3], "zxz")
    Q = O.at("Q", q[3] * N.x)
    P = Q.at("P", 0.3 * B.x + 0.2 * B.z)
    body = kn.RigidBody("b", frame=B, mass_center=Q, mass=1, inertia=kn.inertia(B, 1, 1.5, 2))
    places = [Q.at(f"K{k}", k * B.x - (k - 1) * B.y + 0.5 * B.z) for k in range(3)]
    loads = [kn.Force(p, (k + 1) * N.x - k * B.y) for k, p in enumerate(places)] + [kn.Torque(B, 2 * B.z)]
    eom = kn.derive(kn.System(N, bodies=[body], speeds=dict(zip(u, (x.dt for x in q), strict=True)), loads=loads))
    s = kn.force_system(loads)
    m = kn.motions(N, dict(zip(u, (x.dt for x in q), strict=True)), of=[P])
    for place in (P, Q):
        wanted = [
            m.partial_angular_velocities(B)[r].dot(s.moment(place)) + m.partial_velocities(place)[r].dot(s.resultant)
            for r in u
        ]
        state = {"q": [0.3, 0.8, -0.5, 0.9], "u": [0, 0, 0, 0]}
        np.testing.assert_allclose(
            np.array(eom.evaluate(wanted, **state), dtype=float),
            np.array(eom.evaluate(eom.Fr, **state), dtype=float),
            rtol=1e-11,
        )


def test_a_satellite_over_the_equator_of_an_oblate_planet():
    """Attraction in the equator: G M m/r² (1 + 3 (C − A)/(2 M r²)); no moment there (sec. 4.8)."""
    G, M, A, C, m, r = 1.0, 50.0, 20.0, 26.0, 0.1, 9.0
    planet = kn.RigidBody("planet", frame=N, mass_center=O, mass=M, inertia=kn.inertia(N, A, A, C))
    satellite = kn.Particle("satellite", O.at("S", r * N.x), m)
    load = kn.gravitation(planet, satellite, G)
    (_, pull), _ = load.forces
    np.testing.assert_allclose(
        numbers(pull), [-G * M * m / r**2 * (1 + 3 * (C - A) / (2 * M * r**2)), 0, 0], rtol=1e-13
    )
    np.testing.assert_allclose(numbers(load.torques[0][1]), 0, atol=1e-16)


# 4.11 Generalized inertia forces ------------------------------------------------------------------------------------------------


def test_inertia_torque_of_a_top_in_steady_precession():
    """T* across the nutation axis: (A p cos θ − C (s + p cos θ)) p sin θ, for precession p and spin s."""
    q, u = kn.coordinates("q1:4"), kn.speeds("u1:4")
    B = N.rotate_body("B", q, "zxz")
    A, C = 0.3, 0.5
    top = kn.RigidBody("top", frame=B, mass_center=O, mass=1, inertia=kn.inertia(B, A, A, C))
    eom = kn.derive(kn.System(N, bodies=[top], speeds=dict(zip(u, (x.dt for x in q), strict=True))))
    theta, p, s = 0.7, 1.5, 8.0
    values = (
        dict(zip(q, (0.2, theta, 0.9), strict=True)) | dict(zip(u, (p, 0.0, s), strict=True)) | {x.dt: 0.0 for x in u}
    )
    torque = numbers(eom.inertia_forces["top"].moment(O), values)
    node = np.array([np.cos(0.2), np.sin(0.2), 0])
    wanted = (A * p * np.cos(theta) - C * (s + p * np.cos(theta))) * p * np.sin(theta)
    np.testing.assert_allclose(torque, node * wanted, rtol=1e-12, atol=1e-13)


def test_generalized_inertia_forces_of_an_arm():
    """F*₁ = −(m₁ L²/3 + m₂ L²) q̈₁ − m₂ L (l/2) (cos(q₂ − q₁) q̈₂ − sin(q₂ − q₁) q̇₂²), and F*₂ likewise."""
    q, u, _, eom = arm()
    values = dict(zip(q, (0.4, 1.1), strict=True)) | dict(zip(u, (0.6, -0.8), strict=True))
    values |= {u[0].dt: 1.3, u[1].dt: 0.7}
    c, s = np.cos(0.7), np.sin(0.7)
    wanted = [
        -(2 * 1.44 / 3 + 1.44) * 1.3 - 0.6 * (c * 0.7 - s * 0.64),
        -(1 / 3) * 0.7 - 0.6 * (c * 1.3 + s * 0.36),
    ]
    assert [float(kn.evaluate(x, values)) for x in eom.Fr_star] == pytest.approx(wanted, rel=1e-12)
