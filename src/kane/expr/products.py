# SPDX-License-Identifier: BSD-3-Clause
"""Products and quotients share what they have in common.

u₂/c,  u₁ u₂/(c c)  →  w = u₂/c,  w u₁/c;      c u₁ u₁,  s u₁ u₁  →  v = u₁ u₁,  c v,  s v
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import combinations
from typing import NamedTuple

from kane.expr.build import div, mul
from kane.expr.constants import number_of
from kane.expr.count import price
from kane.expr.node import ONE, Expr, Number, constant, postorder
from kane.expr.ops import CONST, DIV, MUL
from kane.expr.visit import substituted

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
    best, least, found = tuple(roots), price(roots), True
    same = {e: e for e in kept}
    while found:
        products = _products(best, same)
        found = False
        for replaced in _together(products):
            memo: dict[Expr, Expr] = {}
            trial = tuple(substituted(r, replaced | same, memo) for r in best)
            cost = price(trial)
            if cost < least:
                best, least, found = trial, cost, True
                break
    return best


def _products(roots: Sequence[Expr], kept: Mapping[Expr, Expr]) -> dict[Expr, _Product]:
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


def _together(products: dict[Expr, _Product]) -> Iterator[dict[Expr, Expr]]:
    """Replacements that do not meet, all at once and then the best alone: by other products, by what several have in common."""
    for replacements in (_by_others(products), _by_common(products)):
        chosen: dict[Expr, Expr] = {}
        used: set[Expr] = set()
        for _, needed, replaced in replacements:
            if used.isdisjoint(replaced) and chosen.keys().isdisjoint(needed):
                chosen |= replaced
                used |= {*replaced, *needed}
        if chosen:
            yield chosen
            yield replacements[0][2]


_Replacement = tuple[int, tuple[Expr, ...], dict[Expr, Expr]]
"""Operations that are saved, products that have to stay, and what comes in the places of which."""


def _by_others(products: dict[Expr, _Product]) -> list[_Replacement]:
    """Products made of another one, what saves most first."""
    by_factor: dict[Expr, list[Expr]] = {}
    for node, product in products.items():
        if product.powers:
            by_factor.setdefault(next(iter(product.powers)), []).append(node)
    found: list[_Replacement] = []
    for node, product in products.items():
        for f in product.powers if product.own > 1 else ():
            for other in by_factor.get(f, ()):
                part = products[other]
                if other is not node and _holds(product.powers, part.powers) and (gain := _gain(product, part)) > 0:
                    found.append((gain, (other,), {node: _made(product, other, part)}))
    return sorted(found, key=lambda r: -r[0])


def _by_common(products: dict[Expr, _Product]) -> list[_Replacement]:
    """Products made of what several of them have in common, what saves most first."""
    if len(products) > _MOST:
        return []
    by_factor: dict[Expr, list[Expr]] = {}
    for node, product in products.items():
        for f in product.powers:
            by_factor.setdefault(f, []).append(node)
    found: list[_Replacement] = []
    seen: set[frozenset[tuple[Expr, int]]] = set()
    for one, two in combinations([p for p in products.values() if p.own > 1], 2):
        common = _common(one.powers, two.powers)
        degree = sum(map(abs, common.values()))
        key = frozenset(common.items())
        if degree > 1 and key not in seen:
            seen.add(key)
            part = _Product(1, common, 0)
            few = min((by_factor[f] for f in common), key=len)
            gains = {n: _gain(products[n], part) for n in few if _holds(products[n].powers, common)}
            saved = sum(gain for gain in gains.values() if gain > 0) - (degree - 1)
            if saved > 0:
                whole = _of(ONE, common)
                found.append((saved, (), {n: _made(products[n], whole, part) for n, gain in gains.items() if gain > 0}))
    return sorted(found, key=lambda r: -r[0])


def _gain(product: _Product, part: _Product) -> int:
    """How many operations fewer the product takes by another one."""
    rest = sum(abs(k - part.powers.get(f, 0)) for f, k in product.powers.items())
    return product.own - rest - (abs(product.number) != abs(part.number))


def _made(product: _Product, other: Expr, part: _Product) -> Expr:
    """The product by another one."""
    number = _times(product.number, part.number, -1)
    return mul(constant(number), _of(other, {f: k - part.powers.get(f, 0) for f, k in product.powers.items()}))


def _holds(powers: Powers, part: Powers) -> bool:
    return part.keys() <= powers.keys() and all(0 < k <= powers[f] or 0 > k >= powers[f] for f, k in part.items())


def _common(a: Powers, b: Powers) -> Powers:
    found = {}
    for f, k in a.items():
        if f in b and k * (n := b[f]) > 0:
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
