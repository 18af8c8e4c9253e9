# SPDX-License-Identifier: BSD-3-Clause
"""Several sums a x + b y of the same x and y, with numbers a and b, made of each other.

x − y,  2 x − y,  3 x/2 − y/4  →  s = x − y,  t = s + x,  x + t/4
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from itertools import combinations
from typing import NamedTuple

from kane.expr.build import add, mul, sub
from kane.expr.constants import number_of
from kane.expr.forms.count import price
from kane.expr.node import ZERO, Expr, Number, constant, postorder
from kane.expr.ops import ADD, CONST, MUL, NEG, SUB
from kane.expr.visit import fold, imaged, substituted

_MOST = 8
"""Sums of the same terms up to which they are compared."""

Pair = tuple[Number, Number]
"""a and b."""


class _Way(NamedTuple):
    """α p + β q, its operations first."""

    cost: int
    alpha: Fraction
    beta: Fraction
    p: Expr
    q: Expr

    def made(self) -> Expr:
        """The expression."""
        if abs(self.alpha) == abs(self.beta):
            return mul(constant(self.alpha), (add if self.alpha == self.beta else sub)(self.p, self.q))
        return add(mul(constant(self.alpha), self.p), mul(constant(self.beta), self.q))


def combined(roots: Sequence[Expr], kept: Collection[Expr] = ()) -> tuple[Expr, ...]:
    """`roots` with their sums of two terms made of each other, `kept` ones apart, where all together take fewer operations."""
    replaced: dict[Expr, Expr] = {}
    for (x, y), sums in _alike(roots).items():
        if 1 < len(sums) <= _MOST:
            replaced |= _chain(x, y, sums)
    if not replaced:
        return tuple(roots)
    memo: dict[Expr, Expr] = {}
    whole = replaced | {e: e for e in kept}
    found = tuple(substituted(r, whole, memo) for r in roots)
    return found if price(found) < price(roots) else tuple(roots)


def joined(e: Expr) -> Expr:
    """`e` as it reads by itself: like terms in sums of sums joined, where it gets no longer: 3 x/2 − y/4 for x + (2 x − y)/4."""
    images: dict[Expr, Expr] = {}

    def image(node: Expr) -> Expr:
        own = imaged(node, images)
        if own.op is not ADD and own.op is not SUB:
            return own
        found = list(_terms(own))
        terms = _summed(found)
        return reduce(add, (mul(constant(a), x) for x, a in terms.items()), ZERO) if len(terms) < len(found) else own

    made = fold(e, images, image)
    return made if price([made]) <= price([e]) else e


def _summed(found: Iterable[tuple[Expr, Number]]) -> dict[Expr, Number]:
    """The terms with the sums of their numbers."""
    terms: dict[Expr, Number] = {}
    for x, a in found:
        terms[x] = terms.get(x, 0) + a
    return terms


def _alike(roots: Sequence[Expr]) -> dict[tuple[Expr, Expr], dict[Pair, Expr]]:
    """Sums by their two terms, with rational numbers."""
    found: dict[tuple[Expr, Expr], dict[Pair, Expr]] = {}
    for node in postorder(roots):
        if node.op is ADD or node.op is SUB:
            terms = _summed(_terms(node))
            if len(terms) == 2 and all(isinstance(a, int | Fraction) and a for a in terms.values()):
                x, y = sorted(terms, key=lambda e: e.key)
                found.setdefault((x, y), {})[terms[x], terms[y]] = node
    return found


def _terms(e: Expr) -> Iterator[tuple[Expr, Number]]:
    """Terms with their numbers, of sums of sums, too."""
    waiting: list[tuple[Expr, Number]] = [(e, 1)]
    while waiting:
        x, a = waiting.pop()
        if x.op is ADD or x.op is SUB:
            waiting += [(x.args[0], a), (x.args[1], a if x.op is ADD else -a)]
        elif x.op is NEG:
            waiting.append((x.args[0], -a))
        elif x.op is MUL and x.args[0].op is CONST and isinstance(number_of(x.args[0]), int | Fraction):
            waiting.append((x.args[1], a * number_of(x.args[0])))
        else:
            yield x, a


def _chain(x: Expr, y: Expr, sums: Mapping[Pair, Expr]) -> dict[Expr, Expr]:
    """Each sum by terms or sums that come before it, the one that takes least first."""
    known: dict[Pair, Expr] = {(1, 0): x, (0, 1): y}
    left, replaced = dict(sums), {}
    while left:
        ways = {pair: min(_ways(pair, known), key=lambda way: way.cost) for pair in left}
        pair = min(ways, key=lambda own: ways[own].cost)
        node = left.pop(pair)
        known[pair] = ways[pair].made()
        if known[pair] is not node:
            replaced[node] = known[pair]
    return replaced


def _ways(wanted: Pair, known: Mapping[Pair, Expr]) -> Iterator[_Way]:
    (a, b) = wanted
    for ((c, d), p), ((e, f), q) in combinations(known.items(), 2):
        determinant = Fraction(c * f - d * e)
        if determinant:
            alpha, beta = Fraction(a * f - b * e) / determinant, Fraction(c * b - d * a) / determinant
            if not alpha or not beta:
                cost = 1
            elif abs(alpha) == abs(beta):
                cost = 1 + (abs(alpha) != 1)
            else:
                cost = 1 + (abs(alpha) != 1) + (abs(beta) != 1)
            yield _Way(cost, alpha, beta, p, q)
