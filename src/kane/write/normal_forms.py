# SPDX-License-Identifier: BSD-3-Clause
"""Signed trees put together: products with collected powers, sums with like terms merged, in natural order."""

from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from math import gcd, lcm
from typing import TypeVar

from kane.expr.node import Expr, Number, digest
from kane.expr.ops import CONST
from kane.expr.surd import Surd, times
from kane.expr.symbols import Symbol
from kane.write.display import (
    LAST,
    Call,
    Minus,
    Name,
    NumberTree,
    Power,
    Product,
    Rank,
    Signed,
    Sum,
    Tokens,
    Tree,
    joined,
    natural,
    raised,
    symbol_tokens,
)

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
    if isinstance(tree, NumberTree):
        return tree.value
    return tree.coefficient if isinstance(tree, Product) else 1


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
