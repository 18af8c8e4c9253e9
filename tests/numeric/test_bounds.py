# SPDX-License-Identifier: BSD-3-Clause
"""Bounds of what expressions change by: what they do change by, at points around, is within."""

import numpy as np
import pytest

import kane as kn
from kane.expr.evaluate import Walk, evaluate
from kane.numeric.bounds import changes

X, Y, Z = kn.coordinates("x y z")
AT = {X: 0.7, Y: 1.3, Z: -0.4}
SHARE = 1e-6


@pytest.mark.parametrize(
    "e",
    [X * Y - Z, X / (Y + Z) - X, kn.sin(X * Y) * kn.cos(Z) + 3, (X + Y) * (X + Y) - X * X - 2 * X * Y, -X / (2 - Y)],
    ids=str,
)
def test_what_changes_is_within_the_bound_and_not_far_below(e, rng):
    ((value, change),) = changes(Walk([e]), AT, SHARE)
    assert value == pytest.approx(float(evaluate(e, AT)), rel=1e-15)
    around = {s: v * (1 + SHARE * rng.uniform(-1, 1, 2_000)) for s, v in AT.items()}
    moved = np.abs(evaluate(e, around) - value).max()
    assert moved <= change <= 20 * moved


def test_what_cancels_may_change_by_more_than_it_is():
    ((value, change),) = changes(Walk([(X + Y) * Z - X * Z - Y * Z]), AT, 1e-10)
    assert abs(value) < 1e-15 < change


@pytest.mark.parametrize(
    "e", [1 / ((X + Y) * Z - X * Z - Y * Z), kn.sqrt(X), kn.exp(Y), kn.max(X, Y)], ids=["zero", "root", "exp", "max"]
)
def test_nothing_is_said_where_a_divisor_may_vanish_or_of_other_operations(e):
    assert changes(Walk([e]), AT, SHARE) is None
