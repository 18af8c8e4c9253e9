# SPDX-License-Identifier: BSD-3-Clause
"""Legendre polynomials in decimal arithmetic, their roots, and Gauss's quadrature: the same digits on every machine."""

from collections.abc import Sequence
from decimal import Decimal, localcontext
from functools import cache
from math import cos, pi
from typing import Any, NamedTuple

import numpy as np

from kane.numeric.arrays import Array, product

DIGITS = 50
_STEPS = 12

D = Decimal


class Rule(NamedTuple):
    """Places x (m) and weights w (m) with Σ w f(x) = ∫ f dx."""

    places: Array
    weights: Array

    def gram(self, a: Array, b: Array, share: Array | float = 1.0) -> Array:
        """∫ share a_k b_l dx of functions by their values (m × …)."""
        return product(a.T, (self.weights * share)[:, None] * b)


def legendre(count: int, x: Any) -> list[Any]:
    """P_0 … P_count−1 at x, a decimal or any other number, or an array."""
    p = [x * 0 + 1, x]
    for k in range(1, count - 1):
        p.append(((2 * k + 1) * x * p[k] - k * p[k - 1]) / (k + 1))
    return p


def root(n: int, guess: float, of: int = 0) -> D:
    """The root of P_n + `of` P_n−1 near a guess within (−1, 1), by Newton's method."""
    x = D(guess)
    for _ in range(_STEPS):
        p = legendre(n + 1, x)
        slope = sum(w * k * (x * p[k] - (p[k - 1] if k else 0)) for w, k in ((1, n), (of, n - 1)))
        step = (p[n] + of * p[n - 1]) * (x * x - 1) / slope
        x -= step
        if abs(step) < D(10) ** (-DIGITS // 2):  # what is left is the square of it
            break
    return x


def gauss_nodes(n: int) -> tuple[list[D], list[D]]:
    """The roots of P_n in ascending order, and the weights of Gauss's rule on (−1, 1), in the decimal context in force."""
    if n == 1:
        return [D(0)], [D(2)]
    positive = [root(n, cos(pi * (k + 0.75) / (n + 0.5))) for k in range(n // 2)]
    x = [*(-v for v in positive), *([D(0)] if n % 2 else []), *reversed(positive)]
    return x, [2 * (1 - v * v) / (n * legendre(n, v)[n - 1]) ** 2 for v in x]


@cache
def _rule(n: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    with localcontext() as context:
        context.prec = DIGITS
        x, w = gauss_nodes(n)
        return tuple(float((v + 1) / 2) for v in x), tuple(float(v / 2) for v in w)


def gauss(points: int, breaks: Sequence[float] = (0.0, 1.0)) -> Rule:
    """Gauss's rule with so many points in each piece between two breaks, to the last digit."""
    x, w = map(np.array, _rule(points))
    starts = np.array(breaks[:-1])
    lengths = np.array(breaks[1:]) - starts
    return Rule((starts[:, None] + np.multiply.outer(lengths, x)).ravel(), np.multiply.outer(lengths, w).ravel())
