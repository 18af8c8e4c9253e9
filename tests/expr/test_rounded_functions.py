# SPDX-License-Identifier: BSD-3-Clause
"""Constants are the double nearest to the exact value: mpmath's 60 digits are the second route."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kane as kn
from kane.expr import correctly_rounded

WITHIN = {"asin": 1.0, "acos": 1.0, "exp": 600.0, "sinh": 600.0, "cosh": 600.0}
"""Largest argument of some."""
NAMES = ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log")


def exact(name: str, *values: float) -> float:
    with mpmath.workdps(400):
        return float(getattr(mpmath, name)(*map(mpmath.mpf, values)))


@pytest.mark.parametrize("name", NAMES)
@given(
    x=st.floats(-1e6, 1e6, allow_subnormal=False).filter(bool) | st.floats(-1, 1, allow_subnormal=False).filter(bool)
)
def test_functions_of_one_number(name: str, x: float) -> None:
    x = math.remainder(x, WITHIN.get(name, math.inf)) or 0.5
    x = abs(x) if name == "log" else x
    assert correctly_rounded(name, x) == exact(name, x)


@given(*[st.floats(-1e9, 1e9, allow_subnormal=False).filter(bool)] * 2)
def test_angles_and_powers(y: float, x: float) -> None:
    assert correctly_rounded("atan2", y, x) == exact("atan2", y, x)
    assert correctly_rounded("pow", abs(y), math.remainder(x, 8.0) or 1.0) == exact(
        "power", abs(y), math.remainder(x, 8.0) or 1.0
    )


def test_what_has_no_real_value_is_left() -> None:
    assert [correctly_rounded(*of) for of in (("log", -1.0), ("asin", 2.0), ("pow", -2.0, 0.5), ("sin", math.inf))] == [
        None
    ] * 4
    assert correctly_rounded("add", 1.0, 2.0) is None


def test_expressions_take_these_values(rng: np.random.Generator) -> None:
    for x in rng.uniform(-1, 1, 50):
        for f, name in ((kn.sin, "sin"), (kn.cos, "cos"), (kn.tan, "tan"), (kn.exp, "exp"), (kn.asin, "asin")):
            assert kn.evaluate(f(float(x)), {}) == exact(name, float(x))
