# SPDX-License-Identifier: BSD-3-Clause
"""Frames: direction cosines against SciPy, angular velocity and acceleration against finite differences."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kane as kn
from tests.paths import Path, derivative, numbers, unskew

N = kn.Frame("N")
a, b, c, d = kn.coordinates("a b c d")
ANGLES = (a, b, c)
SEQUENCES = ["".join(s) for s in product("xyz", repeat=3) if s[0] != s[1] != s[2]]


def test_there_are_twelve_sequences():
    assert len(SEQUENCES) == 12


def cosines(frame, values):
    return numbers(N.dcm(frame), values)


def check_rates(frame, path, t0=0.0):
    """ω and α of the frame along its own axes and those of N against differences of its direction cosines."""
    values = path.values()

    def dcm(t):
        return cosines(frame, path.values(t))

    def omega(t):
        return unskew(derivative(dcm, t) @ dcm(t).T)

    turn = dcm(t0)
    w, alpha = frame.angular_velocity(N), frame.angular_acceleration(N)
    assert numbers(w.components(N), values) == pytest.approx(omega(t0), abs=1e-9)
    assert numbers(w.components(frame), values) == pytest.approx(turn.T @ omega(t0), abs=1e-9)
    assert numbers(alpha.components(N), values) == pytest.approx(derivative(omega, t0), abs=1e-8)
    assert numbers(N.angular_velocity(frame).components(N), values) == pytest.approx(-omega(t0), abs=1e-9)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_body_sequences(sequence):
    frame = N.rotate_body("B", ANGLES, sequence)
    path = Path(ANGLES, 1)
    expected = Rotation.from_euler(sequence.upper(), path.q).as_matrix()  # capitals: intrinsic
    assert cosines(frame, path.values()) == pytest.approx(expected, abs=1e-14)
    digits = N.rotate_body("B", ANGLES, sequence.translate(str.maketrans("xyz", "123")))
    assert cosines(digits, path.values()) == pytest.approx(expected, abs=1e-14)
    check_rates(frame, path)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_space_sequences(sequence):
    frame = N.rotate_space("B", ANGLES, sequence)
    path = Path(ANGLES, 2)
    expected = Rotation.from_euler(sequence, path.q).as_matrix()  # small letters: extrinsic
    assert cosines(frame, path.values()) == pytest.approx(expected, abs=1e-14)
    check_rates(frame, path)


@pytest.mark.parametrize("seed", range(10))
def test_rotation_about_a_random_axis(seed):
    axis = np.random.default_rng(seed).normal(size=3)
    axis /= np.linalg.norm(axis)
    frame = N.rotate("B", a, axis[0] * N.x + axis[1] * N.y + axis[2] * N.z)
    path = Path((a,), seed)
    expected = Rotation.from_rotvec(path.q[0] * axis).as_matrix()
    assert cosines(frame, path.values()) == pytest.approx(expected, abs=1e-14)
    check_rates(frame, path)


@pytest.mark.parametrize("index", range(3))
@pytest.mark.parametrize("sign", [1, -1])
def test_rotation_about_a_basis_axis(index, sign):
    axis = (N.x, N.y, N.z)[index]
    frame = N.rotate("B", a, axis if sign == 1 else -axis)
    path = Path((a,), 4)
    expected = Rotation.from_rotvec(sign * path.q[0] * np.eye(3)[index]).as_matrix()
    assert cosines(frame, path.values()) == pytest.approx(expected, abs=1e-15)
    check_rates(frame, path)


def test_successive_rotations_about_one_axis_are_one_by_the_sum():
    first = N.rotate("A", a, N.z)
    second = first.rotate("B", b, first.z)
    third = second.rotate("C", kn.pi - c, -second.z)
    assert str(second.angular_velocity(N)) == "(a' + b') B.z"
    assert N.dcm(second)[0, 0] is kn.cos(a + b)
    path = Path(ANGLES, 5)
    turn = path.q[0] + path.q[1] + path.q[2] - np.pi
    assert cosines(third, path.values()) == pytest.approx(Rotation.from_rotvec([0, 0, turn]).as_matrix(), abs=1e-14)
    assert third.parent is second
    check_rates(third, path)
    # the middle frame is still a frame: relative orientation and angular velocity
    assert numbers(second.dcm(third), path.values()) == pytest.approx(
        Rotation.from_rotvec([0, 0, path.q[2] - np.pi]).as_matrix(), abs=1e-14
    )
    assert numbers(third.angular_velocity(second).components(N), path.values()) == pytest.approx([0, 0, path.v[2]])


@pytest.mark.parametrize("axis", "xyz")
def test_a_turn_about_the_same_axis_is_seen_from_the_frame_before(axis):
    """Of frames turned by a, a + b and a + b + c each sees its neighbour turned by one angle; siblings share sines and cosines."""
    first = N.rotate("A", a, getattr(N, axis))
    second = first.rotate("B", b, getattr(first, axis))
    third = second.rotate("C", -c, getattr(second, axis))
    y = "xyz"["xyz".index(axis) - 2]
    assert getattr(first, y).dot(getattr(second, y)) is kn.cos(b)
    assert getattr(second, y).dot(getattr(first, y)) is kn.cos(b)
    assert getattr(second, y).dot(getattr(third, y)) is kn.cos(c)
    path = Path(ANGLES, 7)
    angles = path.values()
    turn = {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}[axis]
    for one, other, angle in (
        (first, second, angles[b]),
        (third, second, angles[c]),
        (first, third, angles[b] - angles[c]),
    ):
        expected = Rotation.from_rotvec(angle * np.array(turn)).as_matrix()
        assert numbers(one.dcm(other), path.values()) == pytest.approx(expected, abs=1e-14)
    sibling = N.rotate("D", d, getattr(N, axis))
    assert getattr(first, y).dot(getattr(sibling, y)) is kn.cos(a) * kn.cos(d) + kn.sin(a) * kn.sin(d)


def test_axis_in_another_frame_that_is_the_same_axis():
    A = N.rotate("A", a, N.z)
    assert N.rotate("B", b, A.z).angular_velocity(N).components(N)[2] is b.dt


@pytest.mark.parametrize("seed", range(3))
def test_long_mixed_chain(seed):
    A = N.rotate("A", a + kn.sin(2 * kn.time), N.y)
    B = A.rotate("B", b, (A.x + 2 * A.y - 2 * A.z) / 3)
    C = B.rotate("C", c * d, B.x).rotate("C'", d, B.x)
    D = C.rotate_space("D", (a * b, kn.time * c, d), "zyx")
    path = Path((a, b, c, d), seed, t0=0.4)
    check_rates(D, path, 0.4)
    # relative rates between two frames, neither of them the root
    values = path.values()

    def relative(t):
        return numbers(B.dcm(D), path.values(t))

    w = unskew(derivative(relative, 0.4) @ relative(0.4).T)
    assert numbers(D.angular_velocity(B).components(B), values) == pytest.approx(w, abs=1e-9)


def test_sibling_frames():
    A, B = N.rotate("A", a, N.x), N.rotate("B", b, N.y)
    path = Path((a, b), 7)
    values = path.values()
    expected = Rotation.from_rotvec([path.q[0], 0, 0]).inv() * Rotation.from_rotvec([0, path.q[1], 0])
    assert numbers(A.dcm(B), values) == pytest.approx(expected.as_matrix(), abs=1e-14)
    assert numbers(B.angular_velocity(A).components(N), values) == pytest.approx([-path.v[0], path.v[1], 0])


def test_angular_acceleration_in_a_moving_frame():
    A = N.rotate("A", a, N.x)
    B = A.rotate_body("B", (b, c, d), "zxy")
    path = Path((a, b, c, d), 8)

    def relative(t):
        return numbers(A.dcm(B), path.values(t))

    def omega(t):
        return unskew(derivative(relative, t) @ relative(t).T)

    alpha = numbers(B.angular_acceleration(A).components(A), path.values())
    assert alpha == pytest.approx(derivative(omega), abs=1e-8)


class TestEulerParameters:
    e = kn.coordinates("e0:4")

    def unit(self, seed):
        e = np.random.default_rng(seed).normal(size=4)
        return e / np.linalg.norm(e)

    @pytest.mark.parametrize("seed", range(5))
    def test_cosines(self, seed):
        frame = N.rotate_euler_parameters("B", self.e)
        e = self.unit(seed)
        expected = Rotation.from_quat([*e[1:], e[0]]).as_matrix()
        assert cosines(frame, dict(zip(self.e, e, strict=True))) == pytest.approx(expected, abs=1e-14)

    def test_angular_velocity_is_three_quasi_rates_from_which_the_rates_follow(self):
        frame = N.rotate_euler_parameters("B", self.e)
        u = kn.speeds("u1:4")
        w = frame.angular_velocity(N)
        body = kn.RigidBody(
            "b",
            frame=frame,
            mass_center=kn.Point("O", fixed_in=N).at("G", 0),
            mass=1,
            inertia=kn.inertia(frame, 1, 2, 3),
        )
        axes = (frame.x, frame.y, frame.z)
        eom = kn.derive(kn.System(N, bodies=[body], speeds=dict(zip(u, (w.dot(x) for x in axes), strict=True))))
        e, rates = self.unit(3), np.array([0.3, -0.8, 1.1])
        e_dot = eom.evaluate(list(eom.rates), q=e, u=rates)

        def turn(t):
            return Rotation.from_quat([*(e + t * np.array(e_dot))[1:], e[0] + t * float(e_dot[0])]).as_matrix()

        spin = unskew(derivative(turn) @ turn(0).T)
        assert turn(0).T @ spin == pytest.approx(rates, abs=1e-9)

    @pytest.mark.parametrize("wrong", [("e0",) * 4, (a, b, c), (a, b, c, c), (a, b, c, kn.parameter("p"))])
    def test_what_they_must_be(self, wrong):
        with pytest.raises(kn.SpaceError, match="four different coordinates"):
            N.rotate_euler_parameters("B", wrong)


class TestMatrix:
    def test_constant(self):
        turn = Rotation.from_euler("XYZ", [0.1, -0.7, 2.0]).as_matrix()
        frame = N.rotate_matrix("B", turn)
        assert cosines(frame, {}) == pytest.approx(turn, abs=1e-15)
        assert frame.angular_velocity(N).is_zero

    def test_moving(self):
        A = N.rotate_body("A", ANGLES, "xyz")
        B = N.rotate_matrix("B", N.dcm(A))
        path = Path(ANGLES, 9)
        check_rates(B, path)

    def test_sign_convention_is_that_of_dcm(self):
        turn = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]  # B.x along N.y
        B = N.rotate_matrix("B", turn)
        assert [str(x) for x in B.x.components(N)] == ["0", "1", "0"]

    @pytest.mark.parametrize(
        ("wrong", "message"),
        [
            ([[1, 0], [0, 1]], "3 × 3"),
            (np.eye(3)[[1, 0, 2]], "right-handed"),
            (2 * np.eye(3), r"column 1 · column 1 = 4"),
            ([[1, 0, 0], [0, 1, 0.1], [0, 0, 1]], "orthogonal"),
            ([[kn.cos(a), kn.sin(a), 0], [kn.sin(a), kn.cos(a), 0], [0, 0, 1]], "orthogonal"),
        ],
    )
    def test_what_it_must_be(self, wrong, message):
        with pytest.raises(kn.SpaceError, match=message):
            N.rotate_matrix("B", wrong)


def test_frames_are_frozen_and_say_where_they_are():
    A = N.rotate("A", a, N.z)
    assert repr(A) == "Frame('A', in N)"
    assert A.root() is N
    with pytest.raises(AttributeError, match="fixed"):
        A.name = "C"


def test_nothing_that_reads_writes():
    """Building and reading other frames and points leaves what is read unchanged."""
    A = N.rotate("A", a, N.z)
    before = A.angular_velocity(N)
    B = A.rotate("B", b, A.x)
    kn.Point("O", fixed_in=N).at("P", B.y).acceleration(N)
    assert A.angular_velocity(N) is before
    assert str(B.angular_velocity(A)) == "b' B.x"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kn.Frame(""), "name for the frame"),
        (lambda: N.rotate("B", a, "z"), "unit vector as axis"),
        (lambda: N.rotate("B", N.z, a), r"an angle by which N is turned, got N\.z\. The order is name, angle, axis"),
        (lambda: N.rotate("B", [a, b, c], "zxz"), r"of three angles rotate_body\(name, angles, sequence\)"),
        (lambda: N.rotate("B", a, 2 * N.z), r"of length 2\. Use axis.normalized"),
        (lambda: N.rotate("B", a, N.x + N.y), r"length 1.41421"),
        (lambda: N.rotate("B", a, kn.parameter("k", 3.0) * N.x), r"length 3"),
        (lambda: N.rotate("B", a, 0 * N.z), "zero vector"),
        (lambda: N.rotate("B", a, N.rotate("A", b, N.z).x), "fixed in frame N, got A.x: it depends on b"),
        (lambda: N.rotate("B", a, kn.cos(kn.state("s", 0.1)) * N.x), "fixed in frame N, got .*: it depends on s"),
        (lambda: N.rotate("B", a, kn.Frame("M").x), "no common root"),
        (lambda: N.rotate_body("B", (a, b, c), "xxy"), "neighbours different"),
        (lambda: N.rotate_body("B", (a, b), "xyz"), "three angles"),
        (lambda: N.rotate_body("B", (a, b, c), "xyw"), "three axes"),
        (lambda: N.rotate_space("B", (a, b), "xyz"), "three angles"),
        (lambda: N.dcm(kn.Frame("M")), "no common root"),
        (lambda: N.dcm("A"), "Expected a Frame"),
        (lambda: N.rotate("A", a, N.z).angular_velocity(kn.Frame("M")), "no common root"),
    ],
)
def test_errors(make, message):
    with pytest.raises(kn.SpaceError, match=message):
        make()


def test_axis_from_parameters_without_default_is_taken_at_its_word():
    k = kn.parameters("k1:4")
    frame = N.rotate("B", a, k[0] * N.x + k[1] * N.y + k[2] * N.z)
    path = Path((a,), 3)
    axis = np.array([2.0, -1.0, 2.0]) / 3
    values = path.values() | dict(zip(k, axis, strict=True))
    expected = Rotation.from_rotvec(path.q[0] * axis).as_matrix()
    assert numbers(N.dcm(frame), values) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("cosines", [5, (1, 2, 3), np.eye(4), np.eye(2)])
def test_what_is_no_matrix_of_direction_cosines(cosines):
    with pytest.raises(kn.SpaceError, match="3 × 3 matrix of direction cosines"):
        N.rotate_matrix("B", cosines)


def test_what_are_no_euler_parameters():
    with pytest.raises(kn.SpaceError, match="four"):
        N.rotate_euler_parameters("B", 5)
