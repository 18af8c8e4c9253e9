# SPDX-License-Identifier: BSD-3-Clause
"""Units: a unit is exponents over base quantities and a scale to SI; units multiply, divide and take powers.

Equal units are one object: scales are rounded to twelve digits. Units go together without factors where one choice of base units
explains them all: N with kg, m and s does, N with t, mm and s does, mm with m does not. With e the exponents of a unit, c its scale
and b the scales of the base units, Σ eᵢ log bᵢ = log c must have a solution b. Elimination in exact exponents finds out, and keeps
track of which units a contradiction is made of.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from kane.units.table import BASES

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


_SLACK = 1e-9


@dataclass(frozen=True, slots=True)
class Conflict:
    """Units that no choice of base units explains together, and the factor that is left over."""

    units: tuple[Unit, ...]
    factor: float


def conflict(units: Iterable[Unit]) -> Conflict | None:
    """The first contradiction among the units; those that come early are believed."""
    rows: dict[int, tuple[list[Fraction], float, dict[Unit, Fraction]]] = {}
    for unit in units:
        exponents, rest = [Fraction(e) for e in unit.exponents], math.log(unit.scale)
        parts = {unit: Fraction(1)}
        for i in range(len(BASES)):
            if not exponents[i]:
                continue
            if i not in rows:
                rows[i] = (exponents, rest, parts)
                break
            row, scale, others = rows[i]
            factor = exponents[i] / row[i]
            exponents = [x - factor * y for x, y in zip(exponents, row, strict=True)]
            rest -= float(factor) * scale
            for other, share in others.items():
                parts[other] = parts.get(other, Fraction(0)) - factor * share
        else:
            if abs(rest) > _SLACK:
                return Conflict(tuple(u for u, share in parts.items() if share), math.exp(rest))
    return None
