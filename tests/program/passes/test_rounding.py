# SPDX-License-Identifier: BSD-3-Clause
"""The running error bound holds, and is not idle."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.program import rounding
from tests.examples import examples
from tests.program.passes.codes import ARITHMETIC, EPS, NUMBERS, STATES, SYMBOLS, code, exact, expressions

a, b, c, d = STATES
FUNCTIONS = (*ARITHMETIC, "sqrt", "sin", "cos", "exp", "tanh", "atan", "abs", "min", "max")
AT = (0.0, 1.1, -0.7, 0.4, 1.3, 2.0, 0.5, 3.0)


@examples(0.3)
@given(expressions(FUNCTIONS), st.lists(NUMBERS, min_size=len(SYMBOLS), max_size=len(SYMBOLS)))
def test_the_bound_holds(roots, values):
    made = code(roots)
    for (value, error), right in zip(rounding(made, values), exact(made, values), strict=True):
        if right is None or not error * EPS < 1e-3 * abs(value):  # else terms of second order count
            continue
        assert abs(value - right) <= 1.01 * error * EPS / 2 + 1e-300


@pytest.mark.parametrize(
    ("expression", "value", "error"),
    [
        (a + b, 0.4, 0.4),
        (a * b, -0.77, 0.77),
        ((a + b) * c, 0.16, 0.16 + 0.4 * 0.4),
        ((a + b) - c, 0.0, 0.4),  # 0.4 of the sum, and nothing for a difference that is zero
        (kn.sqrt(a + b), math.sqrt(0.4), 0.4 / (2 * math.sqrt(0.4)) + math.sqrt(0.4)),
        (c / (a + b), 1.0, 0.4 * 0.4 / 0.4**2 + 1.0),
        (kn.sin(a + b), math.sin(0.4), 0.4 * math.cos(0.4) + math.sin(0.4)),
        (kn.exp(a + b), math.exp(0.4), (1 + 0.4) * math.exp(0.4)),
        (kn.max(a + b, -c), 0.4, 0.4),
        (kn.where(kn.less(a, b), a + b, a - b), 1.8, 1.8),
    ],
    ids=str,
)
def test_by_hand(expression, value, error):
    assert rounding(code([expression]), AT)[0] == pytest.approx((value, error), abs=1e-15)


@pytest.mark.parametrize("root", [1 / (a - 1.1), kn.sqrt(b), kn.log(b)], ids=str)
def test_nothing_is_said_where_a_result_is_not_finite(root):
    value, error = rounding(code([root]), AT)[0]
    assert math.isnan(error) or not math.isfinite(value)
