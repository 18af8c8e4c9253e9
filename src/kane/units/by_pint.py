# SPDX-License-Identifier: BSD-3-Clause
"""Units beyond the usual symbols, read by Pint, which is imported when the first one is met."""

from __future__ import annotations

import math
import re
from difflib import get_close_matches
from fractions import Fraction
from functools import cache
from typing import Any, NoReturn

from kane.errors import UnitError
from kane.units.table import BASES, SYMBOLS, Unit, unit

_PINT_NAMES = {f"[{name}]": i for i, name in enumerate(BASES)}
_MISREAD = re.compile(r"\b([kmM]?N)m\b")  # Pint's Nm is a measure of yarn: metres a kilogram
_STRANGE = re.compile(r"[^\w */^().·°%⁻-]")  # Pint passes over signs that it does not know
_WORD = re.compile(r"[^\W\d_]\w*")
_FINEST = 10_000
_NEAR = 0.8


@cache
def registry() -> Any:
    """Pint's table of units, made once."""
    import pint

    return pint.UnitRegistry()


def by_pint(text: str) -> Unit:
    """The unit that Pint reads in a text; offsets, logarithms and factors are refused."""
    if not text.strip() or _STRANGE.search(text):
        _refuse(text, None)
    if _MISREAD.search(text):
        _refuse(text, _MISREAD.sub(r"\1*m", text))
    try:
        found = registry().Quantity(1, registry().parse_units(text))
        plain = bool(found._is_multiplicative)
        dimensions = dict(found.dimensionality)
        scale = float(found.to_base_units().magnitude) if plain else math.nan
    except Exception:  # of a dozen kinds, assertions and attribute errors among them
        _refuse(text, _suggestion(text))
    if not plain:
        raise UnitError(
            f"Expected a unit in which twice the number is twice the quantity, got {text!r}, which has an offset or is a "
            "logarithm. Use K for temperatures, ratios for levels."
        )
    if not dimensions.keys() <= _PINT_NAMES.keys():
        raise UnitError(f"Expected a unit of {', '.join(BASES)}, got {text!r}, which is of {', '.join(dimensions)}.")
    exponents = [Fraction(0)] * len(BASES)
    for name, value in dimensions.items():
        exponents[_PINT_NAMES[name]] = Fraction(value).limit_denominator(_FINEST)
    try:
        return unit(tuple(exponents), scale)
    except OverflowError:
        _refuse(text, None)


def _refuse(text: str, suggestion: str | None) -> NoReturn:
    cure = f" Did you mean {suggestion!r}?" if suggestion else ""
    raise UnitError(
        f'Expected a unit such as "kg*m^2", "m/s^2", "rad" or "1", got {text!r:.80}.{cure} Leave the unit out ("") for a symbol that '
        "is not to be checked."
    ) from None


def _suggestion(text: str) -> str | None:
    """The text with each word that is no unit replaced by the nearest one."""

    def mended(word: re.Match[str]) -> str:
        return word[0] if _is_unit(word[0]) else _nearest(word[0])

    found = _WORD.sub(mended, text)
    return found if found != text and _readable(found) else None


def _nearest(word: str) -> str:
    stem = word.rstrip("0123456789")
    if stem != word and _is_unit(stem):
        return f"{stem}^{word[len(stem) :]}"
    for name in SYMBOLS:
        if name.lower() == word.lower():
            return name
    near = (
        _apart(word)
        or get_close_matches(word, SYMBOLS, 1)
        or get_close_matches(word, list(registry()._units), 1, _NEAR)
    )
    return near[0] if near else word


def _apart(word: str) -> list[str]:
    """A word that is two or three symbols of different dimensions written as one: Ns as N*s."""
    for i in range(1, len(word)):
        head, tail = word[:i], word[i:]
        rest = [tail] if tail in SYMBOLS else _apart(tail)
        if (
            head in SYMBOLS
            and rest
            and all(SYMBOLS[head].exponents != SYMBOLS[s].exponents for s in rest[0].split("*"))
        ):
            return [f"{head}*{rest[0]}"]
    return []


def _is_unit(word: str) -> bool:
    return word in SYMBOLS or _readable(word)


def _readable(text: str) -> bool:
    try:
        registry().parse_units(text)
    except Exception:
        return False
    return True
