# SPDX-License-Identifier: BSD-3-Clause
"""Measure numbers of vectors (3) and dyadics (3 × 3), and the rotations that take them from one basis to the next."""

from collections.abc import Iterable
from typing import NamedTuple, TypeVar

from kane.expr.build import add, div, mul, neg, sub
from kane.expr.matrix import dot
from kane.expr.node import ZERO, Expr
from kane.space.rotation import (
    NOTHING,
    Basis,
    Cosines,
    Orientation,
    Triple,
    enter,
    leave,
    product,
    transposed,
    turned_symmetric,
)

T = TypeVar("T")
NO_ROWS: Cosines = (NOTHING, NOTHING, NOTHING)


class Turn(NamedTuple):
    """A change of basis, from the base of `basis` to `basis`, or the inverse."""

    basis: Basis
    inverse: bool = False

    @property
    def orientation(self) -> Orientation:
        """The orientation of the basis in its base."""
        o = self.basis.orientation
        assert o is not None
        return o

    @property
    def axis(self) -> int | None:
        """The basis axis of the rotation; None if it is about another axis."""
        return self.orientation.axis

    @property
    def base(self) -> Basis:
        """The base of the basis."""
        return self.orientation.base

    def down(self, v: Triple) -> Triple:
        """The measure numbers after the rotation, from those before it."""
        return leave(self.basis, v) if self.inverse else enter(self.basis, v)

    def up(self, v: Triple) -> Triple:
        """The measure numbers before the rotation, from those after it."""
        return enter(self.basis, v) if self.inverse else leave(self.basis, v)

    def up_symmetric(self, rows: Cosines, *, several: bool = False) -> Cosines:
        """`up` of a symmetric dyadic; `several` if others are turned by the same rotation, so that products of c and s are shared."""
        o = self.orientation
        if o.axis is not None:
            return turned_symmetric(rows, o.axis, o.c, neg(o.s) if self.inverse else o.s, several=several)
        return mirrored(self._by_cosines(rows))

    def up_general(self, rows: Cosines) -> Cosines:
        """`up` of a dyadic."""
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
    """A sequence of changes of basis, from the base of the first to the last."""

    steps: tuple["Turn | Turns", ...]
    axis: None = None

    @property
    def basis(self) -> Basis:
        """The last basis."""
        return self.steps[-1].basis

    @property
    def base(self) -> Basis:
        """The base of the first."""
        return self.steps[0].base

    def down(self, v: Triple) -> Triple:
        """The measure numbers after the rotations, from those before them."""
        return turned_down(self.steps, v)

    def up(self, v: Triple) -> Triple:
        """The measure numbers before the rotations, from those after them."""
        for turn in reversed(self.steps):
            v = turn.up(v)
        return v

    def up_symmetric(self, rows: Cosines, *, several: bool = False) -> Cosines:
        """`up` of a symmetric dyadic; `several` if others are turned by the same rotation, so that products of c and s are shared."""
        for turn in reversed(self.steps):
            rows = turn.up_symmetric(rows, several=several)
        return rows

    def up_general(self, rows: Cosines) -> Cosines:
        """`up` of a dyadic."""
        for turn in reversed(self.steps):
            rows = turn.up_general(rows)
        return rows


def turned_down(turns: Iterable[Turn | Turns], v: Triple) -> Triple:
    """The measure numbers after some rotations, from those before them."""
    for turn in turns:
        v = turn.down(v)
    return v


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
    """Three lists as a tuple of rows."""
    a, b, c = rows
    return (a[0], a[1], a[2]), (b[0], b[1], b[2]), (c[0], c[1], c[2])


def mirrored(rows: Cosines) -> Cosines:
    """The symmetric matrix with the upper triangle of `rows`."""
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
    """A + B for symmetric A and B."""
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
    """A tuple of three values."""
    x, y, z = values
    return x, y, z


def is_zero(v: Iterable[Expr]) -> bool:
    """Whether all values are structural zeros."""
    return all(x is ZERO for x in v)


def put(v: tuple[T, T, T], k: int, x: T) -> tuple[T, T, T]:
    """The triple with entry k replaced by x."""
    return (x, v[1], v[2]) if k == 0 else (v[0], x, v[2]) if k == 1 else (v[0], v[1], x)


def over(v: Triple, d: Expr) -> Triple:
    """v/d."""
    return div(v[0], d), div(v[1], d), div(v[2], d)


def lowered(rows: Cosines, t: Triple, u: Triple, *, symmetric: bool) -> Cosines:
    """A − t uᵀ."""
    out = [list(row) for row in rows]
    for a in range(3):
        for b in range(a if symmetric else 0, 3):
            x = rows[a][b] if t[a] is ZERO or u[b] is ZERO else sub(rows[a][b], mul(t[a], u[b]))
            out[a][b] = x
            if symmetric:
                out[b][a] = x
    return as_rows(out)
