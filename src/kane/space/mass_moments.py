# SPDX-License-Identifier: BSD-3-Clause
"""Moments of mass of what is rigid, along a basis and about its origin: m = Σ m, h = Σ m r and E = Σ m r r.

The inertia is J = (tr E) 1 − E. E is shorter to move than J (E + h p + p h + m p p, without a trace), and what a body presses with
as it turns is shorter in it: with r × (a × (b × r)) = (r·(b × r)) a − (r·a) b × r, whose first term is zero,

    Σ m r × (a × (b × r)) = (E a) × b,        ω × J ω = (E ω) × ω
"""

from collections.abc import Iterable
from typing import NamedTuple

from kane.expr.build import add, mul, neg, sub
from kane.expr.node import ZERO, Expr, constant
from kane.space.rotation import NOTHING, Cosines, Triple
from kane.space.spatial import NO_ROWS, Rigid, Turn, Turns, as_rows, summed, summed_symmetric, times, triple

HALF = constant(0.5)


class Moments(NamedTuple):
    """m, h = m r* and E of what is rigid, and J where that is known."""

    m: Expr
    h: Triple
    e: Cosines
    j: Cosines | None = None

    def plus(self, other: "Moments") -> "Moments":
        """Both together."""
        if self is NO_MOMENTS or other is NO_MOMENTS:
            return other if self is NO_MOMENTS else self
        return Moments(add(self.m, other.m), summed(self.h, other.h), summed_symmetric(self.e, other.e))

    def before(self, turn: Turn | Turns) -> "Moments":
        """Along the basis before a turn."""
        return self if self is NO_MOMENTS else Moments(self.m, turn.up(self.h), turn.up_symmetric(self.e))

    def moved(self, p: Triple) -> "Moments":
        """About the point from which this origin lies at p."""
        if self is NO_MOMENTS or all(x is ZERO for x in p):
            return self
        h = summed(self.h, times(self.m, p))
        rows = [list(row) for row in self.e]
        for a in range(3):
            rows[a][a] = add(rows[a][a], mul(p[a], add(self.h[a], h[a])))
            for b in range(a + 1, 3):
                rows[a][b] = rows[b][a] = add(rows[a][b], add(mul(self.h[a], p[b]), mul(p[a], h[b])))
        return Moments(self.m, h, as_rows(rows))

    def about(self, k: int) -> Expr:
        """The moment of inertia about a basis axis."""
        if self.j is not None:
            return self.j[k][k]
        return add(self.e[(k + 1) % 3][(k + 1) % 3], self.e[(k + 2) % 3][(k + 2) % 3])

    def entry(self, a: int, b: int) -> Expr:
        """J_ab."""
        return self.about(a) if a == b else neg(self.e[a][b])

    def along(self, k: int, v: Triple) -> Expr:
        """The measure number of J v along a basis axis."""
        return sum_of(mul(self.entry(k, b), x) for b, x in enumerate(v) if x is not ZERO)

    def turned_by(self, v: Triple) -> Triple:
        """J v."""
        return NOTHING if v is NOTHING else triple(self.along(k, v) for k in range(3))


NO_MOMENTS = Moments(ZERO, NOTHING, NO_ROWS)


def sum_of(terms: Iterable[Expr]) -> Expr:
    """Σ of terms."""
    total = ZERO
    for x in terms:
        total = add(total, x)
    return total


def moments(body: Rigid) -> Moments:
    """Those of a body with this inertia: E = ½ (tr J) 1 − J."""
    if body.is_nothing:
        return NO_MOMENTS
    rows = [[neg(x) for x in row] for row in body.j]
    for k in range(3):
        a, b = (k + 1) % 3, (k + 2) % 3
        rows[k][k] = mul(HALF, sub(add(body.j[a][a], body.j[b][b]), body.j[k][k]))
    return Moments(body.m, body.h, as_rows(rows), body.j)
