# SPDX-License-Identifier: BSD-3-Clause
"""Gravitation against sums over point masses, its moment, buoyancy and drag."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
G = kn.parameter("G", 1.3)
ROWS = np.array([[0.5, 0.1, -0.2], [0.1, 0.8, 0.05], [-0.2, 0.05, 0.6]])


def cloud(size):
    """Eight point masses with central second moments `ROWS` and no third ones: mass 3, inertia tr·1 − rows."""
    values, axes = np.linalg.eigh(ROWS * size**2)
    points = [s * axes[:, k] * np.sqrt(values[k] * 4 / 3) for k in range(3) for s in (-1, 1)]
    return np.array(points), np.full(6, 3 / 8), 3 - 6 * 3 / 8


def numbers(v, values):
    return np.asarray(kn.evaluate(v.components(N), values), dtype=float)


@pytest.mark.parametrize("distance", [40.0, 80.0])
def test_force_moment_and_potential_to_second_order(distance):
    """What is left out is of the fourth order in size over distance."""
    points, masses, middle = cloud(1.0)
    second = sum(m * np.outer(p, p) for m, p in zip(masses, points, strict=True))
    rows = np.trace(second) * np.eye(3) - second
    r = np.array([2.0, -1.0, 2.0]) / 3 * distance
    m1 = 5.0
    force, torque, potential = -1.3 * m1 * middle * r / distance**3, np.zeros(3), -1.3 * m1 * middle / distance
    for m, p in zip(masses, points, strict=True):
        d = r + p
        f = -1.3 * m1 * m * d / np.linalg.norm(d) ** 3
        force, torque = force + f, torque + np.cross(p, f)
        potential -= 1.3 * m1 * m / np.linalg.norm(d)
    x = kn.coordinates("x1:4")
    P = O.at("P", x[0] * N.x + x[1] * N.y + x[2] * N.z)
    body = kn.RigidBody(
        "moon", frame=N.rotate("B", 0, N.z), mass_center=P, mass=3, inertia=kn.Dyadic.of(N, rows.tolist())
    )
    load = kn.gravitation(kn.Particle("earth", O, m1), body, G)
    values = dict(zip(x, r, strict=True))
    (_, pull), (_, back) = load.forces
    small = (1.0 / distance) ** 4
    np.testing.assert_allclose(numbers(pull, values), force, rtol=0, atol=6 * small * np.linalg.norm(force))
    np.testing.assert_allclose(numbers(back, values), -numbers(pull, values))
    ((_, turn),) = load.torques
    np.testing.assert_allclose(
        numbers(turn, values), torque, rtol=0, atol=6 * small * distance**2 * np.linalg.norm(torque)
    )
    assert kn.evaluate(load.potential, values) == pytest.approx(potential, rel=6 * small)
    plain = -1.3 * m1 * 3 * r / distance**3
    assert np.linalg.norm(plain - force) > 30 * small * np.linalg.norm(force)  # the second order matters
    gradient = [kn.evaluate(kn.diff(load.potential, q), values) for q in x]
    np.testing.assert_allclose(numbers(pull, values), -np.array(gradient), rtol=1e-11)


def test_two_extended_bodies_keep_their_angular_momentum():
    q = kn.coordinates("q1:7")
    A, B = N.rotate("A", q[0], N.z), N.rotate_body("B", q[1:4], "xyz")
    P = O.at("P", (4 + q[4]) * N.x + q[5] * N.y)
    one = kn.RigidBody("one", frame=A, mass_center=O, mass=2, inertia=kn.inertia(A, 1, 2, 2.5))
    other = kn.RigidBody("other", frame=B, mass_center=P, mass=3, inertia=kn.inertia(B, 1, 1.5, 0.7))
    load = kn.gravitation(one, other, G)
    values = dict(zip(q, (0.3, -0.2, 0.9, 0.4, 0.5, 1.2), strict=True))
    whole = kn.force_system(load)
    assert len(load.torques) == 2
    np.testing.assert_allclose(numbers(whole.moment(O), values), 0, atol=1e-15)
    assert whole.is_couple
    system = kn.System(N, bodies=[one, other], speeds="rates", loads=[load])
    kn.derive(system)  # no warning: the potential is that of the forces and torques


def test_particles_attract_each_other():
    x = kn.coordinate("x")
    P = O.at("P", x * N.x)
    load = kn.gravitation(kn.Particle("a", O, 2), kn.Particle("b", P, 3), G)
    assert not load.torques
    assert numbers(load.forces[0][1], {x: 2.0})[0] == pytest.approx(-1.3 * 6 / 4)
    with pytest.raises(kn.ModelError, match="apart"):
        kn.gravitation(kn.Particle("a", O, 2), kn.Particle("b", O, 3), G)
    with pytest.raises(kn.ModelError, match=r"kn\.composite"):
        kn.gravitation([kn.Particle("a", O, 2), kn.Particle("b", P, 2)], kn.Particle("c", O, 3), G)


def test_gravity_moment_librates():
    """Pitch of a satellite on a circular orbit: θ'' = −3 k (Ix − Iz)/Iy sin θ cos θ, for small angles √(3 k (Ix − Iz)/Iy)."""
    q, k = kn.coordinate("q"), kn.parameter("k", 0.4)
    B = N.rotate("B", q, N.y)
    body = kn.RigidBody("sat", frame=B, mass_center=O, mass=1, inertia=kn.inertia(B, 2, 1.5, 1))
    load = kn.gravity_moment(body, N.z, k)
    eom = kn.derive(kn.System(N, bodies=[body], speeds="rates", loads=[load]))
    found = float(eom.evaluate(eom.accelerations[0], q=[0.3], u=[0]))
    assert found == pytest.approx(-3 * 0.4 * (2 - 1) / 1.5 * np.sin(0.3) * np.cos(0.3), rel=1e-13)
    with pytest.raises(kn.ModelError, match="extended"):
        kn.gravity_moment(kn.Particle("p", O, 1), N.z, k)


def test_buoyancy_and_drag():
    z, x = kn.coordinate("z", "m"), kn.coordinate("x", "m")
    P = O.at("P", z * N.z + x * N.x)
    rho, V = kn.parameter("rho", 1000.0, "kg/m^3"), kn.parameter("V", 0.01, "m^3")
    g, c = kn.parameter("g", 9.81, "m/s^2"), kn.parameter("c", 0.3, "N*s/m")
    lift = kn.buoyancy(P, rho, V, -g * N.z)
    assert str(lift.forces[0][1].components(N)[2]) == str(g * rho * V)
    assert kn.unit_of(lift.potential) in ("J", "N*m", "kg*m^2/s^2")
    assert kn.diff(lift.potential, z) is -(rho * V * g)
    drag = kn.linear_drag(P, c)
    assert str(drag.forces[0][1]) == "-c*x' N.x - c*z' N.z"
    wind = kn.linear_drag(P, c, 3 * N.x)
    assert numbers(wind.forces[0][1], {x.dt: 1.0, z.dt: 0.0})[0] == pytest.approx(0.3 * 2)
    square = kn.quadratic_drag(P, kn.parameter("d", 0.2, "kg/m"))
    np.testing.assert_allclose(numbers(square.forces[0][1], {x.dt: 3.0, z.dt: -4.0}), [-0.2 * 5 * 3, 0, 0.2 * 5 * 4])
    m = kn.parameter("m", 2.0, "kg")
    eom = kn.derive(
        kn.System(N, bodies=[kn.Particle("p", P, m)], speeds="rates", loads=[lift, drag, square, kn.gravity(-g * N.z)])
    )
    found = eom.evaluate(eom.accelerations, q=dict(zip((z, x), (0, 0), strict=True)), u=[0, 0])
    assert sorted(float(v) for v in found) == pytest.approx([0, 0.01 * 1000 * 9.81 / 2 - 9.81])
    with pytest.raises(kn.ModelError, match="centre of buoyancy"):
        kn.buoyancy(N, rho, V, -g * N.z)
    with pytest.raises(kn.ModelError, match=r"w\*N.x"):
        kn.linear_drag(P, c, 3)
