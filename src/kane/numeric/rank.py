# SPDX-License-Identifier: BSD-3-Clause
"""Rank: what a matrix of numbers determines, whatever the units of its rows and columns. Every decision on rank is made here.

A is divided by the sizes of its rows and columns; a singular value counts as zero where its share of the largest is no larger than
a threshold of the list below.

Least changes that satisfy linear conditions: in the mass metric, or in that of the numbers as they are.

In the metric ½ δᵀM δ the least δ with A δ = r is M⁻¹Aᵀ (A M⁻¹ Aᵀ)⁺ r, with a pseudo-inverse, so that redundant rows do no harm.
What has no mass is made a little heavy, whatever its unit.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from kane.numeric.arrays import Array, Complex, Mask
from kane.numeric.scale import (
    DERIVE_RANK,
    MOTION_RANK,
    ROUNDED,
    ROUNDED_SUM,
    ROUNDED_TERMS,
    SOLVE_RANK,
    SPEEDS_RANK,
    TAKES_PART,
)


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
    largest = sizes.max(axis=(-2, -1), keepdims=True, initial=0)
    counts = sizes > rounding * largest
    # a product takes a third of the time of np.where, and with 0.0 added leaves no −0 either
    a = a * counts + 0.0 if np.isfinite(largest).all() else np.where(counts, a, 0.0)
    sizes = np.abs(a) if reach is None else np.maximum(reach, np.abs(a))
    divided: dict[int, Array] = {}
    for axis in order:
        size = sizes.max(axis=axis - 2, keepdims=True, initial=0)
        size[size <= 0] = 1.0
        sizes /= size
        if reach is not None:
            a /= size
        divided[axis] = divided[axis] * size if axis in divided else size
    a = a if reach is not None else np.copysign(sizes, a)
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
        return self.rank(threshold) == len(self.values)


def singular(a: Array) -> Singular:
    """The singular values of A (m × n) as it stands: balanced before, or in units that compare."""
    if not a.size:
        return Singular(np.eye(len(a)), np.zeros(0), np.eye(a.shape[1]))
    return Singular(*np.linalg.svd(a))


def surely_regular(a: Array, threshold: float) -> Mask:
    """Of which matrices (k × m × n, m ≤ n) the least singular value counts, by σ_m ≥ 1/‖A⁻¹‖ and σ_1 ≤ ‖A‖ in Frobenius' norm.

    Of wide ones by A Aᵀ, whose singular values are σ². Where the bound leaves doubt nothing is said.
    """
    whole = np.asarray(np.isfinite(a).all(axis=(1, 2)))
    m, power = a.shape[1], 1 if a.shape[1] == a.shape[2] else 2
    inner = a if power == 1 else a @ np.swapaxes(a, 1, 2)
    if not whole.all():
        inner = np.where(whole[:, None, None], inner, np.eye(m))
    try:
        share = 1 / np.sqrt(_squares(inner) * _squares(np.asarray(np.linalg.inv(inner))))
    except np.linalg.LinAlgError:  # where one is singular there is no inverse of any
        values = np.linalg.svd(inner, compute_uv=False)
        share = values[:, -1] / np.maximum(values[:, 0], np.finfo(float).tiny)
    return np.asarray(whole & (share > max(threshold**power, ROUNDED)))


def _squares(a: Array) -> Array:
    """The sums of squares of matrices (k × m × n)."""
    result: Array = np.einsum("kij,kij->k", a, a)
    return result


def null_direction(a: Array, threshold: float) -> Array | None:
    """x (n) with A x = 0, its entries scaled; None where A is regular (or not finite, so that nothing can be said)."""
    if not np.all(np.isfinite(a)):
        return None
    values = singular(balance(a, rounding=0.0).matrix)
    return None if values.regular(threshold) else values.right[-1]


def negative_direction(m: Array) -> Array | None:
    """x (n), its entries scaled, with xᵀ M x < 0 beyond rounding; None where there is none, or M is not finite."""
    if not np.all(np.isfinite(m)):
        return None
    size = np.sqrt(np.abs(np.diag(m)))
    size[size == 0] = 1.0
    values, vectors = np.linalg.eigh(m / np.outer(size, size))
    return vectors[:, 0] if np.min(values, initial=0) < -SOLVE_RANK * np.max(np.abs(values), initial=0) else None


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


class Spectrum(NamedTuple):
    """Eigenvalues λ (n) of a real A, their vectors (n × n, columns), and how far rounding may move Re λ (n)."""

    values: Complex
    vectors: Complex
    rounding: Array


def spectrum(a: Array) -> Spectrum:
    """The eigenvalues of A, measured such that rows and columns are alike.

    Of vectors x and y from the left, δA moves Re λ by Re (yᴴ δA x / yᴴx) to the first order. What rounding makes of A is real: it
    moves the frequency of what swings, and its real part hardly, however large other frequencies are.
    """
    if not a.size:
        return Spectrum(np.zeros(0, complex), np.zeros((0, 0), complex), np.zeros(0))
    from scipy.linalg import eig, matrix_balance  # take their time to import

    alike, (scale, _) = matrix_balance(a, permute=False, separate=True)
    found: Any = eig(a, left=True, right=True)
    values, left, right = found
    x, y = right / scale[:, None], left * scale[:, None]
    with np.errstate(all="ignore"):  # of a λ that has several vectors too few yᴴx is zero
        y = y / np.conj((y.conj() * x).sum(axis=0))
        # ‖Re (ȳ xᵀ)‖ of each
        parts = (y.real**2).sum(axis=0) * (x.real**2).sum(axis=0) + (y.imag**2).sum(axis=0) * (x.imag**2).sum(axis=0)
        crossed = (y.real * y.imag).sum(axis=0) * (x.real * x.imag).sum(axis=0)
        size = np.sqrt(np.maximum(parts + 2 * crossed, 0.0))
        rounding = ROUNDED_TERMS * float(np.linalg.norm(alike)) * size
    return Spectrum(values, right, np.where(np.isfinite(rounding), rounding, np.inf))


def decays(a: Array, found: Spectrum | None = None) -> bool:
    """Whether all x of ẋ = A x die out: no λ has Re λ ≥ 0, nor has any of a matrix that is A but for rounding.

    Re λ is below zero by more than rounding moves it; or A − iω is regular beside λ, as where λ has several vectors too few.
    `found` is its spectrum, where that is known.
    """
    values, _, rounding = found or spectrum(a)
    if not np.all(values.real < 0):
        return False
    doubtful = values[values.real >= -rounding]
    from scipy.linalg import matrix_balance

    alike = np.asarray(matrix_balance(a)[0])
    beside = alike - 1j * doubtful.imag[:, None, None] * np.eye(len(a))
    least = np.linalg.svd(beside, compute_uv=False)[:, -1]
    return bool(np.all(least > ROUNDED * np.linalg.norm(alike)))


# Lengths in the metric of M ------------------------------------------------------------------------------------------


_LIGHT = 1e-6
"""Inertia given to a coordinate without mass, over what the constraints reflect onto it: others take that share of its changes."""
_DEFINITE = 1e-10
"""Least eigenvalue of M, scaled to a unit diagonal, over the largest."""
_EXACT = 1e-14
"""Share of the largest singular value below which one is dropped where the rows were found independent before."""


def least_squares(a: Array, right: Array, share: float = SPEEDS_RANK) -> Array:
    """The least x (n) of those nearest to A x = right; singular values of A below that share of the largest count as zero."""
    return np.asarray(np.linalg.lstsq(a, right, rcond=share)[0])


def least_change(m: Array, a: Array, right: Array, reach: Array | float = 0.0, mix: Mixed | None = None) -> Array:
    """The δ (n) of least δᵀM δ with A δ = right, in the least-squares sense where the rows of A are dependent.

    Which of them count is judged by the sizes `reach` that entries of A have had, and by the combinations `mix` in their places.
    """
    scale = metric(m, np.maximum(reach, np.abs(a)))
    sure = sure_rows(a, reach, mix)
    return np.asarray(scale @ least_squares(sure @ a @ scale, sure @ right, _EXACT))


def least_constraint(
    m: Array, a: Array, f: Array, right: Array, reach: Array | float = 0.0, mix: Mixed | None = None
) -> Array:
    """The x (n) of least ½ xᵀM x − fᵀx with A x = right, Gauss's principle: M x + Aᵀλ = f, M being definite where A leaves x free."""
    size = np.sqrt(reflected(_diagonal(m), np.maximum(reach, np.abs(a))))
    sure = sure_rows(a, reach, mix)
    rows = sure @ a / size
    tall = np.linalg.norm(rows, axis=1, keepdims=True)
    rows, wanted = rows / tall, sure @ right / tall[:, 0]
    whole = np.block([[m / np.outer(size, size), rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    return np.asarray(least_squares(whole, np.append(f / size, wanted), _EXACT)[: len(size)] / size)


def mobility(m: Array, a: Array) -> Array:
    """S (n × n) with S Sᵀ = M⁻¹, where what has no mass moves as the masses do that the constraints join to it."""
    return metric(m, a, 1.0)


def row_sizes(m: Array, a: Array) -> Array:
    """How large the rows of A (k × n) are over what the masses let each x move (k), infinite where nothing moves: so rows compare."""
    sizes = (np.abs(a) / np.sqrt(reflected(_diagonal(m), np.abs(a)))).max(axis=1, initial=0)
    return np.asarray(np.where(sizes > 0, sizes, np.inf))


def sizes(a: Array, root: Array) -> Array:
    """How large the entries of A (m × n) could be: a row's largest share of A S, over what the mass lets each x move, S Sᵀ = M⁻¹ in x.

    Near a dead centre a row is a short one in one x alone; divided by themselves its entries would all look alike.
    """
    mobile = np.linalg.norm(root, axis=1)
    mobile = np.where(mobile > 0, mobile, 1.0)
    return np.asarray((np.abs(a) * mobile).max(axis=1, keepdims=True, initial=0) / mobile)


def metric(m: Array, a: Array | None = None, light: float = _LIGHT) -> Array:
    """S (n × n) with S Sᵀ = M⁻¹; directions that move no mass are made a little heavy: free to move but not arbitrary.

    For a coordinate alone that means: it has `light` of the inertia that the constraints reflect onto it, whatever its unit. A mass
    below zero counts as none.
    """
    own = _diagonal(m)
    added = np.maximum(light * reflected(own, np.zeros((0, len(m))) if a is None else a) - own, 0.0)
    added += np.maximum(-np.diag(m), 0.0)
    heavy = m + np.diag(added)
    size = np.sqrt(np.diag(heavy))
    values, vectors = np.linalg.eigh(heavy / np.outer(size, size))
    values = np.maximum(values, _DEFINITE * values[-1])
    return np.asarray((vectors / np.sqrt(values)) / size[:, None])


def _diagonal(m: Array) -> Array:
    """The diagonal of M (n), where what rounding left of zero in a partial velocity comes squared."""
    own = np.diag(m)
    return np.where(own > ROUNDED**2 * own.max(initial=0), own, 0.0)


def reflected(mass: Array, a: Array) -> Array:
    """What each x (n) has of inertia: its own mass, or without one m (a_i/a)² of the lightest m that a row a of A joins to it.

    Row after row, so that it comes through chains of parts without mass. Where no mass is joined at all, x is measured by its rows.
    """
    if np.all(mass > 0):
        return mass
    a = np.where(np.abs(a) > ROUNDED * np.abs(a).max(initial=0), np.abs(a), 0.0)
    inertia = mass.copy()
    for _ in range(len(a)):
        heavy = inertia > 0
        pace = (a[:, heavy] / np.sqrt(inertia[heavy])).max(axis=1, initial=0)
        joined = np.where(heavy, 0.0, (a[pace > 0] / pace[pace > 0, None]).max(axis=0, initial=0))
        if not joined.any():
            break
        inertia = np.where(heavy, inertia, joined**2)
    rows = np.maximum(a.max(axis=1, keepdims=True, initial=0), np.finfo(float).tiny)
    alone = (a / rows).max(axis=0, initial=0)
    return np.asarray(np.where(inertia > 0, inertia, np.where(alone > 0, alone, 1.0) ** 2))


def of_unit_length(x: Array, sets: Iterable[Sequence[int]]) -> Array:
    """x (n) with its Euler parameters, at the places of each set, divided by their length."""
    x = x.copy()
    for places in map(list, sets):
        x[places] /= np.linalg.norm(x[places])
    return x
