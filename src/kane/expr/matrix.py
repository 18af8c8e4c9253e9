# SPDX-License-Identifier: BSD-3-Clause
"""Frozen matrices of expressions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain
from typing import Any, overload

import numpy as np

from kane import show
from kane.errors import Attributes, ExpressionError, cut
from kane.expr.build import add, mul, neg, sub
from kane.expr.node import ONE, ZERO, Expr, as_expr


def _row(row: Any) -> Iterable[Any]:
    if type(row) is not list and type(row) is not tuple and (isinstance(row, str) or not isinstance(row, Iterable)):
        raise ExpressionError(f"Expected rows of expressions, [[a, b], [c, d]], got {cut(repr(row))} as one of them.")
    return row


class Matrix(Attributes):
    """A matrix of expressions, `A[i, j]`, `A.shape`, `A.T`, `A @ B`, `A + B`, `c * A`; frozen."""

    __slots__ = ("rows", "shape")

    rows: tuple[tuple[Expr, ...], ...]
    shape: tuple[int, int]

    def __init__(self, rows: Iterable[Iterable[Any]], shape: tuple[int, int] | None = None) -> None:
        if not isinstance(rows, Iterable):
            raise ExpressionError(f"Expected a matrix by its rows, [[a, b], [c, d]], got {cut(repr(rows))}.")
        entries = tuple([tuple([x if isinstance(x, Expr) else as_expr(x) for x in _row(row)]) for row in rows])
        if shape is not None and not entries:
            entries = ((),) * shape[0]  # no columns
        widths = {len(row) for row in entries}
        if len(widths) > 1:
            raise ExpressionError(f"Expected rows of one length, got lengths {sorted(widths)}.")
        object.__setattr__(self, "rows", entries)
        object.__setattr__(self, "shape", shape or (len(entries), widths.pop() if widths else 0))

    @classmethod
    def _of(cls, rows: Iterable[Iterable[Expr]], shape: tuple[int, int]) -> Matrix:
        """The matrix of expressions that are known to have this shape."""
        matrix = object.__new__(cls)
        object.__setattr__(matrix, "rows", tuple(map(tuple, rows)) or ((),) * shape[0])
        object.__setattr__(matrix, "shape", shape)
        return matrix

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"A Matrix is frozen: {name!r} cannot be set.")

    def __reduce__(self) -> tuple[Callable[..., Matrix], tuple[Any, ...]]:
        return Matrix, (self.rows, self.shape)

    @classmethod
    def identity(cls, n: int) -> Matrix:
        """The n × n identity."""
        return cls([[ONE if i == j else ZERO for j in range(n)] for i in range(n)])

    def __getitem__(self, place: tuple[int, int]) -> Expr:
        return self.rows[place[0]][place[1]]

    def __iter__(self) -> Iterator[tuple[Expr, ...]]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def T(self) -> Matrix:
        """The transpose."""
        return Matrix._of(zip(*self.rows, strict=True), (self.shape[1], self.shape[0]))

    @property
    def entries(self) -> tuple[Expr, ...]:
        """All entries, row after row."""
        return tuple(chain.from_iterable(self.rows))

    @classmethod
    def column(cls, entries: Sequence[Any]) -> Matrix:
        """A matrix of one column."""
        return cls([(x,) for x in entries], (len(entries), 1))

    def take(self, rows: Sequence[int] | None = None, columns: Sequence[int] | None = None) -> Matrix:
        """The rows and columns of these numbers, in this order; all of them where none are named."""
        chosen = self.rows if rows is None else [self.rows[i] for i in rows]
        if columns is None:
            return Matrix._of(chosen, (len(chosen), self.shape[1]))
        return Matrix._of([[row[j] for j in columns] for row in chosen], (len(chosen), len(columns)))

    def mirrored(self) -> Matrix:
        """The symmetric matrix with the lower triangle of this one."""
        n = range(self.shape[0])
        return Matrix._of([[self.rows[max(i, j)][min(i, j)] for j in n] for i in n], self.shape)

    def map(self, f: Callable[[Expr], Expr]) -> Matrix:
        """`f` of every entry."""
        return Matrix([[f(x) for x in row] for row in self.rows], self.shape)

    def __neg__(self) -> Matrix:
        return Matrix._of([list(map(neg, row)) for row in self.rows], self.shape)

    def _entrywise(self, other: Matrix, f: Callable[[Expr, Expr], Expr]) -> Matrix:
        if self.shape != other.shape:
            raise ExpressionError(f"Expected matrices of one shape, got {self.shape} and {other.shape}.")
        pairs = zip(self.rows, other.rows, strict=True)
        return Matrix._of([[f(x, y) for x, y in zip(r, s, strict=True)] for r, s in pairs], self.shape)

    def __add__(self, other: Matrix) -> Matrix:
        return self._entrywise(other, add)

    def __sub__(self, other: Matrix) -> Matrix:
        return self._entrywise(other, sub)

    def __mul__(self, factor: Any) -> Matrix:
        c = as_expr(factor)
        return Matrix._of([[mul(c, x) for x in row] for row in self.rows], self.shape)

    __rmul__ = __mul__

    @overload
    def __matmul__(self, other: Matrix) -> Matrix: ...
    @overload
    def __matmul__(self, other: Sequence[Any]) -> tuple[Expr, ...]: ...
    def __matmul__(self, other: Matrix | Sequence[Any]) -> Matrix | tuple[Expr, ...]:
        if isinstance(other, Matrix):
            if self.shape[1] != other.shape[0]:
                raise ExpressionError(f"Expected inner sizes that agree, got {self.shape} @ {other.shape}.")
            columns = other.T.rows
            return Matrix._of([[dot(r, c) for c in columns] for r in self.rows], (self.shape[0], other.shape[1]))
        vector = [as_expr(x) for x in other]
        if len(vector) != self.shape[1]:
            raise ExpressionError(f"Expected a vector of length {self.shape[1]}, got {len(vector)}.")
        return tuple(dot(r, vector) for r in self.rows)

    def to_numpy(self) -> np.ndarray[Any, np.dtype[np.object_]]:
        """Object array of the entries."""
        array = np.empty(self.shape, dtype=object)
        for i, row in enumerate(self.rows):
            for j, x in enumerate(row):
                array[i, j] = x
        return array

    def __repr__(self) -> str:
        return "Matrix([" + ",\n        ".join("[" + ", ".join(map(str, r)) + "]" for r in self.rows) + "])"

    _repr_latex_ = show.latex


def dot(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    """Σ a_i b_i."""
    total = ZERO
    for x, y in zip(a, b, strict=True):
        if x is not ZERO and y is not ZERO:
            total = mul(x, y) if total is ZERO else add(total, mul(x, y))
    return total
