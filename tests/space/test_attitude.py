# SPDX-License-Identifier: BSD-3-Clause
"""Attitudes by any numbers, read by any others: round trips, against SciPy, in symbols, at singular places, and what is refused."""

from __future__ import annotations

import pickle
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Scipy

import kane as kn
from kane.errors import SpaceError

SEQUENCES = ["".join(s) for s in product("xyz", repeat=3) if s[0] != s[1] != s[2]]
CLOSE = 1e-14


def apart(r, cosines):
    return np.abs(r.direction_cosines - cosines).max()


def trips(r):
    """How far each way of writing a rotation, and reading it again, carries its direction cosines."""
    c = r.direction_cosines
    yield apart(kn.Rotation.from_direction_cosines(c), c)
    yield apart(kn.Rotation.from_euler_parameters(r.euler_parameters), c)
    yield apart(kn.Rotation.from_axis_angle(*r.axis_angle), c)
    yield apart(kn.Rotation.from_scipy(r.to_scipy()), c)
    for sequence in SEQUENCES:
        for space in (False, True):
            again = kn.Rotation.from_angles(sequence, r.angles(sequence, space=space), space=space)
            yield apart(again, c)


def random(count):
    return kn.Rotation.from_scipy(Scipy.random(count, random_state=20041))


@pytest.mark.slow
def test_round_trips_of_many():
    r = random(100_000)
    assert max(trips(r)) <= CLOSE
    assert apart(kn.Rotation.from_rodrigues_parameters(r.rodrigues_parameters), r.direction_cosines) <= CLOSE


def test_round_trips():
    r = random(2_000)
    assert max(trips(r)) <= CLOSE
    assert apart(kn.Rotation.from_rodrigues_parameters(r.rodrigues_parameters), r.direction_cosines) <= CLOSE


@pytest.mark.parametrize("beside", [0.0, 1e-16, 1e-12, 1e-8, 1e-4])
def test_round_trips_at_singular_attitudes(beside):
    """All attitudes by quarter turns: no rotation, half turns, and every sequence's gimbal lock; and near them."""
    grid = np.array(list(product(np.arange(-2, 3) * np.pi / 2, repeat=3)))
    places = grid + beside * np.random.default_rng(20042).normal(size=grid.shape)
    for sequence in ("xyz", "zxz"):
        assert max(trips(kn.Rotation.from_angles(sequence, places))) <= CLOSE


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_angles_are_those_of_scipy(sequence):
    angles = np.random.default_rng(1).uniform(0.1, 1.4, (50, 3))
    for space, name in ((False, sequence.upper()), (True, sequence)):
        r = kn.Rotation.from_angles(sequence, angles, space=space)
        assert apart(r, Scipy.from_euler(name, angles).as_matrix()) <= CLOSE
        again = kn.Rotation.from_direction_cosines(r.direction_cosines)
        assert again.angles(sequence, space=space) == pytest.approx(angles, abs=1e-13)


def test_gimbal_lock_has_one_angle():
    """Of body-fixed angles the first is 0 there, of space-fixed ones the last."""
    c = kn.Rotation.from_angles("xyz", (0.3, np.pi / 2, 0.4)).direction_cosines
    locked = kn.Rotation.from_direction_cosines(c)
    assert locked.angles("xyz") == pytest.approx([0, np.pi / 2, 0.7], abs=1e-14)
    assert locked.angles("zyx", space=True) == pytest.approx([0.7, np.pi / 2, 0], abs=1e-14)


def test_composition_and_inverse():
    r, s, v = random(20), kn.Rotation.from_angles("zyx", (0.2, -1.0, 2.5)), np.array([1.0, -2.0, 0.5])
    both = r @ s
    assert apart(both, r.direction_cosines @ s.direction_cosines) <= CLOSE
    assert (both @ both.inverse).euler_parameters == pytest.approx(np.tile([1, 0, 0, 0], (20, 1)), abs=CLOSE)
    assert both.apply(v) == pytest.approx(r.apply(s.apply(v)), abs=1e-13)
    assert both.shape == (20,)
    assert s.shape == ()


def test_symbols_are_what_numbers_are():
    q = kn.coordinates("a b c")
    values = dict(zip(q, (0.3, -0.7, 1.1), strict=True))
    other = kn.Rotation.from_rodrigues_parameters(kn.parameters("r1:4"))
    values |= dict(zip(other.rodrigues_parameters, (0.2, 0.5, -0.4), strict=True))
    N = kn.Frame("N")
    for r in (
        kn.Rotation.from_angles("zxz", q),
        kn.Rotation.from_angles("123", q, space=True),
        kn.Rotation.from_axis_angle((0, 0.6, 0.8), q[0]),
        other,
        kn.Rotation.from_angles("zyx", q) @ other,
        (kn.Rotation.from_angles("zyx", q) @ other).inverse,
        kn.Rotation.from_frames(N, N.rotate_space("B", q, "yxz")),
    ):
        number = r.evaluate(values)
        for read in ("euler_parameters", "rodrigues_parameters", "small_angles"):
            assert np.ravel(kn.evaluate(getattr(r, read), values)) == pytest.approx(getattr(number, read), abs=1e-13), (
                read
            )
        for sequence, space in (("xyz", False), ("yxy", True)):
            found = kn.evaluate(r.angles(sequence, space=space), values)
            assert np.ravel(found) == pytest.approx(number.angles(sequence, space=space), abs=1e-13)
        axis, angle = r.axis_angle
        turned = kn.Rotation.from_axis_angle(
            np.ravel(kn.evaluate(axis, values)), float(kn.evaluate([angle], values)[0])
        )
        assert apart(turned, number.direction_cosines) <= 1e-13
        v = kn.parameters("v1:4")
        along = kn.evaluate(r.apply(v), values | dict(zip(v, (1.0, 2.0, 3.0), strict=True)))
        assert np.ravel(along) == pytest.approx(number.apply((1.0, 2.0, 3.0)), abs=1e-13)


def test_symbols_stay_short():
    q = kn.coordinates("a b c")
    assert kn.Rotation.from_angles("xyz", q).angles("xyz") == q
    axis, angle = kn.Rotation.from_axis_angle((0, 0, 1), q[0]).axis_angle
    assert angle is q[0]
    assert [str(x) for x in axis] == ["0", "0", "1"]
    assert str(kn.Rotation.from_axis_angle((0, 0, 1), q[0]).rodrigues_parameters[2]) == "tan(a/2)"


def test_rodrigues_parameters_compose_as_in_the_book():
    """ρ = (ρ₁ + ρ₂ + ρ₁ × ρ₂)/(1 − ρ₁·ρ₂) of body-fixed rotations (Kane, Likins & Levinson 1983, sec. 1.6)."""
    a, b = np.array([0.2, -0.3, 0.5]), np.array([1.0, 0.4, -0.1])
    both = kn.Rotation.from_rodrigues_parameters(a) @ kn.Rotation.from_rodrigues_parameters(b)
    assert both.rodrigues_parameters == pytest.approx((a + b + np.cross(a, b)) / (1 - a @ b), abs=1e-14)


def test_small_rotations_are_those_of_first_order():
    angles = np.array([1e-5, -2e-5, 3e-5])
    near = kn.small_rotation(angles)
    for sequence in SEQUENCES:
        if len(set(sequence)) == 3:
            order = ["xyz".index(k) for k in sequence]
            r = kn.Rotation.from_angles(sequence, angles[order])
            assert np.abs(r.direction_cosines - near).max() < 1e-8
            assert r.small_angles == pytest.approx(angles, abs=1e-9)


def test_rates_of_rodrigues_parameters():
    """ω of a frame by them is that of a frame by their direction cosines."""
    rho = kn.coordinates("x y z")
    N = kn.Frame("N")
    B = N.rotate_rodrigues_parameters("B", rho)
    other = N.rotate_matrix("M", kn.Rotation.from_rodrigues_parameters(rho).direction_cosines)
    values = dict(zip((*rho, *(x.dt for x in rho)), (0.3, -0.8, 1.7, 0.4, -0.2, 0.9), strict=True))
    own, wanted = (np.ravel(kn.evaluate(f.angular_velocity(N).components(f), values)) for f in (B, other))
    assert own == pytest.approx(wanted, abs=1e-14)
    assert kn.count_operations(B.angular_velocity(N).components(B)).total < 40


def test_copies_are_the_same():
    for r in (random(3), kn.Rotation.from_angles("xyz", kn.coordinates("a b c"))):
        again = pickle.loads(pickle.dumps(r))
        assert np.all(
            np.array([a is b for a, b in zip(np.ravel(again._cosines), np.ravel(r._cosines), strict=True)])
        ) or (not r.is_symbolic and np.array_equal(again.direction_cosines, r.direction_cosines))
        assert repr(again) == repr(r)
    assert repr(random(3)) == "Rotation(array of 3)"
    with pytest.raises(AttributeError, match="frozen"):
        random(1).x = 1


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: kn.Rotation(), "from_angles"),
        (lambda: kn.Rotation.from_direction_cosines(np.eye(3) * 1.001), "differs from 1 by 0.002"),
        (lambda: kn.Rotation.from_direction_cosines(np.diag([1, 1, -1])), "left-handed"),
        (lambda: kn.Rotation.from_direction_cosines(np.eye(2)), "shape"),
        (lambda: kn.Rotation.from_euler_parameters((1, 1, 0, 0)), "length 1"),
        (lambda: kn.Rotation.from_euler_parameters((1, np.nan, 0, 0)), "finite"),
        (lambda: kn.Rotation.from_axis_angle((0, 0, 2), 1.0), "length 1"),
        (lambda: kn.Rotation.from_axis_angle(kn.Frame("N").x, 1.0), "components"),
        (lambda: kn.Rotation.from_angles("xxy", (1, 2, 3)), "neighbours different"),
        (lambda: kn.Rotation.from_angles("xyz", ("a", "b", "c")), "numbers or expressions"),
        (lambda: kn.Rotation.from_axis_angle((1, 0, 0), np.pi).inverse @ 3, "R.apply"),
        (lambda: kn.Rotation.from_euler_parameters((0, 1, 0, 0)).rodrigues_parameters, "half a turn"),
        (lambda: kn.Rotation.from_angles("xyz", kn.coordinates("a b c")).to_scipy(), "evaluate"),
        (lambda: kn.Frame("N").rotate_rodrigues_parameters("B", (1, 2)), "three Rodrigues"),
        (lambda: kn.Frame("N").rotate_rodrigues_parameters("B", 1), "three Rodrigues"),
        (lambda: kn.Rotation.from_axis_angle(np.eye(3)[:2], [1, 2, 3]), r"one shape.*\(2,\) and \(3,\)"),
        (lambda: random(4) @ random(3), r"one shape.*\(4,\) and \(3,\)"),
        (lambda: random(4).apply(np.ones((3, 3))), r"one shape.*\(4,\) and \(3,\)"),
        (lambda: random(4) @ kn.Rotation.from_angles("xyz", kn.coordinates("a b c")), "one rotation"),
    ],
)
def test_what_is_refused(make, words):
    with pytest.raises(SpaceError, match=words):
        make()


def test_several_axes_turn_by_one_angle():
    axes = np.array([[1.0, 0, 0], [0, 0.6, 0.8]])
    several = kn.Rotation.from_axis_angle(axes, 0.3)
    assert several.shape == (2,)
    np.testing.assert_allclose(several.direction_cosines, Scipy.from_rotvec(0.3 * axes).as_matrix(), atol=CLOSE)


def test_numbers_evaluate_to_themselves():
    r = random(4)
    np.testing.assert_array_equal(r.evaluate({}).direction_cosines, r.direction_cosines)
