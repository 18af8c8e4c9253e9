# SPDX-License-Identifier: BSD-3-Clause
"""The shortest of a few ways to write an expression: as it was built, collected, or multiplied out with common factors taken out.

Where an expression holds what is known by a name, the name stands for it; products and quotients share what they have in common.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from fractions import Fraction
from itertools import chain, combinations
from operator import itemgetter
from typing import NamedTuple

from kane.expr.build import div, mul, neg
from kane.expr.evaluation import Together, price
from kane.expr.forms.collect import collected, expanded, factored
from kane.expr.node import ONE, Expr, Number, constant, nodes, number_of, postorder
from kane.expr.ops import CONST, DIV, MUL, NEG
from kane.expr.visit import replaced_in


def named(roots: Sequence[Expr], given: Mapping[Expr, Expr], kept: Set[Expr] = frozenset()) -> tuple[Expr, ...]:
    """`roots` with the names of what is `given`, which is found as it is, or as factors of products; what is `kept` stays as it is."""
    known = [(_factors(e), e, name) for e, name in given.items() if e.args]
    together = Together.of(roots)
    if not known:
        return together
    replaced: dict[Expr, Expr] = {}
    held: dict[Expr, frozenset[Expr]] = {}  # by products, also of the products that they divide
    for node in together.order:
        if node.op is MUL or node.op is DIV:
            held[node] = frozenset().union(
                *[held.get(a) or (a,) for a in node.args[: 2 if node.op is MUL else 1]], (node,)
            )
        for factors, e, name in known:
            if node is e or (e.op is NEG and node is e.args[0]):
                replaced[node] = name if node is e else neg(name)
            elif node in held and len(factors) > 1 and held[node].issuperset(factors):
                rest = _without(node, factors, kept)
                if rest is not None:
                    replaced[node] = mul(rest, neg(name) if e.op is NEG else name)
    return replaced_in(together, replaced, kept, together.order)


def _factors(e: Expr) -> list[Expr]:
    """What a product without divisors is the product of, its sign apart; the whole where it is none."""
    result, waiting = [], [e.args[0] if e.op is NEG else e]
    while waiting:
        x = waiting.pop()
        if x.op is MUL:
            waiting += x.args
        else:
            result.append(x)
    return result


def _without(e: Expr, factors: Sequence[Expr], kept: Set[Expr]) -> Expr | None:
    """What is left of a product, in its order, without some factors; None where it has not all of them."""
    left = list(factors)

    def rest(x: Expr) -> Expr:
        place = next((k for k, f in enumerate(left) if f is x), None)
        if place is not None:
            del left[place]
            return ONE
        if x in kept:
            return x
        if x.op is MUL:
            return mul(*map(rest, x.args))
        return div(rest(x.args[0]), x.args[1]) if x.op is DIV else x

    found = rest(e)
    return None if left else found


_MOST = 60
"""Products up to which what each two have in common is looked at."""

Powers = dict[Expr, int]
"""Factors with their powers, below zero for divisors."""


class _Product(NamedTuple):
    """number · Π factors, how many these are, and how many operations are made for it alone."""

    number: Number
    powers: Powers
    degree: int
    own: int


def shared(roots: Sequence[Expr], kept: Set[Expr] = frozenset(), known: "Products | None" = None) -> tuple[Expr, ...]:
    """`roots` with products, `kept` ones apart, made of others, or of what several have in common, where that is less."""
    best, found = Together.of(roots), True
    search = known or Products(kept)
    while found:
        products = search.within(best, best.order)
        found = False
        for replaced in search.together(products):
            trial = Together(replaced_in(best, _settled(replaced, kept), kept, best.order))
            if trial.price < best.price:
                best, found = trial, True
                break
    return best


def _settled(replaced: dict[Expr, Expr], kept: Set[Expr]) -> dict[Expr, Expr]:
    """The same, with no expression that is replaced left in what comes in the places of others, unless these hold each other."""
    settled = replaced
    for _ in replaced:
        own = tuple(settled.values())
        if nodes(own, kept).isdisjoint(replaced):
            return settled
        settled = dict(zip(replaced, replaced_in(own, replaced, kept), strict=True))
    return replaced


_Replacement = tuple[int, tuple[Expr, ...], dict[Expr, Expr]]
"""Operations that are saved, products that have to stay, and what comes in the places of which."""


class Products:
    """What products are products of, and what they have in common: found once for each, `kept` ones apart."""

    def __init__(self, kept: Set[Expr]) -> None:
        self.kept = kept
        self._factors: dict[Expr, tuple[Number, Powers, int]] = {}
        self._common: dict[tuple[Expr, Expr], tuple[Powers, int, frozenset[tuple[Expr, int]]]] = {}

    def within(self, roots: Sequence[Expr], order: Sequence[Expr]) -> dict[Expr, _Product]:
        """The products in `roots` that are used by something else than one product; `order` holds all nodes below."""
        products = [node for node in order if node.op is MUL or node.op is DIV]
        uses = Counter(chain.from_iterable([node.args for node in products]))
        elsewhere = set(roots).union(*[node.args for node in order if node.op is not MUL and node.op is not DIV])
        own: dict[Expr, int] = {}
        parts = set[Expr]()  # of one product
        for node in products:
            if node not in self.kept:
                own[node] = 1 + sum([own[a] for a in node.args if a in parts])
                if uses.get(node) == 1 and node not in elsewhere:
                    parts.add(node)
                if node not in self._factors:
                    self._factors[node] = self._product(node)
        return {node: _Product(*self._factors[node], n) for node, n in own.items() if node not in parts}

    def _product(self, node: Expr) -> tuple[Number, Powers, int]:
        number: Number = 1
        powers: Powers = {}
        for a, sign in zip(node.args, (1, 1 if node.op is MUL else -1), strict=True):
            if a in self._factors:
                inner, below, _ = self._factors[a]
                number = _times(number, inner, sign)
                if not powers and sign > 0:
                    powers = below.copy()
                    continue
                for f, k in below.items():
                    powers[f] = powers.get(f, 0) + sign * k
            elif a.op is CONST and isinstance(number_of(a), int | Fraction):
                number = _times(number, number_of(a), sign)
            else:
                powers[a] = powers.get(a, 0) + sign
        if not all(powers.values()):
            powers = {f: k for f, k in powers.items() if k}
        return number, powers, sum(map(abs, powers.values()))

    def together(self, products: dict[Expr, _Product]) -> Iterator[dict[Expr, Expr]]:
        """Replacements that do not meet, all at once and then the best alone: by other products, by what several have in common."""
        for found in (_by_others, self._by_common):
            replacements = found(products)
            chosen: dict[Expr, Expr] = {}
            used: set[Expr] = set()
            for _, needed, replaced in replacements:
                if used.isdisjoint(replaced) and chosen.keys().isdisjoint(needed):
                    chosen |= replaced
                    used |= {*replaced, *needed}
            if chosen:
                yield chosen
                if len(chosen) > len(replacements[0][2]):
                    yield replacements[0][2]

    def _by_common(self, products: dict[Expr, _Product]) -> list[_Replacement]:
        """Products made of what several of them have in common, what saves most first."""
        if len(products) > _MOST:
            return []
        by_factor: dict[Expr, list[Expr]] = {}
        for node, product in products.items():
            for f in product.powers:
                by_factor.setdefault(f, []).append(node)
        found: list[_Replacement] = []
        seen: set[frozenset[tuple[Expr, int]]] = set()
        for pair in combinations([node for node, product in products.items() if product.own > 1], 2):
            known = self._common.get(pair)
            if known is None:
                common = _common(products[pair[0]].powers, products[pair[1]].powers)
                degree = sum(map(abs, common.values())) if common else 0
                known = self._common[pair] = common, degree, frozenset(common.items() if degree > 1 else ())
            common, degree, key = known
            if degree > 1 and key not in seen:
                seen.add(key)
                part = _Product(1, common, degree, 0)
                few = min([by_factor[f] for f in common], key=len)
                gains = {n: _gain(products[n], part) for n in few if _holds(products[n].powers, common)}
                saved = sum([gain for gain in gains.values() if gain > 0]) - (degree - 1)
                if saved > 0:
                    whole = _of(ONE, common)
                    made = {n: _made(products[n], whole, part) for n, gain in gains.items() if gain > 0}
                    found.append((saved, (), made))
        return sorted(found, key=lambda r: -r[0])


def _times(a: Number, b: Number, sign: int) -> Number:
    if type(b) is int and b == 1:
        return a
    if type(a) is int and a == 1 and sign > 0:
        return b
    return a * b if sign > 0 else Fraction(a) / Fraction(b)


def _by_others(products: dict[Expr, _Product]) -> list[_Replacement]:
    """Products made of another one, what saves most first; of two that are alike but for their numbers the later one by the other."""
    by_factor: dict[Expr, list[tuple[int, Expr, _Product]]] = {}
    for place, (node, product) in enumerate(products.items()):
        if product.powers:
            by_factor.setdefault(next(iter(product.powers)), []).append((place, node, product))
    found: list[tuple[tuple[int, bool], _Replacement]] = []
    for place, (node, product) in enumerate(products.items()):
        least = product.degree - product.own
        for f in product.powers if product.own > 1 else ():
            for other_place, other, part in by_factor.get(f, ()):
                if part.degree > least and other is not node and _holds(product.powers, part.powers):
                    gain = _gain(product, part)
                    if gain > 0:
                        late = other_place > place and part.degree == product.degree and part.number != product.number
                        found.append(((-gain, late), (gain, (other,), {node: _made(product, other, part)})))
    return [replacement for _, replacement in sorted(found, key=itemgetter(0))]


def _gain(product: _Product, part: _Product) -> int:
    """How many operations fewer the product takes by another one that it holds."""
    alike = product.number is part.number or abs(product.number) == abs(part.number)
    return product.own - (product.degree - part.degree) - (not alike)


def _made(product: _Product, other: Expr, part: _Product) -> Expr:
    """The product by another one."""
    number = _times(product.number, part.number, -1)
    return mul(constant(number), _of(other, {f: k - part.powers.get(f, 0) for f, k in product.powers.items()}))


def _holds(powers: Powers, part: Powers) -> bool:
    for f, k in part.items():
        n = powers.get(f, 0)
        if not (0 < k <= n or 0 > k >= n):
            return False
    return True


def _common(a: Powers, b: Powers) -> Powers:
    if a.keys().isdisjoint(b):
        return {}
    result = {}
    for f, k in a.items():
        if f in b and k * (n := b[f]) > 0:
            result[f] = min(k, n) if k > 0 else max(k, n)
    return result


def _of(first: Expr, powers: Powers) -> Expr:
    """`first` times factors, over divisors."""
    for f, k in powers.items():
        for _ in range(k):
            first = mul(first, f)
    for f, k in powers.items():
        for _ in range(-k):
            first = div(first, f)
    return first


_LONG = 300
"""Nodes above which expressions that are read are left as they were built."""
_QUOTIENT = 24
"""Nodes up to which a quotient that is computed is looked at."""


def shortened(*ways: Sequence[Expr]) -> tuple[Expr, ...]:
    """Of each expression, given in one or more ways, the shortest; all as they come first where that is shorter together."""
    first = tuple(ways[0])
    if len(postorder(x for way in ways for x in way)) > _LONG:
        return min(map(tuple, ways), key=price)
    best = tuple(min(_forms(same), key=lambda e: price([e])) for same in zip(*ways, strict=True))
    return min((first, best), key=price)


def _forms(same: Iterable[Expr]) -> list[Expr]:
    result: list[Expr] = []
    for e in same:
        terms = expanded(e)
        result += [e, collected(e)] if terms is None else [e, collected(e), factored(terms)]
    return result


def with_short_quotients(exprs: Sequence[Expr], beside: Sequence[Expr]) -> tuple[Expr, ...]:
    """`exprs` with short quotients in their shortest form, where all, and what stands `beside` them, then take fewer operations.

    I Ω u/(R² (m + I/R²)) is I Ω u/(m R² + I).
    """
    unsigned = (e.args[0] if e.op is NEG else e for e in exprs)
    short = {e: min(_forms([e]), key=lambda form: price([form])) for e in unsigned if _is_short_quotient(e)}
    short = {e: form for e, form in short.items() if form is not e}
    if not short:
        return tuple(exprs)
    best, least = tuple(exprs), price((*beside, *exprs))
    inner = {e: form for e, form in short.items() if not any(x is not e and x in short for x in postorder([e]))}
    for replaced in (inner, *({e: form} for e, form in short.items())):  # what they share decides: together, then each
        trial = replaced_in(best, replaced)
        cost = price((*beside, *trial))
        # what takes as many together is decided by what each takes by itself, as it reads
        if cost < least or (cost == least and sum(map(price, zip(trial))) < sum(map(price, zip(best)))):
            best, least = trial, cost
    return best


def _is_short_quotient(e: Expr) -> bool:
    seen: set[Expr] = set()
    waiting = [e]
    while waiting:
        node = waiting.pop()
        if node not in seen:
            seen.add(node)
            if len(seen) > _QUOTIENT:
                return False
            waiting += node.args
    return any(node.op is DIV for node in seen)
