# SPDX-License-Identifier: BSD-3-Clause
"""Units read from texts: products and quotients of powers of the names in the table, with prefixes, plurals and brackets."""

import re
from difflib import get_close_matches
from fractions import Fraction
from functools import cache, lru_cache
from typing import NoReturn

from kane.errors import UnitError, cut
from kane.units.algebra import (
    BASES,
    FOREIGN,
    ONE,
    PLAIN,
    PREFIXED,
    PREFIXES,
    SHIFTED,
    Unit,
    power,
    product,
    quotient,
    unit,
)

_NAME = r"°[A-Za-z]*|%|[^\W\d_]\w*"
_WORD = re.compile(_NAME)
_FACTOR = re.compile(rf"( *[*·⋅](?!\*) *| */ *| +per +| +|^)({_NAME}|1(?!\d)|\()")
_EXPONENT = re.compile(r" *(?:\^|\*\*) *(?:(-?\d+(?:\.\d+)?)|\( *(-?\d+(?:\.\d+)?(?: */ *\d+)?) *\))")
_RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹μΩ", "-0123456789µΩ")
_FINEST = 10_000
_NEAR = 0.8
_PLURAL = 3
"""Letters that a name needs to take a plural: 2 newtons, but Ns is no unit."""

_BASES = tuple(BASES)
_ROWS = {name: row for rows in (PREFIXED, PLAIN) for row in rows for name in row[0].split()}
_TAKES_PREFIX = {name for names, *_ in PREFIXED for name in names.split()}
USUAL = [p + s for s in ("g", "m", "s", "A", "N", "J", "W", "Pa", "Hz", "V") for p in ("", "m", "k", "M")]
USUAL += ["1", "rad", "deg", "cm", "t", "min", "h", "rpm", "K"]
"""Symbols that are proposed in place of what is no unit."""


@lru_cache(4096)
def parse(text: str) -> Unit:
    """The unit that "kg*m^2" or "m/s^2" means; a UnitError for what means none, or one that models cannot be written in (degC, dB)."""
    meant = _read(text)
    if meant is None:
        _refuse(text)
    return meant


def _read(text: str) -> Unit | None:
    """The unit of a text, None where it is none, or one whose scale is no number."""
    try:
        return _product(re.sub("[⁻⁰¹²³⁴-⁹]+", r"^\g<0>", text).translate(_RAISED).strip(" "))
    except (OverflowError, ZeroDivisionError, RecursionError):
        return None


def _product(text: str) -> Unit | None:
    whole, at = ONE, 0
    while at < len(text):
        factor = _FACTOR.match(text, at)
        if factor is None:
            return None
        at = factor.end()
        if factor[2] == "(":
            close = _closing(text, at)
            base = _product(text[at:close].strip(" ")) if close else None
            at = close + 1
        else:
            base = symbol(factor[2])
        if base is None:
            return None
        exponent = _EXPONENT.match(text, at)
        if exponent is not None:
            base = power(base, Fraction((exponent[1] or exponent[2]).replace(" ", "")).limit_denominator(_FINEST))
            at = exponent.end()
        inverse = "/" in factor[1] or "per" in factor[1]
        whole = quotient(whole, base) if inverse else product(whole, base)
    return whole if text else None


def _closing(text: str, at: int) -> int:
    """Where the bracket closes that is open at `at`; 0 where it does not."""
    depth = 1
    for i in range(at, len(text)):
        depth += (text[i] == "(") - (text[i] == ")")
        if not depth:
            return i
    return 0


@cache
def symbol(word: str) -> Unit | None:
    """The unit of one name, with a prefix or in the plural; None for what is no unit."""
    if word in BASES:
        return unit(tuple(int(word == base) for base in _BASES))
    if word in _ROWS:
        _, scale, of = _ROWS[word]
        base = parse(of) if of else ONE
        return unit(base.exponents, scale * base.scale)
    for i in range(1, len(word)):
        whole = symbol(word[i:]) if word[:i] in PREFIXES and _singular(word[i:]) in _TAKES_PREFIX else None
        if whole is not None:
            return unit(whole.exponents, float(f"1e{PREFIXES[word[:i]]}") * whole.scale)
    return symbol(word[:-1]) if _singular(word) != word else None


def _singular(word: str) -> str:
    return (
        word[:-1] if word not in _ROWS and word.endswith("s") and len(word) > _PLURAL and word[:-1] in _ROWS else word
    )


# What is no unit -----------------------------------------------------------------------------------------------------------


def _refuse(text: str) -> NoReturn:
    words = _WORD.findall(text)
    if not SHIFTED.isdisjoint(words):
        raise UnitError(
            f"Expected a unit in which twice the number is twice the quantity, got {text!r}, which has an offset or is a "
            "logarithm. Use K for temperatures, ratios for levels."
        )
    others = [FOREIGN[w] for w in words if w in FOREIGN]
    if others:
        raise UnitError(f"Expected a unit of {', '.join(BASES.values())}, got {text!r}, which is of [{others[0]}].")
    mended = _WORD.sub(lambda word: word[0] if symbol(word[0]) else _nearest(word[0]), text)
    cure = f" Did you mean {mended!r}?" if mended != text and _read(mended) is not None else ""
    raise UnitError(
        f'Expected a unit such as "kg*m^2", "m/s^2", "rad" or "1", got {cut(repr(text), 80)}.{cure} Leave the unit out '
        '("") for a symbol that '
        "is not to be checked."
    )


def _nearest(word: str) -> str:
    stem = word.rstrip("0123456789")
    if stem != word and symbol(stem):
        return f"{stem}^{word[len(stem) :]}"
    for name in USUAL:
        if name.lower() == word.lower():
            return name
    near = _apart(word) or get_close_matches(word, USUAL, 1) or get_close_matches(word, _ROWS, 1, _NEAR)
    return near[0] if near else word


def _apart(word: str) -> list[str]:
    """A word that is two or three symbols of different dimensions written as one: Ns as N*s."""
    for i in range(1, len(word)):
        head, tail = word[:i], word[i:]
        rest = [tail] if tail in USUAL else _apart(tail) if head in USUAL else []
        if head in USUAL and rest and all(_exponents(head) != _exponents(s) for s in rest[0].split("*")):
            return [f"{head}*{rest[0]}"]
    return []


def _exponents(word: str) -> object:
    meant = symbol(word)
    return meant and meant.exponents
