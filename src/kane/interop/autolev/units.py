# SPDX-License-Identifier: BSD-3-Clause
"""Units after numbers: the factor of each word to m, kg, s, rad, and the conversion to the units of a file."""

import re
from collections.abc import Sequence
from typing import Any

from kane.errors import alike
from kane.interop.autolev.grammar import Line

_DEGREE = 0.017453292519943295
_POUND, _LBF, _FOOT = 0.45359237, 4.4482216152605, 0.3048
Powers = tuple[int, int, int]
_MASS, _LENGTH, _TIME, _NONE = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)
_ROWS: tuple[tuple[float, Powers, str], ...] = (
    (1.0, _LENGTH, "m meter meters metre metres"),
    (1e-2, _LENGTH, "cm centimeter centimeters"),
    (1e-3, _LENGTH, "mm millimeter millimeters"),
    (1e3, _LENGTH, "km kilometer kilometers"),
    (0.0254, _LENGTH, "in inch inches"),
    (_FOOT, _LENGTH, "ft foot feet"),
    (1.0, _MASS, "kg kilogram kilograms kgm"),
    (1e-3, _MASS, "g gm gram grams"),
    (_POUND, _MASS, "lbm"),
    (_LBF / _FOOT, _MASS, "slug slugs"),
    (1.0, _TIME, "s sec secs second seconds"),
    (1e-3, _TIME, "ms msec"),
    (60.0, _TIME, "min minute minutes"),
    (3600.0, _TIME, "hour hours hr hrs"),
    (1.0, _NONE, "rad rads radian radians nounits unit units ul none 1"),
    (_DEGREE, _NONE, "deg degs degree degrees"),
    (360 * _DEGREE, _NONE, "rev revs"),
    (6 * _DEGREE, (0, 0, -1), "rpm"),
    (1.0, (1, 1, -2), "n newton newtons"),
    (1e3, (1, 1, -2), "kn"),
    (_LBF, (1, 1, -2), "lbf"),
    (1.0, (1, 2, -2), "j joule joules"),
    (1.0, (1, 2, -3), "w watt watts"),
    (1.0, (1, -1, -2), "pa pascal pascals"),
    (1.0, (0, 0, -1), "hz hertz"),
)
UNITS = {word: (factor, powers) for factor, powers, words in _ROWS for word in words.split()}
"""The factor of each unit word, and its powers of mass, length and time."""
_FACTOR = re.compile(r"([*/]?)(\w+)(?:\^([+-]?[\d.]+))?")
SI = (1.0, 1.0, 1.0)
"""The units of mass, length and time of a file without a UnitSystem."""


def base_units(words: Sequence[str], line: Line) -> tuple[float, float, float]:
    """The units of mass, length and time of a UnitSystem line."""
    base = list(SI)
    for word in words:
        factor, powers = _unit(word, line)
        if sum(map(abs, powers)) == 1:
            base[powers.index(1)] = factor
    return base[0], base[1], base[2]


def factor_of(unit: Any, base: tuple[float, float, float], line: Line) -> float:
    """The factor of a number with a unit; words with powers are multiplied and divided from left to right."""
    text = "".join(str(x).lower() for x in unit.children if x is not None)
    total = 1.0
    for sign, word, raised in _FACTOR.findall(text):
        factor, powers = _unit(word, line)
        power = float(raised or 1)
        if abs(power) > 12:
            raise line.refuse("a power of a unit of at most 12", power)
        for size, exponent in zip(base, powers, strict=True):
            factor /= size**exponent
        total *= factor ** (-power if sign == "/" else power)
    return total


def _unit(word: str, line: Line) -> tuple[float, Powers]:
    if word.lower() not in UNITS:
        raise line.refuse("a unit", word, alike(word, UNITS).strip() or "An operator may be missing before it.")
    return UNITS[word.lower()]
