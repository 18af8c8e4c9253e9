# SPDX-License-Identifier: BSD-3-Clause
"""Square roots of rational numbers kept exact: ratio · √radicand, so that cos π/4 reads √2/2.

A surd is the nearest float to whatever knows no better. Products, quotients, powers and sums of one radicand stay exact; with any
other float, and in sums of different radicands, it is that float.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

_LARGEST = 10**6
"""Numerator times denominator up to which squares are taken out of a root."""


class Surd(float):
    """ratio · √radicand, with a ratio other than 0 and a radicand above 1 that no square divides."""

    __slots__ = ("radicand", "ratio")
    ratio: Fraction
    radicand: int

    def __new__(cls, ratio: Fraction, radicand: int) -> Surd:
        """The surd and its float."""
        size = math.sqrt(ratio * ratio * radicand)
        made = super().__new__(cls, size if ratio > 0 else -size)
        made.ratio, made.radicand = ratio, radicand
        return made

    def __reduce__(self) -> tuple[Callable[..., Surd], tuple[Any, ...]]:
        return Surd, (self.ratio, self.radicand)

    def __neg__(self) -> Surd:
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

    def reciprocal(self) -> Surd:
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
    if isinstance(value, float) or ratio.numerator * ratio.denominator > _LARGEST:
        return math.sqrt(value)
    radicand, outside, k = ratio.numerator * ratio.denominator, 1, 2
    while k * k <= radicand:
        while radicand % (k * k) == 0:
            radicand, outside = radicand // (k * k), outside * k
        k += 1
    return Surd(Fraction(outside, ratio.denominator), radicand)


def _made(ratio: Fraction, radicand: int) -> Any:
    if radicand == 1 or not ratio:
        return ratio
    return Surd(ratio, radicand)


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
