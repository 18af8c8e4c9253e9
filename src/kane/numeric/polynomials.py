# SPDX-License-Identifier: BSD-3-Clause
"""Polynomials: bounds of a quantity along a step, and Legendre's with Gauss's quadrature.

Where a quantity may pass zero within a step is told by bounds: passages between two places that are looked at are found too.
Through its values at nine places of an interval, close together towards its ends, goes a polynomial of degree 8. Its Bernstein
coefficients bound it: where all have one sign it has no zero, and it has no more zeros than they change sign. What the polynomial
leaves of the quantity is estimated by its last two Chebyshev coefficients, which of many periods may be small by chance: three
more places must agree with it. A quantity with a corner, as a distance has where it is nearly nothing, may dip between two places of
which the polynomial tells nothing: parabolas through the places beside tell where it would pass. Where that leaves a doubt the
interval is halved. Sources: Farouki, *The Bernstein polynomial
basis: a centennial retrospective*, Computer Aided Geometric Design 29 (2012), sec. 5; Trefethen, *Approximation Theory and
Approximation Practice*, 2013, ch. 8.

Legendre polynomials, their roots and Gauss's quadrature are made in decimal arithmetic: the same digits on every machine.
"""

import math
from collections import deque
from collections.abc import Callable, Sequence
from decimal import Decimal, localcontext
from functools import cache
from itertools import pairwise
from math import cos, pi
from typing import Any, NamedTuple

import numpy as np

from kane.numeric.arrays import Array, product
from kane.numeric.scale import EQUAL, SAME_TIME

DEGREE = 8
SHARES = tuple((1 - math.cos(math.pi * k / DEGREE)) / 2 for k in range(DEGREE + 1))
"""The places of an interval at which a quantity is looked at: at no two of them is a multiple of one period over for all."""
MOST = 400
"""So many intervals are halved at most in a step."""
CLOSE = 0.01
"""Share of a quantity's size that a polynomial must not leave, to say anything of it."""
SMALL = 0.1
"""Share of the largest that a quantity has been below which it may touch zero between two places, without a change of sign."""
LEFT = 2.0
"""What a polynomial leaves of a quantity is at most so many times its last Chebyshev coefficients."""
AGREEING = 4.0
"""How many times what is left a value between the places may be off, or `EQUAL` of the size."""
Bracket = tuple[float, float, float, float]
"""Two times and the values there, between which there is one passage."""

_at = np.array(SHARES)
_bernstein = np.array(
    [[math.comb(DEGREE, j) * x**j * (1 - x) ** (DEGREE - j) for j in range(DEGREE + 1)] for x in SHARES]
)
TO_BERNSTEIN: Array = np.linalg.inv(_bernstein)
TO_LAST: Array = np.linalg.inv(np.polynomial.chebyshev.chebvander(2 * _at - 1, DEGREE))[-2:]
"""From values at the places to the Bernstein coefficients, and to the last two Chebyshev coefficients."""


def _onward(gap: int) -> list[float]:
    """The weights of the value at the beginning of a gap and of the two before in the parabola's value at its end."""
    before = [k for k in (gap, gap - 1, gap - 2) if k >= 0]
    weights = [math.prod((_at[gap + 1] - _at[j]) / (_at[k] - _at[j]) for j in before if j != k) for k in before]
    return [float(w) for w in weights] + [0.0] * (3 - len(before))


TO_NEXT: Array = np.array([_onward(gap) for gap in range(DEGREE)]).T
"""3 × 8: of the value at the beginning of each gap, and of the two before, the weights in where they lead to at its end."""
BETWEEN = np.array([0.113, 0.427, 0.731])
_to_between = np.array(
    [[math.comb(DEGREE, j) * x**j * (1 - x) ** (DEGREE - j) for j in range(DEGREE + 1)] for x in BETWEEN]
)
TO_BETWEEN: Array = _to_between @ TO_BERNSTEIN


def left(values: Array) -> float:
    """An estimate of the difference between a quantity and the polynomial through its nine values."""
    return float(LEFT * np.abs(TO_LAST @ values).max())


def passages(of: Callable[[Array], Array], times: Array, values: Array) -> list[Bracket]:
    """Brackets of all passages between the first time and the last, in order; `of` gives values at times.

    Where values are not finite, or after `MOST` halvings, the signs at the places are what there is.
    """
    found, most = list[Bracket](), MOST
    open_ = deque([(times, values)])
    shortest = SAME_TIME * (times[-1] - times[0])
    while open_:
        times, values = open_.popleft()
        here = _seen(times, values)
        if (
            most <= 0
            or times[-1] - times[0] <= shortest
            or (_resolved(values, len(here)) and _agrees(of, times, values))
        ):
            found += here
            continue
        most -= 1
        middle = (times[0] + times[-1]) / 2
        halves = [times[0] + (middle - times[0]) * _at, middle + (times[-1] - middle) * _at]
        between = of(np.array([middle]))
        open_.append((halves[0], np.concatenate([values[:1], of(halves[0][1:-1]), between])))
        open_.append((halves[1], np.concatenate([between, of(halves[1][1:-1]), values[-1:]])))
    return sorted(found)


def _seen(times: Array, values: Array) -> list[Bracket]:
    """The brackets between neighbouring times with different signs; a zero belongs to the bracket that ends there."""
    pairs = pairwise(zip(map(float, times), map(float, values), strict=True))
    return [(s, t, a, b) for (s, a), (t, b) in pairs if (a > 0 and b <= 0) or (a < 0 and b >= 0)]


def _resolved(values: Array, passages: int) -> bool:
    """Whether the bounds exclude further passages, or the values are not finite."""
    if not np.isfinite(values).all():
        return True
    coefficients, slack = TO_BERNSTEIN @ values, left(values)
    if slack > CLOSE * np.abs(values).max() or _leads_beyond(values) or _leads_beyond(values[::-1]):
        return False
    return _changes(coefficients + slack) == _changes(coefficients - slack) == passages


def _leads_beyond(values: Array) -> bool:
    """Whether the parabola through the values before a gap, whose ends have the same sign, crosses zero within it."""
    padded = np.concatenate([values[:1], values[:1], values[:-1]])
    led = sum(weight * padded[2 - k : 2 - k + DEGREE] for k, weight in enumerate(TO_NEXT))
    return bool(((values[:-1] * values[1:] > 0) & (led * values[1:] < 0)).any())


def _agrees(of: Callable[[Array], Array], times: Array, values: Array) -> bool:
    """Whether three further values agree with the polynomial, or are not finite."""
    if not np.isfinite(values).all():
        return True
    between = of(times[0] + (times[-1] - times[0]) * BETWEEN)
    room = max(AGREEING * left(values), EQUAL * float(np.abs(values).max()))
    return not np.isfinite(between).all() or bool((np.abs(between - TO_BETWEEN @ values) <= room).all())


def _changes(values: Array) -> int:
    """The number of sign changes, without zeros."""
    signs = np.sign(values)
    signs = signs[signs != 0]
    return int((signs[1:] != signs[:-1]).sum())


def zero_of(quantity: Callable[[float], float], start: float, end: float, a: float, b: float, xtol: float) -> float:
    """The time of a quantity's zero between two times, with its values a and b there, by Brent's method to `xtol`.

    If the quantity, evaluated again, is zero at an end or has the sign of the other end, that end is returned.
    """
    from scipy.optimize import brentq

    first, last = quantity(start), quantity(end)
    if first * a <= 0:
        return float(start)
    if b == 0 or last * a > 0:
        return float(end)

    def finite(t: float) -> float:  # a pole that is hit may be NaN
        return float(np.nan_to_num(quantity(t), nan=np.inf))

    return float(brentq(finite, start, end, xtol=xtol, maxiter=1000, disp=False))


DIGITS = 50
_STEPS = 12

D = Decimal


class QuadratureRule(NamedTuple):
    """The nodes x (m) and weights w (m) with Σ w f(x) = ∫ f dx."""

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


def gauss(points: int, breaks: Sequence[float] = (0.0, 1.0)) -> QuadratureRule:
    """Gauss's rule with `points` nodes in each interval between two breaks, rounded to the last digit."""
    x, w = map(np.array, _rule(points))
    starts = np.array(breaks[:-1])
    lengths = np.array(breaks[1:]) - starts
    return QuadratureRule(
        (starts[:, None] + np.multiply.outer(lengths, x)).ravel(), np.multiply.outer(lengths, w).ravel()
    )
