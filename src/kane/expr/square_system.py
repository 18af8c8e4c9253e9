# SPDX-License-Identifier: BSD-3-Clause
"""Straight-line code for A x = b that is valid wherever det A is not zero, with pivots that vanish only if det A does.

Elimination in the given order is used if all pivots, except the last one of each irreducible block, are nonzero for all values.
Otherwise the blocks are solved in sequence: by elimination with an entry that is nonzero for all values, then by the adjugate for up
to three rows, and beyond by elimination with row pivoting at run time. The divisor is the determinant of each block without its
content, the parameters and numbers common to all of its terms.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from typing import NamedTuple, Protocol

from kane.errors import SingularError
from kane.expr.build import NODE_BUILDERS, add, div, mul, neg, sub, where
from kane.expr.matrix import LARGEST_ADJUGATE, LU, Rows, back, cofactor, dot, in_order, lu
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.ops import ADD, CONST, DIV, MUL, NEG, SUB
from kane.expr.regular import Sizes, denominator, is_unbounded, largest, never_zero, size
from kane.expr.symbols import Parameter
from kane.expr.visit import fold

Powers = Mapping[Expr, int]
"""Parameters with their powers, above zero."""
Contents = dict[Expr, Powers | None]
"""Contents by expression; None for zero, which is divided by anything."""

_NOTHING: Powers = {}


def content(exprs: Iterable[Expr], memo: Contents) -> Powers:
    """The content of expressions: parameters common to all, with their common powers; empty if all expressions are zero."""
    common: Powers | None = None
    for e in exprs:
        common = _both(common, fold(e, memo, lambda node: _of(node, memo)))
        if common is not None and not common:
            break
    return common or _NOTHING


def _of(node: Expr, memo: Contents) -> Powers | None:
    op, args = node.op, node.args
    if op is MUL or op is DIV:
        a, b = memo[args[0]], memo[args[1]]
        if a is None or b is None:
            return None
        if not b or (not a and op is DIV):
            return a
        sign = 1 if op is MUL else -1
        total = {p: a.get(p, 0) + sign * b.get(p, 0) for p in (*a, *b)}
        return {p: k for p, k in total.items() if k > 0}
    if op is ADD or op is SUB:
        return _both(memo[args[0]], memo[args[1]])
    if op is NEG:
        return memo[args[0]]
    if isinstance(node, Parameter):
        return {node: 1}
    return None if node is ZERO else _NOTHING


def _both(a: Powers | None, b: Powers | None) -> Powers | None:
    if a is None or b is None:
        return b if a is None else a
    return {p: min(k, b[p]) for p, k in a.items() if p in b} if a and b else _NOTHING


def divider(memo: Contents) -> Callable[[Expr, Powers], Expr]:
    """A function that divides expressions by powers in their content; shared subexpressions are divided once."""
    done: dict[tuple[Expr, frozenset[tuple[Expr, int]]], Expr] = {}

    def divided(e: Expr, by: Powers) -> Expr:
        if not by or e is ZERO:
            return e
        key = e, frozenset(by.items())
        if key not in done:
            done[key] = _divided(e, by)
        return done[key]

    def _divided(e: Expr, by: Powers) -> Expr:
        op, args = e.op, e.args
        if op is ADD or op is SUB:
            return (add if op is ADD else sub)(divided(args[0], by), divided(args[1], by))
        if op is NEG:
            return neg(divided(args[0], by))
        if op is MUL:
            own = memo.get(args[0]) or _NOTHING
            first = {p: min(k, own[p]) for p, k in by.items() if p in own}
            rest = {p: k - first.get(p, 0) for p, k in by.items() if k > first.get(p, 0)}
            return mul(divided(args[0], first), divided(args[1], rest))
        if op is DIV and all((memo.get(args[0]) or _NOTHING).get(p, 0) >= k for p, k in by.items()):
            return div(divided(args[0], by), args[1])
        return ONE if by == {e: 1} else div(e, product_of(by))

    return divided


def product_of(powers: Powers) -> Expr:
    """The product of parameters with their powers."""
    total: Expr = ONE
    for p, k in powers.items():
        for _ in range(k):
            total = mul(total, p)
    return total


def over_number(e: Expr, divisor: Expr) -> Expr:
    """e divided by a number, distributed over a sum if each term has a numerical factor, so that no operation is added."""
    if e.op is NEG:
        return neg(over_number(e.args[0], divisor))
    if not _absorbs(e):
        return div(e, divisor)
    if e.op is ADD or e.op is SUB:
        return (add if e.op is ADD else sub)(*(over_number(a, divisor) for a in e.args))
    if e.op is MUL:
        first, second = e.args
        inner = _absorbs(first)
        return mul(over_number(first, divisor) if inner else first, second if inner else over_number(second, divisor))
    return div(e, divisor)


def _absorbs(e: Expr) -> bool:
    """Whether e, each term of it if it is a sum, has a number as a factor."""
    if e.op is MUL:
        return any(a.op is not NEG and _absorbs(a) for a in e.args)
    if e.op is ADD or e.op is SUB or e.op is NEG:
        return all(map(_absorbs, e.args))
    return e.op is CONST or (e.op is DIV and (e.args[1].op is CONST or e.args[0].op is CONST))


class Divisor(NamedTuple):
    """A divisor, its size (of a quotient that of the numerator), and the unknowns that are undetermined where it vanishes."""

    value: Expr
    size: Expr
    unknowns: tuple[int, ...]


class SquareSolver(Protocol):
    """A solver of A x = b."""

    @property
    def divisors(self) -> tuple[Divisor, ...]:
        """The divisors that may vanish."""

    def solve(self, b: Sequence[Expr]) -> list[Expr]:
        """x with A x = b."""


@dataclass(frozen=True, slots=True, eq=False)
class InOrder:
    """Elimination in the given order."""

    factors: LU
    divisors: tuple[Divisor, ...]

    def solve(self, b: Sequence[Expr]) -> list[Expr]:
        """x with A x = b."""
        return self.factors.solve(b)


@dataclass(frozen=True, slots=True, eq=False)
class Triangular:
    """Solution of the irreducible blocks in sequence, each with its rows and columns."""

    rows: Rows
    blocks: tuple[tuple[list[int], list[int], SquareSolver], ...]

    @property
    def divisors(self) -> tuple[Divisor, ...]:
        """The divisors of the blocks that may vanish."""
        return tuple(
            d._replace(unknowns=tuple(own[k] for k in d.unknowns)) for _, own, s in self.blocks for d in s.divisors
        )

    def solve(self, b: Sequence[Expr]) -> list[Expr]:
        """x with A x = b."""
        x = [ZERO] * len(b)
        for block, own, solver in self.blocks:
            right = [sub(b[i], dot(self.rows[i], x)) for i in block]
            for c, value in zip(own, solver.solve(right), strict=True):
                x[c] = value
        return x


@dataclass(frozen=True, slots=True, eq=False)
class Eliminated:
    """Elimination of one unknown by an entry, in `row` and `column`, that is nonzero for all values; `rest` solves for the others."""

    row: int
    column: int
    top: Sequence[Expr]
    factors: Sequence[Expr]
    rest: SquareSolver

    @property
    def divisors(self) -> tuple[Divisor, ...]:
        """The divisors of `rest` that may vanish."""
        return tuple(d._replace(unknowns=tuple(k + (k >= self.column) for k in d.unknowns)) for d in self.rest.divisors)

    def solve(self, b: Sequence[Expr]) -> list[Expr]:
        """x with A x = b."""
        others = [i for i in range(len(b)) if i != self.row]
        right = [sub(b[i], mul(f, b[self.row])) for i, f in zip(others, self.factors, strict=True)]
        x = self.rest.solve(right)
        x.insert(self.column, ZERO)
        x[self.column] = div(sub(b[self.row], dot(self.top, x)), self.top[self.column])
        return x


@dataclass(frozen=True, slots=True, eq=False)
class Adjugate:
    """x = adj(A) (b / det A), for a few rows; of R A C, A without parameters common to rows (`left`) and columns (`right`)."""

    adjugate: Rows
    divisor: Divisor
    left: Sequence[Expr]
    right: Sequence[Expr]

    @property
    def divisors(self) -> tuple[Divisor, ...]:
        """The determinant, if it may vanish."""
        return () if never_zero(self.divisor.value) else (self.divisor,)

    def solve(self, b: Sequence[Expr]) -> list[Expr]:
        """x with A x = b."""
        value = self.divisor.value
        if len(b) == 1:
            return [div(b[0], value)]
        plain = [dot(row, self._over(b, self.left)) for row in self.adjugate]
        whole = all(x is ONE for x in self.left)
        fewer = any(x is not ONE for x in self.right) or sum(x is not ZERO for x in plain) <= sum(
            x is not ZERO for x in b
        )
        if whole and fewer:
            return self._over(plain, [mul(value, k) for k in self.right])
        shares = self._over(b, [mul(value, k) for k in self.left])
        return self._over([dot(row, shares) for row in self.adjugate], self.right)

    def _over(self, x: Sequence[Expr], by: Sequence[Expr]) -> list[Expr]:
        return [div(a, k) for a, k in zip(x, by, strict=True)]


@dataclass(frozen=True, slots=True, eq=False)
class Swap:
    """Exchange of rows `top` and `low` if `condition` holds at run time."""

    top: int
    low: int
    condition: Expr

    def apply(self, x: list[Expr]) -> None:
        """Applies the step to one column, in place."""
        a, b = x[self.top], x[self.low]
        x[self.top], x[self.low] = where(self.condition, b, a), where(self.condition, a, b)


@dataclass(frozen=True, slots=True, eq=False)
class EliminationStep:
    """Subtraction of `factor` times row `top` from row `low`."""

    top: int
    low: int
    factor: Expr

    def apply(self, x: list[Expr]) -> None:
        """Applies the step to one column, in place."""
        x[self.low] = sub(x[self.low], mul(self.factor, x[self.top]))


@dataclass(frozen=True, slots=True, eq=False)
class Pivoted:
    """Elimination with row pivoting at run time: the pivot row is the one whose entry is largest relative to the row's size."""

    steps: tuple[Swap | EliminationStep, ...]
    upper: Rows
    divisors: tuple[Divisor, ...]

    def solve(self, b: Sequence[Expr]) -> list[Expr]:
        """x with A x = b."""
        x = list(b)
        for step in self.steps:
            step.apply(x)
        return back(self.upper, x)


class _Reach:
    """The sizes of rows, computed when read, since most solvers need none."""

    def __init__(self, size_of: Callable[[int], Expr]) -> None:
        self._size_of = cache(size_of)

    def __getitem__(self, i: int) -> Expr:
        return self._size_of(i)

    def of(self, rows: Sequence[int]) -> "_Reach":
        """The sizes of some rows."""
        return _Reach(lambda k: self[rows[k]])


def square(rows: Rows, reach: Callable[[int], Expr] | None = None) -> SquareSolver:
    """The solver of A x = b for a square matrix.

    Parameters
    ----------
    rows : A
    reach : the size of a row by its number, which may include entries outside A; by default that of its entries

    Raises
    ------
    SingularError
        if A has no inverse whatever its symbols are
    """
    memo: Sizes = {}
    sizes = _Reach(reach or (lambda i: largest(size(x, memo) for x in rows[i])))
    return _in_given_order(rows, sizes, memo) or _triangular(rows, sizes, memo)


def _in_given_order(rows: Rows, sizes: _Reach, memo: Sizes) -> InOrder | None:
    """Elimination in the given order if only the last pivots of blocks may vanish, else None."""
    blocks = in_order(rows)
    home = {i: k for k, (block, _) in enumerate(blocks) for i in block}
    paired = all(home[i] == k for k, (_, own) in enumerate(blocks) for i in own)
    parts = [sorted(block) for block, _ in blocks] if paired else [list(range(len(rows)))]
    last = {part[-1]: part for part in parts}
    try:
        factors = lu(rows)
    except SingularError:
        return None
    found = []
    for i, pivot in enumerate(factors.pivots):
        if never_zero(pivot):
            continue
        if i not in last:
            return None
        found.append(Divisor(pivot, _size(pivot, sizes, last[i], memo), tuple(last[i])))
    return InOrder(factors, tuple(found))


def _size(determinant: Expr, sizes: _Reach, rows: Sequence[int], memo: Sizes) -> Expr:
    """The size of a divisor; if it has no bound, as a distance, the product of the rows' sizes if that is larger."""
    below = denominator(determinant)
    own = size(below, memo)
    if not is_unbounded(below):
        return own
    whole = reduce(mul, [sizes[k] for k in rows])
    while determinant is not below:
        if determinant.op is DIV:
            whole = mul(whole, determinant.args[1])
        determinant = determinant.args[0]
    return largest([own, whole])


def _triangular(rows: Rows, sizes: _Reach, memo: Sizes) -> SquareSolver:
    parts = []
    for block, own in in_order(rows):
        inner = [[rows[i][c] for c in own] for i in block]
        parts.append((block, own, _block(inner, sizes.of(block), memo)))
    return Triangular(rows, tuple(parts))


def _block(rows: Rows, sizes: _Reach, memo: Sizes) -> SquareSolver:
    n = len(rows)
    place = _sure(rows) if n > 1 else None
    if place is not None:
        return _eliminated(rows, sizes, memo, *place)
    return _adjugate(rows, sizes, memo) if n <= LARGEST_ADJUGATE else _pivoted(rows, sizes)


def _sure(rows: Rows) -> tuple[int, int] | None:
    """The entry, nonzero for all values, with the sparsest row and column; None if there is none."""
    width = [sum(x is not ZERO for x in row) - 1 for row in rows]
    height = [sum(row[j] is not ZERO for row in rows) - 1 for j in range(len(rows))]
    places = [(i, j) for i, row in enumerate(rows) for j, x in enumerate(row) if never_zero(x)]
    return min(places, key=lambda p: (width[p[0]] * height[p[1]], p), default=None)


def _eliminated(rows: Rows, sizes: _Reach, memo: Sizes, r: int, c: int) -> Eliminated:
    top = rows[r]
    others = [i for i in range(len(rows)) if i != r]
    factors = [div(rows[i][c], top[c]) for i in others]
    rest = [
        [sub(x, mul(f, y)) for j, (x, y) in enumerate(zip(rows[i], top, strict=True)) if j != c]
        for i, f in zip(others, factors, strict=True)
    ]
    left = _Reach(lambda k: largest([sizes[others[k]], *(size(x, memo) for x in rest[k])]))
    return Eliminated(r, c, top, factors, _triangular(rest, left, memo))


def _adjugate(rows: Rows, sizes: _Reach, memo: Sizes) -> Adjugate:
    n = len(rows)
    if n > 1 and not any(is_unbounded(x) or _is_quotient(x) for row in rows for x in row):
        columns, right = _primitive(list(zip(*rows, strict=True)))
        rows, left = _primitive(list(zip(*columns, strict=True)))
    else:
        left = right = [ONE] * n
    cofactors = [[ONE]] if n == 1 else [[cofactor(rows, i, j) for j in range(n)] for i in range(n)]
    value = dot(rows[0], cofactors[0])
    if value is ZERO:
        raise SingularError(f"Expected an invertible {n} × {n} block, got determinant 0.")
    divisor = Divisor(value, _size(value, sizes, range(n), memo), tuple(range(n)))
    return Adjugate([list(column) for column in zip(*cofactors, strict=True)], divisor, left, right)


def _is_quotient(e: Expr) -> bool:
    return (e.args[0] if e.op is NEG else e).op is DIV


def _primitive(rows: Sequence[Sequence[Expr]]) -> tuple[list[list[Expr]], list[Expr]]:
    """Rows divided by the parameters common to their entries, and these parameters."""
    memo: Contents = {}
    divided = divider(memo)
    common = [content(row, memo) for row in rows]
    return [[divided(x, c) for x in row] for row, c in zip(rows, common, strict=True)], [product_of(c) for c in common]


def _pivoted(rows: Rows, sizes: _Reach) -> Pivoted:
    n = len(rows)
    columns, scale = [list(column) for column in zip(*rows, strict=True)], [sizes[i] for i in range(n)]
    steps: list[Swap | EliminationStep] = []

    def take(step: Swap | EliminationStep, after: int) -> None:
        steps.append(step)
        for column in columns[after:]:
            step.apply(column)

    for j, column in enumerate(columns):
        for i in range(j + 1, n):
            if column[i] is ZERO:
                continue
            swap = Swap(j, i, _larger(column[i], scale[i], column[j], scale[j]))
            take(swap, j)
            swap.apply(scale)
        if column[j] is ZERO:
            raise SingularError(f"Expected an invertible {n} × {n} block, got a column without a pivot.")
        for i in range(j + 1, n):
            if column[i] is not ZERO:
                take(EliminationStep(j, i, div(column[i], column[j])), j + 1)
                column[i] = ZERO
    upper = [[columns[k][i] for k in range(n)] for i in range(n)]
    divisors = tuple(Divisor(upper[i][i], scale[i], tuple(range(n))) for i in range(n))
    return Pivoted(tuple(steps), upper, divisors)


def _larger(x: Expr, x_size: Expr, y: Expr, y_size: Expr) -> Expr:
    """The condition that x is larger than y relative to the sizes of their rows."""
    a, b = largest([y]), largest([x])
    if x_size is not y_size:
        a, b = mul(a, x_size), mul(b, y_size)
    return NODE_BUILDERS["less"](a, b)
