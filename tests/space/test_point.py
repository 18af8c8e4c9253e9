# SPDX-License-Identifier: BSD-3-Clause
"""Points: positions, velocities and accelerations against finite differences, and particles of a frame."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kane as kn
from tests.paths import Path, derivative, numbers, second_derivative

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
q = kn.coordinates("q1:7")
PATH = Path(q, 21, t0=0.3)
STATE = PATH.values()


def along(v, values=STATE, frame=N):
    return numbers(v.components(frame), values)


def check_motion(point, by_hand, t0=0.3):
    """Position, velocity and acceleration against a function of time written in NumPy."""
    assert along(point.position(O)) == pytest.approx(by_hand(t0), abs=1e-13)
    assert along(point.velocity(N)) == pytest.approx(derivative(by_hand, t0), abs=1e-9)
    assert along(point.acceleration(N)) == pytest.approx(second_derivative(by_hand, t0), abs=1e-7)


A = N.rotate("A", q[0], N.z)
B = A.rotate("B", q[1] + kn.sin(3 * kn.time), (A.x - 2 * A.y + 2 * A.z) / 3)
C = B.rotate_space("C", q[2:5], "zyx")
P1 = O.at("P1", (1 + q[5]) * A.x + 2 * N.z)
P2 = P1.at("P2", kn.time**2 * B.y - q[0] * q[1] * B.z)
P3 = P2.at("P3", 3 * C.z - C.x + q[2] * N.y)


def by_hand(count):
    def position(t):
        x = PATH.at(t)
        a = Rotation.from_rotvec([0, 0, x[0]])
        b = a * Rotation.from_rotvec((x[1] + np.sin(3 * t)) * np.array([1, -2, 2]) / 3)
        c = b * Rotation.from_euler("zyx", x[2:5])
        r = np.add(a.apply([1 + x[5], 0, 0]), [0, 0, 2])
        if count > 1:
            r = r + b.apply([0, t * t, -x[0] * x[1]])
        if count > 2:
            r = r + c.apply([-1, 0, 3]) + np.array([0, x[2], 0])
        return r

    return position


@pytest.mark.parametrize("count", [1, 2, 3])
def test_motion_of_nested_points(count):
    check_motion((P1, P2, P3)[count - 1], by_hand(count))


def test_a_prescribed_point():
    P = O.at("P", kn.sin(2 * kn.time) * N.x + kn.time**3 * N.y)
    assert along(P.velocity(N)) == pytest.approx([2 * np.cos(0.6), 3 * 0.09, 0])
    assert along(P.acceleration(N)) == pytest.approx([-4 * np.sin(0.6), 1.8, 0])


def test_relative_positions():
    Q = O.at("Q", N.y).at("Q'", -2 * A.y)
    r = along(P3.position(Q))
    assert r == pytest.approx(by_hand(3)(0.3) - along(Q.position(O)), abs=1e-13)
    assert along(Q.position(P3)) == pytest.approx(-r)
    assert P3.position(P3).is_zero
    assert along(P2.position(P3)) == pytest.approx(-along(P3.position(P2)))


def test_relative_velocity_as_derivative_in_a_moving_frame():
    def seen(t):
        values = PATH.values(t)
        return numbers(B.dcm(N), values) @ (by_hand(3)(t) - by_hand(1)(t))

    assert along(P3.position(P1).dt(B), frame=B) == pytest.approx(derivative(seen, 0.3), abs=1e-9)


class TestParticles:
    """`X.fixed_in(B, "Q", r)`: the particle of B that is at X + r now."""

    def test_on_a_rigid_body_it_is_the_geometric_point(self):
        body = O.at("G", q[5] * N.x)
        arm = 2 * B.x - B.y
        particle, point = body.fixed_in(B, "Q", arm), body.at("Q", arm)
        for read in (lambda p: p.velocity(N), lambda p: p.acceleration(N), lambda p: p.position(O)):
            assert along(read(particle)) == pytest.approx(along(read(point)), abs=1e-13)

    def test_velocity_and_acceleration_are_those_of_the_body(self):
        """A particle that now is where a rod's end touches: it keeps its place in the frame from now on."""
        arm = q[3] * N.x + kn.sin(q[4]) * B.y + kn.time * A.z  # constant in no frame
        particle = P2.fixed_in(C, "Q", arm)
        now = numbers(C.dcm(N), STATE) @ along(arm)

        def material(t):
            return by_hand(2)(t) + numbers(N.dcm(C), PATH.values(t)) @ now

        assert along(particle.velocity(N)) == pytest.approx(derivative(material, 0.3), abs=1e-9)
        assert along(particle.acceleration(N)) == pytest.approx(second_derivative(material, 0.3), abs=1e-6)
        assert along(particle.position(O)) == pytest.approx(by_hand(2)(0.3) + along(arm), abs=1e-13)
        # the geometric point at the same place moves otherwise
        assert along(P2.at("X", arm).velocity(N)) != pytest.approx(along(particle.velocity(N)), abs=1e-2)

    def test_upright_disk_that_rolls(self):
        """v^Ĉ = 0 and its derivative is 0, while the particle's acceleration is v²/R, upwards."""
        x, spin = kn.coordinates("x spin")
        R = kn.parameter("R", 0.4)
        v = 1.7
        disk = N.rotate("D", spin, N.y)
        center = O.at("C*", x * N.x + R * N.z)
        contact = center.fixed_in(disk, "C^", -R * N.z)
        state = {x: 0.7, spin: 0.7 / 0.4, x.dt: v, spin.dt: v / 0.4, x.dt.dt: 0.0, spin.dt.dt: 0.0}
        velocity = contact.velocity(N)
        assert along(velocity, state) == pytest.approx([0, 0, 0], abs=1e-15)
        assert along(velocity.dt(N), state) == pytest.approx([0, 0, 0], abs=1e-15)
        assert along(contact.acceleration(N), state) == pytest.approx([0, 0, v * v / 0.4])

    def test_without_offset_it_is_the_point_itself_as_part_of_the_frame(self):
        Q = P2.fixed_in(C, "Q")
        assert along(Q.velocity(N)) == pytest.approx(along(P2.velocity(N)))
        assert along(Q.acceleration(N)) == pytest.approx(along(P2.acceleration(N)))

    def test_nothing_is_built_on_it(self):
        Q = P2.fixed_in(C, "Q", C.x)
        with pytest.raises(
            kn.SpaceError, match=r"geometric point to build S on, got Q, a particle of C.*Build S on P2"
        ):
            Q.at("S", C.x)
        with pytest.raises(kn.SpaceError, match="a particle of C"):
            Q.fixed_in(C, "S")

    def test_no_declaration_changes_an_existing_object(self):
        Q = P2.fixed_in(C, "Q", C.x)
        before = str(Q.velocity(N)), str(P2.velocity(N))
        kn.reaction("R", at=P2, along=N.x)
        P2.at("later", 3 * N.x).velocity(N)
        assert (str(Q.velocity(N)), str(P2.velocity(N))) == before

    def test_repr(self):
        assert repr(P2.fixed_in(C, "Q", C.x)) == "Point('Q', particle of C, from P2 by C.x)"
        assert repr(O) == "Point('O', fixed in N)"


def test_deep_chain_without_recursion():
    point = O
    for _ in range(3000):
        point = point.at("P", N.x)
    assert along(point.position(O)) == pytest.approx([3000, 0, 0])
    assert point.velocity(N).is_zero


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kn.Point("", fixed_in=N), "name for the point"),
        (lambda: kn.Point("P", fixed_in="N"), "fixed_in=frame"),
        (lambda: kn.Point("P", fixed_in=A), "Expected a root frame .* Fix a point in N"),
        (lambda: O.at("P", 3), r"Expected a Vector \(or 0\)"),
        (lambda: O.at("P", kn.Frame("M").x), "no common root"),
        (lambda: O.fixed_in("B", "P"), "Expected a frame in fixed_in"),
        (lambda: O.fixed_in(kn.Frame("M"), "P"), "no common root"),
        (lambda: O.position(kn.Point("X", fixed_in=N)), "no common root"),
        (lambda: P2.velocity(A), r"where its root O is fixed, got frame A.*velocity\(A, Q\)"),
        (lambda: P2.acceleration(A), "the acceleration of P2 in N"),
    ],
)
def test_errors(make, message):
    with pytest.raises(kn.SpaceError, match=message):
        make()


def test_frozen():
    with pytest.raises(AttributeError, match="fixed"):
        O.name = "P"
