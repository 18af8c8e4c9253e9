# SPDX-License-Identifier: BSD-3-Clause
"""Sums of products of sines and cosines read by the sum of two angles: cos a cos b + sin a sin b as cos(a − b).

    n x cos a cos b ± n x sin a sin b = n x cos(a ∓ b),   n x sin a cos b ± n x cos a sin b = n x sin(a ± b)

Sums are also multiplied out for it, where less is left then.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from itertools import combinations

from kane.expr.build import NODE_BUILDERS, add, cos, sin, sub, sum_of
from kane.expr.evaluation import free_symbols, price
from kane.expr.forms.collect import Expansions, Powers, Term, expanded, factor_powers, factored, terms_of
from kane.expr.node import Expr, Number, digest, postorder
from kane.expr.ops import ADD, COS, NEG, SIN, SUB
from kane.expr.visit import fold, imaged

_SUMS = {ADD, SUB, NEG}
_LARGEST = 4000
"""Nodes beyond which nothing is looked for."""


def by_two_angles(roots: Sequence[Expr]) -> tuple[Expr, ...]:
    """`roots` with sines and cosines of sums of angles, where together they get shorter."""
    order = postorder(roots)
    if len(order) > _LARGEST or len({x.args[0] for x in order if x.op is SIN}) < 2:
        return tuple(roots)
    result, known = tuple(roots), Expansions()
    for read in (_as_they_stand, lambda e: _multiplied_out(e, known)):
        result = min((result, _rewritten(result, read)), key=price)
    return result


def _rewritten(roots: Sequence[Expr], read: Callable[[Expr], Expr]) -> tuple[Expr, ...]:
    images: dict[Expr, Expr] = {}
    order = postorder(roots)
    whole = {*roots, *(a for x in order if x.op not in _SUMS for a in x.args)}  # a sum in a sum is read with it

    def image(node: Expr) -> Expr:
        own = imaged(node, images)
        return read(own) if node in whole and own.op in _SUMS else own

    return tuple([fold(e, images, image) for e in roots])


def _as_they_stand(e: Expr) -> Expr:
    """The sum with the pairs among its terms."""
    terms = terms_of(e)
    if terms is None:
        return e
    paired = _paired(terms)
    return e if paired is None else sum_of(factored([term]) for term in paired)


def _multiplied_out(e: Expr, known: Expansions) -> Expr:
    """The sum with the pairs among the terms that there are when it is multiplied out, where that is shorter."""
    terms = expanded(e, known)
    paired = None if terms is None else _paired(terms)
    if paired is None:
        return e
    plain = sum_of(factored([term]) for term in paired)
    return min((e, plain, factored(paired)), key=lambda x: price([x]))


# Pairs ---------------------------------------------------------------------------------------------------------------


def _paired(terms: Sequence[Term]) -> list[Term] | None:
    """The terms with two made one as often as that can be; None where it cannot."""
    found, changed = list(terms), False
    while (pair := _pair(found)) is not None:
        i, j, term = pair
        found = [*found[:i], term, *found[i + 1 : j], *found[j + 1 :]]
        changed = True
    return found if changed else None


def _pair(terms: Sequence[Term]) -> tuple[int, int, Term] | None:
    """The first two terms that are one, their places and what they are together."""
    seen: dict[tuple[Powers, frozenset[Expr]], int] = {}
    for j, (n, powers) in enumerate(terms):
        for rest, two in _functions(powers):
            i = seen.get((rest, frozenset(map(_other, two))))
            if i is not None and abs(terms[i][0]) == abs(n):
                return i, j, _joined(n, n == terms[i][0], rest, two)
            seen[rest, frozenset(two)] = j
    return None


def _functions(powers: Powers) -> Iterator[tuple[Powers, tuple[Expr, Expr]]]:
    """What is left of a product without two sines or cosines of different angles, and these."""
    own = [f for f, k in powers if k > 0 and (f.op is SIN or f.op is COS)]
    for f, g in combinations(own, 2):
        if f.args[0] is not g.args[0]:
            left = ((x, k - (x is f or x is g)) for x, k in powers)
            yield tuple([(x, k) for x, k in left if k]), (f, g)


def _other(f: Expr) -> Expr:
    """The cosine of a sine's angle, the sine of a cosine's."""
    return NODE_BUILDERS["cos" if f.op is SIN else "sin"](f.args[0])


def _joined(n: Number, alike: bool, rest: Powers, two: tuple[Expr, Expr]) -> Term:
    """n · rest · two and the like of the others, with the same number or the opposite one, as one term."""
    f, g = sorted(two, key=lambda x: _by_names(x.args[0]))
    a, b = f.args[0], g.args[0]
    if f.op is g.op:
        whole, opposite = cos(sub(a, b) if alike else add(a, b)), f.op is SIN and not alike
    else:
        whole, opposite = sin(add(a, b) if alike else sub(a, b)), f.op is COS and not alike
    powers = dict(rest)
    powers[whole] = powers.get(whole, 0) + 1
    return -n if opposite else n, factor_powers(powers)


def _by_names(angle: Expr) -> tuple[list[list[int | str]], bytes]:
    """q2 before q10."""
    names = (re.split(r"([0-9]+)", s.name) for s in free_symbols([angle]))
    return sorted([int(p) if i % 2 else p for i, p in enumerate(parts)] for parts in names), digest(angle)
