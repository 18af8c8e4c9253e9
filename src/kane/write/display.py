# SPDX-License-Identifier: BSD-3-Clause
"""What is printed: sums, products, powers and calls, and the order in which people write them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from fractions import Fraction
from typing import TypeAlias

from kane.expr.node import Number
from kane.expr.surd import Surd
from kane.expr.symbols import (
    AuxiliarySpeed,
    Coordinate,
    Input,
    Parameter,
    QuasiRate,
    Rate,
    Reaction,
    Speed,
    StateVariable,
    Symbol,
    Time,
)

Token: TypeAlias = tuple[int, tuple[str | int, ...], int]
Tokens: TypeAlias = tuple[Token, ...]


@dataclass(frozen=True, slots=True, eq=False)
class NumberTree:
    """A number that is not negative."""

    value: Number
    tokens: Tokens


@dataclass(frozen=True, slots=True, eq=False)
class Name:
    """A symbol, π, or (without a symbol) a named intermediate."""

    text: str
    symbol: Symbol | None
    tokens: Tokens


@dataclass(frozen=True, slots=True, eq=False)
class Minus:
    """−body."""

    body: Tree
    tokens: Tokens


@dataclass(frozen=True, slots=True, eq=False)
class Sum:
    """Terms with their signs: True is minus. The first one stood at the place `moved` in the natural order."""

    terms: tuple[tuple[bool, Tree], ...]
    moved: int
    tokens: Tokens

    @classmethod
    def of(cls, ordered: Sequence[tuple[bool, Tree]], tokens: Tokens) -> Sum:
        """The sum of terms in natural order: the first positive one is written first."""
        moved = next((i for i, (minus, _) in enumerate(ordered) if not minus), 0)
        return cls((ordered[moved], *ordered[:moved], *ordered[moved + 1 :]), moved, tokens)

    def flipped(self) -> Sum:
        """The sum with all signs changed."""
        first, *others = [(not minus, tree) for minus, tree in self.terms]
        others.insert(self.moved, first)
        return Sum.of(others, self.tokens)

    @property
    def leads_with_minus(self) -> bool:
        """Whether -sum reads better: by the sign of its number (1 - cos q), else of the first in natural order."""
        minus, last = self.terms[-1 if self.moved < len(self.terms) - 1 else 0]
        return minus if isinstance(last, NumberTree) else self.terms[1 if self.moved else 0][0]


@dataclass(frozen=True, slots=True, eq=False)
class Product:
    """coefficient · Π above / Π below; factors with positive exponents, the coefficient positive."""

    coefficient: Number
    above: tuple[tuple[Tree, int], ...]
    below: tuple[tuple[Tree, int], ...]
    tokens: Tokens


@dataclass(frozen=True, slots=True, eq=False)
class Power:
    """base to an exponent that is not a whole number."""

    base: Tree
    exponent: Tree
    tokens: Tokens


@dataclass(frozen=True, slots=True, eq=False)
class Call:
    """A function of its arguments; `less` is the comparison a < b."""

    name: str
    args: tuple[Tree, ...]
    tokens: Tokens


Tree: TypeAlias = "NumberTree | Name | Minus | Sum | Product | Power | Call"
Signed: TypeAlias = tuple[bool, Tree]


# The order in which people write -----------------------------------------------------------------------

_WIDTH = 24
Rank = IntEnum("Rank", "CONSTANT PARAMETER PI COORDINATE SPEED Z SUM CALL COMPARISON END", start=0)
"""What comes first in products and sums."""
_KINDS: dict[type[Symbol], int] = {
    Coordinate: 0,
    Rate: 1,
    QuasiRate: 2,
    Speed: 3,
    AuxiliarySpeed: 4,
    Reaction: 6,
    Input: 7,
    StateVariable: 7,
    Time: 8,
}
LAST: Tokens = ((Rank.END, (), 0),)


def natural(name: str) -> tuple[str | int, ...]:
    """Sort key of a name: q2 before q10, capitals beside small letters.

    >>> sorted(["q10", "q2", "R", "g"], key=natural)
    ['g', 'q2', 'q10', 'R']
    """
    pieces = re.split(r"([0-9]+)", name)
    return (*(int(p) if i % 2 else p.lower() for i, p in enumerate(pieces)), -1, name)


def symbol_tokens(symbol: Symbol) -> Tokens:
    """Parameters as in μ m g R: numbers without a unit, masses, gravity, the others."""
    if isinstance(symbol, Parameter):
        stem = symbol.name.rstrip("0123456789")
        place = 3
        if symbol.unit == "1":
            place = 0
        elif symbol.unit == "kg" or (not symbol.unit and stem in ("m", "M")):
            place = 1
        elif symbol.name == "g":
            place = 2
        return ((Rank.PARAMETER, (str(place), 0, *natural(symbol.name)), -1),)
    kind = _KINDS.get(type(symbol), 9)
    if isinstance(symbol, Rate) and isinstance(symbol.place, Symbol) and not isinstance(symbol.place, Coordinate):
        kind = 5
    return ((Rank.SPEED if kind >= 2 else Rank.COORDINATE, (str(kind), 0, *natural(symbol.name)), -1),)


def raised(tokens: Tokens, exponent: int) -> Tokens:
    """Sort key of a power: higher ones first."""
    rank, name, _ = tokens[0]
    return ((rank, name, -exponent), *tokens[1:])


def joined(head: Token | None, parts: Iterable[Tokens]) -> Tokens:
    """Sort key of a compound, cut off where nobody reads that far."""
    tokens: list[Token] = [] if head is None else [head]
    for p in parts:
        tokens.extend(p)
        if len(tokens) >= _WIDTH:
            break
    return tuple(tokens[:_WIDTH])


def split_coefficient(value: Number) -> tuple[Number, int]:
    """A positive coefficient as what is written above and below the line."""
    if isinstance(value, Surd):
        return Surd(Fraction(value.ratio.numerator), value.radicand), value.ratio.denominator
    return (value.numerator, value.denominator) if isinstance(value, Fraction) else (value, 1)
