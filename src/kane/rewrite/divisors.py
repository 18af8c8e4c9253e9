# SPDX-License-Identifier: BSD-3-Clause
"""Greedy extraction of common divisors from sums of products, with a heap ordered by gain.

There are three kinds of divisors (the kernels and cubes of fast_extract; Rajski and Vasudevamurthi 1992, *IEEE Trans. CAD* 11(6),
p. 778, extended by signs, constants and tiers): a factor of several terms of a sum, a pair of terms in several sums or with several
factors, and a pair of factors of several products.
"""

import heapq
from abc import ABC, abstractmethod
from collections.abc import Hashable, Iterable
from typing import Any, ClassVar

from kane.rewrite.graph import ONE, Cube, Graph, Price, common, over

MOST = 32
"""Terms of a sum, and literals of a cube, up to which pairs are looked at."""
_TWICE = 2
"""How often one divisor is taken out: what goes back into its only reader would be found again and again."""
_SEVERAL = 2


class DivisorKind(ABC):
    """A kind of divisor: `places` are its occurrences, `lone` the occurrence of one found once; `rank` orders equal gains.

    A place is a term or a pair of terms. Places are entered with new terms, and those of removed terms are dropped when next read.
    `fresh` are the divisors with new places, `often` counts how often each was extracted.
    """

    rank: ClassVar[int]

    def __init__(self, graph: Graph, price: Price) -> None:
        self.graph, self.price = graph, price
        self.places: dict[Any, list[Any]] = {}
        self.lone: dict[Any, Any] = {}
        self.fresh: dict[Any, None] = {}
        self.often: dict[Any, int] = {}

    @abstractmethod
    def shown(self, t: int, lone: dict[int, int], often: set[int]) -> Iterable[tuple[Hashable, Any]]:
        """The divisors in a new term, with places, of literals that occur in other terms too; `lone` counts the other literals."""

    @abstractmethod
    def further(self, t: int, x: int, lone: dict[int, int], often: set[int]) -> Iterable[tuple[Hashable, Any]]:
        """The further divisors in term t once its literal x occurs in another term."""

    def stands(self, place: Any) -> bool:
        """Whether the terms of a place still exist."""
        owner: int = self.graph.owner[place]
        return owner >= 0

    def standing(self, key: Any) -> bool:
        """Whether a divisor still has several places; drops the others."""
        owner = self.graph.owner
        held = self.places[key] = [t for t in self.places[key] if owner[t] >= 0]
        return len(held) >= _SEVERAL

    @abstractmethod
    def gain(self, key: Any) -> int:
        """The decrease of the price by extracting a divisor from all its places."""

    @abstractmethod
    def taken(self, key: Any) -> list[int]:
        """Extracts a divisor; the sums that changed."""

    def _made(self, terms: list[tuple[int, Cube]], places: list[tuple[list[int], Cube, int]]) -> list[int]:
        """Makes the sum of `terms` and puts its product with a cube in each of `places`, for the terms of one sum."""
        g = self.graph
        d, sign = g.sum(terms)
        changed = [x >> 1 for _, cube in terms for x in cube if g.terms[x >> 1] is not None]
        changed.append(d)
        for held, base, s in places:
            owner = g.owner[held[0]]
            if owner < 0 or owner == d or any(g.owner[t] != owner for t in held):
                continue
            for t in held:
                g.drop(t)
            g.add(owner, s * sign, g.times(base, (2 * d,)))
            changed.append(owner)
        return changed


class Factor(DivisorKind):
    """A literal in several terms of one sum; their common cube is factored out."""

    rank = 0

    def shown(self, t: int, lone: dict[int, int], often: set[int]) -> Iterable[tuple[Hashable, Any]]:  # noqa: D102
        v = self.graph.owner[t]
        return [((v, x), t) for x in dict.fromkeys(self.graph.cube[t]) if x in often]

    def further(self, t: int, x: int, lone: dict[int, int], often: set[int]) -> Iterable[tuple[Hashable, Any]]:  # noqa: D102
        return [((self.graph.owner[t], x), t)]

    def gain(self, key: Any) -> int:  # noqa: D102
        price, cube = self.price, self.graph.cube
        cubes = [cube[t] for t in self.places[key]]
        base = common(cubes)
        rest = [over(c, base) for c in cubes]
        before = price.sum(cubes)
        varies = any(price.varies(c) for c in rest)
        return before - price.sum(rest) - price.with_factor(base, varies)

    def taken(self, key: Any) -> list[int]:  # noqa: D102
        g = self.graph
        held = self.places[key]
        base = common([g.cube[t] for t in held])
        return self._made([(g.sign[t], over(g.cube[t], base)) for t in held], [(held, base, 1)])


class Pair(DivisorKind):
    """Two terms without their common cube, in several sums or with several factors."""

    rank = 1

    def shown(self, t: int, lone: dict[int, int], often: set[int]) -> Iterable[tuple[Hashable, Any]]:  # noqa: D102
        g = self.graph
        own = g.terms[g.owner[t]]
        assert own is not None
        if len(own) > MOST or lone[t]:
            return []
        cubes, signs = g.cube, g.sign
        a, s = cubes[t], signs[t]
        apart = frozenset(a).isdisjoint
        result = []
        for u in own.values():
            if u != t and lone.get(u) == 0:
                b = cubes[u]
                rest, other = (a, b) if apart(b) else _without_common(a, b)
                if rest < other:
                    result.append(((rest, other, s * signs[u]), (t, u)))
                else:
                    result.append(((other, rest, s * signs[u]), (u, t)))
        return result

    def further(self, t: int, x: int, lone: dict[int, int], often: set[int]) -> Iterable[tuple[Hashable, Any]]:  # noqa: D102
        return self.shown(t, lone, often)

    def stands(self, place: Any) -> bool:  # noqa: D102
        return super().stands(place[0]) and super().stands(place[1])

    def standing(self, key: Any) -> bool:  # noqa: D102
        owner = self.graph.owner
        held = self.places[key] = [p for p in self.places[key] if owner[p[0]] >= 0 and owner[p[1]] >= 0]
        return len(held) >= _SEVERAL

    def gain(self, key: Any) -> int:  # noqa: D102
        g, price = self.graph, self.price
        first, second, _ = key
        varies = price.varies(first) or price.varies(second)
        total = -price.sum([first, second])
        for t, u in self.places[key]:
            a = g.cube[t]
            total += price.sum([a, g.cube[u]]) - price.with_factor(over(a, first), varies)
        return total

    def taken(self, key: Any) -> list[int]:  # noqa: D102
        g = self.graph
        first, second, sign = key
        used = set[int]()
        places = []
        for t, u in self.places[key]:
            if t in used or u in used:
                continue
            used |= {t, u}
            places.append(([t, u], over(g.cube[t], first), g.sign[t]))
        return self._made([(1, first), (sign, second)], places)


class CubePair(DivisorKind):
    """Two literals in several products."""

    rank = 2

    def shown(self, t: int, lone: dict[int, int], often: set[int]) -> Iterable[tuple[Hashable, Any]]:  # noqa: D102
        cube = [x for x in self.graph.cube[t] if x in often]
        n = len(cube)
        if n < 2 or n > MOST:
            return []
        found = dict.fromkeys([(cube[i], cube[j]) for j in range(1, n) for i in range(j)])
        return [(pair, t) for pair in found]

    def further(self, t: int, x: int, lone: dict[int, int], often: set[int]) -> Iterable[tuple[Hashable, Any]]:  # noqa: D102
        cube = self.graph.cube[t]
        if len(cube) > MOST:
            return []
        others = dict.fromkeys([y for y in cube if y in often and (y != x or cube.count(x) > 1)])
        return [((x, y) if x < y else (y, x), t) for y in others]

    def gain(self, key: Any) -> int:  # noqa: D102
        varies = self.graph.varies
        weight = self.price.operation(varies[key[0] >> 1] or varies[key[1] >> 1])
        return (len(self.places[key]) - 1) * weight

    def taken(self, key: Any) -> list[int]:  # noqa: D102
        g = self.graph
        d, _ = g.sum([(1, key)])
        changed = [d]
        for t in self.places[key]:
            v, cube = g.owner[t], g.cube[t]
            if v < 0 or v == d:
                continue
            n = 0
            while _holds(cube, key):
                cube = over(cube, key)
                n += 1
            sign = g.sign[t]
            g.drop(t)
            g.add(v, sign, g.times(cube, (2 * d,) * n))
            changed.append(v)
        return changed


DIVISORS: tuple[type[DivisorKind], ...] = (Factor, Pair, CubePair)


class DivisorSearch:
    """The search over all kinds of divisors, with gains updated as terms are added and removed."""

    def __init__(self, graph: Graph, price: Price, rows: Iterable[type[DivisorKind]] = DIVISORS) -> None:
        self.graph = graph
        self.rows = [row(graph, price) for row in rows]
        self._lone: dict[int, int] = {}
        self._first: dict[int, int] = {}
        self._often = set[int]()
        self._heap: list[tuple[int, int, int, DivisorKind, Any]] = []
        self._turn = 0
        for v in range(len(graph.terms)):
            for t in graph.of(v):
                self.enter(t)
        graph.listener = self.enter

    def enter(self, t: int) -> None:
        """Adds a term with its divisors."""
        often, first, lone, owner = self._often, self._first, self._lone, self.graph.owner
        alone = 0
        for x in dict.fromkeys(self.graph.cube[t]):
            if x in often:
                continue
            u = first.setdefault(x, t)
            if u == t:
                alone += 1
                continue
            often.add(x)
            lone[u] -= 1
            if owner[u] >= 0:
                for row in self.rows:
                    if found := row.further(u, x, lone, often):
                        self._put(row, found)
        lone[t] = alone
        for row in self.rows:
            if found := row.shown(t, lone, often):
                self._put(row, found)

    def _put(self, row: DivisorKind, shown: Iterable[tuple[Hashable, Any]]) -> None:
        fresh, places, lone = row.fresh, row.places, row.lone
        for key, place in shown:
            held = places.get(key)
            if held is not None:
                held.append(place)
                fresh[key] = None
            elif (other := lone.setdefault(key, place)) is not place:
                if row.stands(other):
                    places[key] = [other, place]
                    del lone[key]
                    fresh[key] = None
                else:
                    lone[key] = place

    def run(self) -> int:
        """Extracts divisors while one has a gain; the total gain."""
        total = 0
        while found := self._best():
            row, key, gain = found
            row.often[key] = row.often.get(key, 0) + 1
            changed = row.taken(key)
            self.graph.settle(dict.fromkeys(changed))
            total += gain
        return total

    def _best(self) -> tuple[DivisorKind, Any, int] | None:
        """The divisor with the largest gain, with it; None if none has a gain."""
        for row in self.rows:
            for key in row.fresh:
                self._push(row, key)
            row.fresh.clear()
        heap = self._heap
        while heap:
            gain, _, _, row, key = heapq.heappop(heap)
            if row.often.get(key, 0) >= _TWICE or not row.standing(key):
                continue
            now = row.gain(key)
            if now == -gain:
                return row, key, now
            self._push(row, key, now)
        return None

    def _push(self, row: DivisorKind, key: Any, gain: int | None = None) -> None:
        if gain is None:
            if not row.standing(key):
                return
            gain = row.gain(key)
        if gain > 0:
            self._turn += 1
            heapq.heappush(self._heap, (-gain, row.rank, self._turn, row, key))


def _holds(cube: Cube, part: Cube) -> bool:
    """Whether a cube contains all literals of another one."""
    if len(part) == 1:
        return part[0] in cube
    left = list(cube)
    for x in part:
        if x not in left:
            return False
        left.remove(x)
    return True


def _without_common(a: Cube, b: Cube) -> tuple[Cube, Cube]:
    """Two cubes without their common literals."""
    left = list(b)
    rest = []
    for x in a:
        if x in left:
            left.remove(x)
        else:
            rest.append(x)
    return tuple(rest) or ONE, tuple(left) or ONE
