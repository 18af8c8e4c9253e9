# SPDX-License-Identifier: BSD-3-Clause
"""Pairs of terms in several sums, and of factors in several products, are computed once, the most frequent first."""

import heapq

from kane.expr.ops import ADD, MUL, Op
from kane.program.passes.nary import Flat

Pair = tuple[int, int]


def paired(flat: Flat) -> None:
    """Share pairs among the sums and among the products, in place."""
    for kind in (MUL, ADD):
        _share(flat, kind)


def _share(flat: Flat, kind: Op) -> None:
    kinds, parts = flat.kinds, flat.parts
    seen: dict[int, int] = {}
    nodes = [v for v, k in enumerate(kinds) if k is kind and flat.uses[v]]
    for v in nodes:
        for x in {p >> 1 for p in parts[v]}:
            seen[x] = seen.get(x, 0) + 1
    holders: dict[Pair, dict[int, None]] = {}
    for v in nodes:
        shared = [p for p in parts[v] if seen[p >> 1] > 1]
        for i, x in enumerate(shared):
            for y in shared[:i]:
                holders.setdefault(_pair(x, y), {})[v] = None
    heap = [(-len(own), k, pair) for k, (pair, own) in enumerate(holders.items()) if len(own) > 1]
    heapq.heapify(heap)
    turn = len(holders)
    while heap:
        count, k, pair = heapq.heappop(heap)
        own = holders[pair]
        if len(own) != -count:
            if len(own) > 1:
                heapq.heappush(heap, (-len(own), k, pair))
            continue
        held = list(own)
        varies = flat.varies[pair[0] >> 1] or flat.varies[pair[1] >> 1]
        z = flat.add(kind, list(pair), varies, len(held))
        flat.uses[pair[0] >> 1] -= len(held) - 1
        flat.uses[pair[1] >> 1] -= len(held) - 1
        fresh: dict[Pair, None] = {}
        for v in held:
            _replace(flat, holders, seen, v, pair, z, fresh)
        for new in fresh:
            if len(holders[new]) > 1:
                turn += 1
                heapq.heappush(heap, (-len(holders[new]), turn, new))


def _pair(x: int, y: int) -> Pair:
    """The two parts in order, the first one positive."""
    if x > y:
        x, y = y, x
    return (x & ~1, y ^ (x & 1))


def _replace(
    flat: Flat,
    holders: dict[Pair, dict[int, None]],
    seen: dict[int, int],
    v: int,
    pair: Pair,
    z: int,
    fresh: dict[Pair, None],
) -> None:
    """Put z in the place of the pair in v, and count the pairs of v anew."""
    own = flat.parts[v]
    x, y = pair
    sign = 0 if x in own and own.count(y) > (x == y) else 1
    x, y = x ^ sign, y ^ sign
    place = min(own.index(x), own.index(y))
    shared = [p for p in own if seen[p >> 1] > 1]
    for i, p in enumerate(shared):
        for r in shared[:i]:
            holders[_pair(p, r)].pop(v, None)
    own.remove(x)
    own.remove(y)
    own.insert(place, 2 * z + sign)
    seen[z] = seen.get(z, 0) + 1
    if seen[z] == 1:
        seen[z] = 2
    shared = [p for p in own if seen[p >> 1] > 1]
    for i, p in enumerate(shared):
        for r in shared[:i]:
            q = _pair(p, r)
            holders.setdefault(q, {})[v] = None
            if p >> 1 == z or r >> 1 == z:
                fresh[q] = None
