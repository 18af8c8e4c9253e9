# SPDX-License-Identifier: BSD-3-Clause
"""Sums of products of sines and cosines, by two angles: the same value, fewer operations, and the expected text."""

import numpy as np
import pytest

import kane as kn
from kane.expr import by_two_angles, price

q1, q2, q10 = kn.coordinates("q1, q2, q10")
m, g, l = kn.parameters("m, g, l")
s1, c1, s2, c2, s10, c10 = (f(q) for q in (q1, q2, q10) for f in (kn.sin, kn.cos))


@pytest.mark.parametrize(
    ("e", "text"),
    [
        (c2 * c1 + s1 * s2, "cos(q1 - q2)"),
        (c2 * c1 - s1 * s2, "cos(q1 + q2)"),
        (s1 * s2 - c2 * c1, "-cos(q1 + q2)"),
        (s10 * c2 + c10 * s2, "sin(q2 + q10)"),
        (s10 * c2 - c10 * s2, "-sin(q2 - q10)"),
        (m * c1 * l * c2 - g + l * s2 * s1 * m, "m*l*cos(q1 - q2) - g"),
        (g * s1 / 2 + 3 * l * c1 * s2 - 3 * s1 * l * c2, "g*sin(q1)/2 - 3*l*sin(q1 - q2)"),
        ((c1 * c2 - s1 * s2) * c10 - (s1 * c2 + c1 * s2) * s10, "cos(q1 + q2 + q10)"),
        (m * (g * c1 + l * c2) * s1 - m * (g * s1 + l * s2) * c1, "m*l*sin(q1 - q2)"),
        (2 * c1 * c2 + s1 * s2, "2*cos(q1)*cos(q2) + sin(q1)*sin(q2)"),  # other numbers: no one term
        (m * c1 * c2 + l * s1 * s2, "m*cos(q1)*cos(q2) + l*sin(q1)*sin(q2)"),
        (c1 * c1 * c2 + s1 * s1 * s2, "cos(q1)^2*cos(q2) + sin(q1)^2*sin(q2)"),
    ],
)
def test_pairs(e: kn.Expr, text: str) -> None:
    (found,) = by_two_angles([e])
    assert str(found) == text
    assert price([found]) <= price([e])
    at = {q1: 0.7, q2: -1.9, q10: 2.3, m: 1.3, g: 9.1, l: 0.4}
    value, wanted = kn.evaluate([found, e], at)
    np.testing.assert_allclose(value, wanted, rtol=1e-14)


def test_what_others_share_is_not_taken_apart() -> None:
    """Where what is read by two angles is not shorter beside the other roots, they stay as they are."""
    x = c1 * c2
    roots = (x + s1 * s2, x * kn.exp(x), s1 * s2 * m, s1 * s2 / g)
    assert price(by_two_angles(roots)) <= price(roots)
    assert by_two_angles([m * s1, m * c1 + g]) == (m * s1, m * c1 + g)
