# SPDX-License-Identifier: BSD-3-Clause
"""Projection of states onto the constraints with the least change in the mass metric, residuals, and loss of rank along a motion.

With the metric ½ δᵀM δ, displacements Δq = W δ and changes of the speeds Δu are (Hairer & Wanner 1996, sec. VII.2)

    δ  = −M⁻¹A_cᵀ (A_c M⁻¹ A_cᵀ)⁺ f          f the configuration constraints, A_c their rows of A
    Δu = −M⁻¹Aᵀ (A M⁻¹ Aᵀ)⁺ (A u + b)

with pseudo-inverses, so that redundant constraints are admissible. Euler parameters are divided by their length.

Projection cannot satisfy constraints that contradict each other, or that regain rank with a residual left: `missed`. A residual is a
violation if it exceeds what the tolerances allow: those of coordinates and speeds, times the largest derivatives that the constraint
has had along the motion, and the relative tolerance times the terms of the constraint.

A small singular value of A that is ten times as large where A has changed by a tenth of its size vanishes near by: the motion passes
a position at which rank drops. One that stays small belongs to constraints that are nearly dependent everywhere, such as those of a
reducer of 10,000 : 1, and the combination of rows must still be satisfied: `mixes`.

A step may cross a state at which rank is lost, or at which the dependent block of A is singular: `crosses`. The ends of the step do
not show this: it may span several turns, and if two rows are lost at once the determinant keeps its sign. Therefore A is sampled
between them, more densely where it changes much or may lose rank: the least singular value σ changes by no more than A does,

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
    """f of configuration constraints (c) and the sizes of its `terms`, A (m × n), b (m), M (n × n) and W at a state.

    `speeds` are computed from the independent ones if W has false poles, else empty; closure branches differ in the scalars `branch`.
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
        """Whether projection is possible: all numbers are finite, and no diagonal entry of M is negative."""
        inertia = np.diag(self.m)
        heavy = np.all(inertia >= -ROUNDED * inertia.max(initial=0))
        return bool(heavy) and all(np.all(np.isfinite(v)) for v in (self.f, self.a, self.b, self.m))


def constraint_numbers(eom: Equations) -> Bundle[Numbers]:
    """The routine of `Numbers` as functions of the state."""
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
    """The constraints of equations of motion: the routine of `numbers`, indices of Euler parameters, intended closure branches."""

    numbers: BundleRoutine[Numbers]
    coordinates: int
    euler: tuple[tuple[int, ...], ...]
    meant: tuple[ClosureBranch, ...] = ()

    def turned(self, numbers: Numbers) -> str:
        """The closures that are on another branch than the intended one, as text; "" if there are none."""
        return turned_closures(self.meant, turned(self.meant, numbers.branch)) if self.meant else ""

    def project(
        self, t: float, x: Array, p: Array, r: Array, reach: Array | float = 0.0, mixes: Mixes = (None, None)
    ) -> tuple[Array, Numbers]:
        """The state projected onto the constraints, and the numbers there; `reach` are the largest entries of A along the motion.

        `mixes` are combinations that replace the rows of the configuration constraints, and all rows, when rank is decided.
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
    """Whether there are constraints, or Euler parameters, whose length must be 1."""
    return bool(eom.constraints.constraints or eom.system.euler_parameters)


def constraint_projection(numeric: Numeric[Equations]) -> ConstraintProjection | None:
    """The projection of the equations; None without constraints and Euler parameters."""
    eom = numeric.equations
    if not is_constrained(eom):
        return None
    place = {c: i for i, c in enumerate(eom.coordinates)}
    euler = tuple(tuple(place[e] for e in s.coordinates) for s in eom.system.euler_parameters)
    return ConstraintProjection(numeric.routine(constraint_numbers), len(place), euler, branches(eom.system))


_SLACK = 10.0
"""Multiple of the tolerances that a residual may have: one step leaves about one."""
_TINY = np.finfo(float).tiny
_ANY = 1 / _TINY**0.5
"""The admissible change of a speed that changes no coordinate: large in any unit."""

Tolerances = tuple[float, float]
"""Relative and absolute tolerance."""


def missed(
    eom: Equations,
    numbers: Numbers,
    x: Array,
    reach: Array,
    tolerances: Tolerances,
    values: Callable[[], Mapping[Expr, Any]],
) -> str:
    """The constraint that is violated most at x = (q, u, a), and its residual, as text; "" if all are satisfied.

    `reach` (m × n) are the largest entries of A along the motion; `values()` returns a number for every symbol.
    """
    with np.errstate(invalid="ignore"):  # numbers that are not finite are reported elsewhere
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
    return f"{eom.derived.constraints.constraints[worst].name!r} is violated by {abs(residual[worst]):.3g}"


def _residuals(numbers: Numbers, x: Array, reach: Array, tolerances: Tolerances) -> tuple[Array, Array]:
    """f of configuration constraints, A u + b of motion constraints, and limits of both by the tolerances of q and u.

    Time derivatives of configuration constraints are omitted: near a loss of rank they amplify rounding, and f shows violations soon.
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
    """The sizes of the terms of f, and of A u + b of motion constraints, with sines and cosines replaced by 1."""
    rows, memo = eom.derived.constraints, Sizes()
    sizes = [size(k.expr, memo) for k in eom.system.holonomic]
    for a, b in list(zip(rows.a, rows.b, strict=True))[len(sizes) :]:
        sizes.append(largest([*(mul(size(x, memo), u) for x, u in zip(a, eom.speeds, strict=True)), size(b, memo)]))
    return sizes[:count]


_NEARBY = (0.03, 0.3)
"""Relative change of A at a place near by that shows whether a singular value is small only here."""
_FACTOR = 4.0
_TRIES = 60
_GROWS = 10.0
"""Factor by which a singular value that vanishes near by must have grown there."""

Place = Callable[[Array], Numbers]


def mixes(
    projection: ConstraintProjection, t: float, x: Array, given: tuple[Array, Array], numbers: Numbers, reach: Array
) -> Mixes:
    """Combinations that replace rows of A, of the configuration constraints and of all, at a state x; `given` are p and r.

    None if the rows are used as they are: no singular value is small, or the small ones vanish near by.
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
    """Whether one of the `weak` singular values of the first `count` rows is much larger at a place near by."""
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
    """A at a place in the direction `along` where it has changed by a share of its size; None if it does not change."""
    step, factor = 1.0, 0.0
    for _ in range(_TRIES):
        numbers = beside(step * along)
        change = np.abs((numbers.a[: len(a)] - a) / sizes).max() if numbers.finite else np.inf
        if _NEARBY[0] <= change <= _NEARBY[1]:
            return numbers.a[: len(a)]
        wanted = _FACTOR if change < _NEARBY[0] else 1 / _FACTOR
        # after a step too short and one too long, the factor is replaced by its square root
        step *= wanted if factor in (0.0, wanted) else wanted**0.5
        factor = wanted
    return None


_FIRST = 8
"""Number of parts of a step that are examined first."""
_FAR = 0.25
"""Change of the balanced A from one state to the next above which the part is halved."""
_CURVED = 1.5
"""Assumed length of the path of A, relative to the distance of its ends."""
_DEPTH = 40
_MOST = 4096
"""Largest number of halvings, and of states that are examined."""
_CLEAR = 10 * MOTION_RANK
"""Relative singular value above which a state is clear of a loss of rank."""
_CLOSE = np.geomspace(1e-4, 0.1, 7)
"""Shares of a step at which its distance from an end with a loss of rank is examined."""


class RankHistory(NamedTuple):
    """At times t (k): the balanced A (k × m × n), the `least` singular value of its rank, and its ratio `share` to the largest.

    `side` is the sign of the determinant of the dependent block, 0 if A is not finite.
    """

    t: Array
    a: Array
    least: Array
    share: Array
    side: Array

    @property
    def lost(self) -> Mask:
        """At which times rank is lost (k)."""
        return np.asarray(self.share < MOTION_RANK)

    def only(self, kept: slice | Indices) -> RankHistory:
        """The history at some of the times."""
        return RankHistory(*(part[kept] for part in self))

    def and_at(self, other: RankHistory) -> RankHistory:
        """The history at these times and at those of `other`, in order."""
        together = RankHistory(*map(np.concatenate, zip(self, other, strict=True)))
        return together.only(np.argsort(together.t))


def looked_at(t: Array, a: Array, partition: Partition, reach: Array, mix: Mixed | None = None) -> RankHistory:
    """The history of A (k × m × n) at times t (k), with the present dependent speeds; `mix` replaces the rows for the rank."""
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
    """Whether a step crosses a loss of rank or a singular dependent block; such a state at `start` or `end` does not count."""
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
    """The history without the neighbourhoods of ends at which rank is lost."""
    first, last = (bool(at.share[k] < MOTION_RANK) for k in (0, -1))
    close = [*(start + length * _CLOSE if first else ()), *(start + length * (1 - _CLOSE) if last else ())]
    if not close:
        return at
    at = at.and_at(along(np.array(close)))
    clear = np.flatnonzero(at.share > _CLEAR)
    if not len(clear):
        return at.only(slice(0, 0))
    return at.only(slice(clear[0] if first else 0, clear[-1] + 1 if last else len(at.t)))
