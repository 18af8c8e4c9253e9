# SPDX-License-Identifier: BSD-3-Clause
"""Arithmetic of constant nodes that keeps a bound on the error of each: what rounding leaves of zero becomes zero.

A float that was given is known to a few units in its last place. Sums, products and quotients pass the errors of their terms on
(Higham 2002, Accuracy and Stability of Numerical Algorithms, sec. 3.3), and a result that is no larger than its error is zero: the
scalar product of perpendicular unit vectors is, though in floats it comes out as 1e-17. Where terms cancel in part the error is a
larger share of the result than of a float that was given; such a constant carries it, until the next sum. Integers, fractions and
surds are exact, and so are their sums and products. Elementary functions of constants are rounded to the nearest double: on every
machine alike.
"""

import math
from collections.abc import Callable
from decimal import Decimal, localcontext
from functools import lru_cache

import numpy as np

from kane.expr.node import ZERO, Expr, Number, constant
from kane.expr.ops import COS, SIN, Op
from kane.expr.surd import times

_DIGITS = 50
_TERMS = 40
"""Terms of a series: at |r| ≤ π/4 the last is 1e-51."""
_LARGEST = 1e9
"""Beyond, so many digits of π are not enough for an angle, and the C library's value is taken."""
_HALF_PI = Decimal("1.5707963267948966192313216916397514420985846996875529104874722961539082")
_ZERO, _ONE = Decimal(0), Decimal(1)


def _sin_cos(x: Decimal) -> tuple[Decimal, Decimal]:
    n = int((x / _HALF_PI).to_integral_value())
    r = x - n * _HALF_PI
    sums, term = [_ZERO, _ONE], _ONE  # sine, cosine
    for k in range(1, _TERMS):
        term = term * r / k
        sums[k % 2 == 0] += -term if k & 2 else term
    sine, cosine = sums
    return ((sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine))[n % 4]


def _tan(x: Decimal) -> Decimal:
    sine, cosine = _sin_cos(x)
    return sine / cosine


def _angle(y: Decimal, x: Decimal) -> Decimal:
    """The angle with tangent y/x."""
    near = math.atan2(y, x)
    if not near:
        near = float(y / x)  # so small that it is the tangent
    s, c = _sin_cos(Decimal(near))
    return Decimal(near) + (y * c - x * s) / (x * c + y * s)


def _beside(x: Decimal) -> Decimal:
    return ((1 - x) * (1 + x)).sqrt()


def _hyperbolic(x: Decimal, sign: int) -> Decimal:
    rising = x.exp()
    return (rising + sign / rising) / 2


_FUNCTIONS: dict[str, Callable[..., Decimal]] = {
    "sin": lambda x: _sin_cos(x)[0],
    "cos": lambda x: _sin_cos(x)[1],
    "tan": _tan,
    "asin": lambda x: _angle(x, _beside(x)),
    "acos": lambda x: _angle(_beside(x), x),
    "atan": lambda x: _angle(x, _ONE),
    "atan2": _angle,
    "sinh": lambda x: _hyperbolic(x, -1),
    "cosh": lambda x: _hyperbolic(x, 1),
    "tanh": lambda x: _hyperbolic(x, -1) / _hyperbolic(x, 1),
    "exp": lambda x: x.exp(),
    "log": lambda x: x.ln(),
    "pow": lambda x, y: x**y,
}


def value_of_numbers(op: Op, *values: float) -> float:
    """The value of an operation at numbers."""
    known = correctly_rounded(op.name, *values)
    if known is not None:
        return known
    with np.errstate(all="ignore"):
        return float(op.numpy(*map(np.float64, values)))


@lru_cache(maxsize=4096)
def correctly_rounded(name: str, *values: float) -> float | None:
    """The value of an elementary function by its name in `OPS`, at finite numbers other than 0.

    None for another operation, and for numbers at which it is not real.
    """
    function = _FUNCTIONS.get(name)
    if function is None or not all(map(math.isfinite, values)) or not all(values):
        return None
    if name in ("sin", "cos", "tan") and abs(values[0]) > _LARGEST:
        return None
    with localcontext() as context:
        context.prec = _DIGITS + max(
            0, *(-Decimal(v).adjusted() for v in values)
        )  # differences of what is nearly equal
        try:
            return float(function(*map(Decimal, values)))
        except ArithmeticError:
            return None


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
