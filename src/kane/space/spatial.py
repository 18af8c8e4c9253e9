# SPDX-License-Identifier: BSD-3-Clause
"""Measure numbers of inertias and of forces with their moments, about a point along a basis; turned and moved to others.

An inertia maps the accelerations (α, a) of a basis and of its origin to a moment about that point and a force,

    n = J α + H a,   f = Hᵀ α + M a.

For a rigid body J is the inertia about the origin, H = [h×] with h = m r* and M = m 1 (Featherstone 2008, ch. 7).
"""

from collections.abc import Iterable
from typing import NamedTuple

from kane.expr.build import add, mul, neg, sub
from kane.expr.matrix import dot
from kane.expr.node import TWO, ZERO, Expr
from kane.space.columns import NO_COLUMNS, Columns, at, joined, moved, turned
from kane.space.rotation import (
    NOTHING,
    Basis,
    Cosines,
    Orientation,
    Triple,
    cross3,
    enter,
    leave,
    product,
    transposed,
    turned_symmetric,
)

NO_ROWS: Cosines = (NOTHING, NOTHING, NOTHING)


class Turn(NamedTuple):
    """A change of basis from the base of a basis to this, or back where `inverse`."""

    basis: Basis
    inverse: bool = False

    @property
    def orientation(self) -> Orientation:
        """That of the basis in its base."""
        o = self.basis.orientation
        assert o is not None
        return o

    @property
    def axis(self) -> int | None:
        """The basis axis that it turns about; None about another."""
        return self.orientation.axis

    @property
    def base(self) -> Basis:
        """The base of the basis."""
        return self.orientation.base

    def down(self, v: Triple) -> Triple:
        """Measure numbers before the turn as those after it."""
        return leave(self.basis, v) if self.inverse else enter(self.basis, v)

    def up(self, v: Triple) -> Triple:
        """Measure numbers after the turn as those before it."""
        return enter(self.basis, v) if self.inverse else leave(self.basis, v)

    def up_symmetric(self, rows: Cosines, *, several: bool = False) -> Cosines:
        """Those of a symmetric dyadic, one of `several` or not."""
        o = self.orientation
        if o.axis is not None:
            return turned_symmetric(rows, o.axis, o.c, neg(o.s) if self.inverse else o.s, several=several)
        return mirrored(self._by_cosines(rows))

    def up_general(self, rows: Cosines) -> Cosines:
        """Those of a dyadic."""
        o = self.orientation
        if o.axis is not None:
            return _turned_general(rows, o.axis, o.c, neg(o.s) if self.inverse else o.s)
        return self._by_cosines(rows)

    def _by_cosines(self, rows: Cosines) -> Cosines:
        c = self.orientation.cosines
        assert c is not None
        return similar(transposed(c) if self.inverse else c, rows)


def similar(c: Cosines, rows: Cosines) -> Cosines:
    """C A Cᵀ."""
    a, b, d = (product(c, row) for row in rows)
    columns = transposed((a, b, d))
    a, b, d = (product(c, column) for column in columns)
    return transposed((a, b, d))


class Turns(NamedTuple):
    """Changes of basis one after the other, from the base of the first to the last."""

    steps: tuple["Turn | Turns", ...]
    axis: None = None

    @property
    def basis(self) -> Basis:
        """The last."""
        return self.steps[-1].basis

    @property
    def base(self) -> Basis:
        """The base of the first."""
        return self.steps[0].base

    def down(self, v: Triple) -> Triple:
        """Measure numbers before the turns as those after them."""
        for turn in self.steps:
            v = turn.down(v)
        return v

    def up(self, v: Triple) -> Triple:
        """Measure numbers after the turns as those before them."""
        for turn in reversed(self.steps):
            v = turn.up(v)
        return v

    def up_symmetric(self, rows: Cosines, *, several: bool = False) -> Cosines:
        """Those of a symmetric dyadic, one of `several` or not."""
        for turn in reversed(self.steps):
            rows = turn.up_symmetric(rows, several=several)
        return rows

    def up_general(self, rows: Cosines) -> Cosines:
        """Those of a dyadic."""
        for turn in reversed(self.steps):
            rows = turn.up_general(rows)
        return rows


def _turned_general(rows: Cosines, axis: int, c: Expr, s: Expr) -> Cosines:
    """R A Rᵀ, R the rotation about a basis axis with cosine c and sine s.

    Across the axis, with y = s (a₁₁ − a₂₂) + c (a₁₂ + a₂₁) and z = c y − (a₁₂ + a₂₁): a₁₁ − s y, a₂₂ + s y, a₁₂ + z, a₂₁ + z … where
    the antisymmetric part stays.
    """
    i, j, k = axis, (axis + 1) % 3, (axis + 2) % 3
    out = [list(row) for row in rows]
    a, b, d, e = rows[j][j], rows[j][k], rows[k][j], rows[k][k]
    if not (a is ZERO and b is ZERO and d is ZERO and e is ZERO):
        both = add(b, d)
        y = add(mul(s, sub(a, e)), mul(c, both))
        z = sub(mul(c, y), both)
        out[j][j], out[k][k] = sub(a, mul(s, y)), add(e, mul(s, y))
        out[j][k], out[k][j] = add(b, z), add(d, z)
    x, y = rows[i][j], rows[i][k]
    out[i][j], out[i][k] = sub(mul(c, x), mul(s, y)), add(mul(s, x), mul(c, y))
    x, y = rows[j][i], rows[k][i]
    out[j][i], out[k][i] = sub(mul(c, x), mul(s, y)), add(mul(s, x), mul(c, y))
    return as_rows(out)


def as_rows(rows: list[list[Expr]]) -> Cosines:
    """A list of lists as rows."""
    a, b, c = rows
    return (a[0], a[1], a[2]), (b[0], b[1], b[2]), (c[0], c[1], c[2])


def mirrored(rows: Cosines) -> Cosines:
    """The rows with the entries of the upper triangle below it too."""
    (a, b, c), (_, d, e), (_, _, f) = rows
    return (a, b, c), (b, d, e), (c, e, f)


def summed(a: Triple, b: Triple) -> Triple:
    """a + b."""
    if a is NOTHING or b is NOTHING:
        return b if a is NOTHING else a
    return add(a[0], b[0]), add(a[1], b[1]), add(a[2], b[2])


def along(axis: int, x: Expr) -> Triple:
    """x along a basis axis."""
    return (x, ZERO, ZERO) if axis == 0 else (ZERO, x, ZERO) if axis == 1 else (ZERO, ZERO, x)


def negative(v: Triple) -> Triple:
    """−v."""
    return neg(v[0]), neg(v[1]), neg(v[2])


def times(k: Expr, v: Triple) -> Triple:
    """k v."""
    return mul(k, v[0]), mul(k, v[1]), mul(k, v[2])


def summed_rows(a: Cosines, b: Cosines) -> Cosines:
    """A + B."""
    return summed(a[0], b[0]), summed(a[1], b[1]), summed(a[2], b[2])


def summed_symmetric(a: Cosines, b: Cosines) -> Cosines:
    """A + B of symmetric ones, whose entries below the diagonal are those above."""
    return mirrored(summed_rows(a, b))


def skew(v: Triple) -> Cosines:
    """[v×]."""
    x, y, z = v
    return (ZERO, neg(z), y), (z, ZERO, neg(x)), (neg(y), x, ZERO)


def centripetal(w: Triple, r: Triple, square: Expr) -> Triple:
    """ω × (ω × r); `square` is ω · ω, which is the same along every basis."""
    present = [k for k in range(3) if r[k] is not ZERO]
    if len(present) == 1:
        k = present[0]
        i, j = (k + 1) % 3, (k + 2) % 3
        both = mul(w[k], r[k])
        out = [ZERO, ZERO, ZERO]
        out[k] = neg(mul(add(mul(w[i], w[i]), mul(w[j], w[j])), r[k]))
        out[i], out[j] = mul(w[i], both), mul(w[j], both)
        return out[0], out[1], out[2]
    if w[0] is ZERO and w[1] is ZERO:
        pull = neg(mul(w[2], w[2]))
        return mul(pull, r[0]), mul(pull, r[1]), ZERO
    both = dot(w, r)
    return triple([sub(mul(w[k], both), mul(r[k], square)) for k in range(3)]) if present else NOTHING


def triple(values: Iterable[Expr]) -> Triple:
    """Three values."""
    x, y, z = values
    return x, y, z


class Rigid(NamedTuple):
    """Mass, h = m r* and the inertia about the origin of what is rigid."""

    m: Expr
    h: Triple
    j: Cosines

    def plus(self, other: "Rigid") -> "Rigid":
        """Both together."""
        return Rigid(add(self.m, other.m), summed(self.h, other.h), summed_symmetric(self.j, other.j))

    def before(self, turn: Turn | Turns) -> "Rigid":
        """Along the basis before a turn."""
        return Rigid(self.m, turn.up(self.h), turn.up_symmetric(self.j))

    def moved(self, r: Triple) -> "Rigid":
        """About the point from which this origin lies at r."""
        m, h = self.m, self.h
        whole = add(mul(TWO, dot(h, r)), mul(m, dot(r, r)))
        rows = [list(row) for row in self.j]
        for a in range(3):
            for b in range(a, 3):
                x = rows[a][b]
                if r[a] is not ZERO or r[b] is not ZERO:
                    x = sub(x, add(mul(h[a], r[b]), mul(r[a], h[b])))
                    x = sub(x, mul(m, mul(r[a], r[b])))
                rows[a][b] = rows[b][a] = add(x, whole) if a == b else x
        return Rigid(m, summed(h, times(m, r)), as_rows(rows))

    def bias(self, w: Triple, square: Expr) -> tuple[Triple, Triple]:
        """Moment and force of ω × J ω and ω × (ω × h), with ω · ω; what J has of the unit dyadic adds nothing."""
        (a, b, c), (d, e, f), (g, h, common) = self.j
        j = (sub(a, common), b, c), (d, sub(e, common), f), (g, h, ZERO)
        return cross3(w, product(j, w)), centripetal(w, self.h, square)

    def about(self, k: int) -> Expr:
        """The moment of inertia about a basis axis."""
        return self.j[k][k]

    def turned_by(self, v: Triple) -> Triple:
        """J v."""
        return product(self.j, v)

    @property
    def is_nothing(self) -> bool:
        """Whether there is none."""
        return self.m is ZERO and all(x is ZERO for row in (self.h, *self.j) for x in row)


NO_MASS = Rigid(ZERO, NOTHING, NO_ROWS)


class Inertia(NamedTuple):
    """J, H and M, the moment n and force f that are there at no acceleration, and columns of freedoms that move several parts."""

    j: Cosines
    h: Cosines
    m: Cosines
    n: Triple
    f: Triple
    columns: Columns = NO_COLUMNS

    def plus(self, other: "Inertia") -> "Inertia":
        """Both together."""
        return Inertia(
            summed_symmetric(self.j, other.j),
            summed_rows(self.h, other.h),
            summed_symmetric(self.m, other.m),
            summed(self.n, other.n),
            summed(self.f, other.f),
            joined(self.columns, other.columns),
        )

    def before(self, turn: Turn | Turns) -> "Inertia":
        """Along the basis before a turn."""
        return Inertia(
            turn.up_symmetric(self.j, several=True),
            turn.up_general(self.h),
            turn.up_symmetric(self.m, several=True),
            turn.up(self.n),
            turn.up(self.f),
            turned(self.columns, turn.up),
        )

    def moved(self, r: Triple) -> "Inertia":
        """About the point from which this origin lies at r."""
        if r is NOTHING or all(x is ZERO for x in r):
            return self
        (m_0, m_1, m_2), (h_0, h_1, h_2) = self.m, self.h
        g = summed_rows(self.h, transposed((cross3(r, m_0), cross3(r, m_1), cross3(r, m_2))))  # H + [r×] M
        left = cross3(r, h_0), cross3(r, h_1), cross3(r, h_2)  # the columns of [r×] Hᵀ
        right = cross3(g[0], r), cross3(g[1], r), cross3(g[2], r)  # the rows of G [r×]
        rows = [list(row) for row in self.j]
        for a in range(3):
            for b in range(a, 3):
                rows[a][b] = rows[b][a] = sub(add(rows[a][b], left[b][a]), right[a][b])
        n = summed(self.n, cross3(r, self.f))
        return Inertia(as_rows(rows), g, self.m, n, self.f, moved(self.columns, r))

    def at(self, alpha: Triple, a: Triple) -> "Inertia":
        """The same with what known parts of the acceleration add to n and f."""
        if alpha is NOTHING and a is NOTHING:
            return self
        n = summed(summed(self.n, product(self.j, alpha)), product(self.h, a))
        f = summed(summed(self.f, product(transposed(self.h), alpha)), product(self.m, a))
        return self._replace(n=n, f=f, columns=at(self.columns, alpha, a))


NO_INERTIA = Inertia(NO_ROWS, NO_ROWS, NO_ROWS, NOTHING, NOTHING)


def of_rigid(body: Rigid, n: Triple, f: Triple) -> Inertia:
    """The inertia of a rigid body, with what else is there at no acceleration."""
    m = body.m
    return Inertia(body.j, skew(body.h), ((m, ZERO, ZERO), (ZERO, m, ZERO), (ZERO, ZERO, m)), n, f)


def to_rigid(felt: Inertia) -> Rigid:
    """The rigid body with this inertia, which is that of one."""
    return Rigid(felt.m[0][0], (felt.h[2][1], felt.h[0][2], felt.h[1][0]), felt.j)
