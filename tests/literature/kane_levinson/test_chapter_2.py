# SPDX-License-Identifier: BSD-3-Clause
"""Kane & Levinson 1985, chapter 2: kinematics, without bodies.

Each problem is of the kind of its section; what is expected is in closed form, or computed in NumPy without `kane`.
"""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

import kane as kn
from tests.literature.kane_levinson.test_chapter_1 import complex_step, turn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)


def numbers(v, frame, values):
    return np.asarray(kn.evaluate(v.components(frame), values), dtype=float)


# 2.1, 2.2 Angular velocity, simple angular velocity ---------------------------------------------------------------------------


@pytest.mark.parametrize("sequence", ["".join(p) for p in permutations("xyz")] + ["xyx", "zxz", "yzy"])
def test_angular_velocity_from_direction_cosines(sequence):
    """ω = b₁ (ḃ₂·b₃) + b₂ (ḃ₃·b₁) + b₃ (ḃ₁·b₂), of any three successive rotations."""
    q = kn.coordinates("q1:4")
    B = N.rotate_body("B", q, sequence)
    angles, rates = np.array([0.4, -0.9, 1.3]), np.array([0.7, 0.5, -1.1])

    def cosines(t):
        r = np.eye(3)
        for axis, angle, rate in zip(sequence, angles, rates, strict=True):
            r = r @ turn("xyz".index(axis), angle + rate * t)
        return r

    b, b_dot = cosines(0).real, complex_step(cosines, 0.0)
    wanted = [b_dot[:, (k + 1) % 3] @ b[:, (k + 2) % 3] for k in range(3)]
    values = dict(zip(q, angles, strict=True)) | {x.dt: r for x, r in zip(q, rates, strict=True)}
    np.testing.assert_allclose(numbers(B.angular_velocity(N), B, values), wanted, rtol=1e-13, atol=1e-14)


def test_hookes_joint():
    """Two shafts at the angle β, coupled by a cross: ω₂/ω₁ = cos β/(1 − sin² β cos² q₁), by the constraint of its arms alone."""
    beta = kn.parameter("beta", 0.6, "rad")
    q1, q2 = kn.coordinates("q1 q2")
    u1, u2 = kn.speeds("u1 u2")
    A = N.rotate("A", q1, N.z)
    tilted = N.rotate("M", beta, N.x)
    C = tilted.rotate("C", q2, tilted.z)
    axis, angle = C.simple_rotation(tilted)
    assert (str(axis), str(angle)) == ("M.z", "q2")
    m = kn.motions(
        N, {u1: q1.dt, u2: q2.dt}, of=[A, C], holonomic=[A.x.dot(C.y)], dependent_speeds=[u2], near={q1: 0.0, q2: 0.0}
    )
    assert m.degrees_of_freedom == 1
    for x in (0.0, 0.5, 1.2, 2.0, 3.0):
        y = np.arctan2(np.cos(0.6) * 0 + np.sin(x), np.cos(x) * np.cos(0.6))  # tan q2 = tan q1/cos β, or its inverse
        other = np.arctan2(np.sin(x) * np.cos(0.6), np.cos(x))
        zero = [abs(float(kn.evaluate(A.x.dot(C.y), {q1: x, q2: z, beta: 0.6}))) for z in (y, other)]
        z = (y, other)[int(np.argmin(zero))]
        assert min(zero) < 1e-15
        ratio = float(kn.evaluate(m.A_n[0, 0], {q1: x, q2: z, beta: 0.6}))
        known = [np.cos(0.6) / (1 - np.sin(0.6) ** 2 * f(x) ** 2) for f in (np.cos, np.sin)]
        assert ratio == pytest.approx(known[int(np.argmin(np.abs(np.array(known) - ratio)))], rel=1e-13)


# 2.3 to 2.5 Two reference frames, auxiliary frames, angular acceleration -------------------------------------------------------


def test_angular_velocities_add_and_angular_accelerations_do_not():
    """ᴺω^C = ᴺω^B + ᴮω^C, but ᴺα^C = ᴺα^B + ᴮα^C + ᴺω^B × ᴮω^C: a rotor on a turning arm."""
    q1, q2 = kn.coordinates("q1 q2")
    B = N.rotate("B", q1, N.z)
    C = B.rotate("C", q2, B.x)
    values = {q1: 0.3, q2: 1.0, q1.dt: 2.0, q2.dt: 5.0, q1.dt.dt: 0.7, q2.dt.dt: -0.4}
    w = C.angular_velocity(N) - B.angular_velocity(N) - C.angular_velocity(B)
    assert w.is_zero
    found = numbers(C.angular_acceleration(N), B, values)
    np.testing.assert_allclose(found, [-0.4, 10.0, 0.7], rtol=1e-14)  # q̈₂ b₁ + q̇₁ q̇₂ b₂ + q̈₁ b₃


# 2.6 to 2.8 Velocity and acceleration, two points of a body, a point moving on it ----------------------------------------------


def test_two_points_fixed_on_a_body():
    """v^Q = v^P + ω × r, a^Q = a^P + α × r + ω × (ω × r), of a blade on a hub that flies along a curve."""
    x, q1, q2 = kn.coordinates("x q1 q2")
    H = N.rotate("H", q1, N.z)
    B = H.rotate("B", q2, H.y)
    P = O.at("P", x * N.x + x**2 * N.y)
    Q = P.at("Q", 3 * B.x + B.z)
    values = {x: 0.5, q1: 0.3, q2: -0.7, x.dt: 1.1, q1.dt: 4.0, q2.dt: 0.6, x.dt.dt: 0.2, q1.dt.dt: -1.0, q2.dt.dt: 2.0}

    def place(t):
        s = 0.5 + 1.1 * t + 0.1 * t**2
        a, b = 0.3 + 4 * t - 0.5 * t**2, -0.7 + 0.6 * t + t**2
        return np.array([s, s**2, 0]) + turn(2, a) @ turn(1, b) @ np.array([3, 0, 1])

    np.testing.assert_allclose(numbers(Q.velocity(N), N, values), complex_step(place, 0.0), rtol=1e-13)
    w, alpha, r = (numbers(v, N, values) for v in (B.angular_velocity(N), B.angular_acceleration(N), Q.position(P)))
    a = numbers(P.acceleration(N), N, values) + np.cross(alpha, r) + np.cross(w, np.cross(w, r))
    np.testing.assert_allclose(numbers(Q.acceleration(N), N, values), a, rtol=1e-12)


def test_a_bead_on_a_turning_hoop():
    """Spherical components: −r θ'² − r Ω² sin² θ, r θ'' − r Ω² sin θ cos θ, 2 r Ω θ' cos θ; the Coriolis part is the last."""
    theta, r, W = kn.coordinate("theta"), kn.parameter("r", 0.4, "m"), kn.parameter("W", 3.0, "rad/s")
    H = N.rotate("H", W * kn.time, N.z)
    E = H.rotate("E", theta, H.y)  # E.z along the radius, E.x along growing θ
    P = O.at("P", r * E.z)
    u = kn.speed("u")
    m = kn.motions(N, {u: theta.dt})
    values = {theta: 0.8, u: 2.0, u.dt: -1.5, r: 0.4, W: 3.0, kn.time: 0.3}
    s, c = np.sin(0.8), np.cos(0.8)
    wanted = [0.4 * -1.5 - 0.4 * 9 * s * c, 2 * 0.4 * 3 * 2 * c, -0.4 * 4 - 0.4 * 9 * s * s]
    np.testing.assert_allclose(numbers(m.acceleration(P), E, values), wanted, rtol=1e-13)
    on_hoop = O.fixed_in(
        H, "H̄", P.position(O)
    )  # the particle of the hoop under the bead: velocity and acceleration without θ'
    np.testing.assert_allclose(numbers(m.velocity(on_hoop), E, values), [0, 0.4 * 3 * s, 0], atol=1e-15)
    relative = numbers(m.velocity(P, H, O), E, values)
    np.testing.assert_allclose(
        numbers(m.velocity(P), E, values), numbers(m.velocity(on_hoop), E, values) + relative, rtol=1e-13
    )
    spin = np.array([-3 * s, 0, 3 * c])
    total = (
        numbers(m.acceleration(on_hoop), E, values)
        + numbers(m.acceleration(P, H, O), E, values)
        + 2 * np.cross(spin, relative)
    )
    np.testing.assert_allclose(numbers(m.acceleration(P), E, values), total, rtol=1e-13)


# 2.9 to 2.13 Constraints, coordinates, speeds -----------------------------------------------------------------------------------


def test_a_four_bar_has_one_freedom():
    """Three angles less two constraints; the ratios of angular speeds by the law of sines."""
    q, u = kn.coordinates("q1:4"), kn.speeds("u1:4")
    links, lengths = [N.rotate(f"L{k}", x, N.z) for k, x in enumerate(q)], (1.0, 2.5, 2.0)
    end = O
    for k, (f, length) in enumerate(zip(links, lengths, strict=True)):
        end = end.at(f"P{k}", (length if k < 2 else -length) * f.x)
    m = kn.motions(
        N, dict(zip(u, (x.dt for x in q), strict=True)), of=[end], holonomic=kn.coincident(end, O.at("G", 3 * N.x), along=[N.x, N.y]),
        dependent_speeds=u[1:],
    )  # fmt: skip
    assert m.degrees_of_freedom == 1
    a = 0.9
    tip = np.array([np.cos(a), np.sin(a)]) - [3, 0]  # from the far pin to the crank's end
    d = np.linalg.norm(tip)
    psi = np.arctan2(tip[1], tip[0])
    q3 = psi - np.arccos((d * d + 4 - 6.25) / (2 * 2 * d))
    far = np.array([3, 0]) + 2 * np.array([np.cos(q3), np.sin(q3)])
    q2 = np.arctan2(far[1] - np.sin(a), far[0] - np.cos(a))
    ratios = [np.sin(a - q3) / (2.5 * np.sin(q3 - q2)), np.sin(a - q2) / (2 * np.sin(q3 - q2))]
    values = dict(zip(q, (a, q2, q3), strict=True))
    found = [float(kn.evaluate(m.A_n[k, 0], values)) for k in range(2)]
    np.testing.assert_allclose(sorted(found), sorted(ratios), rtol=1e-12)


def test_rates_from_speeds_along_the_body():
    """q̇ = W u + X of z-x-z angles, with a table that is turned at a given rate: W and X in closed form."""
    q, u = kn.coordinates("q1:4"), kn.speeds("u1:4")
    rate = kn.parameter("rate", 0.7, "rad/s")
    T = N.rotate("T", rate * kn.time, N.x)
    B = T.rotate_body("B", q, "zxz")
    w = B.angular_velocity(N)
    m = kn.motions(N, dict(zip(u, (w.dot(B.x), w.dot(B.y), w.dot(B.z)), strict=True)))
    values = dict(zip(q, (0.5, 0.9, -0.6), strict=True)) | {rate: 0.7, kn.time: 0.2}
    s2, c2, s3, c3 = np.sin(0.9), np.cos(0.9), np.sin(-0.6), np.cos(-0.6)
    W = np.array([[s3 / s2, c3 / s2, 0], [c3, -s3, 0], [-s3 * c2 / s2, -c3 * c2 / s2, 1]])
    np.testing.assert_allclose(kn.evaluate(m.W, values), W, rtol=1e-13, atol=1e-15)
    turned = turn(2, 0.5).real @ turn(0, 0.9).real @ turn(2, -0.6).real
    z = turned.T @ [0.7, 0, 0]
    np.testing.assert_allclose(np.array(kn.evaluate(list(m.z), values), dtype=float), z, rtol=1e-13)
    np.testing.assert_allclose(np.array(kn.evaluate(list(m.X), values), dtype=float), -W @ z, rtol=1e-12, atol=1e-14)


# 2.14 Partial angular velocities, partial velocities ----------------------------------------------------------------------------


def test_partial_velocities_of_a_two_link_arm():
    """With u₁ = q̇₁ and u₂ = q̇₁ + q̇₂: v₁ = L₁ a₂, v₂ = L₂ b₂ of the hand; with rates as speeds v₁ = L₁ a₂ + L₂ b₂."""
    q1, q2 = kn.coordinates("q1 q2")
    u1, u2 = kn.speeds("u1 u2")
    A = N.rotate("A", q1, N.z)
    B = A.rotate("B", q2, A.z)
    hand = O.at("E", 2 * A.x).at("H", 3 * B.x)
    absolute = kn.motions(N, {u1: q1.dt, u2: q1.dt + q2.dt})
    relative = kn.motions(N, {u1: q1.dt, u2: q2.dt})
    assert [str(v) for v in absolute.partial_velocities(hand).values()] == ["2 A.y", "3 B.y"]
    values = {q1: 0.4, q2: 0.9}
    for v, wanted in zip(relative.partial_velocities(hand).values(), (2 * A.y + 3 * B.y, 3 * B.y), strict=True):
        np.testing.assert_allclose(numbers(v, N, values), numbers(wanted, N, values), rtol=1e-14)
    assert [str(v) for v in absolute.partial_angular_velocities(B).values()] == ["0", "B.z"]
    assert [str(v) for v in relative.partial_angular_velocities(B, A).values()] == ["0", "B.z"]


def test_a_rolling_disk_has_three_nonholonomic_partial_velocities():
    """ṽ of the centre: −R b₂ for the lean, R along the heading for the spin; none for the turn; the contact has none."""
    q, u, R = kn.coordinates("q1:6"), kn.speeds("u1:6"), kn.parameter("R", 0.3, "m")
    A = N.rotate("A", q[0], N.z)
    B = A.rotate("B", q[1], A.x)
    C = B.rotate("C", q[2], B.y)
    P = O.at("P", q[3] * N.x + q[4] * N.y + R * B.z)
    D = P.fixed_in(C, "D", -R * B.z)
    w = C.angular_velocity(N)
    definitions = (w.dot(B.x), w.dot(B.y), w.dot(B.z), q[3].dt, q[4].dt)
    m = kn.motions(N, dict(zip(u, definitions, strict=True)), nonholonomic=kn.no_slip(D, along=[N.x, N.y]))
    values = {q[0]: 0.4, q[1]: 0.3, q[2]: 0.2, R: 0.3}
    found = m.independent.partial_velocities(P)
    for v, wanted in zip(found.values(), ([0, -0.3, 0], [0.3, 0, 0], [0, 0, 0]), strict=True):
        np.testing.assert_allclose(numbers(v, B, values), wanted, atol=1e-15)
    assert all(v.is_zero for v in m.independent.partial_velocities(D).values())
    assert m.degrees_of_freedom == 3


# 2.15 Acceleration and partial velocities ---------------------------------------------------------------------------------------


def test_acceleration_from_the_square_of_velocity():
    """v_r·a = ½ (d/dt ∂v²/∂q̇_r − ∂v²/∂q_r), with u = q̇: a particle on a turning, sliding arm."""
    q1, q2 = kn.coordinates("q1 q2")
    A = N.rotate("A", q1, N.z)
    B = A.rotate("B", kn.sin(2 * kn.time), A.x)
    P = O.at("P", q2 * B.y + q1 * N.z)
    m = kn.motions(N, "rates", of=[P])
    v, a = P.velocity(N), P.acceleration(N)
    square = v.dot(v)
    values = {q1: 0.4, q2: 1.2, q1.dt: 0.7, q2.dt: -0.5, q1.dt.dt: 0.3, q2.dt.dt: 1.1, kn.time: 0.6}
    for q, partial in zip((q1, q2), m.partial_velocities(P).values(), strict=True):
        left = kn.evaluate(partial.dot(a), values)
        right = kn.evaluate(kn.time_derivative(kn.diff(square, q.dt)) - kn.diff(square, q), values) / 2
        assert float(left) == pytest.approx(float(right), rel=1e-12)
