# SPDX-License-Identifier: BSD-3-Clause
"""What is printed: sums, products, powers and calls, and the order in which people write them.

Signed trees are put together: products with collected powers, sums with like terms merged, in natural order.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from fractions import Fraction
from functools import lru_cache
from math import gcd, lcm
from typing import TypeAlias, TypeVar

from kane.expr.node import Expr, Number, digest
from kane.expr.numbers import Surd, times
from kane.expr.ops import CONST
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


Item = TypeVar("Item")
Factors = tuple[tuple[Tree, int], ...]

_SMALL = 3
"""Exponents of sums up to which their numbers are looked at."""


def number_tree(value: Number) -> NumberTree:
    """A number that is not negative."""
    return NumberTree(_plain(value), ((Rank.CONSTANT, (), 0),))


def size_of(value: Number) -> Number:
    """|value|, exact."""
    return -value if value < 0 else value


def _raised(value: Number, exponent: int) -> Number:
    power: Number = (value if isinstance(value, Surd) else Fraction(value)) ** exponent
    return power


def _plain(value: Number) -> Number:
    return value.numerator if isinstance(value, Fraction) and value.denominator == 1 else value


def name_tree(text: str, symbol: Symbol | None = None) -> Name:
    """A symbol, or a named intermediate."""
    if symbol is not None:
        return Name(text, symbol, symbol_tokens(symbol))
    return Name(text, None, ((Rank.Z, natural(text), -1),))


PI_NAME = Name("pi", None, ((Rank.PI, ("pi",), -1),))


def unsigned(form: Signed) -> Tree:
    """The tree with its sign written out."""
    negative, tree = form
    return Minus(tree, tree.tokens) if negative else tree


_ODD = {"sin", "tan", "asin", "atan", "sinh", "tanh", "sign"}
_EVEN = {"cos", "cosh", "abs"}


def call(name: str, args: Sequence[Signed]) -> Signed:
    """A function; sin(q1 - q2), not -sin(q2 - q1), and arguments of min and max in natural order."""
    trees = [unsigned(a) for a in args]
    if name == "pow":
        base, exponent = trees
        return False, Power(base, exponent, joined((Rank.SUM, ("", 0, "^"), -1), (t.tokens for t in trees)))
    negative = False
    if name in ("min", "max"):
        trees.sort(key=lambda t: t.tokens)
    elif (name in _ODD or name in _EVEN) and isinstance(trees[0], Sum) and trees[0].leads_with_minus:
        trees[0] = trees[0].flipped()
        negative = name in _ODD
    rank = Rank.COMPARISON if name == "less" else Rank.CALL
    return negative, Call(name, tuple(trees), joined((rank, (name,), -1), (t.tokens for t in trees)))


def product_form(negative: bool, coefficient: Number, factors: Sequence[tuple[Signed, int, Expr]]) -> Signed:
    """Of a - b and b - a the same one is a factor whichever the graph holds."""
    if coefficient < 0:
        negative, coefficient = not negative, -coefficient
    shown_factors: list[tuple[Tree, int, Expr]] = []
    for (minus, tree), exponent, node in factors:
        shown = tree
        # A sum may have come out as a number.
        if isinstance(shown, NumberTree) and node.op is not CONST and (shown.value or exponent > 0):
            if not shown.value:
                return False, number_tree(0)
            coefficient = times(coefficient, _raised(shown.value, exponent))
            negative ^= minus and exponent % 2 == 1
            continue
        if isinstance(shown, Sum) and shown.leads_with_minus:
            shown, minus = shown.flipped(), not minus
        negative ^= minus and exponent % 2 == 1
        shown_factors.append((shown, exponent, node))
    ordered = _sorted([(raised(t.tokens, e), n, (t, e)) for t, e, n in shown_factors])
    above = tuple((t, e) for t, e in ordered if e > 0)
    below = tuple((t, -e) for t, e in ordered if e < 0)
    if not above and not below:
        return negative, number_tree(coefficient)
    if coefficient == 1 and not below and len(above) == 1 and above[0][1] == 1:
        return negative, above[0][0]
    tokens = joined(None, (raised(t.tokens, e) for t, e in ordered))
    return negative, _product(coefficient, above, below, tokens)


def _product(coefficient: Number, above: Factors, below: Factors, tokens: Tokens) -> Product:
    """What numbers of a sum share goes to the product's where fewer digits or fractions are left: (4*x - y)/5 for 4*(x - y/4)/5."""
    shown: list[Factors] = []
    for factors, sign in ((above, 1), (below, -1)):
        kept = []
        for tree, exponent in factors:
            if isinstance(tree, Sum) and isinstance(coefficient, int | Fraction) and exponent <= _SMALL:
                common, primitive = _primitive(tree)
                moved = coefficient * Fraction(common) ** (sign * exponent)
                alone = moved == 1 and len(above) + len(below) == 1  # would be a sum in a sum
                if common != 1 and not alone and _read(moved, primitive) < _read(coefficient, tree):
                    coefficient, tree = moved, primitive
            kept.append((tree, exponent))
        shown.append(tuple(kept))
    return Product(_plain(coefficient), shown[0], shown[1], tokens)


@lru_cache(maxsize=256)
def _primitive(tree: Sum) -> tuple[Fraction | int, Sum]:
    """The largest number whose multiples all numbers of a sum are, and the sum without it; 1 where one is no fraction."""
    sizes = [_coefficient(t) for _, t in tree.terms]
    if not all(isinstance(x, int | Fraction) for x in sizes):
        return 1, tree
    exact = [Fraction(x) for x in sizes]
    common = Fraction(gcd(*(x.numerator for x in exact)), lcm(*(x.denominator for x in exact)))
    if common in (0, 1):
        return 1, tree
    terms = tuple((minus, scaled(1 / common, (False, t))[1]) for minus, t in tree.terms)
    if any(isinstance(_bare(t), Sum) and _coefficient(t) == 1 for _, t in terms):
        return 1, tree  # would hold a sum in a sum
    return common, Sum(terms, tree.moved, tree.tokens)


def _coefficient(tree: Tree) -> Number:
    """The number of a term."""
    return tree.value if isinstance(tree, NumberTree) else tree.coefficient if isinstance(tree, Product) else 1


def _read(coefficient: Number, tree: Sum) -> tuple[int, int]:
    """How many digits are read in a number and in those of a sum's terms, and how many fractions there are beside no number alone."""
    terms = [t for _, t in tree.terms]
    bare = any(isinstance(t, NumberTree) for t in terms)
    found = [_digits(coefficient), *(_digits(_coefficient(t), alone=isinstance(t, NumberTree)) for t in terms)]
    return sum(n for n, _ in found), 0 if bare else sum(fraction for _, fraction in found)


def _digits(value: Number, alone: bool = False) -> tuple[int, bool]:
    """How many digits are read where this number is, none for 1 beside a factor, two for 3/4; and whether it is a fraction."""
    above, below = Fraction(value).as_integer_ratio()
    count = sum(len(str(x)) for x, shown in ((above, alone or above != 1), (below, below != 1)) if shown)
    return count, below != 1


def scaled(coefficient: Number, form: Signed) -> Signed:
    """The form times a number."""
    negative, tree = form
    if coefficient < 0:
        negative, coefficient = not negative, -coefficient
    if coefficient == 1:
        return negative, tree
    if isinstance(tree, Sum) and tree.leads_with_minus:
        negative, tree = not negative, tree.flipped()
    if isinstance(tree, NumberTree):
        return negative, number_tree(times(coefficient, tree.value))
    if isinstance(tree, Product):
        return negative, _product(times(coefficient, tree.coefficient), tree.above, tree.below, tree.tokens)
    return negative, _product(coefficient, ((tree, 1),), (), tree.tokens)


def _merged(constant: Number, terms: Sequence[tuple[Signed, Expr]]) -> tuple[Number, list[tuple[Signed, Expr]]]:
    """Terms alike once flattened become one: m*R^2*u/4 - m*R^2*u/2 reads -m*R^2*u/4."""
    groups: dict[object, list[tuple[Signed, Expr]]] = {}
    for (negative, tree), node in terms:
        if isinstance(tree, NumberTree):
            constant += -tree.value if negative else tree.value
            continue
        above, below = (tree.above, tree.below) if isinstance(tree, Product) else (((tree, 1),), ())
        alike = tuple((id(t), e) for t, e in above), tuple((id(t), e) for t, e in below)
        groups.setdefault(alike, []).append(((negative, tree), node))
    kept: list[tuple[Signed, Expr]] = []
    for group in groups.values():
        if len(group) == 1:
            kept += group
            continue
        total: Number = 0
        for (negative, tree), _ in group:
            total += -_coefficient(tree) if negative else _coefficient(tree)
        if total:
            (_, first), node = group[0]
            kept.append((scaled(total, (False, _bare(first))), node))
    return constant, kept


def _bare(tree: Tree) -> Tree:
    """The product without its coefficient."""
    if not isinstance(tree, Product):
        return tree
    if not tree.below and len(tree.above) == 1 and tree.above[0][1] == 1:
        return tree.above[0][0]
    return Product(1, tree.above, tree.below, tree.tokens)


def sum_form(constant: Number, terms: Sequence[tuple[Signed, Expr]]) -> Signed:
    """Terms in natural order, like ones merged, the constant last."""
    constant, terms = _merged(constant, terms)
    ordered = _sorted([((*t.tokens, *LAST), n, (s, t)) for (s, t), n in terms])
    if constant:
        ordered.append((constant < 0, number_tree(size_of(constant))))
    if not ordered:
        return False, number_tree(0)
    if len(ordered) == 1:
        return ordered[0]
    return False, Sum.of(ordered, joined((Rank.SUM, (), -1), (t.tokens for _, t in ordered)))


def _sorted(items: list[tuple[Tokens, Expr, Item]]) -> list[Item]:
    """By what is read; what reads alike (so far as compared), by structure."""
    alike = Counter((tokens, node.key) for tokens, node, _ in items)
    keyed = [
        ((tokens, node.key, digest(node) if alike[tokens, node.key] > 1 else b""), item) for tokens, node, item in items
    ]
    keyed.sort(key=lambda k: k[0])
    return [item for _, item in keyed]
