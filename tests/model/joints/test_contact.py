# SPDX-License-Identifier: BSD-3-Clause
"""Wheels on planes: where they touch, what constraints say, and the force of the ground."""

from __future__ import annotations

import numpy as np
import pytest

import kane as kn
from tests.model.joints.kinds import rigid
from tests.model.joints.rates import power_and_rate
from tests.oracles.compare import error

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
G = 9.81
R = kn.parameter("R", 0.3, "m")
r = kn.parameter("r", 0.07, "m")


def disk(wheel, center, plane, normal, **more):
    return kn.disk_on_plane("tyre", wheel, center, plane, axis=wheel.z, radius=R, normal=normal, **more)


def sphere(wheel, center, plane, normal, **more):
    return kn.sphere_on_plane("tyre", wheel, center, plane, radius=R, normal=normal, **more)


def torus(wheel, center, plane, normal, **more):
    return kn.torus_on_plane("tyre", wheel, center, plane, axis=wheel.z, radius=R, crown=r, normal=normal, **more)


SHAPES = {"disk": (disk, 0.3, 0.0), "sphere": (sphere, 0.0, 0.3), "torus": (torus, 0.3, 0.07)}


def lowest(ring, crown, turn):
    """The lowest point of a torus from its centre, of 721 × 721 candidates."""
    a, b = np.meshgrid(np.linspace(-np.pi, np.pi, 721), np.linspace(-np.pi, np.pi, 721))
    out = np.stack([np.cos(a), np.sin(a), 0 * a])
    surface = ring * out + crown * (np.cos(b) * out + np.sin(b) * np.array([0, 0, 1])[:, None, None])
    points = turn @ surface.reshape(3, -1)
    return points[:, np.argmin(points[2])]


@pytest.mark.slow
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_contact_is_the_lowest_point(shape, seed):
    make, ring, crown = SHAPES[shape]
    body = kn.ball("B", O, N)
    contact = make(body.frame, body.point, O, N.z)
    e = np.random.default_rng(seed).normal(size=4)
    values = dict(zip(body.coordinates, e / np.linalg.norm(e), strict=True))
    turn = np.array(kn.evaluate(N.dcm(body.frame), values), dtype=float)
    found = np.array([float(x) for x in kn.evaluate(contact.point.position(O).components(N), values)])
    expected = lowest(ring, crown, turn)
    assert found[2] == pytest.approx(expected[2], abs=1e-5)
    np.testing.assert_allclose(found, expected, atol=3e-3)
    np.testing.assert_allclose(
        kn.evaluate(contact.particle.position(contact.point).components(N), values), 0, atol=1e-15
    )


def on_a_moving_plane(make):
    """A wheel and, below it, a plank that is free too."""
    plank = kn.free("plank", O, N, child="P")
    body = kn.free("body", plank.point.at("over", 0.5 * plank.frame.y), plank.frame, child="B")
    contact = make(body.frame, body.point, plank.point.at("Q", 0.1 * plank.frame.x), plank.frame.y)
    bodies = [rigid(j.name, j.frame, j.point, 1, kn.inertia(j.frame, 1, 2, 2.5)) for j in (plank, body)]
    return kn.System(N, bodies=bodies, joints=[plank, body], holonomic=contact.height, nonholonomic=contact.rolling)


def on_the_ground(make):
    body = kn.free("body", O, N, child="B")
    contact = make(body.frame, body.point, O, N.z)
    bodies = [rigid("b", body.frame, body.point, 1, kn.inertia(body.frame, 1, 2, 2.5))]
    return kn.System(N, bodies=bodies, joints=[body], holonomic=contact.height, nonholonomic=contact.rolling)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("system", [on_a_moving_plane, on_the_ground])
def test_the_rate_of_each_constraint_is_the_power_of_its_forces(shape, system):
    power, rate, drift, second = power_and_rate(system(SHAPES[shape][0]), 4)
    assert len(rate) == 3
    assert np.abs(rate).min() > 1e-3
    np.testing.assert_allclose(power, rate, atol=1e-12)
    np.testing.assert_allclose(drift, second, atol=1e-11)


def rolling_wheel(make, *, short=False):
    """Yaw, lean and spin, the centre anywhere: a heavy wheel on the ground."""
    q = kn.coordinates("yaw, lean, spin, x, y, z")
    Y = N.rotate("Y", q[0], N.z)
    L = Y.rotate("L", kn.pi / 2 - q[1], Y.x)
    B = L.rotate("B", q[2], L.z)
    center = O.at("B*", q[3] * N.x + q[4] * N.y + q[5] * N.z)
    contact = make(B, center, O, N.z, **({"down": -L.y} if short else {}))
    body = rigid("wheel", B, center, 1.2, kn.inertia(B, 0.03, 0.03, 0.06))
    w = B.angular_velocity(N)
    u = kn.speeds("u1:7")
    speeds = dict(zip(u, [w.dot(L.x), w.dot(L.y), w.dot(L.z), *(x.dt for x in q[3:])], strict=True))
    loads = [kn.gravity(-G * N.z), kn.Force(center, 0.7 * N.x)]
    system = kn.System(
        N, bodies=[body], speeds=speeds, loads=loads, holonomic=contact.height, nonholonomic=contact.rolling
    )
    return kn.derive(system), contact, center, u


@pytest.mark.parametrize("shape", SHAPES)
def test_the_ground_pushes_as_newton_says(shape):
    """The contact force is m (a − g) less the other force; the centre's height is that of the shape; power of contact is zero."""
    make, ring, crown = SHAPES[shape]
    eom, contact, center, u = rolling_wheel(make)
    lean, w = 0.4, [0.3, -0.8, 5.0]
    height = ring * np.cos(lean) + crown
    q = {"yaw": 0.5, "lean": lean, "spin": 1.0, "x": 0.2, "y": -0.1, "z": height}
    state = kn.assemble(eom, q=q, u=dict(zip(u[:3], w, strict=True)))
    at = {"q": state.q, "u": state.u}
    assert float(eom.evaluate(contact.height.expr, **at)) == pytest.approx(0, abs=1e-14)
    found = eom.reaction("tyre")
    assert found.point is contact.particle
    a = np.array([float(x) for x in eom.evaluate(eom.point_accelerations[center].components(N), **at)])
    force = eom.evaluate(found.force.components(N), **at)
    assert error(force, 1.2 * (a + np.array([0, 0, G])) - [0.7, 0, 0]) < 1e-11
    v = eom.evaluate(eom.velocities[contact.particle].components(N), **at)
    assert np.abs(np.array(v, dtype=float)).max() < 1e-12
    dE, P = eom.evaluate([eom.time_derivative(eom.energy), eom.power], **at)
    assert float(dE) == pytest.approx(float(P))


@pytest.mark.parametrize("shape", ["disk", "torus"])
def test_the_direction_down_may_be_given(shape):
    short, long = rolling_wheel(SHAPES[shape][0], short=True), rolling_wheel(SHAPES[shape][0])
    q, u = {"yaw": 0.5, "lean": 0.4, "spin": 1, "x": 0.2, "y": -0.1, "z": 0.35}, [0.3, -0.8, 5.0, 0.1, 0.2, -0.1]
    rows = [np.array(eom.evaluate(eom.A, q=q, u=u), dtype=float) for eom, *_ in (short, long)]
    np.testing.assert_allclose(*rows, atol=1e-14)
    assert short[0].operations.total <= long[0].operations.total


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda B: kn.sphere_on_plane("s", B, O, O, radius=0, normal=N.z), "a radius of 's' above zero, got 0"),
        (lambda B: kn.disk_on_plane("s", B, O, O, axis=N.z, radius=1, normal=N.z), "axis of 's' fixed in B"),
        (lambda B: kn.disk_on_plane("s", B, O, O, axis=B.z, radius=1, normal=B.z), "wheel 's' not to lie flat"),
        (lambda B: kn.disk_on_plane("s", B, O, O, axis=B.z, radius=1, normal=N.z, down=B.x), "down= in the plane of the wheel"),
        (lambda B: kn.disk_on_plane("s", B, O, O, axis=B.z, radius=1, normal=N.z, down=-N.z), "down= in the plane of the wheel"),
        (lambda B: kn.torus_on_plane("s", B, O, O, axis=B.z, radius=1, crown=-1, normal=N.z), "a crown radius of 's' above zero"),
        (lambda B: kn.sphere_on_plane("s", B, O, O, radius=1, normal=2 * N.z), "unit vector as the normal of 's'"),
    ],
)  # fmt: skip
def test_faults_are_named(make, message):
    q = kn.coordinates("q1:3")
    A = N.rotate("A", q[0], N.x)
    with pytest.raises(kn.ModelError, match=message):
        make(A.rotate("B", q[1], A.y))
