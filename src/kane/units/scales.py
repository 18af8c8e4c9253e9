# SPDX-License-Identifier: BSD-3-Clause
"""Whether units go together without factors: one choice of base units explains them all.

N with kg, m and s does, N with t, mm and s does, mm with m does not. With e the exponents of a unit, c its scale and b the
scales of the base units, Σ eᵢ log bᵢ = log c must have a solution b. Elimination in exact exponents finds out, and keeps
track of which units a contradiction is made of.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from kane.units.algebra import Unit
from kane.units.table import BASES

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
