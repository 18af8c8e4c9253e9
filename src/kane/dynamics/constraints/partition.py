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

Array = npt.NDArray[np.float64]
_LARGE = 0.15
"""Share of the largest entry left that a pivot must have."""
RANK = 1e-8
"""Share of the largest entry below which nothing is left."""
_ROUNDING = 1e-13
"""Share of the largest entry of A below which an entry is taken for what rounding left of zero; dividing by it would make it count."""


@dataclass(frozen=True, slots=True)
class Partition:
    """Row `rows[k]` gives speed `dependent[k]`, in this order; `redundant` rows follow from the others there."""

    rows: tuple[int, ...]
    dependent: tuple[int, ...]
    redundant: tuple[int, ...]

    def independent(self, count: int) -> tuple[int, ...]:
        """The other speeds of `count`."""
        given = set(self.dependent)
        return tuple(i for i in range(count) if i not in given)


def balanced(a: Array, reach: Array | None = None) -> Array:
    """A with rows and columns divided by their largest entries, so that units do not matter; rounding is dropped first.

    `reach` holds the sizes that the entries have had along a motion: measured by them, what is small now shows.
    """
    return _balanced(a, reach)[0]


def _balanced(a: Array, reach: Array | None = None) -> tuple[Array, Array]:
    """The balanced matrix, and what its rows were divided by."""
    a = np.where(np.abs(a) > _ROUNDING * np.abs(a).max(initial=0), a, 0.0)
    sizes = np.abs(a) if reach is None else np.maximum(reach, np.abs(a))
    rows = np.ones(len(a))
    for _ in range(2):
        for axis in (0, 1):
            size = sizes.max(axis=axis, keepdims=True, initial=0)
            size = np.where(size > 0, size, 1.0)
            a, sizes = a / size, sizes / size
            rows = rows * size[:, 0] if axis else rows
    return a, rows


def choose(
    a: Array,
    preferred: Sequence[int] = (),
    *,
    easy: npt.NDArray[np.bool_] | None = None,
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
    full = np.abs(work) > RANK
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
                full[i] |= full[r]
                cheap[i] &= ~full[r]
                work[i, c] = 0.0
    return Partition(tuple(rows), tuple(columns), tuple(sorted(left)))


def _pivot(
    work: Array, full: npt.NDArray[np.bool_], cheap: npt.NDArray[np.bool_], rows: list[int], columns: list[int]
) -> tuple[int, int] | None:
    """The emptiest of the large entries."""
    if not rows or not columns:
        return None
    block = np.abs(work[np.ix_(rows, columns)])
    largest = float(block.max())
    if not largest > RANK:
        return None
    shape = full[np.ix_(rows, columns)]
    cost = np.outer(shape.sum(axis=1) - 1, shape.sum(axis=0) - 1) + 0.5 * ~cheap[np.ix_(rows, columns)]
    cost = np.where(block >= _LARGE * largest, cost, np.inf) - 1e-3 * block / largest
    i, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
    return rows[i], columns[j]


def dependencies(a: Array) -> Array:
    """The vectors x with Σ x_i A_i / size_i = 0, a row each, for the rows A_i of A and their `row_sizes`."""
    work = balanced(np.array(a, dtype=float))
    if not work.size:
        return np.zeros((0, len(work)))
    left, sigma, _ = np.linalg.svd(work)
    return np.asarray(left[:, int((sigma > RANK * sigma[0]).sum()) :].T)


def row_sizes(a: Array) -> Array:
    """What balancing divides the rows of A by."""
    return _balanced(np.array(a, dtype=float))[1]


def indeterminate(a: Array) -> Array:
    """Which multipliers the forces in the speeds do not determine: those in which a vector x with xᵀ A = 0 is not zero."""
    return np.asarray(np.abs(dependencies(a)).max(axis=0, initial=0) > 1e-6)


def within(a: Array, column: Array) -> bool:
    """Whether `column` is a combination of the columns of `a`."""
    wider = np.column_stack([a, column])
    return _rank(wider) == _rank(np.column_stack([a, np.zeros_like(column)]))


def _rank(a: Array) -> int:
    sigma = np.linalg.svd(balanced(a), compute_uv=False)
    return int((sigma > RANK * sigma.max(initial=0)).sum())
