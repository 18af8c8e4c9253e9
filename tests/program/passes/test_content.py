# SPDX-License-Identifier: BSD-3-Clause
"""Parameters leave products and sums: the same values, fewer operations with the state, fewer divisions."""

from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.equations import program
from kane.expr import DIV
from kane.gallery import four_bar, slider_crank
from kane.program import assembled, receipt, rewritten, rounding, starts, written
from tests.examples import examples
from tests.program.passes.codes import (
    ARITHMETIC,
    EPS,
    NUMBERS,
    PARAMETERS,
    STATES,
    SYMBOLS,
    code,
    exact,
    expressions,
)

a, b, c, d = STATES
k, l, m = PARAMETERS
FUNCTIONS = (*ARITHMETIC, *ARITHMETIC, "sqrt", "sin", "abs", "min", "max")


def state(*roots):
    """Operations with the state of roots in normal form, rewritten, and divisions among them."""
    given = code(roots)
    made = assembled(written(starts(given)[0], given))
    body = made.routines[0].body
    return sum(made.op(i).cost for i in body), sum(made.op(i) is DIV for i in body)


@examples(0.5)
@given(
    st.lists(expressions(FUNCTIONS), min_size=1, max_size=2),
    st.lists(NUMBERS, min_size=len(SYMBOLS), max_size=len(SYMBOLS)),
    st.booleans(),
)
def test_values_stay_within_the_bound(routines, values, reciprocals):
    made = code(*routines, reciprocals=reciprocals)
    for found in (rewritten(made),):
        for (value, error), right in zip(rounding(found, values), exact(made, values), strict=True):
            if right is not None and error * EPS < 1e-3 * abs(value):
                assert abs(value - right) <= 1.01 * error * EPS / 2 + 1e-300


def test_divisors_share_what_varies():
    assert state(a / (k * (b + c)), d / (l * (b + c))) == (6, 1)


def test_a_length_that_is_divided_out_comes_back_free():
    x = a / (k * b)
    assert state(kn.sin(k * x) + k * x * c) == state(kn.sin(a / b) + a / b * c)


def test_parameters_meet_where_they_are_hoisted():
    y = k * a + k * b
    assert state(l * y * c, m * y * d) == (5, 0)  # y = a + b, (k l) (y c), (k m) (y d)
    assert state(k * k * a * b + k * l * c * d) == (6, 0)  # k (k a b + l c d)


def test_a_sum_of_parameters_is_a_factor_too():
    moment = (k * k + l * l) * m
    assert state(moment * a / (moment * b)) == (1, 1)


def test_the_four_bar_divides_twice():
    """By the sine of the angle between crank and rocker, and by the reduced mass, whose factor b² leaves the fraction."""
    made = program(kn.derive(four_bar.system()).solved, ("rhs",))
    body = made.routine("rhs").body
    assert sum(made.op(i) is DIV for i in body) == 2
    assert receipt(made)["rhs"].state <= 90
    assert receipt(program(kn.derive(slider_crank.system()).solved, ("rhs",)))["rhs"].state <= 77


def test_numbers_in_brackets_may_share_factors_again():
    """cos a (k l m + k m²) + …: the bracket is factored once more, and is not found in itself."""
    made = code([k * l * m * kn.cos(a) + k * m * m * kn.cos(a) + b * c])
    assert sum(op.cost for op in rewritten(made).ops) <= 7
