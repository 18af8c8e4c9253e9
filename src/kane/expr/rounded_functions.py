# SPDX-License-Identifier: BSD-3-Clause
"""Elementary functions of numbers, rounded to the nearest double: what becomes a constant has the same digits on every machine.

The C library's and NumPy's functions may differ in the last digit from processor to processor. Here sin and cos are summed in
decimal arithmetic by Taylor's series; exp, log and powers are those of the standard library's `decimal`; the inverse functions
take one Newton step from the C library's value, whose error of some 1e-16 it cubes.
"""

import math
from collections.abc import Callable
from decimal import Decimal, localcontext
from functools import lru_cache

import numpy as np

from kane.expr.ops import Op

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
