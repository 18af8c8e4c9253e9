# SPDX-License-Identifier: BSD-3-Clause
"""The normal form of a graph, and rewriting rules for one node and its readers, each applied only if it lowers the price.

In normal form products are inlined in all their readers, and the common cube of a sum's terms is factored out. The sharing that is
lost is recovered by the search for divisors, which also finds expressions that were written in different forms.
"""

from collections.abc import Callable, Iterable

from kane.expr.ops import OPS
from kane.rewrite.graph import ONE, Coefficients, Cube, Graph, Price, common, over

MOST = 32
"""Readers of a literal up to which sums that resemble each other are looked for among them."""

_FEW = 2
"""Terms that two sums have in common from which on one is looked for in the other."""
_SIN, _COS = OPS["sin"], OPS["cos"]
Terms = dict[Cube, float]
"""Terms of a sum by their cubes without constants."""


def content(g: Graph, price: Price, v: int) -> int:
    """Distributes c of c x, with parameters c, over the products that read it, where it is computed with their other parameters."""
    if not g.is_product(v) or not g.varies[v] or g.calls[v] or g.is_result(v):
        return 0
    t = g.only(v)
    c, rest = _split(g, g.cube[t])
    if not c or len(rest) < 1:
        return 0
    gain = price.product(g.cube[t]) - price.product(rest)
    shared: dict[Cube, None] = {}
    news = []
    for r in g.readers[v]:
        cube = g.cube[r]
        other = tuple([x for x in cube if x >> 1 != v])
        whole = [x for x in cube if x >> 1 == v]
        own = other
        for x in whole:
            own = g.times(own, _power(c, x))
            own = g.times(own, _power(rest, x) if len(rest) == 1 else (x,))
        both = _split(g, own)[0]
        gain += price.product(cube) - price.product(own)
        if both in shared:
            gain += price.product(both)
        shared[both] = None
        news.append((r, own))
    if gain <= 0:
        return 0
    sign = g.sign[t]
    changed = [v]
    for r, own in news:
        owner, s = g.owner[r], g.sign[r]
        n = sum([x >> 1 == v for x in g.cube[r]])
        g.drop(r)
        g.add(owner, s * (sign if len(rest) == 1 and n & 1 else 1), own)
        changed.append(owner)
    if g.is_read(v):
        g.drop(t)
        g.add(v, sign, rest)
    g.settle(dict.fromkeys(changed))
    return gain


def squares(g: Graph, price: Price, v: int) -> int:
    """x sin² + x cos² → x, x − x sin² → x cos² and x − x cos² → x sin²."""
    own = g.terms[v]
    if own is None or len(own) < 2 or not any(len(set(cube)) < len(cube) for cube in own):
        return 0
    mine = _terms(g, v)
    changes: list[Terms] = []
    for cube in mine:
        for x in dict.fromkeys(cube):
            twin = _twin(g, x) if cube.count(x) > 1 else None
            if twin is not None:
                base = over(cube, (x, x))
                other = tuple(sorted([*base, twin, twin]))
                shares = (mine[cube], -mine.get(base, 0.0), mine.get(other, 0.0))
                changes += [{cube: -k, other: -k, base: k} for k in dict.fromkeys(shares) if k]
    return _changed(g, price, v, mine, changes)


def resum(g: Graph, price: Price, v: int) -> int:
    """Writes a sum as a multiple of another sum and a few more terms."""
    own = g.terms[v]
    if own is None or len(own) < 2:
        return 0
    near: dict[int, int] = {}
    place, owner, terms, rest = g.place, g.owner, g.terms, g.rest
    before = place.get(v, 0)
    for cube in own:
        readers = min([g.readers[x >> 1] for x in cube], key=len) if cube else {}
        if len(readers) > MOST:
            continue
        for r in readers:
            if rest[r] == cube:
                w = owner[r]
                if place.get(w, before) < before and len(terms[w] or ()) > 1:
                    near[w] = near.get(w, 0) + 1
    found: list[tuple[int, int, Terms]] = []
    near = {w: n for w, n in near.items() if n >= _FEW}
    mine = _terms(g, v) if near else {}
    for w in near:
        other = _terms(g, w)
        for ratio in dict.fromkeys([mine[c] / other[c] for c in mine if c in other]):
            gone = [c for c, k in other.items() if c in mine and mine[c] == ratio * k]
            likely = sum([price.product(c) + price.operation(price.varies(c)) for c in gone])
            likely -= sum([price.product(c) + price.operation(price.varies(c)) for c in other if c not in mine])
            likely += sum([price.operation(price.varies(c)) for c in other if abs(mine.get(c, 1.0)) != 1.0])
            if likely > price.operation(g.varies[w]):
                found.append((-likely, len(found), {c: -ratio * k for c, k in other.items()} | {(2 * w,): ratio}))
    for _, _, change in sorted(found):
        if gain := _changed(g, price, v, mine, [change]):
            return gain
    return 0


NodeRow = Callable[[Graph, Price, int], int]
"""It gives what is gained at a sum."""
ROWS: tuple[NodeRow, ...] = (squares, content, resum)


def sweep(g: Graph, price: Price, rows: Iterable[NodeRow] = ROWS) -> int:
    """Applies each rule once to each sum changed since the last sweep; the number of changes that lowered the price."""
    order = g.order()
    g.place = {v: i for i, v in enumerate(order)}
    changed, g.changed = g.changed, {}
    gained = 0
    for v in order:
        if v in changed:
            for row in rows:
                if g.terms[v] is not None and g.is_read(v):
                    gained += row(g, price, v) > 0
    return gained


def _changed(g: Graph, price: Price, v: int, mine: Terms, changes: list[Terms]) -> int:
    """Applies the best of some changes to the coefficients of a sum, if it lowers the price; the gain."""
    best, cost = None, price.sum([g.cube[t] for t in g.of(v)])
    gain = 0
    for change in changes:
        left = Coefficients(g)
        for cube, k in (*mine.items(), *change.items()):
            left.add(cube, k)
        terms = left.terms()
        if terms and cost - price.sum([c for _, c in terms]) > gain:
            best, gain = terms, cost - price.sum([c for _, c in terms])
    if best is None:
        return 0
    for t in g.of(v):
        g.drop(t)
    for sign, cube in best:
        g.add(v, sign, cube)
    g.settle([v])
    return gain


def _terms(g: Graph, v: int) -> Terms:
    result: Terms = {}
    for t in g.of(v):
        result[g.rest[t]] = g.sign[t] * g.factor[t]
    return result


def _split(g: Graph, cube: Cube) -> tuple[Cube, Cube]:
    """Splits a cube into parameters and the rest."""
    varies = g.varies
    return tuple([x for x in cube if not varies[x >> 1]]), tuple([x for x in cube if varies[x >> 1]])


def _power(cube: Cube, literal: int) -> Cube:
    """The cube of a literal's sign: the cube, or its reciprocal if the literal is a reciprocal."""
    return tuple(sorted([x ^ 1 for x in cube])) if literal & 1 else cube


def _twin(g: Graph, literal: int) -> int | None:
    """The cosine of a sine's angle, or the sine of a cosine's; None for other literals, or if it does not exist."""
    v = literal >> 1
    op = g.op[v]
    if literal & 1 or op not in (_SIN, _COS):
        return None
    twin = g.known(_COS if op is _SIN else _SIN, g.args[v])
    return None if twin is None else 2 * twin


_MOST = 12
"""Literals of a product up to which it goes into what reads it."""


def normal(g: Graph) -> Graph:
    """The graph with equal results in normal form."""
    return _Normal(g).made()


class _Normal:
    """The construction of the new graph, with the sign and cube of each old node in it."""

    def __init__(self, old: Graph) -> None:
        self.old, self.new = old, Graph()
        self.image: dict[int, tuple[int, Cube]] = {}

    def made(self) -> Graph:
        old, new = self.old, self.new
        for v in range(len(old.varies)):
            if old.terms[v] is None and old.op[v] is None and old.number[v] is None:
                self.image[v] = 1, (2 * new.input(old.varies[v]),)
        for v in old.order():
            if v not in self.image:
                self.image[v] = self._of(v)
        for v, s in old.results:
            new.result(*self._node(v, s))
        return new

    def _node(self, v: int, sign: int) -> tuple[int, int]:
        """The node of an old one, with a sign."""
        s, cube = self.image[v]
        if len(cube) == 1 and not cube[0] & 1:
            return cube[0] >> 1, s * sign
        if not cube:
            return self.new.constant(1.0), s * sign
        x, more = self.new.sum([(1, cube)])
        return x, s * sign * more

    def _of(self, v: int) -> tuple[int, Cube]:
        old, new = self.old, self.new
        value, op = old.number[v], old.op[v]
        if value is not None:
            return 1, ONE if value == 1.0 else (2 * new.constant(value),)
        if op is not None:
            return 1, (2 * new.function(op, tuple([self._node(a, s) for a, s in old.args[v]])),)
        total = Coefficients(new)
        for t in old.of(v):
            sign, cube = old.sign[t], ONE
            for x in old.cube[t]:
                s, own = self.image[x >> 1]
                sign *= s
                cube = new.times(cube, tuple(sorted([y ^ 1 for y in own])) if x & 1 else own)
            rest, size = new.parted(cube)
            total.add(rest, sign * size)
        return self._sum(total.terms())

    def _sum(self, terms: list[tuple[int, Cube]]) -> tuple[int, Cube]:
        new = self.new
        if not terms:
            return 1, (2 * new.nothing(),)
        if len(terms) == 1:
            ((sign, cube),) = terms
            if len(cube) > _MOST:
                x, s = new.sum([(sign, cube)])
                return s, (2 * x,)
            return sign, cube
        base = common([c for _, c in terms])
        x, s = new.sum([(sign, over(c, base)) for sign, c in terms])
        return s, new.times(base, (2 * x,))
