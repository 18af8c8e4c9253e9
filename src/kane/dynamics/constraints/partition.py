# SPDX-License-Identifier: BSD-3-Clause
"""The choice of dependent speeds in A u + b = 0, and their order of elimination: complete pivoting on numerical values of A.

Among entries of sufficient size the pivot is the one with the sparsest row and column (Markowitz 1957), so that the straight-line
elimination stays sparse; rows without a pivot are redundant.

The rank at several configurations is the highest one at configurations from which the mechanism can move, since a lower rank is met
only in passing. Configurations at which nothing can move belong to another assembly and count only if there are no others.

Constraint embedding gives u_D and u̇_D in the independent speeds, and the equations of motion reduced to these. With the
dependent speeds u_D of a partition, A_D u_D + A_I u_I + A_a u_a + b = 0 gives

    u_D = A_n u_I + A_na u_a + b_n          A_n = −A_D⁻¹ A_I,   A_na = −A_D⁻¹ A_a,   b_n = −A_D⁻¹ b
    u̇_D = A_n u̇_I + c_D                     c_D = −A_D⁻¹ (Ȧ u + ḃ)

Each generalized force becomes F̃_r = F_r + Σ_D A_n[D, r] F_D (Kane & Levinson 1985, sec. 4.4). With u̇ = B u̇_I + c, B = [1; A_n],

    (BᵀMB) u̇_I = Bᵀ(f − M c) + BᵀG R

The auxiliary equations are formed with the total partial velocities: (M_a + A_naᵀ M_D) u̇ = f_a + A_naᵀ f_D + (G_a + A_naᵀ G_D) R.

`watch` makes expressions that tell, at a state on the constraints, whether rows A_R left out as redundant follow from the others:
A_R,I + A_R,D A_n must vanish beside the sizes of its terms and of the row at other configurations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, reduce
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from kane.dynamics.constraints.manifold import Configurations, Manifold, configurations
from kane.dynamics.forcing import Blocks
from kane.dynamics.lazy import read
from kane.errors import ModelError
from kane.expr.build import NODE_BUILDERS, add, div, mul, where
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr, constant
from kane.expr.regular import Guards, Sizes, guarding, guards, guards_by_parts, largest, size
from kane.expr.square_system import Divisor, SquareSolver, square
from kane.expr.symbols import Speed, Symbol
from kane.kinematics.velocities import Following
from kane.kinematics.velocity_constraints import ConstraintRows
from kane.model.constraints import Constraint
from kane.model.system import System
from kane.numeric.arrays import Array, Indices, Mask, median
from kane.numeric.rank import balanced
from kane.numeric.scale import BETTER, CLOSED_NEARLY, DERIVE_RANK, NEAR_SINGULAR, PIVOT, POOR


@dataclass(frozen=True, slots=True)
class Partition:
    """The pivots of the elimination: row `rows[k]` is solved for speed `dependent[k]`, in this order; `redundant` rows have none."""

    rows: tuple[int, ...]
    dependent: tuple[int, ...]
    redundant: tuple[int, ...]

    def independent(self, count: int) -> tuple[int, ...]:
        """The indices of the independent speeds among `count` speeds."""
        dependent = set(self.dependent)
        return tuple(i for i in range(count) if i not in dependent)

    def first(self, count: int) -> Partition:
        """The partition with the first `count` pivots; all other rows are redundant."""
        return Partition(
            self.rows[:count], self.dependent[:count], tuple(sorted((*self.rows[count:], *self.redundant)))
        )


def choose(
    a: Array, preferred: Sequence[int] = (), *, easy: Mask | None = None, reach: Array | None = None
) -> Partition:
    """Partition of A u + b = 0 by elimination at the numbers `a` (m × n).

    Parameters
    ----------
    a : the matrix at a configuration that satisfies the constraints
    preferred : speeds to be made dependent first
    easy : where entries are numbers, which are the cheapest pivots
    reach : sizes that the entries have had, if they are known
    """
    return choose_each(np.asarray(a, dtype=float)[None], preferred, easy=easy, reach=reach)[0]


def choose_each(
    a: Array, preferred: Sequence[int] = (), *, easy: Mask | None = None, reach: Array | None = None
) -> list[Partition]:
    """`choose` at each of several matrices (k × m × n), which are eliminated side by side."""
    count, m, n = a.shape
    order = np.array([*preferred, *(c for c in range(n) if c not in set(preferred))], dtype=int)
    work = balanced(a, reach)[:, :, order]
    easily = np.zeros((m, n), dtype=bool) if easy is None else np.asarray(easy)[:, order]
    cheap, full = np.tile(easily, (count, 1, 1)), np.abs(work) > DERIVE_RANK
    first = np.arange(n) < len(preferred)
    open_rows, open_columns = np.ones((count, m), dtype=bool), np.ones((count, n), dtype=bool)
    each, going = np.arange(count), np.ones(count, dtype=bool)
    rows: list[list[int]] = [[] for _ in range(count)]
    columns: list[list[int]] = [[] for _ in range(count)]
    for _ in range(min(m, n)):
        asked = open_columns & first
        sizes = np.abs(work) * open_rows[:, :, None]
        # preferred columns while they have pivots, then any column
        given = (sizes.max(axis=1, initial=0) > DERIVE_RANK) & asked
        wanted = np.where(given.any(axis=1)[:, None], asked, open_columns)
        going &= (sizes * wanted[:, None, :]).max(axis=(1, 2), initial=0) > DERIVE_RANK
        if not going.any():
            break
        r, c = _pivots(sizes, full, cheap, open_rows[:, :, None] & wanted[:, None, :])
        for k in np.flatnonzero(going).tolist():
            rows[k].append(int(r[k]))
            columns[k].append(int(order[c[k]]))
        open_rows[each[going], r[going]] = False
        open_columns[each[going], c[going]] = False
        _eliminate(work, full, cheap, open_rows & going[:, None], r, c)
    left = [tuple(sorted(set(range(m)) - set(taken))) for taken in rows]
    return [Partition(tuple(i), tuple(j), rest) for i, j, rest in zip(rows, columns, left, strict=True)]


def _pivots(sizes: Array, full: Mask, cheap: Mask, among: Mask) -> tuple[Indices, Indices]:
    """Row and column of each matrix's next pivot: the large entry of `among` with the sparsest row and column."""
    count, _, n = sizes.shape
    sizes, full = np.where(among, sizes, 0.0), full & among
    largest = sizes.max(axis=(1, 2), keepdims=True, initial=0)
    largest[largest <= 0] = 1.0
    across = (full.sum(axis=2, keepdims=True) - 1) * (full.sum(axis=1, keepdims=True) - 1)
    # sizes that differ only by rounding are ties, decided by order
    cost = np.where(among & (sizes >= PIVOT * largest), across + 0.5 * ~cheap, np.inf)
    place = (cost - 1e-3 * np.round(sizes / largest, 6)).reshape(count, -1).argmin(axis=1)
    return place // n, place % n


def _eliminate(work: Array, full: Mask, cheap: Mask, others: Mask, r: Indices, c: Indices) -> None:
    """Eliminates column c of each matrix by the pivot (r, c) from the rows `others`, in place; updates the masks of structure."""
    each = np.arange(len(work))
    top, column = work[each, r], work[each, :, c]
    pivot = np.where(top[each, c] == 0, 1.0, top[each, c])
    factors = np.where(others, column / pivot[:, None], 0.0)
    touched = (factors != 0)[:, :, None]
    work -= np.where(touched, factors[:, :, None] * top[:, None, :], 0.0)
    filled = touched & full[each, :, c][:, :, None] & full[each, r][:, None, :]  # not what rounding leaves of zero
    full |= filled
    cheap &= ~filled
    changed, rows = np.nonzero(touched[:, :, 0])
    work[changed, rows, c[changed]] = 0.0


def quality(a: Array, partition: Partition, reach: Array | None = None) -> float:
    """How well conditioned the dependent block of A (m × n) is, after balancing: from 0, singular, to 1.

    The smaller of its reciprocal condition number and the ratio of its largest entry to that of its rows.
    """
    return float(qualities(a[None], partition, reach)[0])


def qualities(a: Array, partition: Partition, reach: Array | None = None) -> Array:
    """The `quality` at each of several matrices (k × m × n)."""
    return np.asarray(qualities_of(balanced(a, reach), [partition])[0])


def qualities_of(scaled: Array, partitions: Sequence[Partition]) -> Array:
    """The `quality` of each of several partitions at each of several balanced matrices (k × m × n): partitions × k."""
    result = np.ones((len(partitions), len(scaled)))
    alike: dict[int, list[int]] = {}
    for i, p in enumerate(partitions):
        alike.setdefault(len(p.dependent), []).append(i)
    for d, places in alike.items():
        if not d or not len(scaled):
            continue
        rows = np.array([partitions[i].rows for i in places])
        columns = np.array([partitions[i].dependent for i in places])
        block = scaled[:, rows[:, :, None], columns[:, None, :]]  # k × partitions × d × d
        values = np.linalg.svd(block, compute_uv=False)
        with np.errstate(invalid="ignore", divide="ignore"):
            share = np.abs(block).max(axis=(2, 3)) / np.abs(scaled).max(axis=2)[:, rows].max(axis=2)
            least = np.minimum(values[..., -1] / values[..., 0], share)
            result[places] = np.where(least > 0, least, 0.0).T
    return result


_SHARE = 0.25
"""Share of the configurations at which dependent speeds may be poorly determined, as every choice is at some configuration."""
_ROUNDS, _EXCHANGES = 6, 8
"""The number of rounds of exchanges, and of exchanges tried in each."""
_FEW = 10_000
"""The number of entries up to which all matrices are eliminated together at once, which takes little longer than one."""

Merit = tuple[int, int, float]


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """Configurations on the constraints, with A (count × m × n) and its rank (count) at each."""

    at: Configurations
    a: Array
    ranks: Array

    def reach(self, conditions: Manifold) -> Array:
        """The size of the terms of each configuration constraint (m), 1 if it has none.

        The larger of the terms themselves, with sines and cosines as 1, and of |∂f/∂q| |q|, with Euler parameters as 1.
        """
        at, memo = self.at, dict[Expr, tuple[Expr, ...]]()
        unit = {e for s in conditions.system.euler_parameters for e in s.coordinates}
        q = np.array(
            [np.broadcast_to(1.0 if c in unit else at.values[c], at.count) for c in conditions.system.coordinates]
        ).T
        own = np.abs(at.matrices(Matrix.column([size(f, memo) for f in conditions.f])))[:, :, 0]
        moved = (np.abs(at.matrices(conditions.gradient)) @ np.abs(q)[:, :, None])[:, :, 0]
        found = np.maximum(own, moved).max(axis=0, initial=0)
        return np.asarray(np.where(found > 0, found, 1.0))

    def of_rank(self, rank: int) -> Compared:
        """The configurations at which A has this rank."""
        kept = np.flatnonzero(self.ranks == rank)
        return Compared(self.at.only(kept), self.a[kept], self.ranks[kept])

    def and_those_of(self, other: Compared) -> Compared:
        """These configurations, then those of `other`."""
        a, found = np.concatenate([self.a, other.a]), np.concatenate([self.ranks, other.ranks])
        return Compared(self.at.and_those_of(other.at), a, found)


def compared(
    system: System, rows: ConstraintRows, near: Mapping[Symbol, float] | None, conditions: Manifold | None = None
) -> Compared:
    """Configurations on the constraints (`conditions`) at which A has the rank of the motion.

    If ranks differ, more configurations are sampled around one of each rank. ModelError if A is finite at none.
    """

    def at(place: Mapping[Symbol, float] | None) -> Compared:
        found = configurations(system, [*rows.a.entries, *rows.a_auxiliary.entries], place, conditions=conditions)
        a = found.matrices(rows.a)
        usable = np.flatnonzero(np.isfinite(a).all(axis=(1, 2)))
        return Compared(found.only(usable), a[usable], ranks(a[usable]))

    first = at(near)
    if not len(first.ranks):
        raise ModelError(
            "Expected constraints that are finite where their configuration constraints hold, got infinity or NaN: coordinates or "
            "parameters' defaults are singular there."
        )
    # the rank at special configurations, where motions begin, counts only if it is higher than elsewhere
    usual = first.ranks[~first.at.special]
    every = sorted({*usual.tolist(), max(first.ranks.tolist())}, reverse=True)
    if len(every) == 1 or near or first.at.missed:
        return first.of_rank(every[0])
    around = [at(first.of_rank(r).at.at(0)) for r in every]
    # the rank of a branch is that beside the configuration, which may itself be singular
    beside = [round(median(x.ranks[1:] if len(x.ranks) > 1 else x.ranks)) for x in around]
    moving = [r for r, x in zip(beside, around, strict=True) if len(x.ranks) > 1 and r < len(system.speeds)]
    rank = max(moving or beside)
    for r, x in zip(beside, around, strict=True):
        if r == rank:
            first = first.and_those_of(x)
    return first.of_rank(rank)


def ranks(a: Array) -> Array:
    """The rank of each of several matrices (k × m × n)."""
    if not a.size:
        return np.zeros(len(a), dtype=int)
    values = np.linalg.svd(balanced(a), compute_uv=False)
    return np.asarray((values > DERIVE_RANK * values[:, :1]).sum(axis=1))


def chosen(a: Array, special: Mask, preferred: Sequence[int], easy: Mask) -> Partition:
    """The partition at the first of several matrices (k × m × n) of one rank, or another one that is much better at all of them.

    The others are the partitions at each matrix, and the best of these improved by exchanges of one speed. `preferred` speeds come
    before quality, see `choose`; dependent speeds must be well determined at `special` matrices (k), and at most of the others.
    Of the special ones the first, where all is zero and motions begin, comes before those beyond it.
    """
    scaled = balanced(a)
    first_special = np.flatnonzero(special)[:1]

    def merits(partitions: Sequence[Partition]) -> list[Merit]:
        """Minus the preferred speeds left out, minus the near-singular configurations, at zero first, and the quality."""
        found = qualities_of(scaled, partitions)
        usual = _quantile(found, _SHARE)
        poor = (found < NEAR_SINGULAR).sum(axis=1)
        least = np.minimum(usual, found[:, special].min(axis=1, initial=1.0))
        every = len(preferred) + 1
        absent = [len(set(preferred) - set(p.dependent)) for p in partitions]
        at_zero = len(a) * (found[:, first_special] < NEAR_SINGULAR).sum(axis=1)
        scores = zip(absent, poor.tolist(), (poor + at_zero).tolist(), least.tolist(), strict=True)
        return [(-gone if bad < len(a) else -every, -weight, good) for gone, bad, weight, good in scores]

    together = a if a.size <= _FEW else a[:1]
    first, *others = choose_each(together, preferred, easy=easy)
    (best,) = merits([first])
    if best[:2] == (0, 0) and best[2] >= POOR:
        return first
    others = list(dict.fromkeys(others or choose_each(a[1:], preferred, easy=easy)))
    found, least = _best(first, (best[0], best[1], BETTER * best[2]), others, merits)
    for _ in range(_ROUNDS):
        before = found
        found, least = _best(found, least, exchanged(scaled, found), merits)
        if found is before:
            break
    if found.dependent == first.dependent:
        return first
    # take the order of elimination of the matrix at which the quality is highest
    again = choose(a[int(np.argmax(qualities_of(scaled, [found])))], found.dependent, easy=easy)
    return again if set(again.dependent) == set(found.dependent) else found


def _quantile(values: Array, share: float) -> Array:
    """The quantile of each row by linear interpolation; np.quantile takes ten times as long for a few numbers."""
    ordered, place = np.sort(values, axis=1), share * (values.shape[1] - 1)
    low = int(place)
    high = min(low + 1, values.shape[1] - 1)
    return np.asarray(ordered[:, low] + (place - low) * (ordered[:, high] - ordered[:, low]))


def _best(
    found: Partition, least: Merit, others: Sequence[Partition], merits: Callable[[Sequence[Partition]], list[Merit]]
) -> tuple[Partition, Merit]:
    """The first of the best `others` and its merit, if that exceeds `least`, else `found` and `least`."""
    scores = merits(others) if others else []
    highest = max(scores, default=least)
    return (others[scores.index(highest)], highest) if highest > least else (found, least)


def exchanged(scaled: Array, partition: Partition) -> list[Partition]:
    """The `_EXCHANGES` partitions with one dependent speed exchanged whose least |det A_D| over balanced matrices is largest.

    Exchanging u_i for u_j multiplies det A_D by the entry (i, j) of A_D⁻¹ A.
    """
    rows = scaled[:, list(partition.rows)]
    free = partition.independent(scaled.shape[2])
    dependent = partition.dependent
    if not dependent or not free:
        return []
    left, values, right = np.linalg.svd(rows[:, :, list(dependent)])
    values = np.maximum(values, NEAR_SINGULAR**2)
    ratios = np.swapaxes(right, 1, 2) @ ((np.swapaxes(left, 1, 2) @ rows[:, :, list(free)]) / values[:, :, None])
    with np.errstate(divide="ignore"):
        least = (np.log(np.abs(ratios)) + np.log(values).sum(axis=1)[:, None, None]).min(axis=0)
    places = np.unravel_index(np.argsort(-least, axis=None)[:_EXCHANGES], least.shape)
    return [
        Partition(partition.rows, (*dependent[:i], free[j], *dependent[i + 1 :]), partition.redundant)
        for i, j in zip(*places, strict=True)
    ]


class DependentSpeeds(NamedTuple):
    """A_n (d × i), A_na (d × a), b_n and c_D (d), the divisors, and the sizes of these and of their factors."""

    a_n: Matrix
    a_na: Matrix
    b_n: tuple[Expr, ...]
    c: Callable[[], tuple[Expr, ...]]
    divisors: tuple[Divisor, ...] = ()
    guards: Guards = MappingProxyType({})

    def guarded(self, by: Guards) -> DependentSpeeds:
        """The same expressions, NaN where a divisor vanishes."""
        guard = guarding({**by, **self.guards})
        return self._replace(
            a_n=self.a_n.map(guard),
            a_na=self.a_na.map(guard),
            b_n=tuple(map(guard, self.b_n)),
            c=lambda: tuple(map(guard, self.c())),
        )


@dataclass(frozen=True, eq=False)
class Embedding:
    """The dependent speeds in the independent ones, solved for when first read.

    `beside` are the sizes of further divisors of results. Solutions are guarded last, after all cancellation.
    """

    rows: ConstraintRows
    partition: Partition
    independent: tuple[int, ...]
    solve: Callable[[], DependentSpeeds]
    beside: Guards = field(default_factory=dict)

    solution = read[DependentSpeeds](lambda e: e.solve(), "The solution for the dependent speeds and their rates.")
    a_n = read[Matrix](lambda e: e.solution.a_n, "A_n of u_D = A_n u_I + A_na u_a + b_n.")
    a_na = read[Matrix](lambda e: e.solution.a_na, "A_na of u_D = A_n u_I + A_na u_a + b_n.")
    b_n = read[tuple[Expr, ...]](lambda e: e.solution.b_n, "b_n of u_D = A_n u_I + A_na u_a + b_n.")
    c = read[tuple[Expr, ...]](lambda e: e.solution.c(), "c_D of u̇_D = A_n u̇_I + c_D.")
    divisors = read[tuple[Divisor, ...]](lambda e: e.solution.divisors, "The solver of the constraints.")
    guards = read[Guards](
        lambda e: {**e.beside, **e.solution.guards},
        "The sizes of the divisors, of their factors, and of other divisors of the results.",
    )

    @property
    def guards_in_use(self) -> Guards:
        """The guards of divisors; those of the solution only if it has been read."""
        return self.guards if "solution" in self.__dict__ else self.beside

    transposed = read[SquareSolver](
        lambda e: square(e.rows.a.take(e.partition.rows, e.partition.dependent).T.rows),
        "The solver with A_Dᵀ, separate because its expressions differ wherever a factor is a quotient.",
    )

    def multipliers(self, residual: Sequence[Expr]) -> tuple[Expr, ...]:
        """λ by constraint, from A_Dᵀ λ = (M u̇ − f)_D, the `residual` of the dependent speeds; zero for redundant rows."""
        solution, divisors = self.transposed.solve(residual), self.transposed.divisors
        own = guards([(d.value, d.size) for d in divisors], [*self.rows.a.entries, *residual], solution)
        values = dict(zip(self.partition.rows, map(guarding(own | dict(self.guards)), solution), strict=True))
        return tuple(values.get(r, ZERO) for r in range(len(self.rows.constraints)))

    def following(self, speeds: Sequence[Speed]) -> dict[Expr, Following]:
        """The dependent speeds as functions of the independent ones."""
        own = [speeds[i] for i in self.independent]
        rows: list[dict[Expr, Expr]] = [
            {u: c for u, c in zip(own, row, strict=True) if c is not ZERO} for row in self.a_n.rows
        ]
        places = [speeds[d] for d in self.partition.dependent]
        parts = zip(places, rows, self.b_n, self.c, strict=True)
        return {u: Following(row, rest, bias) for u, row, rest, bias in parts}

    def every(self, u_dot: Sequence[Expr]) -> tuple[Expr, ...]:
        """u̇ = B u̇_I + c."""
        values = dict(zip(self.independent, u_dot, strict=True))
        dependent = self.a_n @ Matrix.column(u_dot) + Matrix.column(self.c)
        values.update(zip(self.partition.dependent, dependent.entries, strict=True))
        return tuple(values[i] for i in range(len(values)))

    def transposed_times(self, m: Matrix) -> Matrix:
        """Bᵀ m."""
        return m.take(self.independent) + self.a_n.T @ m.take(self.partition.dependent)

    def reduced(self, blocks: Blocks) -> Blocks:
        """M, f and G of the independent speeds, BᵀMB, Bᵀ(f − M c) and BᵀG, and those of auxiliary speeds in u̇_I."""
        dependent, a_na_t, c = self.partition.dependent, self.a_na.T, Matrix.column(self.c)

        def times_b(m: Matrix) -> Matrix:
            return m.take(columns=self.independent) + m.take(columns=dependent) @ self.a_n

        def total(m_a: Matrix, m: Matrix) -> Matrix:
            return m_a + a_na_t @ m.take(dependent)

        spread = times_b(blocks.mass)
        forcing = Matrix.column(blocks.forcing)
        left = forcing - blocks.mass.take(columns=dependent) @ c
        left_a = Matrix.column(blocks.forcing_a) - blocks.mass_a.take(columns=dependent) @ c
        if any(x is not ZERO for x in self.a_na.entries):
            right = self.transposed_times(left)
        else:
            right = self.transposed_times(forcing) - spread.take(dependent).T @ c
        return Blocks(
            self.transposed_times(spread).mirrored(),
            right.entries,
            self.transposed_times(blocks.coupling),
            total(times_b(blocks.mass_a), spread),
            total(left_a, left).entries,
            total(blocks.coupling_a, blocks.coupling),
            blocks.evident,
        )

    def watching(self, beside: Guards) -> Embedding:
        """The embedding with the sizes of further divisors."""
        return replace(self, solve=lambda: self.solution, beside=beside)

    def guarded(self) -> Embedding:
        """The same expressions, NaN where a divisor vanishes."""
        return replace(self, solve=lambda: self.solution.guarded(self.beside))


def embedding(rows: ConstraintRows, partition: Partition) -> Embedding:
    """The embedding of constraints with the dependent speeds of `partition`."""
    free = partition.independent(rows.a.shape[1])
    return Embedding(rows, partition, free, lambda: _solution(rows, partition, free))


def _solution(rows: ConstraintRows, partition: Partition, free: Sequence[int]) -> DependentSpeeds:
    memo: Sizes = {}
    whole = rows.a.take(partition.rows).rows
    solver = square(
        rows.a.take(partition.rows, partition.dependent).rows, lambda i: largest(size(x, memo) for x in whole[i])
    )

    def negative_solution(right: Matrix) -> Matrix:
        columns = (-right.take(partition.rows)).T
        return Matrix([solver.solve(b) for b in columns], columns.shape).T

    @cache
    def c() -> tuple[Expr, ...]:
        return negative_solution(Matrix.column(rows.drift)).entries

    inputs = (rows.a.take(columns=free), rows.a_auxiliary, Matrix.column(rows.b))
    a_n, a_na, b_n = map(negative_solution, inputs)

    before = (lambda: (x for m in (rows.a, *inputs) for x in m.entries), lambda: rows.drift)
    after = (lambda: (x for m in (a_n, a_na, b_n) for x in m.entries), c)
    sizes = guards_by_parts([(d.value, d.size) for d in solver.divisors], before, after)
    return DependentSpeeds(a_n, a_na, b_n.entries, c, solver.divisors, sizes)


_HOLDS = 1e-2
"""Share above which a row holds more: beside a place where branches meet it is the root of what a closed state may leave open."""


class RedundantRow(NamedTuple):
    """A redundant row: the largest entry of A_R,I + A_R,D A_n (`beyond`), and the `limit` below which the row follows."""

    constraint: Constraint
    beyond: Expr
    limit: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Watch:
    """The redundant rows, and the residual `open` of the configuration constraints, scaled to be below 1 if they are closed."""

    rows: tuple[RedundantRow, ...]
    open: Expr

    def guarding(self) -> tuple[Callable[[Expr], Expr], dict[Expr, Constraint]]:
        """A function that makes an expression NaN where a row does not follow, and the guard, 1 or NaN, of each row."""
        less = NODE_BUILDERS["less"]
        off = where(less(self.open, ONE), ZERO, ONE)
        follow = [where(less(r.limit, r.beyond), off, ONE) for r in self.rows]
        guards = [NODE_BUILDERS["regular"](x, ONE) for x in follow]
        lost = guards[-1]
        for x, guard in zip(follow[-2::-1], guards[-2::-1], strict=True):
            lost = where(less(ZERO, x), lost, guard)
        all_follow = less(ZERO, reduce(NODE_BUILDERS["min"], follow))
        names = dict(zip(guards, (r.constraint for r in self.rows), strict=True))
        return lambda value: where(all_follow, value, lost), names


def watch(embedding: Embedding, compared: Compared, conditions: Manifold) -> Watch | None:
    """The watch of the redundant rows of `embedding`, with sizes from the `compared` configurations; None if there are no rows."""
    rows, redundant = embedding.rows, embedding.partition.redundant
    if not redundant:
        return None
    own = rows.a.take(redundant, embedding.independent)
    by_dependent = rows.a.take(redundant, embedding.partition.dependent)
    usual = np.abs(compared.a[:, list(redundant)]).max(axis=(0, 2), initial=0)
    found, absolute = [], NODE_BUILDERS["abs"]
    for k, r in enumerate(redundant):
        sizes = list(map(absolute, by_dependent.rows[k]))
        pairs = list(zip(own.rows[k], embedding.a_n.T, strict=True))
        beyond = largest(add(x, dot(by_dependent.rows[k], column)) for x, column in pairs)
        terms = largest(add(absolute(x), dot(sizes, list(map(absolute, column)))) for x, column in pairs)
        limit = mul(constant(_HOLDS), largest([terms, constant(float(usual[k]))]))
        found.append(RedundantRow(rows.constraints[r], beyond, limit))
    reach = compared.reach(conditions)
    off = largest(div(f, constant(float(CLOSED_NEARLY * r))) for f, r in zip(conditions.f, reach, strict=True) if r > 0)
    return Watch(tuple(found), off)
