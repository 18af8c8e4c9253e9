# SPDX-License-Identifier: BSD-3-Clause
"""The normal form of a graph: products go into all that reads them, and what all terms of a sum share stands before it.

Sharing that is lost so is found again by divisors; that of what was written in several ways is found for the first time.
"""

from __future__ import annotations

from kane.rewrite.graph import ONE, Coefficients, Cube, Graph, common, over

_MOST = 12
"""Literals of a product up to which it goes into what reads it."""


def normal(g: Graph) -> Graph:
    """The graph with equal results in normal form."""
    return _Normal(g).made()


class _Normal:
    """The new graph, and of each old node the sign and cube that it is there."""

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
