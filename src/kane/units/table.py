# SPDX-License-Identifier: BSD-3-Clause
"""Units: a unit is exponents over base quantities and a scale to SI; units multiply, divide and take powers.

Products of the usual symbols are read here; every other text goes to Pint, which takes longer to import than most
models to derive. Equal units are one object: scales are rounded to twelve digits.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

Exponent = int | Fraction

BASES = ("mass", "length", "time", "current", "temperature", "substance", "luminosity")
"""Base quantities, in the order of `Unit.exponents`."""


@dataclass(frozen=True, slots=True, eq=False)
class Unit:
    """Exponents over `BASES`, and how many coherent SI units one of it is."""

    exponents: tuple[Exponent, ...]
    scale: float

    @property
    def is_bare(self) -> bool:
        """Whether it is of dimension one: an angle, a ratio."""
        return self.exponents == NONE


NONE: tuple[Exponent, ...] = (0,) * len(BASES)
NUMBER = Unit(NONE, 1.0)
"""Of a number without a unit: of dimension one, and nobody said so."""
ANY = Unit(NONE, 1.0)
"""Of the number 0, which is zero in any unit."""

_units: dict[tuple[tuple[Exponent, ...], float], Unit] = {}


def unit(exponents: tuple[Exponent, ...], scale: float = 1.0) -> Unit:
    """The one unit with these exponents and this scale.

    Raises
    ------
    OverflowError
        if the scale is zero or infinite
    """
    rounded = float(f"{scale:.12g}")
    if not 0 < rounded < math.inf:
        raise OverflowError(scale)
    key = (tuple(int(e) if e == int(e) else e for e in exponents), rounded)
    return _units.setdefault(key, Unit(*key))


@lru_cache(8192)
def product(a: Unit, b: Unit) -> Unit:
    """The unit of x y."""
    if a is NUMBER or b is ANY:
        return b
    if b is NUMBER or a is ANY:
        return a
    return unit(tuple(x + y for x, y in zip(a.exponents, b.exponents, strict=True)), a.scale * b.scale)


@lru_cache(8192)
def power(a: Unit, p: Exponent) -> Unit:
    """The unit of x**p."""
    return a if a is NUMBER or a is ANY else unit(tuple(e * p for e in a.exponents), a.scale**p)


@lru_cache(8192)
def quotient(a: Unit, b: Unit) -> Unit:
    """The unit of x / y."""
    return product(a, power(b, -1))


# What the table knows: symbol → (scale, exponents of mass, length, time, current).
_PREFIXES = {"": 1.0, "m": 1e-3, "k": 1e3, "M": 1e6}
_PREFIXED = {
    "g": (1e-3, (1,)),
    "m": (1.0, (0, 1)),
    "s": (1.0, (0, 0, 1)),
    "A": (1.0, (0, 0, 0, 1)),
    "N": (1.0, (1, 1, -2)),
    "J": (1.0, (1, 2, -2)),
    "W": (1.0, (1, 2, -3)),
    "Pa": (1.0, (1, -1, -2)),
    "Hz": (1.0, (0, 0, -1)),
    "V": (1.0, (1, 2, -3, -1)),
}
_SINGLE: dict[str, tuple[float, tuple[int, ...]]] = {
    "1": (1.0, ()),
    "rad": (1.0, ()),
    "deg": (math.pi / 180, ()),
    "cm": (1e-2, (0, 1)),
    "t": (1e3, (1,)),
    "min": (60.0, (0, 0, 1)),
    "h": (3600.0, (0, 0, 1)),
    "rpm": (math.pi / 30, (0, 0, -1)),
    "K": (1.0, (0, 0, 0, 0, 1)),
}


def _of_row(scale: float, exponents: tuple[int, ...]) -> Unit:
    return unit(exponents + NONE[len(exponents) :], scale)


SYMBOLS: dict[str, Unit] = {
    p + s: _of_row(factor * row[0], row[1]) for s, row in _PREFIXED.items() for p, factor in _PREFIXES.items()
} | {s: _of_row(*row) for s, row in _SINGLE.items()}
"""The symbols that are read without Pint."""

ONE = SYMBOLS["1"]
MASS, LENGTH, TIME, FORCE, ENERGY = (SYMBOLS[s] for s in ("kg", "m", "s", "N", "J"))

_FACTOR = re.compile(r"( *\*(?!\*) *| */ *| +|^)([A-Za-z]+|1)(?:(?:\^|\*\*)(-?\d{1,2}))?")


@lru_cache(4096)
def parse(text: str) -> Unit:
    """The unit that a text such as "kg*m^2" or "m/s^2" means.

    Raises
    ------
    UnitError
        if it means none, or one that models cannot be written in (degC, dB)
    """
    try:
        found = _usual(text.strip(" "))
    except OverflowError:
        found = None
    if found is None:
        from kane.units.by_pint import by_pint

        return by_pint(text)
    return found


def _usual(text: str) -> Unit | None:
    """A product of powers of symbols in the table; None for any other text."""
    found, at = ONE, 0
    while at < len(text):
        factor = _FACTOR.match(text, at)
        symbol = SYMBOLS.get(factor[2]) if factor is not None else None
        if factor is None or symbol is None:
            return None
        term = power(symbol, int(factor[3] or 1))
        found = quotient(found, term) if "/" in factor[1] else product(found, term)
        at = factor.end()
    return found if text else None
