# SPDX-License-Identifier: BSD-3-Clause
"""Frozen matrices of expressions, and symbolic linear algebra: LDLᵀ, LU with partial pivoting, inverses by irreducible blocks.

The irreducible blocks of a square matrix are found from its structural zeros (block triangular form); the order of elimination of a
symmetric one is that of minimum degree.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from heapq import heappop, heappush
from itertools import chain
from typing import Any, NamedTuple, overload

import numpy as np

from kane import show
from kane.errors import Attributes, ExpressionError, SingularError, cut
from kane.expect import is_list
from kane.expr.build import add, div, mul, neg, sub
from kane.expr.node import BUILDERS, ONE, ZERO, Expr, as_expr, as_exprs
from kane.expr.ops import CONST


def _row(row: Any) -> Iterable[Any]:
    if type(row) is not list and type(row) is not tuple and not is_list(row):
        raise ExpressionError(f"Expected rows of expressions, [[a, b], [c, d]], got {cut(repr(row))} as one of them.")
    return row


class Matrix(Attributes):
    """A matrix of expressions, `A[i, j]`, `A.shape`, `A.T`, `A @ B`, `A + B`, `c * A`; frozen."""

    __slots__ = ("rows", "shape")

    rows: tuple[tuple[Expr, ...], ...]
    shape: tuple[int, int]

    def __init__(self, rows: Iterable[Iterable[Any]], shape: tuple[int, int] | None = None) -> None:
        if not is_list(rows):
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
        """A column matrix with these entries."""
        return cls([(x,) for x in entries], (len(entries), 1))

    def take(self, rows: Sequence[int] | None = None, columns: Sequence[int] | None = None) -> Matrix:
        """The submatrix of rows and columns with these indices, in this order; None takes all of them."""
        chosen = self.rows if rows is None else [self.rows[i] for i in rows]
        if columns is None:
            return Matrix._of(chosen, (len(chosen), self.shape[1]))
        return Matrix._of([[row[j] for j in columns] for row in chosen], (len(chosen), len(columns)))

    def mirrored(self) -> Matrix:
        """The symmetric matrix that has the same lower triangle as this one."""
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


Rows = Sequence[Sequence[Expr]]


def structural_rank(rows: Rows, width: int) -> int:
    """Largest number of nonzero entries no two of which share a row or column."""
    return sum(c >= 0 for c in matched_columns(rows)) if rows and width else 0


def matched_columns(rows: Rows) -> list[int]:
    """A maximum matching of rows and columns by augmenting paths: a different column for each row, −1 for unmatched rows.

    Matrices here have few rows; a library's matching would take longer to import than to run.
    """
    supports = [[c for c, x in enumerate(row) if x is not ZERO] for row in rows]
    owner = _forced(supports)
    for i in sorted(set(range(len(rows))) - set(owner.values())):
        _augment(supports, owner, i)
    match = [-1] * len(rows)
    for c, i in owner.items():
        match[i] = c
    return match


def _forced(supports: Sequence[Sequence[int]]) -> dict[int, int]:
    """Rows matched to the only column left to them: all rows of a triangular matrix, whose augmenting paths would be long."""
    users: dict[int, list[int]] = {}
    for i, support in enumerate(supports):
        for c in support:
            users.setdefault(c, []).append(i)
    left = [len(support) for support in supports]
    owner: dict[int, int] = {}
    single = [i for i, count in enumerate(left) if count == 1]
    for i in single:
        for c in [c for c in supports[i] if c not in owner]:  # none where another row has taken it
            owner[c] = i
            for j in users[c]:
                left[j] -= 1
                if left[j] == 1:
                    single.append(j)
    return owner


def _augment(supports: Sequence[Sequence[int]], owner: dict[int, int], start: int) -> None:
    """Matches row `start` by an augmenting path, found depth first without recursion; changes nothing if there is none."""
    tried: set[int] = set()
    path = [(start, iter(supports[start]))]
    taken: list[int] = []
    while path:
        row, columns = path[-1]
        c = next((c for c in columns if c not in tried), None)
        if c is None:
            path.pop()
            if taken:
                taken.pop()
            continue
        tried.add(c)
        taken.append(c)
        if c not in owner:
            for (row, _), column in zip(path, taken, strict=True):
                owner[column] = row
            return
        path.append((owner[c], iter(supports[owner[c]])))


def blocks(rows: Rows, match: list[int]) -> list[list[int]]:
    """The irreducible blocks of rows: strongly connected components of the graph from each row to the owners of its columns."""
    owner = {c: i for i, c in enumerate(match)}
    n = len(rows)
    reach = np.eye(n, dtype=bool)
    for i, row in enumerate(rows):
        for c, x in enumerate(row):
            if x is not ZERO:
                reach[i, owner[c]] = True
    for _ in range(n.bit_length()):
        reach = (reach.astype(np.float32) @ reach.astype(np.float32)) > 0
    together = reach & reach.T
    found: dict[int, list[int]] = {}
    for i in range(n):
        found.setdefault(int(np.argmax(together[i])), []).append(i)
    return list(found.values())


def in_order(rows: Rows) -> list[tuple[list[int], list[int]]]:
    """Rows and columns of the irreducible blocks, each after the blocks whose unknowns occur in its rows.

    Raises
    ------
    SingularError
        if no choice of entries gives every row a column of its own
    """
    supports = [[c for c, x in enumerate(row) if x is not ZERO] for row in rows]
    single = all(len(support) == 1 for support in supports) and len({support[0] for support in supports}) == len(rows)
    match = [support[0] for support in supports] if single else matched_columns(rows)
    if -1 in match:
        rank = sum(c >= 0 for c in match)
        raise SingularError(f"Expected an invertible matrix, got structural rank {rank} of {len(rows)}.")
    waiting = [[i] for i in range(len(rows))] if single else blocks(rows, match)
    return [(block, [match[i] for i in block]) for block in _ready(supports, match, waiting)]


def _ready(supports: list[list[int]], match: list[int], waiting: list[list[int]]) -> Iterator[list[int]]:
    """The blocks in topological order, each after those whose unknowns occur in its rows; ties in the given order."""
    place = {match[i]: k for k, block in enumerate(waiting) for i in block}
    needed = [{place[c] for i in block for c in supports[i]} - {k} for k, block in enumerate(waiting)]
    users: list[list[int]] = [[] for _ in waiting]
    for k, before in enumerate(needed):
        for j in before:
            users[j].append(k)
    ready = [k for k, before in enumerate(needed) if not before]
    while ready:
        k = heappop(ready)
        yield waiting[k]
        for user in users[k]:
            needed[user].discard(k)
            if not needed[user]:
                heappush(ready, user)


LARGEST_ADJUGATE = 3
"""Rows of the largest block that is solved by its adjugate."""


class LDL(NamedTuple):
    """The factors of M = L D Lᵀ in an `order` of rows and columns: `lower[i][j]` for j < i, and the pivots, in that order."""

    lower: list[list[Expr]]
    pivots: list[Expr]
    order: Sequence[int]

    def forward(self, b: Sequence[Expr]) -> list[Expr]:
        """L⁻¹ b, in the order."""
        return forward(self.lower, [b[i] for i in self.order])

    def over(self, y: Sequence[Expr]) -> list[Expr]:
        """D⁻¹ y, in the order."""
        return [div(v, d) for v, d in zip(y, self.pivots, strict=True)]

    def finish(self, y: Sequence[Expr]) -> list[Expr]:
        """x with D Lᵀ x = y, the solution of M x = b after y = L⁻¹ b."""
        x = self.over(y)
        for i in reversed(range(len(x))):
            for j, entry in enumerate(self.lower[i]):
                if entry is not ZERO and x[i] is not ZERO:
                    x[j] = sub(x[j], mul(entry, x[i]))
        value = dict(zip(self.order, x, strict=True))
        return [value[i] for i in range(len(x))]

    def solve(self, b: Sequence[Expr]) -> list[Expr]:
        """x with M x = b."""
        return self.finish(self.forward(b))


def ldl(rows: Rows, order: Sequence[int] | None = None) -> LDL:
    """The factors of a symmetric positive definite matrix, without pivoting; without `order` only the lower triangle is read.

    Costs n(n−1)(n+4)/6 + … operations: each l_ij d_j is kept, so that an update is one multiplication and one subtraction.
    """
    order = range(len(rows)) if order is None else order
    rows = [[rows[i][j] for j in order] for i in order]
    n = len(rows)
    work = [[rows[i][j] for j in range(i + 1)] for i in range(n)]
    lower: list[list[Expr]] = [[ZERO] * i for i in range(n)]
    pivots: list[Expr] = []
    for j in range(n):
        pivot = work[j][j]
        if pivot is ZERO:
            raise SingularError(f"Expected a positive definite matrix, got pivot 0 in row {j + 1} of {n}.")
        pivots.append(pivot)
        column = [work[i][j] for i in range(j + 1, n)]
        factors = [div(x, pivot) for x in column]
        for a, i in enumerate(range(j + 1, n)):
            lower[i][j] = factors[a]
            if factors[a] is ZERO:
                continue
            for b in range(a + 1):
                if column[b] is not ZERO:
                    k = j + 1 + b
                    work[i][k] = sub(work[i][k], mul(factors[a], column[b]))
    return LDL(lower, pivots, order)


def forward(lower: Rows, b: Sequence[Expr]) -> list[Expr]:
    """y with L y = b for L with ones on its diagonal, `lower[i][j]` for j < i."""
    y = list(b)
    for i, row in enumerate(lower):
        for j, x in enumerate(row):
            if x is not ZERO and y[j] is not ZERO:
                y[i] = sub(y[i], mul(x, y[j]))
    return y


def back(upper: Rows, y: Sequence[Expr]) -> list[Expr]:
    """x with U x = y, `upper[i][j]` for j ≥ i."""
    x = list(y)
    for i in reversed(range(len(x))):
        row = upper[i]
        x[i] = div(sub(x[i], dot(row[i + 1 : len(x)], x[i + 1 :])), row[i])
    return x


def solve_lu(rows: Rows, columns: Rows) -> list[list[Expr]]:
    """The solutions of A x = b for each b in `columns`, by LU with partial pivoting at run time (`where`).

    For small blocks whose entries' sizes are known only at run time.
    """
    n = len(rows)
    work = [[*rows[i], *(b[i] for b in columns)] for i in range(n)]
    for j in range(n):
        for i in range(j + 1, n):
            if work[i][j] is ZERO:
                continue
            if work[j][j] is ZERO:
                work[j], work[i] = work[i], work[j]
                continue
            swap = BUILDERS["less"](abs(work[j][j]), abs(work[i][j]))
            top, low = work[j], work[i]
            pairs = list(zip(top, low, strict=True))
            work[j] = [BUILDERS["where"](swap, y, x) for x, y in pairs]
            work[i] = [BUILDERS["where"](swap, x, y) for x, y in pairs]
        if work[j][j] is ZERO:
            raise SingularError(
                f"Expected an invertible {n} × {n} block, got a column without a pivot (column {j + 1})."
            )
        for i in range(j + 1, n):
            if work[i][j] is not ZERO:
                _, work[i] = _eliminated(work[i], work[j], j)
    return [back(work, [row[c] for row in work]) for c in range(n, n + len(columns))]


class LU(NamedTuple):
    """A = L U with ones on L's diagonal: `lower[i][j]` for j < i, and the rows of U, `upper[i][j]` for j ≥ i."""

    lower: list[list[Expr]]
    upper: list[list[Expr]]

    @property
    def pivots(self) -> tuple[Expr, ...]:
        """The diagonal of U."""
        return tuple(row[i] for i, row in enumerate(self.upper))

    def solve(self, b: Sequence[Expr]) -> list[Expr]:
        """x with A x = b."""
        return back(self.upper, forward(self.lower, b))


def lu(rows: Rows) -> LU:
    """The factors of a square matrix by elimination in the given order, without pivoting.

    For an order chosen from numerical values; near a zero of a pivot another order must be chosen.
    """
    n = len(rows)
    upper = [list(row) for row in rows]
    lower: list[list[Expr]] = [[ZERO] * i for i in range(n)]
    for j in range(n):
        pivot = upper[j][j]
        if pivot is ZERO:
            raise SingularError(f"Expected a pivot that is not zero in row {j + 1} of {n}.")
        for i in range(j + 1, n):
            if upper[i][j] is not ZERO:
                lower[i][j], upper[i] = _eliminated(upper[i], upper[j], j)
    return LU(lower, upper)


def _eliminated(row: list[Expr], top: list[Expr], j: int) -> tuple[Expr, list[Expr]]:
    """The factor l with row[j] = l top[j], and row − l top."""
    factor = div(row[j], top[j])
    pairs = enumerate(zip(row, top, strict=True))
    return factor, [ZERO if k <= j else x if y is ZERO else sub(x, mul(factor, y)) for k, (x, y) in pairs]


def solve_linear(matrix: Matrix | Sequence[Sequence[Any]], b: Sequence[Any]) -> tuple[Expr, ...]:
    """x with A x = b for a small dense matrix.

    Raises
    ------
    ExpressionError
        if the matrix is not square, or b has another length
    SingularError
        if it has no inverse
    """
    a = matrix if isinstance(matrix, Matrix) else Matrix(matrix)
    right = as_exprs("the right-hand sides", b)
    if a.shape != (len(right), len(right)):
        raise ExpressionError(
            f"Expected a square matrix and as many right-hand sides, got shape {a.shape} and {len(right)} of them."
        )
    return tuple(solve_lu(a.rows, [list(right)])[0])


class InverseRows(NamedTuple):
    """The rows of an inverse, and the divisors of its entries, one of which vanishes if there is no inverse."""

    rows: list[list[Expr]]
    pivots: list[Expr]


def invert(rows: Rows) -> InverseRows:
    """Inverse of a sparse square matrix, block by block along its block triangular form.

    Blocks of one are divided by, blocks up to three are inverted by their adjugate (so that they are singular only where their
    determinant vanishes), larger ones by LU with partial pivoting.
    """
    n = len(rows)
    result: list[dict[int, Expr]] = [{} for _ in range(n)]
    pivots: list[Expr] = []
    for block, own in in_order(rows):
        inverse = _block_inverse([[rows[i][c] for c in own] for i in block], pivots)
        right: list[dict[int, Expr]] = []
        for i in block:
            unit = {i: ONE}
            for c, x in enumerate(rows[i]):
                for k, y in result[c].items() if x is not ZERO and c not in own else ():
                    unit[k] = sub(unit.get(k, ZERO), mul(x, y))
            right.append(unit)
        columns = sorted({k for r in right for k in r})
        for a, c in enumerate(own):
            found = {k: dot(inverse[a], [r.get(k, ZERO) for r in right]) for k in columns}
            result[c] = {k: x for k, x in found.items() if x is not ZERO}
    return InverseRows([[row.get(k, ZERO) for k in range(n)] for row in result], pivots)


def determinant(a: Rows) -> Expr:
    """Determinant of a matrix by its first row: of a few rows, or sparse ones."""
    if len(a) == 1:
        return a[0][0]
    return dot(a[0], [ZERO if x is ZERO else cofactor(a, 0, j) for j, x in enumerate(a[0])])


def _block_inverse(a: list[list[Expr]], pivots: list[Expr]) -> list[list[Expr]]:
    n = len(a)
    if n == 1:
        if a[0][0].op is not CONST:
            pivots.append(a[0][0])
        return [[div(ONE, a[0][0])]]
    if n > LARGEST_ADJUGATE:
        units = [[ONE if i == j else ZERO for i in range(n)] for j in range(n)]
        columns = solve_lu(a, units)
        return [[columns[j][i] for j in range(n)] for i in range(n)]
    cofactors = [[cofactor(a, i, j) for j in range(n)] for i in range(n)]
    size = dot(a[0], cofactors[0])
    if size is ZERO:
        raise SingularError(f"Expected an invertible {n} × {n} block, got determinant 0.")
    if size.op is not CONST:
        pivots.append(size)
    return [[div(cofactors[j][i], size) for j in range(n)] for i in range(n)]


def cofactor(a: Rows, i: int, j: int) -> Expr:
    """The cofactor of an entry of a matrix of two rows or more."""
    minor = [[x for c, x in enumerate(row) if c != j] for r, row in enumerate(a) if r != i]
    if len(minor) == 2:
        (a11, a12), (a21, a22) = minor
        value = sub(mul(a11, a22), mul(a12, a21))
    else:
        value = determinant(minor)
    return neg(value) if (i + j) % 2 else value


def sparse_order(rows: Sequence[Sequence[Expr]]) -> list[int]:
    """The minimum-degree order of elimination of a symmetric matrix (Tinney & Walker 1967); ties keep the given order.

    The mass matrix of a tree is eliminated from the tips, without fill-in; a full matrix keeps its order.
    """
    ties = [{j for j, x in enumerate(row) if j != i and x is not ZERO} for i, row in enumerate(rows)]
    left, order = list(range(len(ties))), []
    while left:
        chosen = min(left, key=lambda i: len(ties[i]))
        left.remove(chosen)
        order.append(chosen)
        for i in ties[chosen]:
            ties[i] |= ties[chosen] - {i}
            ties[i].discard(chosen)
    return order
