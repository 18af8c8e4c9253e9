# SPDX-License-Identifier: BSD-3-Clause
"""Gauss's rule: exact for polynomials of degree 2n − 1, and NumPy's to rounding."""

from fractions import Fraction

import numpy as np
import pytest

from kane.numeric import gauss

EPS = np.finfo(float).eps


@pytest.mark.parametrize("n", [1, 2, 3, 8, 41])
def test_places_and_weights_are_those_of_numpy(n: int) -> None:
    x, w = np.polynomial.legendre.leggauss(n)
    rule = gauss(n)
    np.testing.assert_allclose(rule.places, (x + 1) / 2, atol=4 * EPS)
    np.testing.assert_allclose(rule.weights, w / 2, atol=n * EPS)


@pytest.mark.parametrize("n", [1, 2, 5, 12])
def test_powers_are_integrated_exactly(n: int) -> None:
    """In exact arithmetic only the rounding of places and weights is left."""
    rule = gauss(n)
    for power in range(2 * n):
        total = sum(Fraction(w) * Fraction(x) ** power for x, w in zip(*map(np.ndarray.tolist, rule), strict=True))
        assert abs(total - Fraction(1, power + 1)) < 2 * EPS


def test_pieces() -> None:
    """∫ over pieces of what is a polynomial on each."""
    rule = gauss(4, (0.0, 0.3, 1.0))
    assert rule.weights @ np.abs(rule.places - 0.3) == pytest.approx((0.3**2 + 0.7**2) / 2, rel=8 * EPS)
