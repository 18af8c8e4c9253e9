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
