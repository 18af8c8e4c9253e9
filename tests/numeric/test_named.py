# SPDX-License-Identifier: BSD-3-Clause
"""Symbols by themselves or by name, and numbers for them."""

import numpy as np
import pytest

import kane as kn
from kane.numeric import finite_number, named_values, symbol_named, symbols_named

x, y = kn.coordinates("x y", "m")
m = kn.parameter("m", 2.0, "kg")


@pytest.mark.parametrize(
    "given", [{x: 1, y: 2}, {"x": 1, "y": 2}, {"y": 2, x: 1}, [1, 2], np.array([1, 2]), (v for v in (1, 2))]
)
def test_symbols_names_and_order_are_alike(given):
    assert named_values("coordinates", (x, y), given) == {x: 1, y: 2}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"z": 1}, "got one for 'z'"),
        (
            {kn.coordinate("x"): 1},
            r"another symbol of the name 'x': kn.coordinate\('x'\) in place of kn.coordinate\('x', unit='m'\)",
        ),
        ({kn.coordinate("x", "mm"): 1}, "unit='mm'.* in place of .*unit='m'.*own symbol, or give the name alone"),
        ({x: 1, "x": 2}, "one value for x, got two"),
        ([1], "Expected 2 coordinates .x, y., got 1"),
        ("xy", "a list of coordinates or a dict"),
        (x, "a list of coordinates or a dict"),
        (np.array(1.0), "a list of coordinates or a dict"),
        (3.0, "a list of coordinates or a dict"),
    ],
)
def test_what_is_said_of_others(given, message):
    with pytest.raises(kn.ValueMissingError, match=message):
        named_values("coordinates", (x, y), given)


def test_a_parameter_that_dropped_out_shares_its_dict_with_variants():
    spare = kn.parameter("k", 3.0)
    assert named_values("parameters", (m,), {m: 1, spare: 4}) == {m: 1}
    with pytest.raises(kn.ValueMissingError, match="got one for 'k'"):
        named_values("parameters", (m,), {"k": 4})
    with pytest.raises(kn.ValueMissingError, match="another symbol of the name 'm'"):
        named_values("parameters", (m,), {kn.parameter("m", 2.0, "g"): 4})
    with pytest.raises(kn.ValueMissingError, match="got one for k"):
        named_values("coordinates", (x, y), {spare: 4})


def test_lookup():
    assert symbol_named((x, y), "y") is y
    assert symbols_named("coordinates", (x, y), [y, "x"]) is not None
    assert y in symbols_named("coordinates", (x, y), ["y"])
    with pytest.raises(kn.ValueMissingError, match="Expected one of x, y, got 'X'"):
        symbol_named((x, y), "X")


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (2 * x, r"got the expression 2\*x. Give its value, kn.evaluate"),
        (lambda t: t, "got the function"),
        ([1, 2], "got an array of shape .2,"),
        ("one", "got 'one'. Give a plain number in the unit of x"),
        (np.nan, "finite start value for x, got nan"),
    ],
)
def test_what_is_no_number(value, message):
    with pytest.raises(kn.SimulationError, match=message):
        finite_number("start value", "x", value)


@pytest.mark.parametrize("given", [0, 0.0])
def test_zero_stands_for_all_at_zero_but_for_parameters(given):
    assert named_values("coordinates", (x, y), given) == {x: 0.0, y: 0.0}
    with pytest.raises(kn.ValueMissingError, match="a list of parameters or a dict"):
        named_values("parameters", (m,), given)
