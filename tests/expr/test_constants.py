# SPDX-License-Identifier: BSD-3-Clause
"""Numbers that are folded while an expression is built: what rounding leaves of zero is zero, what was given stays."""

from __future__ import annotations

import pickle
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import kane as kn
from kane.expr import ZERO, add, as_expr, constant_value, cos, div, error_of, mul, sin, sub, weight

N = kn.Frame("N")
Q = kn.coordinate("q")
SEEDS = st.integers(0, 2**32 - 1)


def perpendicular(seed: int) -> tuple[kn.Vector, kn.Vector]:
    """Unit vectors at random, one of them with a small component: what is left of two terms then is small beside them."""
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(2, 3))
    a[2] *= 10.0 ** rng.uniform(-6, 0)
    a /= np.linalg.norm(a)
    b = np.cross(a, b)
    b /= np.linalg.norm(b)
    return tuple(float(x) * N.x + float(y) * N.y + float(z) * N.z for x, y, z in (a, b))  # type: ignore[return-value]


@given(SEEDS)
def test_perpendicular_vectors_have_no_product(seed):
    a, b = perpendicular(seed)
    assert a.dot(b) is ZERO
    assert (Q * a).dot(b) is ZERO
    assert (Q * b).dot(3 * a) is ZERO
    assert (a * 0.3).cross(a).is_zero
    assert a.cross(b).dot(b) is ZERO


@given(SEEDS)
@example(4516)  # two sums in a row take away more than half of their terms
def test_turned_back_vectors_are_what_they_were(seed):
    a, b = perpendicular(seed)
    angle = float(np.random.default_rng(seed).normal())
    A = N.rotate("A", angle, a)
    there = kn.Vector([(A, x)]) if (x := b.components(A)) else b
    assert all(x is ZERO for x in (there - b).express(N).scalars())
    assert A.dcm(N)[0, 0] is not ZERO


def test_an_error_is_carried_until_the_next_sum():
    a, b = as_expr(0.7310001), as_expr(0.731)
    small = sub(a, b)
    assert float(constant_value(small)) == pytest.approx(1e-7, rel=1e-6)
    assert error_of(small) > 1e-9 * 1e-7
    assert sub(small, as_expr(1e-7)) is ZERO  # no digit of it is certain
    again = pickle.loads(pickle.dumps(small * Q))  # what kane wrote
    assert again is small * Q


def test_the_weight_of_a_product_is_its_size():
    """Nothing cancelled in it, however many factors it has; in a small difference of large numbers something did."""
    for count in range(1, 8):
        factors = [as_expr(0.1 + 0.3 * k) for k in range(count)]
        whole = factors[0]
        for x in factors[1:]:
            whole = mul(whole, x)
        assert weight(whole) == abs(constant_value(whole))
    left = sub(as_expr(0.3), as_expr(0.3 - 1e-10))
    assert weight(left) > 0.1 * 0.3


def test_what_was_given_stays():
    for x in (1e-17, 1e-300, 0.1, 2.5e17):
        assert constant_value(mul(as_expr(x), as_expr(3.7))) == x * 3.7
    assert constant_value(add(as_expr(1e-10), as_expr(1))) == 1 + 1e-10
    assert constant_value(sub(as_expr(Fraction(1, 3)), as_expr(Fraction(333, 1000)))) == Fraction(1, 3000)
    assert constant_value(div(as_expr(1e-17), as_expr(3.3))) == 1e-17 / 3.3


@given(st.floats(-50, 50), st.integers(-20, 20))
def test_sines_of_whole_turns_written_in_floats(x, k):
    turns = sub(add(as_expr(x), as_expr(k * np.pi)), as_expr(x))
    assert sin(turns) is ZERO
    assert abs(float(constant_value(cos(turns)))) == pytest.approx(1)
