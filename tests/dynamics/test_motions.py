# SPDX-License-Identifier: BSD-3-Clause
"""Motions without bodies: those of the same system with bodies, and definitions in the textbook's words."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import kane as kn

M = kn.parameter("M", 1.0, "kg")


class Disk:
    """A disk that rolls on a plane, by angles and the place of its contact (Kane & Levinson 1985, sec. 2.12 to 2.14)."""

    def __init__(self):
        self.N = N = kn.Frame("N")
        self.O = O = kn.Point("O", fixed_in=N)
        self.q = q = kn.coordinates("q1:6")
        self.u = kn.speeds("u1:6")
        self.R = R = kn.parameter("R", 0.3, "m")
        self.A = A = N.rotate("A", q[0], N.z)
        self.B = B = A.rotate("B", q[1], A.x)
        self.C = C = B.rotate("C", q[2], B.y)
        self.P = O.at("P", q[3] * N.x + q[4] * N.y + R * B.z)
        self.D = self.P.fixed_in(C, "D", -R * B.z)
        w = C.angular_velocity(N)
        definitions = (w.dot(B.x), w.dot(B.y), w.dot(B.z), q[3].dt, q[4].dt)
        self.speeds = dict(zip(self.u, definitions, strict=True))


@pytest.mark.slow
def test_they_are_those_of_a_system_with_bodies():
    d = Disk()
    body = kn.RigidBody("disk", frame=d.C, mass_center=d.P, mass=M, inertia=kn.thin_disk(d.C, M, d.R, d.C.y))
    held = kn.no_slip(d.D, along=[d.N.x, d.N.y])
    eom = kn.derive(kn.System(d.N, bodies=[body], speeds=d.speeds, nonholonomic=held))
    m = kn.motions(d.N, d.speeds, nonholonomic=held)
    assert str(m.angular_velocity(d.C)) == str(eom.angular_velocities[d.C]) == "u1 B.x + u2 B.y + u3 B.z"
    assert str(m.velocity(d.P)) == str(eom.velocities[d.P])
    assert str(m.acceleration(d.P)) in (str(eom.point_accelerations[d.P]), str(eom.point_accelerations[d.P].gathered()))
    assert m.partial_velocities(d.P).keys() == set(d.u)
    for u in d.u:
        assert str(m.partial_velocities(d.P)[u]) == str(eom.partial_velocities[d.P][u])
    assert m.degrees_of_freedom == 3
    assert m.dependent_speeds == (d.u[3], d.u[4])
    assert str(m.A_n) == str(eom.A_n)
    free = m.independent
    assert free.speeds == d.u[:3]
    values = {d.q[0]: 0.4, d.q[1]: 0.3, d.R: 0.3}
    for u in free.speeds:
        found, wanted = (
            v.components(d.N) for v in (free.partial_velocities(d.P)[u], eom.partial_velocities_nh[d.P][u])
        )
        np.testing.assert_allclose(kn.evaluate(found, values), kn.evaluate(wanted, values), atol=1e-15)
    assert free.velocity(d.D).is_zero
    assert [str(r) for r in m.rates] == [str(r) for r in eom.derived.rates]


@pytest.mark.parametrize("frame", "NABC")
def test_in_any_frame(frame, rng):
    """Velocities and accelerations in speeds are those in rates, in any frame; partial velocities make up the velocities."""
    d = Disk()
    F = getattr(d, frame)
    m = kn.motions(d.N, d.speeds)
    Q = d.O if frame in "NA" else d.P
    S = d.P.at("S", d.R * d.C.x + d.q[3] * d.A.y)
    K = S.fixed_in(d.C, "K", d.R * d.B.x)
    symbols = [*d.q, *(q.dt for q in d.q), *(q.dt.dt for q in d.q)]
    values = dict(zip(symbols, rng.uniform(0.2, 1, 15), strict=True)) | {d.R: 0.3}
    for u, definition in d.speeds.items():
        values[u] = float(kn.evaluate(definition, values))
        values[u.dt] = float(kn.evaluate(kn.time_derivative(definition), values))

    def same(a, b):
        one, other = (kn.evaluate(v.components(d.N), values) for v in (a, b))
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-11)

    same(m.angular_velocity(d.C, F), d.C.angular_velocity(F))
    same(m.angular_acceleration(d.C, F), d.C.angular_acceleration(F))
    for P in (S, K):
        same(m.velocity(P, F, Q), P.velocity(F, Q))
        same(m.acceleration(P, F, Q), P.acceleration(F, Q))
        parts = m.partial_velocities(P, F, Q)
        same(sum((v * u for u, v in parts.items()), start=kn.Vector()), P.velocity(F, Q))  # z = 0, no time
    turns = m.partial_angular_velocities(d.C, F)
    same(sum((w * u for u, w in turns.items()), start=kn.Vector()), d.C.angular_velocity(F))


def test_partial_velocities_are_derivatives_by_the_speeds():
    """∂v/∂u_r, and with u = q̇ ∂r/∂q_r (sec. 2.14)."""
    d = Disk()
    m = kn.motions(d.N, d.speeds)
    for u, v in m.partial_velocities(d.P).items():
        by = m.velocity(d.P).diff(u, d.N)
        values = {d.q[0]: 0.4, d.q[1]: 0.3, d.R: 0.3}
        np.testing.assert_allclose(
            kn.evaluate(v.components(d.N), values), kn.evaluate(by.components(d.N), values), atol=1e-15
        )
    rates = kn.motions(d.N, "rates", of=[d.P, d.C])
    for q, v in zip(d.q, rates.partial_velocities(d.P).values(), strict=True):
        by = d.P.position(d.O).diff(q, d.N)
        np.testing.assert_allclose(
            kn.evaluate(v.components(d.N), values), kn.evaluate(by.components(d.N), values), atol=1e-15
        )


def test_prescribed_motion_is_the_part_without_speeds():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q, u, w = kn.coordinate("q"), kn.speed("u"), kn.parameter("w")
    T = N.rotate("T", w * kn.time, N.z)
    P = O.at("P", q * T.x)
    m = kn.motions(N, {u: q.dt})
    assert str(m.velocity(P)) == "u T.x + w*q T.y"
    assert [str(v) for v in m.partial_velocities(P).values()] == ["T.x"]
    assert str(m.velocity(P, T, O)) == "u T.x"
    assert str(m.in_speeds(P.velocity(N))) == "u T.x + w*q T.y"


def test_euler_parameters_and_constraints():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    e, x, y = kn.coordinates("e0:4"), kn.coordinate("x"), kn.coordinate("y")
    B = N.rotate_euler_parameters("B", e)
    w = kn.speeds("w1:4")
    v = kn.speeds("v1:3")
    spin = B.angular_velocity(N)
    P = O.at("P", x * N.x + y * N.y)
    m = kn.motions(
        N,
        {**{u: spin.dot(a) for u, a in zip(w, (B.x, B.y, B.z), strict=True)}, v[0]: x.dt, v[1]: y.dt},
        of=[B],
        holonomic=kn.distance(P, O, 2),
        coordinates=[*e, x, y],
    )
    assert str(m.angular_velocity(B)) == "w1 B.x + w2 B.y + w3 B.z"
    assert m.degrees_of_freedom == 4
    assert len(m.coordinates) == 6


def test_errors():
    d = Disk()
    m = kn.motions(d.N, d.speeds)
    with pytest.raises(kn.SpaceError, match="origin=Q"):
        m.velocity(d.P, d.A)
    other = kn.coordinate("other")
    F = d.N.rotate("F", other, d.N.z)
    with pytest.raises(kn.SpeedsError, match=r"of=\[F\]"):
        m.angular_velocity(F)
    with pytest.raises(kn.SpeedsError, match="rate"):
        kn.motions(d.N, d.speeds, of=[F])
    with pytest.raises(kn.ModelError, match="frames and points"):
        kn.motions(d.N, d.speeds, of=[d.u[0]])
    with pytest.raises(kn.SpaceError, match="Expected a frame"):
        m.angular_velocity(d.P)
    with pytest.raises(kn.SpaceError, match="Expected a point"):
        m.velocity(d.N)
    with pytest.raises(kn.SpaceError, match="Expected a frame, got 'A'"):
        m.velocity(d.P, "A")
    with pytest.raises(kn.ModelError, match="root frame"):
        kn.motions(d.A, d.speeds)
    with pytest.raises(kn.ModelError, match="restrict the motion"):
        kn.motions(d.N, d.speeds, nonholonomic=[d.R * 0 + 1])
    assert "3 degrees" in repr(kn.motions(d.N, d.speeds, nonholonomic=kn.no_slip(d.D, along=[d.N.x, d.N.y])))


def test_units_are_checked():
    N = kn.Frame("N")
    q, u, m = kn.coordinate("q", "m"), kn.speed("u", "m/s"), kn.parameter("m", 1.0, "kg")
    P = kn.Point("O", fixed_in=N).at("P", q * m * N.x)
    with pytest.raises(kn.UnitError, match="the position of P"):
        kn.motions(N, {u: q.dt}, of=[P])


def test_they_can_be_pickled():
    d = Disk()
    m = kn.motions(d.N, d.speeds, nonholonomic=kn.no_slip(d.D, along=[d.N.x, d.N.y]))
    again = pickle.loads(pickle.dumps(m))
    assert str(again.A_n) == str(m.A_n)
