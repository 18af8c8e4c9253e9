# SPDX-License-Identifier: BSD-3-Clause
"""Sums whose terms share factors: a b + a c becomes a (b + c), the factor of the most terms first."""

import heapq

from kane.expr.ops import ADD, MUL
from kane.program.passes.nary import MOST, Flat

Brackets = dict[tuple[tuple[int, ...], ...], int]
"""Sums in brackets by their parts, each with its own: what stands in two of them becomes a factor that terms share.

A product that a factor is taken out of keeps its number, so that numbers alone would find the sum from which it was taken."""


def factored(flat: Flat) -> None:
    """Factor every sum, in place.

    A term that something else reads too stays: its product is needed anyway. What is left in brackets is a sum again.
    """
    brackets: Brackets = {}
    waiting = [v for v, kind in enumerate(flat.kinds) if kind is ADD]
    while waiting:
        v = waiting.pop()
        if flat.uses[v]:  # else its terms stand in another sum by now
            _factor(flat, v, waiting, brackets)


def _factor(flat: Flat, v: int, waiting: list[int], brackets: Brackets) -> None:
    """Factor one sum; new sums in brackets come to `waiting`."""
    kinds, parts, uses, varies = flat.kinds, flat.parts, flat.uses, flat.varies
    terms = dict(enumerate(parts[v]))
    holders: dict[int, dict[int, None]] = {}
    for k, term in terms.items():
        t = term >> 1
        if kinds[t] is MUL and uses[t] == 1 and varies[t] is varies[v]:
            for f in parts[t]:
                holders.setdefault(f, {})[k] = None
    heap = [(-len(own), -f) for f, own in holders.items() if len(own) > 1]
    heapq.heapify(heap)
    while heap:
        count, f = heapq.heappop(heap)
        own = holders[-f]
        if len(own) != -count:
            if len(own) > 1:
                heapq.heappush(heap, (-len(own), f))
            continue
        held = sorted(own)
        before = {g: k for k in held for g in parts[terms[k] >> 1]}
        for g in before:
            for k in held:
                holders[g].pop(k, None)
        product = _taken_out(flat, [terms.pop(k) for k in held], waiting, brackets)
        terms[held[0]] = 2 * product
        for g in parts[product]:
            more = holders.setdefault(g, {})
            more[held[0]] = None
            if len(more) > 1:
                heapq.heappush(heap, (-len(more), -g))
    if len(terms) == 1:
        # the sum is that product: its number stays, since others know it
        only = terms[0] >> 1
        kinds[v], parts[v] = MUL, list(parts[only])
        uses[only] = 0
    elif len(terms) < len(parts[v]):
        parts[v] = [terms[k] for k in sorted(terms)]


def _taken_out(flat: Flat, terms: list[int], waiting: list[int], brackets: Brackets) -> int:
    """The product of the factors that all terms share and the sum of what is left of them."""
    parts, uses = flat.parts, flat.uses
    common = _common([parts[term >> 1] for term in terms])
    for f in common:
        uses[f >> 1] -= len(terms) - 1
    bracket: list[int] = []
    for term in terms:
        t, sign = term >> 1, term & 1
        left = list(parts[t])
        for f in common:
            left.remove(f)
        if len(left) > 1:
            parts[t] = left
            flat.varies[t] = any(flat.varies[f >> 1] for f in left)
            bracket.append(term)
            continue
        uses[t] = 0
        inner = left[0] >> 1
        if flat.kinds[inner] is ADD and uses[inner] == 1 and len(bracket) + len(parts[inner]) <= MOST:
            bracket += [p ^ sign for p in parts[inner]]
            uses[inner] = 0
        else:
            bracket.append(left[0] ^ sign)
    key = tuple(sorted((p, *(parts[p >> 1] if flat.kinds[p >> 1] is MUL else ())) for p in bracket))
    known = brackets.get(key)
    if known is None or not uses[known]:
        varies = any(flat.varies[p >> 1] for p in bracket)
        known = brackets[key] = flat.add(ADD, bracket, varies, 1)
        waiting.append(known)
    else:
        uses[known] += 1
        for p in bracket:
            uses[p >> 1] -= 1
    factors = [*common, 2 * known]
    return flat.add(MUL, factors, any(flat.varies[f >> 1] for f in factors), 1)


def _common(products: list[list[int]]) -> list[int]:
    """The factors that all products share, one less where else nothing were left of one."""
    common = list(products[0])
    for factors in products[1:]:
        left, kept = list(factors), []
        for f in common:
            if f in left:
                left.remove(f)
                kept.append(f)
        common = kept
    return common[: min(map(len, products)) - 1]
