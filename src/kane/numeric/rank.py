# SPDX-License-Identifier: BSD-3-Clause
"""Rank: what a matrix of numbers determines, whatever the units of its rows and columns. Every decision on rank is made here.

A is divided by the sizes of its rows and columns; a singular value counts as zero where its share of the largest is no larger than
a threshold of the list below.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kane.numeric.arrays import Array, Mask
from kane.numeric.scale import DERIVE_RANK, MOTION_RANK, ROUNDED, ROUNDED_SUM, TAKES_PART


@dataclass(frozen=True, slots=True, eq=False)
class Balanced:
    """`matrix` (m × n) = A divided by the sizes of `rows` (m × 1) and `columns` (1 × n)."""

    matrix: Array
    rows: Array
    columns: Array


def balance(
    a: Array, reach: Array | float | None = None, *, order: tuple[int, ...] = (0, 1, 0, 1), rounding: float = ROUNDED
) -> Balanced:
    """A with rows and columns divided by their largest entries, so that units do not matter; rounding is dropped first.

    Parameters
    ----------
    a : A (m × n), or several (… × m × n)
    reach : sizes that the entries have had along a motion (m × n): measured by them, what is small now shows
    order : which sizes are divided out one after the other, those of columns (0) or of rows (1)
    rounding : share of the largest entry that is dropped
    """
    sizes = np.abs(a)
    counts = sizes > rounding * sizes.max(axis=(-2, -1), keepdims=True, initial=0)
    a, sizes = np.where(counts, a, 0.0), np.where(counts, sizes, 0.0)
    if reach is not None:
        sizes = np.maximum(reach, sizes)
    divided: dict[int, Array] = {}
    for axis in order:
        size = sizes.max(axis=axis - 2, keepdims=True, initial=0)
        size[size <= 0] = 1.0
        a, sizes = a / size, sizes / size
        divided[axis] = divided[axis] * size if axis in divided else size
    return Balanced(a, divided[1], divided[0])


def balanced(a: Array, reach: Array | float | None = None) -> Array:
    """The matrix (m × n) of `balance`."""
    return balance(a, reach).matrix


def level(rows: Array, rounding: float = ROUNDED_SUM) -> Array:
    """Rows (m × n) divided by their largest entries, those of rounding alone zero."""
    size = np.abs(rows).max(axis=1, keepdims=True, initial=0)
    counts = size > rounding * size.max(initial=0)
    return np.where(counts, rows / np.where(counts, size, 1.0), 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Singular:
    """A = `left` diag(`values`) `right`, the values falling; what a threshold says of them."""

    left: Array
    values: Array
    right: Array

    def rank(self, threshold: float) -> int:
        """How many singular values count."""
        return int((self.values > threshold * self.values[:1]).sum())

    def kernel(self, threshold: float) -> Array:
        """The x with A x = 0, orthonormal, one a row."""
        return self.right[self.rank(threshold) :]

    def cokernel(self, threshold: float) -> Array:
        """The x with xᵀ A = 0, orthonormal, one a row."""
        return self.left[:, self.rank(threshold) :].T

    def regular(self, threshold: float) -> bool:
        """Whether the least singular value counts."""
        return bool(self.values[-1] > threshold * self.values[0])


def singular(a: Array) -> Singular:
    """The singular values of A (m × n) as it stands: balanced before, or in units that compare."""
    if not a.size:
        return Singular(np.eye(len(a)), np.zeros(0), np.eye(a.shape[1]))
    return Singular(*np.linalg.svd(a))


def null_direction(a: Array, threshold: float) -> Array | None:
    """x (n) with A x = 0, its entries scaled; None where A is regular (or not finite, so that nothing can be said)."""
    if not np.all(np.isfinite(a)):
        return None
    values = singular(balance(a, rounding=0.0).matrix)
    return None if values.regular(threshold) else values.right[-1]


def dependencies(a: Array) -> Array:
    """The vectors x with Σ x_i A_i / size_i = 0, a row each (k × m), for the rows A_i of A and what balancing divides them by."""
    return singular(balanced(a)).cokernel(DERIVE_RANK)


def indeterminate(a: Array) -> Mask:
    """Which multipliers (m) the forces in the speeds do not determine: those in which a vector x with xᵀ A = 0 is not zero."""
    return np.asarray(np.abs(dependencies(a)).max(axis=0, initial=0) > TAKES_PART)


def within(a: Array, column: Array) -> bool:
    """Whether `column` (m) is a combination of the columns of A (m × n)."""
    wide, plain = np.column_stack([a, column]), np.column_stack([a, np.zeros_like(column)])
    return singular(balanced(wide)).rank(DERIVE_RANK) == singular(balanced(plain)).rank(DERIVE_RANK)


@dataclass(frozen=True, slots=True, eq=False)
class Mixed:
    """Combinations `rows` (k × m) of the rows of A, those that are small everywhere enlarged; `reach` (k × n) are the sizes of theirs.

    They stand in the places of the rows where it is asked which of them count.
    """

    rows: Array
    reach: Array

    def grown(self, a: Array) -> Mixed:
        """With the sizes that the entries have at A too."""
        return Mixed(self.rows, np.maximum(self.reach, np.abs(self.rows @ a)))


def weak_values(values: Array) -> Mask:
    """Which singular values count at a configuration and not along a motion."""
    return np.asarray((values > DERIVE_RANK * values[:1]) & (values <= MOTION_RANK * values[:1]))


def mixed(a: Array, reach: Array | float = 0.0) -> Mixed:
    """The combinations that the singular values of A say, those that count at a configuration and not along a motion made as large.

    Where nothing is left of a combination here its size is that of the terms it is made of.
    """
    seen = np.maximum(reach, np.abs(a))
    seen = np.where(seen > ROUNDED * seen.max(initial=0), seen, 0.0)
    rows, values = combinations(a, seen)
    weak = weak_values(values)
    rows = rows / np.where(weak, values, 1.0)[:, None]
    own = np.abs(rows @ a)
    return Mixed(rows, np.where(weak[:, None], own, np.maximum(own, np.abs(rows) @ seen)))


def combinations(a: Array, reach: Array | float = 0.0, mix: Mixed | None = None) -> tuple[Array, Array]:
    """Independent combinations of the rows of A (k × m), and its singular values (k), A divided by the sizes its rows and columns had.

    So units do not matter, and a row that vanishes now is not mistaken for one in small units; those of `mix` are taken for it.
    """
    if mix is not None:
        rows, sizes = combinations(mix.rows @ a, mix.reach)
        return rows @ mix.rows, sizes
    scaled = balance(a, reach, order=(1, 0))
    values = singular(scaled.matrix)
    return (values.left / scaled.rows).T[: len(values.values)], values.values


def sure_rows(a: Array, reach: Array | float = 0.0, mix: Mixed | None = None) -> Array:
    """The combinations of the rows of A that count in a motion (rank × m)."""
    rows, values = combinations(a, reach, mix)
    return np.asarray(rows[values > MOTION_RANK * values[0]])
