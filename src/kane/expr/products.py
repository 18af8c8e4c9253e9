# SPDX-License-Identifier: BSD-3-Clause
"""Products and quotients share what they have in common.

u₂/c,  u₁ u₂/(c c)  →  w = u₂/c,  w u₁/c;      c u₁ u₁,  s u₁ u₁  →  v = u₁ u₁,  c v,  s v
"""

from collections.abc import Collection, Iterator, Sequence
from fractions import Fraction
from itertools import combinations
from typing import NamedTuple

from kane.expr.build import div, mul
from kane.expr.count import price
from kane.expr.node import ONE, Expr, Number, constant, postorder
from kane.expr.ops import CONST, DIV, MUL
from kane.expr.patterns import number_of
from kane.expr.visit import substitute

_MOST = 60
"""Products up to which what each two have in common is looked at."""

Powers = dict[Expr, int]
"""Factors with their powers, below zero for divisors."""


class _Product(NamedTuple):
    """number · Π factors, and how many operations are made for it alone."""

    number: Number
    powers: Powers
    own: int


def shared(roots: Sequence[Expr], kept: Collection[Expr] = ()) -> tuple[Expr, ...]:
    """`roots` with products, `kept` ones apart, made of others, or of what several have in common, where that is less."""
    best, least, done = tuple(roots), price(roots), False
    same = {e: e for e in kept}
    while not done:
        done = True
        for replaced in _replacements(_products(best, same)):
            memo: dict[Expr, Expr] = {}
            found = tuple(substitute(r, replaced | same, memo) for r in best)
            cost = price(found)
            if cost < least:
                best, least, done = found, cost, False
                break
    return best


def _products(roots: Sequence[Expr], kept: Collection[Expr]) -> dict[Expr, _Product]:
    """The products in `roots` that are used by something else than one product, and what they are products of."""
    uses: dict[Expr, int] = dict.fromkeys(roots, 2)
    order = postorder(roots)
    for node in order:
        for a in node.args:
            uses[a] = uses.get(a, 0) + (1 if node.op is MUL or node.op is DIV else 2)
    found: dict[Expr, _Product] = {}
    for node in order:
        if (node.op is MUL or node.op is DIV) and node not in kept:
            found[node] = _product(node, found, uses)
    return {node: product for node, product in found.items() if uses[node] > 1}


def _product(node: Expr, found: dict[Expr, _Product], uses: dict[Expr, int]) -> _Product:
    number: Number = 1
    powers: Powers = {}
    own = 1
    for a, sign in zip(node.args, (1, 1 if node.op is MUL else -1), strict=True):
        inner = found.get(a)
        if inner is not None:
            number = _times(number, inner.number, sign)
            own += inner.own if uses[a] == 1 else 0
            for f, k in inner.powers.items():
                powers[f] = powers.get(f, 0) + sign * k
        elif a.op is CONST and isinstance(number_of(a), int | Fraction):
            number = _times(number, number_of(a), sign)
        else:
            powers[a] = powers.get(a, 0) + sign
    return _Product(number, {f: k for f, k in powers.items() if k}, own)


def _times(a: Number, b: Number, sign: int) -> Number:
    return a * b if sign > 0 else Fraction(a) / Fraction(b)


def _replacements(products: dict[Expr, _Product]) -> Iterator[dict[Expr, Expr]]:
    """Products by what takes fewer operations in their places: of another one, or of what two have in common."""
    by_factor: dict[Expr, list[Expr]] = {}
    for node, product in products.items():
        if product.powers:
            by_factor.setdefault(next(iter(product.powers)), []).append(node)
    for node, product in products.items():
        for f in product.powers if product.own > 1 else ():
            for other in by_factor.get(f, ()):
                part = products[other]
                if other is not node and _holds(product.powers, part.powers) and _gain(product, part) > 0:
                    yield {node: _made(product, other, part)}
    if len(products) > _MOST:
        return
    seen: set[frozenset[tuple[Expr, int]]] = set()
    for one, two in combinations(products.values(), 2):
        common = _common(one.powers, two.powers)
        key = frozenset(common.items())
        degree = sum(map(abs, common.values()))
        if degree > 1 and key not in seen:
            seen.add(key)
            part = _Product(1, common, 0)
            gains = {n: _gain(p, part) for n, p in products.items() if _holds(p.powers, common)}
            if sum(gain for gain in gains.values() if gain > 0) >= degree:
                whole = _of(ONE, common)
                yield {n: _made(products[n], whole, part) for n, gain in gains.items() if gain > 0}


def _gain(product: _Product, part: _Product) -> int:
    """How many operations fewer the product takes by another one."""
    rest = sum(abs(k - part.powers.get(f, 0)) for f, k in product.powers.items())
    return product.own - rest - (abs(product.number) != abs(part.number))


def _made(product: _Product, other: Expr, part: _Product) -> Expr:
    """The product by another one."""
    number = _times(product.number, part.number, -1)
    return mul(constant(number), _of(other, {f: k - part.powers.get(f, 0) for f, k in product.powers.items()}))


def _holds(powers: Powers, part: Powers) -> bool:
    return all(0 < k <= powers.get(f, 0) or 0 > k >= powers.get(f, 0) for f, k in part.items())


def _common(a: Powers, b: Powers) -> Powers:
    found = {}
    for f, k in a.items():
        n = b.get(f, 0)
        if k * n > 0:
            found[f] = min(k, n) if k > 0 else max(k, n)
    return found


def _of(first: Expr, powers: Powers) -> Expr:
    """`first` times factors, over divisors."""
    for f, k in powers.items():
        for _ in range(k):
            first = mul(first, f)
    for f, k in powers.items():
        for _ in range(-k):
            first = div(first, f)
    return first
