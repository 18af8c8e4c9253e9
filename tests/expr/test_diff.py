# SPDX-License-Identifier: BSD-3-Clause
"""What is differentiated by: symbols, or their names; anything else is no zero."""

import pytest

import kane as kn

x, y = kn.coordinates("x y")


def test_by_name():
    e = x * x * y
    assert kn.diff(e, "x") is kn.diff(e, x) is 2 * x * y
    assert kn.gradient(e, ["x", y]) == kn.gradient(e, [x, y])
    assert kn.jacobian([e, x], ["y"]).entries == kn.jacobian([e, x], [y]).entries
    assert kn.diff(e, kn.parameter("k")) is kn.Rational(0)


@pytest.mark.parametrize("what", ["z", x + y, 2 * x, x * x, 1.0, None])
def test_what_is_no_symbol_is_refused(what):
    for derivative in (
        lambda: kn.diff(x * x * y, what),
        lambda: kn.gradient(x * x * y, [what]),
        lambda: kn.jacobian([x * x * y, x], [what]),
    ):
        with pytest.raises(
            kn.ExpressionError, match=r"Expected a symbol, or the name of one in the expression \(x, y\)"
        ):
            derivative()


def test_a_name_that_two_symbols_have():
    with pytest.raises(kn.ExpressionError, match="got 'x'"):
        kn.diff(x * kn.coordinate("x", "m"), "x")
