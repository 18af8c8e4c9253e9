# SPDX-License-Identifier: BSD-3-Clause
"""Antiderivatives differentiate back to what they came from; what the table has not is None."""

from __future__ import annotations

import pytest

import kane as kn
from kane.dynamics import line_integral
from kane.expr import antiderivative

x, y = kn.coordinates("x y")
a, b = kn.parameter("a", 1.3), kn.parameter("b", 0.7)
AT = {x: 1.1, y: 0.6, a: 1.3, b: 0.7}
KNOWN = {
    "powers": x**3 * y + 2 / x - 1 / x**3,
    "one angle": kn.sin(x) * kn.cos(x) ** 3 + kn.sin(a * x) ** 4 * kn.cos(a * x),
    "squares": kn.sin(x) ** 2 + kn.cos(b * x) ** 4,
    "angles": kn.sin(a * x + y) * kn.cos(x) * kn.cos(2 * x - y),
    "by parts": x**2 * kn.sin(a * x + y) * kn.cos(x) + x**3 * kn.exp(-a * x),
    "beats that stand": x * kn.cos(x + y) * kn.sin(x - y),
    "roots": x / kn.sqrt(x**2 + y**2) + (2 * x + 1) * kn.sqrt(x**2 + x + 2),
    "a spring": a * (kn.sqrt(x * x + y * y) - b) * x / kn.sqrt(x * x + y * y),
    "gravitation": (x - b * kn.cos(y)) / kn.sqrt(x * x - 2 * b * x * kn.cos(y) + b * b) ** 3,
    "quotients": kn.tan(x) + kn.sin(x) / (2 + kn.cos(x)) + x / (x**2 + y**2) ** 2,
    "one side": kn.max(x - b, 0) ** 2,
    "nothing of x": y * kn.exp(y),
}


@pytest.mark.parametrize("name", KNOWN)
def test_differentiates_back(name):
    found = antiderivative(KNOWN[name], x)
    assert found is not None
    assert kn.evaluate(kn.diff(found, x), AT) == pytest.approx(kn.evaluate(KNOWN[name], AT), rel=1e-12)


@pytest.mark.parametrize("e", [kn.exp(x**2), kn.sin(x) / x, kn.sqrt(x**3 + 1), kn.abs(x), kn.cos(x**2)])
def test_what_is_not_there(e):
    assert antiderivative(e, x) is None


def test_lines_give_a_potential_as_short_as_it_was():
    for v in (x**2 * y + b * y * kn.cos(x), b / kn.sqrt(x**2 + y**2), kn.sin(x + y) * y**2):
        found = line_integral([kn.diff(v, x), kn.diff(v, y)], (x, y))
        assert found.by_rule == ()
        assert kn.count_operations([found.value]).total <= kn.count_operations([v]).total


def test_gauss_where_there_is_no_closed_form():
    found = line_integral([kn.exp(-(x**2))], (x,))
    assert found.by_rule == (x,)
    assert kn.evaluate(found.value, {x: 1.1}) == pytest.approx(
        0.8802050695740817 * 0.886226925452758, rel=1e-13
    )  # √π/2 erf x
