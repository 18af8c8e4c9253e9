# SPDX-License-Identifier: BSD-3-Clause
"""Which speeds the constraints give, and in which order they are solved for: chosen from numbers, by complete pivoting.

Among the entries that are large enough the one whose row and column are emptiest is taken (Markowitz 1957), so that the
straight-line elimination stays sparse; rows in which nothing is left are redundant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kane.numeric.arrays import Array, Mask
from kane.numeric.rank import DERIVE_RANK, balanced

_LARGE = 0.15
"""Share of the largest entry left that a pivot must have."""
POOR = 0.02
"""Quality below which other dependent speeds are sought."""


@dataclass(frozen=True, slots=True)
class Partition:
    """Row `rows[k]` gives speed `dependent[k]`, in this order; `redundant` rows follow from the others there."""

    rows: tuple[int, ...]
    dependent: tuple[int, ...]
    redundant: tuple[int, ...]

    def independent(self, count: int) -> tuple[int, ...]:
        """The other speeds of `count`."""
        dependent = set(self.dependent)
        return tuple(i for i in range(count) if i not in dependent)

    def first(self, count: int) -> Partition:
        """The first `count` pivots; the other rows follow from theirs."""
        return Partition(
            self.rows[:count], self.dependent[:count], tuple(sorted((*self.rows[count:], *self.redundant)))
        )


def choose(
    a: Array,
    preferred: Sequence[int] = (),
    *,
    easy: Mask | None = None,
    reach: Array | None = None,
) -> Partition:
    """Partition of A u + b = 0 by elimination at the numbers `a` (m × n).

    Parameters
    ----------
    a : the matrix at a configuration that satisfies the constraints
    preferred : speeds to be made dependent first
    easy : where entries are numbers, which are the cheapest pivots
    reach : sizes that the entries have had, if they are known
    """
    work = balanced(np.array(a, dtype=float), reach)
    m, n = work.shape
    cheap = np.zeros((m, n), dtype=bool) if easy is None else easy
    full = np.abs(work) > DERIVE_RANK
    rows: list[int] = []
    columns: list[int] = []
    left = set(range(m))
    for _ in range(min(m, n)):
        open_rows = sorted(left)
        wanted = [c for c in preferred if c not in columns] or [c for c in range(n) if c not in columns]
        best = _pivot(work, full, cheap, open_rows, wanted)
        if best is None and preferred:
            best = _pivot(work, full, cheap, open_rows, [c for c in range(n) if c not in columns])
        if best is None:
            break
        r, c = best
        rows.append(r)
        columns.append(c)
        left.remove(r)
        for i in left:
            factor = work[i, c] / work[r, c]
            if factor:
                work[i] -= factor * work[r]
                if full[i, c]:  # not what rounding leaves of zero
                    full[i] |= full[r]
                    cheap[i] &= ~full[r]
                work[i, c] = 0.0
    return Partition(tuple(rows), tuple(columns), tuple(sorted(left)))


def _pivot(work: Array, full: Mask, cheap: Mask, rows: list[int], columns: list[int]) -> tuple[int, int] | None:
    """The emptiest of the large entries."""
    if not rows or not columns:
        return None
    places = np.ix_(rows, columns)
    block = np.abs(work[places])
    largest = float(block.max())
    if not largest > DERIVE_RANK:
        return None
    shape = full[places]
    cost = np.outer(shape.sum(axis=1) - 1, shape.sum(axis=0) - 1) + 0.5 * ~cheap[places]
    # what only rounding tells apart is a tie, which the order decides
    cost = np.where(block >= _LARGE * largest, cost, np.inf) - 1e-3 * np.round(block / largest, 6)
    i, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
    return rows[i], columns[j]


def quality(a: Array, partition: Partition, reach: Array | None = None) -> float:
    """How well the rows give the dependent speeds, A (m × n) balanced: the lesser of two shares, 1 at best, 0 where they do not.

    The reciprocal condition number of the dependent block, and its largest entry over that of the rows, since all of it may be small.
    """
    return float(qualities(a[None], partition, reach)[0])


def qualities(a: Array, partition: Partition, reach: Array | None = None) -> Array:
    """The `quality` at each of several matrices (k × m × n)."""
    rows = balanced(a, reach)[:, list(partition.rows)]
    block = rows[:, :, list(partition.dependent)]
    if not block.size:
        return np.ones(len(a))
    values = np.linalg.svd(block, compute_uv=False)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.abs(block).max(axis=(1, 2)) / np.abs(rows).max(axis=(1, 2))
        return np.asarray(np.nan_to_num(np.minimum(values[:, -1] / values[:, 0], share)))
