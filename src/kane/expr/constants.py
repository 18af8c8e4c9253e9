# SPDX-License-Identifier: BSD-3-Clause
"""Arithmetic of constant nodes that keeps a bound on the error of each: what rounding leaves of zero becomes zero.

A float that was given is known to a few units in its last place. Sums, products and quotients pass the errors of their terms on
(Higham 2002, Accuracy and Stability of Numerical Algorithms, sec. 3.3), and a result that is no larger than its error is zero: the
scalar product of perpendicular unit vectors is, though in floats it comes out as 1e-17. Where terms cancel in part the error is a
larger share of the result than of a float that was given; such a constant carries it, until the next sum. Integers, fractions and
surds are exact, and so are their sums and products.
"""

import math

from kane.expr.node import ZERO, Expr, Number, constant
from kane.expr.ops import COS, SIN
from kane.expr.rounded_functions import value_of_numbers
from kane.expr.surd import times

EPS = 2.0**-52
GIVEN = 4 * EPS
"""Error of a float that was given, over its size: components of a vector that was divided by its length have about one EPS."""
_KEPT = 9 * EPS
"""Error over size from which on a constant carries it; below, it counts as given: products and quotients of floats that were given,
whose errors are 2 GIVEN, are ordinary floats.

Each step of a sum may forget as much, so that it is no larger: of 32 EPS a sum of three terms and their difference from what they
were forgot more than rounding had left there.
"""
_ORDINARY = 32 * EPS
"""Error over size up to which nothing need have cancelled in a constant: that of a product of a few factors that were given.

Weights of constants are multiplied along a chain: were a product's 2, that of fifteen links were 2¹⁵.
"""


def number_of(a: Expr) -> Number:
    """The number of a constant node."""
    return a.value  # type: ignore[attr-defined, no-any-return]


def error_of(a: Expr) -> float:
    """The bound on the error of a constant node."""
    value = number_of(a)
    return _carried(a) or GIVEN * abs(value) if isinstance(value, float) else 0.0


def _carried(a: Expr) -> float:
    return a.error  # type: ignore[attr-defined, no-any-return]


def _rounded(value: float, error: float) -> Expr:
    """The constant of a value that was computed with at most that error; ZERO where nothing of it is certain."""
    size = abs(value)
    if size <= error < math.inf:
        return ZERO
    return constant(value, error) if error > _KEPT * size else constant(value)


def total(a: Expr, b: Expr, sign: int = 1) -> Expr:
    """a + sign·b of two constants."""
    value = number_of(a) + sign * number_of(b)
    return _rounded(value, error_of(a) + error_of(b)) if type(value) is float else constant(value)


def product(a: Expr, b: Expr) -> Expr:
    """a b of two constants."""
    x, y = number_of(a), number_of(b)
    value = times(x, y)
    return (
        _rounded(value, abs(float(x)) * error_of(b) + abs(float(y)) * error_of(a))
        if type(value) is float
        else constant(value)
    )


def quotient(a: Expr, b: Expr) -> Expr:
    """a / b of two constants, b not 0."""
    below = number_of(b)
    value = float(number_of(a) / below)
    return _rounded(value, (error_of(a) + abs(value) * error_of(b)) / abs(float(below)))


def turned(a: Expr, quarters: int) -> Expr:
    """sin(a + quarters π/2) of a constant a, quarters 0 or 1."""
    sine, cosine = (value_of_numbers(op, float(number_of(a))) for op in (SIN, COS))
    value, slope = (cosine, sine) if quarters else (sine, cosine)
    return _rounded(value, abs(slope) * error_of(a))


def opposite(a: Expr) -> Expr:
    """−a of a constant."""
    return constant(-number_of(a), _carried(a))


def weight(a: Expr) -> float:
    """The size beside which a constant counts as zero: its own, or that of what cancelled in it."""
    size, carried = abs(float(number_of(a))), _carried(a)
    return carried / GIVEN if carried > _ORDINARY * size else size
