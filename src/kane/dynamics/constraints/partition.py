# SPDX-License-Identifier: BSD-3-Clause
"""Which speeds the constraints give, and in which order they are solved for: chosen from numbers, by complete pivoting.

Among the entries that are large enough the one whose row and column are emptiest is taken (Markowitz 1957), so that the
straight-line elimination stays sparse; rows in which nothing is left are redundant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kane.numeric.arrays import Array, Mask
from kane.numeric.rank import balanced
from kane.numeric.scale import DERIVE_RANK, PIVOT

Indices = npt.NDArray[np.intp]


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
    return choose_each(np.asarray(a, dtype=float)[None], preferred, easy=easy, reach=reach)[0]


def choose_each(
    a: Array,
    preferred: Sequence[int] = (),
    *,
    easy: Mask | None = None,
    reach: Array | None = None,
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
        # what is preferred while there is any, and anything where it is not given
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
    """Row and column of the emptiest of the large entries `among` those that are left, of each matrix."""
    count, _, n = sizes.shape
    sizes, full = np.where(among, sizes, 0.0), full & among
    largest = sizes.max(axis=(1, 2), keepdims=True, initial=0)
    largest[largest <= 0] = 1.0
    across = (full.sum(axis=2, keepdims=True) - 1) * (full.sum(axis=1, keepdims=True) - 1)
    # what only rounding tells apart is a tie, which the order decides
    cost = np.where(among & (sizes >= PIVOT * largest), across + 0.5 * ~cheap, np.inf)
    place = (cost - 1e-3 * np.round(sizes / largest, 6)).reshape(count, -1).argmin(axis=1)
    return place // n, place % n


def _eliminate(work: Array, full: Mask, cheap: Mask, others: Mask, r: Indices, c: Indices) -> None:
    """One column of each matrix by its pivot, in the rows `others`."""
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
    """How well the rows give the dependent speeds, A (m × n) balanced: the lesser of two shares, 1 at best, 0 where they do not.

    The reciprocal condition number of the dependent block, and its largest entry over that of the rows, since all of it may be small.
    """
    return float(qualities(a[None], partition, reach)[0])


def qualities(a: Array, partition: Partition, reach: Array | None = None) -> Array:
    """The `quality` at each of several matrices (k × m × n)."""
    return np.asarray(qualities_of(balanced(a, reach), [partition])[0])


def qualities_of(scaled: Array, partitions: Sequence[Partition]) -> Array:
    """The `quality` of each of several partitions at each of several balanced matrices (k × m × n): partitions × k."""
    found = np.ones((len(partitions), len(scaled)))
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
            found[places] = np.where(least > 0, least, 0.0).T
    return found
