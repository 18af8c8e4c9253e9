# SPDX-License-Identifier: BSD-3-Clause
"""Taylor's expansion against known series, and against what is left of it."""

from __future__ import annotations

import pytest

import kane as kn

x, y = kn.coordinates("x y")
a = kn.parameter("a", 1.3)


def test_known_series():
    assert str(kn.taylor(kn.cos(x), {x: 0}, 4)) == "1 - x^2*(1/2 - x^2/24)"
    assert kn.evaluate(kn.taylor(kn.exp(a * x), {x: 0}, 3), {x: 0.2}) == pytest.approx(
        1 + 0.26 + 0.26**2 / 2 + 0.26**3 / 6
    )


def test_what_is_left_is_of_the_next_order():
    """Halving the distance divides the remainder by 2ⁿ⁺¹."""
    e = kn.sin(x * y + a) * kn.exp(-x) / (1 + y**2)
    for order in range(4):
        near = kn.taylor(e, {x: 0.3, y: a}, order)
        left = [abs(kn.evaluate(e - near, {x: 0.3 + h, y: 1.3 - 0.7 * h})) for h in (2.0**-6, 2.0**-7)]
        assert left[0] / left[1] == pytest.approx(2 ** (order + 1), rel=0.1)


def test_others_are_kept():
    assert str(kn.taylor(a * x * y**2, {"x": 0}, 1)) == "a*x*y^2"


def test_what_cannot_be():
    with pytest.raises(kn.ArgumentError, match="order from 0 to 12"):
        kn.taylor(x, {x: 0}, -1)
    with pytest.raises(kn.ArgumentError, match="values free of x"):
        kn.taylor(x * y, {x: 2 * x})


@pytest.mark.parametrize(
    "e", [abs(x), abs(x) + x, kn.max(x, 0), kn.where(kn.less(x, 0), x, 2 * x), kn.where(kn.less(0, x), 1, 0)]
)
def test_a_corner_has_no_expansion(e):
    with pytest.raises(kn.ExpressionError, match=r"all derivatives exist, got a corner: .* switches at x = 0"):
        kn.taylor(e, {x: 0}, 1)
    assert kn.evaluate(kn.taylor(e, {x: 1}, 1), {x: 1.2}) == pytest.approx(kn.evaluate(e, {x: 1.2}))


def test_a_corner_of_later_derivatives_does_not_matter():
    """x |x| has the value and the slope 0, and no second derivative; x² either way has all."""
    assert kn.taylor(x * abs(x), {x: 0}, 1) is x - x
    with pytest.raises(kn.ExpressionError, match="corner"):
        kn.taylor(x * abs(x), {x: 0}, 2)
    assert kn.taylor(abs(x) * abs(x), {x: 0}, 2) is kn.taylor(x**2, {x: 0}, 2)
