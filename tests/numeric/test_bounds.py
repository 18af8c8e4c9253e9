# SPDX-License-Identifier: BSD-3-Clause
"""Bounds of what expressions change by: what they do change by, at points around, is within, and so is what rounding does."""

from fractions import Fraction

import numpy as np
import pytest

import kane as kn
from kane import evaluate
from kane.numeric import bounded, vanish

X, Y, Z = kn.coordinates("x y z")
AT = {X: 0.7, Y: 1.3, Z: -0.4}
SHARE = 1e-6
SMOOTH = [
    X * Y - Z, X / (Y + Z) - X, kn.sin(X * Y) * kn.cos(Z) + 3, (X + Y) * (X + Y) - X * X - 2 * X * Y, -X / (2 - Y), kn.sqrt(X) - Y,
    kn.exp(Y) * Z, kn.max(X, Y) - Z, kn.min(X, Y), kn.atan2(X, Y) + kn.tan(Z), kn.where(kn.less(X, Y), X, Z) * 2, X**Y,
]  # fmt: skip


@pytest.mark.parametrize("e", SMOOTH, ids=str)
def test_what_changes_is_within_the_bound_and_not_far_below(e, rng):
    ((value, change),) = bounded([e], AT, SHARE)
    assert value == pytest.approx(float(evaluate(e, AT)), rel=1e-15)
    around = {s: v * (1 + SHARE * rng.uniform(-1, 1, 2_000)) for s, v in AT.items()}
    moved = np.abs(evaluate(e, around) - value).max()
    assert moved <= change <= 20 * moved


def test_arrays_are_bounded_as_each_of_their_numbers(rng):
    at = {s: v + rng.normal(size=5) for s, v in AT.items()}
    together = bounded(SMOOTH[:4], at)
    alone = [bounded(SMOOTH[:4], {s: v[k] for s, v in at.items()}) for k in range(5)]
    assert np.array(together) == pytest.approx(np.moveaxis(np.array(alone), 0, -1), rel=1e-14)


def test_what_cancels_may_change_by_more_than_it_is():
    ((value, change),) = bounded([(X + Y) * Z - X * Z - Y * Z], AT)
    assert abs(value) < change < 1e-14


def test_nothing_bounds_a_quotient_whose_divisor_may_vanish():
    ((_, change),) = bounded([1 / ((X + Y) * Z - X * Z - Y * Z)], AT)
    assert not change < np.inf


def test_rounding_is_within_the_bound_of_sums_that_cancel(rng):
    a, b = kn.coordinates("a1:9"), kn.coordinates("b1:9")
    e = sum(x * y for x, y in zip(a, b, strict=True))
    for _ in range(50):
        x, y = rng.normal(size=(2, 8))
        y[-1] = -(x[:-1] @ y[:-1]) / x[-1]
        ((value, change),) = bounded([e], dict(zip((*a, *b), (*x, *y), strict=True)))
        exact = sum(Fraction(v) * Fraction(w) for v, w in zip(x, y, strict=True))
        assert abs(Fraction(float(value)) - exact) <= change
        assert abs(value) <= change


def test_what_vanishes_does_so_whatever_the_parameters_are():
    a, b = kn.parameter("a", 0.7), kn.parameter("b", 0.7)
    identity = kn.sin(X + Y) - kn.sin(X) * kn.cos(Y) - kn.cos(X) * kn.sin(Y)
    assert vanish([identity, a * identity, a - b, identity + 1e-9 * X, X * 0]) == [True, True, False, False, True]
    assert vanish([a - b], known={a: 0.7, b: 0.7}) == [True]
    assert vanish([1 / identity, kn.sqrt(-X)]) == [False, False]
