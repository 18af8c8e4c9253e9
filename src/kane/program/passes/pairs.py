# SPDX-License-Identifier: BSD-3-Clause
"""Pairs of terms in several sums, and of factors in several products, are computed once, the most frequent first."""

import heapq
from collections import Counter

from kane.expr.ops import ADD, MUL, Op
from kane.program.passes.nary import Flat

Pair = tuple[int, int]


def paired(flat: Flat) -> None:
    """Share pairs among the products and among the sums, in place."""
    for kind in (MUL, ADD):
        _share(flat, _Holders(flat, kind), kind)


class _Holders:
    """Which nodes of a kind hold which pairs: `of` gives the nodes by pair, of the parts that are there more than once."""

    def __init__(self, flat: Flat, kind: Op) -> None:
        self.parts = flat.parts
        nodes = [v for v, k in enumerate(flat.kinds) if k is kind and flat.uses[v]]
        seen = Counter([p >> 1 for v in nodes for p in self.parts[v]])
        self.often = {x for x, n in seen.items() if n > 1}
        self.of: dict[Pair, dict[int, None]] = {}
        for v in nodes:
            self.enter(v)

    def pairs(self, v: int) -> list[Pair]:
        """The pairs of a node."""
        often = self.often
        shared = [p for p in self.parts[v] if p >> 1 in often]
        return [_pair(x, y) for i, x in enumerate(shared) for y in shared[:i]] if len(shared) > 1 else []

    def enter(self, v: int) -> None:
        """Enter a node with its pairs."""
        for pair in self.pairs(v):
            self.of.setdefault(pair, {})[v] = None

    def leave(self, v: int) -> None:
        """Take a node out, before its parts change."""
        for pair in self.pairs(v):
            self.of[pair].pop(v, None)


def _share(flat: Flat, holders: _Holders, kind: Op) -> None:
    """Make a node of the most frequent pair, again and again; of equally frequent ones the one that was met first."""
    heap = [(-len(own), k, pair) for k, (pair, own) in enumerate(holders.of.items()) if len(own) > 1]
    heapq.heapify(heap)
    turn = len(holders.of)
    while heap:
        count, k, pair = heapq.heappop(heap)
        held = list(holders.of[pair])
        if len(held) != -count:
            if len(held) > 1:
                heapq.heappush(heap, (-len(held), k, pair))
            continue
        x, y = pair
        z = flat.add(kind, [x, y], flat.varies[x >> 1] or flat.varies[y >> 1], len(held))
        holders.often.add(z)
        for part in pair:
            flat.uses[part >> 1] -= len(held) - 1
        for v in held:
            holders.leave(v)
            _replace(flat.parts[v], x, y, 2 * z)
            holders.enter(v)
        fresh = dict.fromkeys(new for v in held for new in holders.pairs(v) if 2 * z in (new[0] & ~1, new[1] & ~1))
        for new in fresh:
            if len(holders.of[new]) > 1:
                turn += 1
                heapq.heappush(heap, (-len(holders.of[new]), turn, new))


def _pair(x: int, y: int) -> Pair:
    """The two parts in order, the first one positive."""
    if x > y:
        x, y = y, x
    return (x & ~1, y ^ (x & 1))


def _replace(parts: list[int], x: int, y: int, z: int) -> None:
    """Put z in the place of x and y, or −z in that of −x and −y."""
    if x not in parts or parts.count(y) == (x == y):
        x, y, z = x ^ 1, y ^ 1, z ^ 1
    place = min(parts.index(x), parts.index(y))
    parts.remove(x)
    parts.remove(y)
    parts.insert(place, z)
