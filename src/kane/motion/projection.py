# SPDX-License-Identifier: BSD-3-Clause
"""The constraints along a motion: projection onto them with the least change in the mass metric, what they miss, and loss of rank.

With the metric ½ δᵀM δ, displacements Δq = W δ and changes of the speeds Δu are

    δ  = −M⁻¹A_cᵀ (A_c M⁻¹ A_cᵀ)⁺ f          f the configuration constraints, A_c their rows of A
    Δu = −M⁻¹Aᵀ (A M⁻¹ Aᵀ)⁺ (A u + b)

with pseudo-inverses, so that redundant constraints do no harm. Euler parameters are divided by their length.

No projection closes constraints that contradict each other, or that lost rank and hold again: `missed`. A residual counts where it is
more than the tolerances leave open: those of coordinates and speeds, times the largest slopes that the constraint has had, and their
relative one of the terms that it is made of.

A singular value of A that is small at a state and ten times as large where A has changed by a tenth of its size vanishes nearby: the
motion comes through a position at which rank drops. One that is as small there belongs to constraints that are nearly the same by
nature, such as those of a reducer of 10,000 : 1; what it holds must be held: `mixes`.

A step may lead across a state at which rank is lost, or at which the dependent speeds that are stepped do not follow: `crosses`. Its
ends do not tell: a step may be turns long, and where two rows are lost at once their determinant keeps its sign. So A is looked at
between them, closer where it moves far or where its rank may vanish: the least singular value σ changes by no more than A does,

    σ = 0 between two states only if σ₁ + σ₂ ≤ ‖A₂ − A₁‖
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from kane.dynamics.constraints.manifold import branch_scalars, branches, turned, turned_closures
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.readings.unsolved import mass_matrix
from kane.equations.compiled import Numeric, ports
from kane.equations.equations import Equations
from kane.expr.build import mul
from kane.expr.evaluation import evaluate
from kane.expr.matrix import Matrix
from kane.expr.node import Expr
from kane.expr.regular import Sizes, largest, size
from kane.model.constraints import ClosureBranch
from kane.numeric.arrays import Array, Indices, Mask
from kane.numeric.newton import improved
from kane.numeric.rank import (
    Mixed,
    balance,
    combinations,
    least_change,
    mixed,
    of_unit_length,
    row_sizes,
    singular,
    weak_values,
)
from kane.numeric.scale import CLOSED, CLOSED_FULLY, MOTION_RANK, ROUNDED
from kane.program.from_expressions import Bundle
from kane.program.native.compiled_routine import BundleRoutine

Mixes = tuple[Mixed | None, Mixed | None]

_ROUNDS = 6


@dataclass(frozen=True, slots=True)
class Numbers:
    """f (configuration) and the sizes of its `terms`, A, b, M and W at a state.

    `speeds` are the speeds themselves where they follow from the independent ones alone, `branch` what tells branches apart.
    """

    f: Array
    terms: Array
    a: Array
    b: Array
    m: Array
    w: Array
    speeds: Array
    branch: Array

    @property
    def finite(self) -> bool:
        """Whether the constraints can be kept there: all numbers are finite, and no speed alone has a negative kinetic energy."""
        inertia = np.diag(self.m)
        heavy = np.all(inertia >= -ROUNDED * inertia.max(initial=0))
        return bool(heavy) and all(np.all(np.isfinite(v)) for v in (self.f, self.a, self.b, self.m))


def constraint_numbers(eom: Equations) -> Bundle[Numbers]:
    """What keeps a state on the constraints."""
    solved = eom.solved
    f, d = [c.expr for c in eom.system.holonomic], solved.regular

    def written(m: Matrix) -> Matrix:
        return Matrix([solved.written(row) for row in m], m.shape)

    speeds = solved.speeds_by_independent if solved.twin else ()
    scalars = branch_scalars(branches(eom.system))
    memo = Sizes()
    groups = {
        "f": f,
        "terms": [size(x, memo) for x in f],
        "a": d.A,
        "b": d.b,
        "m": mass_matrix(solved) if solved.twin is None else written(d.mass_matrix),
        "w": written(d.W),
        "speeds": speeds,
        "branch": scalars,
    }
    return Bundle("constraints", ports(eom.derived), Numbers, groups)


@dataclass(frozen=True, slots=True, eq=False)
class ConstraintProjection:
    """The constraints of equations of motion: their numbers as one routine, where Euler parameters are, what branches are meant."""

    numbers: BundleRoutine[Numbers]
    coordinates: int
    euler: tuple[tuple[int, ...], ...]
    meant: tuple[ClosureBranch, ...] = ()

    def turned(self, numbers: Numbers) -> str:
        """Which closures are turned away from the branch that they mean, in words; "" where none is."""
        return turned_closures(self.meant, turned(self.meant, numbers.branch)) if self.meant else ""

    def project(
        self, t: float, x: Array, p: Array, r: Array, reach: Array | float = 0.0, mixes: Mixes = (None, None)
    ) -> tuple[Array, Numbers]:
        """The state moved onto the constraints, and the numbers there; `reach` holds the sizes that entries of A have had.

        `mixes` are what counts in the places of the rows of the configuration constraints, and in those of all.
        """
        nq = self.coordinates
        x = of_unit_length(x, self.euler)
        now = self.numbers(t, x, p, r)
        if not now.finite:
            return x, now
        reach = np.maximum(reach, np.abs(now.a))
        c, n = len(now.f), len(now.m)
        size = row_sizes(now.m, reach[:c])
        limit = CLOSED_FULLY * (now.terms / size).max(initial=0)

        def closer(at: tuple[Array, Numbers]) -> tuple[Array, Numbers]:
            x, now = at
            shift = now.w[:, :n] @ least_change(now.m, now.a[:c], -now.f, reach[:c], mixes[0])
            x = of_unit_length(np.append(x[:nq] + shift, x[nq:]), self.euler)
            return x, self.numbers(t, x, p, r)

        x, now = improved((x, now), lambda at: np.abs(at[1].f / size).max(initial=0), closer, limit, _ROUNDS)
        if len(now.speeds):
            x = np.concatenate([x[:nq], now.speeds, x[nq + n :]])
        elif len(now.b):
            u = x[nq : nq + n]
            change = least_change(now.m, now.a, -(now.a @ u + now.b), reach, mixes[1])
            x = np.concatenate([x[:nq], u + change, x[nq + n :]])
        return x, now


def is_constrained(eom: Equations) -> bool:
    """Whether there is anything to keep: constraints, or the length of Euler parameters."""
    return bool(eom.constraints.constraints or eom.system.euler_parameters)


def constraint_projection(numeric: Numeric[Equations]) -> ConstraintProjection | None:
    """The constraints of the equations, None where there is nothing to keep."""
    eom = numeric.equations
    if not is_constrained(eom):
        return None
    place = {c: i for i, c in enumerate(eom.coordinates)}
    euler = tuple(tuple(place[e] for e in s.coordinates) for s in eom.system.euler_parameters)
    return ConstraintProjection(numeric.routine(constraint_numbers), len(place), euler, branches(eom.system))


_SLACK = 10.0
"""Tolerances that a residual may measure: one step leaves about one."""
_TINY = np.finfo(float).tiny
_ANY = 1 / _TINY**0.5
"""A change of a speed that moves no coordinate, in any unit."""

Tolerances = tuple[float, float]
"""Relative and absolute."""


def missed(
    eom: Equations,
    numbers: Numbers,
    x: Array,
    reach: Array,
    tolerances: Tolerances,
    values: Callable[[], Mapping[Expr, Any]],
) -> str:
    """The constraint that is missed most at x = (q, u, a), and by how much, in words; "" where all hold.

    `reach` (m × n) holds the sizes that entries of A have had, `values` gives a number for every symbol.
    """
    with np.errstate(invalid="ignore"):  # of numbers that are not finite nothing is said here
        residual, slopes = _residuals(numbers, x, reach, tolerances)
    over = np.abs(residual) > slopes
    if not over.any():
        return ""
    terms = np.array(evaluate(_terms(eom, len(residual)), values()), dtype=float)
    limit = slopes + max(_SLACK * tolerances[0], CLOSED) * terms
    off = np.abs(residual) / np.maximum(limit, _TINY)
    worst = int(np.argmax(np.where(np.isfinite(off), off, 0.0)))
    if not off[worst] > 1:
        return ""
    return f"{eom.derived.constraints.constraints[worst].name!r} is missed by {abs(residual[worst]):.3g}"


def _residuals(numbers: Numbers, x: Array, reach: Array, tolerances: Tolerances) -> tuple[Array, Array]:
    """f of configuration constraints, A u + b of motion constraints, and what the tolerances of q and u make of them.

    Rates of configuration constraints are left out: near a position at which rank drops rounding makes much of them, and f tells soon.
    """
    rtol, atol = tolerances
    open_ = _SLACK * (atol + rtol * np.abs(x))
    c, n = len(numbers.f), len(numbers.m)
    nq = len(numbers.w)
    # the change in each speed's direction that leaves every coordinate within its tolerance
    pace, most = np.abs(numbers.w[:, :n]), open_[:nq, None]
    along = np.divide(most, pace, out=np.full(pace.shape, _ANY), where=pace > most / _ANY)
    slopes = reach[:c] @ along.min(axis=0, initial=_ANY)
    if len(numbers.speeds):
        return numbers.f, slopes
    rates = numbers.a[c:] @ x[nq : nq + n] + numbers.b[c:]
    return np.concatenate([numbers.f, rates]), np.concatenate([slopes, reach[c:] @ open_[nq : nq + n]])


def _terms(eom: Equations, count: int) -> list[Expr]:
    """The sizes of the terms of f, and of those of A u + b of motion constraints, sines and cosines taken as 1."""
    rows, memo = eom.derived.constraints, Sizes()
    sizes = [size(k.expr, memo) for k in eom.system.holonomic]
    for a, b in list(zip(rows.a, rows.b, strict=True))[len(sizes) :]:
        sizes.append(largest([*(mul(size(x, memo), u) for x, u in zip(a, eom.speeds, strict=True)), size(b, memo)]))
    return sizes[:count]


_NEARBY = (0.03, 0.3)
"""Share of its size by which A must have changed at a place that tells what is small here alone."""
_FACTOR = 4.0
_TRIES = 60
_GROWS = 10.0
"""By how much a singular value that vanishes nearby must have grown there."""

Place = Callable[[Array], Numbers]


def mixes(
    projection: ConstraintProjection, t: float, x: Array, given: tuple[Array, Array], numbers: Numbers, reach: Array
) -> Mixes:
    """What counts in the places of the rows of A, of the configuration constraints and of all, at a state x of values p and r `given`.

    None for rows that count as they are: no singular value is small, or what is small vanishes here.
    """
    nq = projection.coordinates

    def beside(change: Array) -> Numbers:
        return projection.project(t, np.append(x[:nq] + change, x[nq:]), *given, reach)[1]

    def mix(count: int) -> Mixed | None:
        a = numbers.a[:count]
        values = combinations(a, reach[:count])[1] if count else np.zeros(0)
        weak = weak_values(values)
        return mixed(a, reach[:count]) if weak.any() and not _vanishes(numbers, reach, beside, count, weak) else None

    return mix(len(numbers.f)), mix(len(numbers.a))


def _vanishes(numbers: Numbers, reach: Array, beside: Place, count: int, weak: Mask) -> bool:
    """Whether a singular value of the first `count` rows, of those that are `weak`, is much larger at some place beside."""
    size = balance(numbers.a[:count], reach[:count], order=(1, 0))
    sizes = size.rows * size.columns
    here = singular(numbers.a[:count] / sizes)
    sure = int(np.flatnonzero(weak)[0])
    for direction in here.right[sure:] / size.columns[0]:
        change = numbers.w[:, : len(direction)] @ direction
        for sign in (1.0, -1.0):
            a = _nearby(beside, sign * change, numbers.a[:count], sizes)
            if a is not None and np.any(singular(a / sizes).values[weak] > _GROWS * here.values[weak]):
                return True
    return False


def _nearby(beside: Place, along: Array, a: Array, sizes: Array) -> Array | None:
    """A where it has changed by a share of its size on the way `along`, None where it does not change."""
    step, factor = 1.0, 0.0
    for _ in range(_TRIES):
        numbers = beside(step * along)
        change = np.abs((numbers.a[: len(a)] - a) / sizes).max() if numbers.finite else np.inf
        if _NEARBY[0] <= change <= _NEARBY[1]:
            return numbers.a[: len(a)]
        wanted = _FACTOR if change < _NEARBY[0] else 1 / _FACTOR
        # between two steps of which one is too short and one too long the halves are tried
        step *= wanted if factor in (0.0, wanted) else wanted**0.5
        factor = wanted
    return None


_FIRST = 8
"""Parts in which a step is looked at first."""
_FAR = 0.25
"""Change of A from one state to the next, its entries being 1 at most, that is looked at closer."""
_CURVED = 1.5
"""What A moves on a curve, over the distance of its ends."""
_DEPTH = 40
_MOST = 4096
"""How often parts are halved, and how many states are looked at, at most."""
_CLEAR = 10 * MOTION_RANK
"""Share of rank above which a state is away from one at which rank is lost."""
_CLOSE = np.geomspace(1e-4, 0.1, 7)
"""Shares of a step after which it is away from such an end."""


class RankHistory(NamedTuple):
    """At several times: A over the sizes that it has had, and its singular value that makes the rank, over the largest too.

    `side` is the sign of the dependent block's determinant, 0 where there is none.
    """

    t: Array
    a: Array
    least: Array
    share: Array
    side: Array

    @property
    def lost(self) -> Mask:
        """Where rank is lost."""
        return np.asarray(self.share < MOTION_RANK)

    def only(self, kept: slice | Indices) -> RankHistory:
        """Some of the times."""
        return RankHistory(*(part[kept] for part in self))

    def and_at(self, other: RankHistory) -> RankHistory:
        """These times and others, in order."""
        together = RankHistory(*map(np.concatenate, zip(self, other, strict=True)))
        return together.only(np.argsort(together.t))


def looked_at(t: Array, a: Array, partition: Partition, reach: Array, mix: Mixed | None = None) -> RankHistory:
    """A (k × m × n) at times t (k), with the dependent speeds that are stepped; `mix` stands in the places of the rows for rank."""
    finite = np.asarray(np.isfinite(a).all(axis=(1, 2)))
    a = np.where(finite[:, None, None], a, 0.0)
    plain = balance(a, reach, order=(1, 0)).matrix
    scaled = plain if mix is None else balance(mix.rows @ a, mix.reach, order=(1, 0)).matrix
    rank = len(partition.rows)
    values = np.linalg.svd(scaled, compute_uv=False)
    block = plain[:, list(partition.rows)][:, :, list(partition.dependent)]
    side = np.where(finite, np.linalg.slogdet(block)[0], 0.0)
    least = np.where(finite, values[:, rank - 1], np.inf)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = least / values[:, 0]
    return RankHistory(t, scaled, least, np.where(share >= 0, share, np.inf), side)


def crosses(along: Callable[[Array], RankHistory], start: float, end: float) -> bool:
    """Whether a step from `start` to `end` leads across such a state; one at which it begins or ends is none."""
    length = end - start
    at = along(np.linspace(start, end, _FIRST + 1))
    at = _away(along, at, start, length)
    for _ in range(_DEPTH):
        if len(at.t) < 2:
            return False
        if at.lost.any() or (at.side[1:] * at.side[:-1] < 0).any():
            return True
        moved = np.sqrt(((at.a[1:] - at.a[:-1]) ** 2).sum(axis=(1, 2)))
        closer = np.flatnonzero((moved > _FAR) | (at.least[1:] + at.least[:-1] <= _CURVED * moved))
        if not len(closer) or len(at.t) > _MOST:
            return False
        at = at.and_at(along((at.t[closer] + at.t[closer + 1]) / 2))
    return False


def _away(along: Callable[[Array], RankHistory], at: RankHistory, start: float, length: float) -> RankHistory:
    """Without the surroundings of an end at which rank is lost."""
    first, last = (bool(at.share[k] < MOTION_RANK) for k in (0, -1))
    close = [*(start + length * _CLOSE if first else ()), *(start + length * (1 - _CLOSE) if last else ())]
    if not close:
        return at
    at = at.and_at(along(np.array(close)))
    clear = np.flatnonzero(at.share > _CLEAR)
    if not len(clear):
        return at.only(slice(0, 0))
    return at.only(slice(clear[0] if first else 0, clear[-1] + 1 if last else len(at.t)))
