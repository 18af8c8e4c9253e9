# SPDX-License-Identifier: BSD-3-Clause
"""Units: a unit is exponents over base quantities and a scale to SI; units multiply, divide and take powers.

Equal units are one object: scales are rounded to twelve digits.
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

Exponent = int | Fraction


@dataclass(frozen=True, slots=True, eq=False)
class Unit:
    """Exponents over kg, m, s, A, K, mol and cd, and how many coherent SI units one of it is."""

    exponents: tuple[Exponent, ...]
    scale: float

    @property
    def is_bare(self) -> bool:
        """Whether it is of dimension one: an angle, a ratio."""
        return self.exponents == NONE


NONE: tuple[Exponent, ...] = (0,) * 7
NUMBER = Unit(NONE, 1.0)
"""Of a number without a unit: of dimension one, and nobody said so."""
ANY = Unit(NONE, 1.0)
"""Of the number 0, which is zero in any unit."""

_units: dict[tuple[tuple[Exponent, ...], float], Unit] = {}


def unit(exponents: tuple[Exponent, ...], scale: float = 1.0) -> Unit:
    """The one unit with these exponents and this scale; an OverflowError where the scale is zero or infinite."""
    rounded = float(f"{scale:.12g}")
    if not 0 < rounded < math.inf:
        raise OverflowError(scale)
    key = (tuple(int(e) if e == int(e) else e for e in exponents), rounded)
    return _units.setdefault(key, Unit(*key))


ONE = unit(NONE)
"""Of what is said to be of dimension one: a ratio, an angle in radians."""


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
