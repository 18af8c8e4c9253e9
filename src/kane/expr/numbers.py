# SPDX-License-Identifier: BSD-3-Clause
"""Numbers beyond Python's: square roots of rational numbers kept exact, and elementary functions rounded once.

A surd is ratio · √radicand, so that cos π/4 reads √2/2. It is the nearest float to whatever knows no better. Products, quotients,
powers and sums of one radicand stay exact; with any other float, and in sums of different radicands, it is that float.

Elementary functions of floats are rounded to the nearest double: on every machine alike.
"""

import math
from collections.abc import Callable
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np

from kane.expr.ops import Op

_SQUARED = 10**6
"""Numerator times denominator up to which squares are taken out of a root."""


class Surd(float):
    """ratio · √radicand, with a ratio other than 0 and a radicand above 1 that no square divides."""

    __slots__ = ("radicand", "ratio")
    ratio: Fraction
    radicand: int

    def __new__(cls, ratio: Fraction, radicand: int) -> "Surd":
        """The surd and its float."""
        size = math.sqrt(ratio * ratio * radicand)
        made = super().__new__(cls, size if ratio > 0 else -size)
        made.ratio, made.radicand = ratio, radicand
        return made

    def __reduce__(self) -> "tuple[Callable[..., Surd], tuple[Any, ...]]":
        return Surd, (self.ratio, self.radicand)

    def __neg__(self) -> "Surd":
        return Surd(-self.ratio, self.radicand)

    def __add__(self, other: Any) -> Any:
        if isinstance(other, Surd) and other.radicand == self.radicand:
            return _made(self.ratio + other.ratio, self.radicand)
        return self if isinstance(other, int) and other == 0 else float(self) + other

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Surd):
            common = math.gcd(self.radicand, other.radicand)
            return _made(self.ratio * other.ratio * common, self.radicand * other.radicand // (common * common))
        if isinstance(other, int | Fraction):
            return _made(self.ratio * other, self.radicand)
        return float(self) * other

    __rmul__ = __mul__

    def reciprocal(self) -> "Surd":
        """1/self."""
        return Surd(1 / (self.ratio * self.radicand), self.radicand)

    def __truediv__(self, other: Any) -> Any:
        if isinstance(other, Surd):
            return self * other.reciprocal()
        return self * (Fraction(1) / other) if isinstance(other, int | Fraction) else float(self) / other

    def __rtruediv__(self, other: Any) -> Any:
        return self.reciprocal() * other

    def __pow__(self, exponent: Any, modulus: None = None) -> Any:
        if not isinstance(exponent, int):
            return float(self) ** exponent
        half, odd = divmod(exponent, 2)
        whole = self.ratio**exponent * Fraction(self.radicand) ** half
        return _made(whole, self.radicand) if odd else whole


def times(a: Any, b: Any) -> Any:
    """a · b of two numbers, exact where one is a surd and the other a fraction: a fraction in front would make it a float."""
    return b * a if isinstance(b, Surd) else a * b


def root(value: Any) -> Any:
    """√value of a number ≥ 0: exact where it is a fraction of ordinary size, else a float."""
    ratio = Fraction(value)
    top, bottom = math.isqrt(ratio.numerator), math.isqrt(ratio.denominator)
    if top * top == ratio.numerator and bottom * bottom == ratio.denominator:
        return Fraction(top, bottom)
    if isinstance(value, float) or ratio.numerator * ratio.denominator > _SQUARED:
        return math.sqrt(value)
    radicand, outside, k = ratio.numerator * ratio.denominator, 1, 2
    while k * k <= radicand:
        while radicand % (k * k) == 0:
            radicand, outside = radicand // (k * k), outside * k
        k += 1
    return Surd(Fraction(outside, ratio.denominator), radicand)


def _made(ratio: Fraction, radicand: int) -> Any:
    return ratio if radicand == 1 or not ratio else Surd(ratio, radicand)


_SINES = {
    Fraction(0): Fraction(0),
    Fraction(1, 6): Fraction(1, 2),
    Fraction(1, 4): Surd(Fraction(1, 2), 2),
    Fraction(1, 3): Surd(Fraction(1, 2), 3),
    Fraction(1, 2): Fraction(1),
}


def sine_of_turns(ratio: Fraction | int) -> Any:
    """sin(ratio · π) where it is a rational number or a surd of multiples of π/6 and π/4, else None."""
    left = Fraction(ratio) % 2
    below = left >= 1
    left -= below
    value = _SINES.get(min(left, 1 - left))
    return None if value is None else -value if below else value


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
