# SPDX-License-Identifier: BSD-3-Clause
"""Which of several configurations tell the rank of the constraints, and which dependent speeds are determined at all of these.

The rank is that of the motion: the highest at configurations from which the mechanism moves, since where it drops it is lost in
passing. A configuration at which nothing can move is another assembly, and counts where there are no others.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kane.dynamics.constraints.configurations import Configurations, configurations
from kane.dynamics.constraints.manifold import Manifold
from kane.dynamics.constraints.partition import Partition, choose, choose_each, qualities_of
from kane.errors import ModelError
from kane.expr.matrix import Matrix
from kane.expr.node import Expr
from kane.expr.size import size
from kane.expr.symbols import Symbol
from kane.kinematics.constraints import ConstraintRows
from kane.model.system import System
from kane.numeric.arrays import Array, Mask
from kane.numeric.rank import balanced
from kane.numeric.scale import BETTER, DERIVE_RANK, NEAR_SINGULAR, POOR

_SHARE = 0.25
"""Share of the configurations at which dependent speeds may be poorly determined: every choice is somewhere."""
_ROUNDS, _EXCHANGES = 6, 8
"""How many speeds are exchanged one after the other, and how many exchanges are looked at for each."""
_FEW = 10_000
"""Entries up to which matrices are eliminated side by side from the start: few small ones take the time of one."""

Merit = tuple[int, int, float]


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """Configurations, A there (count × m × n) and its rank at each (count)."""

    at: Configurations
    a: Array
    ranks: Array

    def reach(self, conditions: Manifold) -> Array:
        """The usual size of the terms of each configuration constraint, 1 where it has none.

        That is of the terms themselves, sines and cosines taken as 1, and of derivatives times lengths, Euler parameters as 1.
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
        """Those of one rank."""
        kept = np.flatnonzero(self.ranks == rank)
        return Compared(self.at.only(kept), self.a[kept], self.ranks[kept])

    def and_those_of(self, other: Compared) -> Compared:
        """These, then those of another search."""
        a, found = np.concatenate([self.a, other.a]), np.concatenate([self.ranks, other.ranks])
        return Compared(self.at.and_those_of(other.at), a, found)


def compared(
    system: System, rows: ConstraintRows, near: Mapping[Symbol, float] | None, conditions: Manifold | None = None
) -> Compared:
    """Configurations of the motion, which `conditions` hold, all of one rank of the constraints.

    A ModelError says that A is finite at none. Where ranks differ they are looked at again around one of each.
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
    # where motions begin, rank may drop: that says nothing, but where it is higher than elsewhere
    usual = first.ranks[~first.at.special]
    every = sorted({*usual.tolist(), max(first.ranks.tolist())}, reverse=True)
    if len(every) == 1 or near or first.at.missed:
        return first.of_rank(every[0])
    around = [at(first.of_rank(r).at.at(0)) for r in every]
    # that of a branch is the rank beside the place, which may be a singular one itself
    beside = [round(float(np.median(x.ranks[1:] if len(x.ranks) > 1 else x.ranks))) for x in around]
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
    """The partition at the first of several matrices (k × m × n) of one rank; another one where that is much better at all of them.

    Others are those at each of the matrices, and the best of these with one speed after the other exchanged while that helps. What is
    `preferred` comes before quality, see `choose`; at `special` ones (k) dependent speeds must be good, at the others most times.
    """
    scaled = balanced(a)

    def merits(partitions: Sequence[Partition]) -> list[Merit]:
        """Minus how many speeds asked for are not given, minus at how many configurations speeds do not follow; the quality else."""
        found = qualities_of(scaled, partitions)
        usual = _quantile(found, _SHARE)
        poor = (found < NEAR_SINGULAR).sum(axis=1)
        least = np.minimum(usual, found[:, special].min(axis=1, initial=1.0))
        every = len(preferred) + 1
        absent = [len(set(preferred) - set(p.dependent)) for p in partitions]
        told = zip(absent, poor.tolist(), least.tolist(), strict=True)
        return [(-gone if bad < len(a) else -every, -bad, good) for gone, bad, good in told]

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
    # in the order in which they are eliminated where they follow best
    again = choose(a[int(np.argmax(qualities_of(scaled, [found])))], found.dependent, easy=easy)
    return again if set(again.dependent) == set(found.dependent) else found


def _quantile(values: Array, share: float) -> Array:
    """The quantile of each row, between neighbours in proportion; NumPy's own takes ten times as long for a few numbers."""
    ordered, place = np.sort(values, axis=1), share * (values.shape[1] - 1)
    low = int(place)
    high = min(low + 1, values.shape[1] - 1)
    return np.asarray(ordered[:, low] + (place - low) * (ordered[:, high] - ordered[:, low]))


def _best(
    found: Partition, least: Merit, others: Sequence[Partition], merits: Callable[[Sequence[Partition]], list[Merit]]
) -> tuple[Partition, Merit]:
    """The first of the best `others` with its merit, if that is more than the `least`, that of what was `found`."""
    told = merits(others) if others else []
    own = max(told, default=least)
    return (others[told.index(own)], own) if own > least else (found, least)


def exchanged(scaled: Array, partition: Partition) -> list[Partition]:
    """A few with one dependent speed exchanged for another, for which the least determinant of balanced matrices is largest.

    Exchanging u_i for u_j multiplies det A_D by the entry (i, j) of A_D⁻¹ A.
    """
    rows = scaled[:, list(partition.rows)]
    free = partition.independent(scaled.shape[2])
    if not partition.dependent or not free:
        return []
    left, values, right = np.linalg.svd(rows[:, :, list(partition.dependent)])
    values = np.maximum(values, NEAR_SINGULAR**2)
    ratios = np.swapaxes(right, 1, 2) @ ((np.swapaxes(left, 1, 2) @ rows[:, :, list(free)]) / values[:, :, None])
    with np.errstate(divide="ignore"):
        least = (np.log(np.abs(ratios)) + np.log(values).sum(axis=1)[:, None, None]).min(axis=0)
    places = np.unravel_index(np.argsort(-least, axis=None)[:_EXCHANGES], least.shape)
    return [
        Partition(partition.rows, _replaced(partition.dependent, i, free[j]), partition.redundant)
        for i, j in zip(*places, strict=True)
    ]


def _replaced(places: tuple[int, ...], at: int, by: int) -> tuple[int, ...]:
    return (*places[:at], by, *places[at + 1 :])
