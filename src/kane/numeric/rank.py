# SPDX-License-Identifier: BSD-3-Clause
"""Numerical rank by singular values of balanced matrices, and minimum-norm solutions in the mass metric. All rank decisions are here.

A is balanced: divided by the sizes of its rows and columns, so that units do not matter. A singular value counts as zero if its ratio
to the largest does not exceed a threshold of `kane.numeric.scale`.

In the mass metric the δ of least ½ δᵀM δ with A δ = r is M⁻¹Aᵀ (A M⁻¹ Aᵀ)⁺ r, with a pseudoinverse, so that redundant rows do no
harm. Directions without mass get a small one, independent of units.
"""

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
    """A with rows and columns divided by their largest entries; entries within rounding are set to zero first.

    Parameters
    ----------
    a : A (m × n), or several (… × m × n)
    reach : largest sizes of the entries along a motion (m × n), to divide by, so that entries that are small now are seen as such
    order : the sequence of divisions, by sizes of columns (0) or of rows (1)
    rounding : ratio to the largest entry below which entries are set to zero
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
    """Rows (m × n) divided by their largest entries; rows within rounding become zero."""
    size = np.abs(rows).max(axis=1, keepdims=True, initial=0)
    counts = size > rounding * size.max(initial=0)
    return np.where(counts, rows / np.where(counts, size, 1.0), 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Singular:
    """The singular value decomposition A = `left` diag(`values`) `right`, values in descending order, and rank by a threshold."""

    left: Array
    values: Array
    right: Array

    def rank(self, threshold: float) -> int:
        """The number of singular values above `threshold` times the largest."""
        return int((self.values > threshold * self.values[:1]).sum())

    def kernel(self, threshold: float) -> Array:
        """An orthonormal basis of the x with A x = 0, one per row."""
        return self.right[self.rank(threshold) :]

    def cokernel(self, threshold: float) -> Array:
        """An orthonormal basis of the x with xᵀ A = 0, one per row."""
        return self.left[:, self.rank(threshold) :].T

    def regular(self, threshold: float) -> bool:
        """Whether no singular value counts as zero."""
        return self.rank(threshold) == len(self.values)


def singular(a: Array) -> Singular:
    """The singular value decomposition of A (m × n), which is not balanced here."""
    if not a.size:
        return Singular(np.eye(len(a)), np.zeros(0), np.eye(a.shape[1]))
    return Singular(*np.linalg.svd(a))


def surely_regular(a: Array, threshold: float) -> Mask:
    """Which matrices (k × m × n, m ≤ n) are certainly regular, by σ_m ≥ 1/‖A⁻¹‖ and σ_1 ≤ ‖A‖ in the Frobenius norm.

    Wide matrices are judged by A Aᵀ, whose singular values are σ². False if the bounds do not decide.
    """
    whole = np.asarray(np.isfinite(a).all(axis=(1, 2)))
    m, power = a.shape[1], 1 if a.shape[1] == a.shape[2] else 2
    inner = a if power == 1 else a @ np.swapaxes(a, 1, 2)
    if not whole.all():
        inner = np.where(whole[:, None, None], inner, np.eye(m))
    try:
        share = 1 / np.sqrt(_squares(inner) * _squares(np.asarray(np.linalg.inv(inner))))
    except np.linalg.LinAlgError:  # np.linalg.inv fails for all if one is singular
        values = np.linalg.svd(inner, compute_uv=False)
        share = values[:, -1] / np.maximum(values[:, 0], np.finfo(float).tiny)
    return np.asarray(whole & (share > max(threshold**power, ROUNDED)))


def _squares(a: Array) -> Array:
    """The sums of squares of matrices (k × m × n)."""
    result: Array = np.einsum("kij,kij->k", a, a)
    return result


def null_direction(a: Array, threshold: float) -> Array | None:
    """A scaled x (n) with A x = 0; None if A is regular or not finite."""
    if not np.all(np.isfinite(a)):
        return None
    values = singular(balance(a, rounding=0.0).matrix)
    return None if values.regular(threshold) else values.right[-1]


def negative_direction(m: Array) -> Array | None:
    """A scaled x (n) with xᵀ M x < 0 beyond rounding; None if there is none, or M is not finite."""
    if not np.all(np.isfinite(m)):
        return None
    size = np.sqrt(np.abs(np.diag(m)))
    size[size == 0] = 1.0
    values, vectors = np.linalg.eigh(m / np.outer(size, size))
    return vectors[:, 0] if np.min(values, initial=0) < -SOLVE_RANK * np.max(np.abs(values), initial=0) else None


def dependencies(a: Array) -> Array:
    """A basis (k × m) of the x with Σ x_i A_i / size_i = 0, for the rows A_i of A and their sizes in balancing."""
    return singular(balanced(a)).cokernel(DERIVE_RANK)


def indeterminate(a: Array) -> Mask:
    """Which multipliers (m) are not determined by Aᵀ λ: those for which some x with xᵀ A = 0 has a nonzero entry."""
    return np.asarray(np.abs(dependencies(a)).max(axis=0, initial=0) > TAKES_PART)


def within(a: Array, column: Array) -> bool:
    """Whether `column` (m) is a combination of the columns of A (m × n)."""
    wide, plain = np.column_stack([a, column]), np.column_stack([a, np.zeros_like(column)])
    return singular(balanced(wide)).rank(DERIVE_RANK) == singular(balanced(plain)).rank(DERIVE_RANK)


@dataclass(frozen=True, slots=True, eq=False)
class Mixed:
    """Combinations `rows` (k × m) of the rows of A, scaled up if they are small along a whole motion, and the sizes `reach` (k × n).

    Their rank is decided in the place of that of the rows.
    """

    rows: Array
    reach: Array

    def grown(self, a: Array) -> "Mixed":
        """The combinations with `reach` extended by the sizes at A."""
        return Mixed(self.rows, np.maximum(self.reach, np.abs(self.rows @ a)))


def weak_values(values: Array) -> Mask:
    """Which singular values exceed the threshold of a configuration but not that of a motion."""
    return np.asarray((values > DERIVE_RANK * values[:1]) & (values <= MOTION_RANK * values[:1]))


def mixed(a: Array, reach: Array | float = 0.0) -> Mixed:
    """The combinations of rows by the singular vectors of A, with those of `weak_values` scaled up.

    The size of the other combinations includes that of their terms, since they may cancel at this configuration.
    """
    seen = np.maximum(reach, np.abs(a))
    seen = np.where(seen > ROUNDED * seen.max(initial=0), seen, 0.0)
    rows, values = combinations(a, seen)
    weak = weak_values(values)
    rows = rows / np.where(weak, values, 1.0)[:, None]
    own = np.abs(rows @ a)
    return Mixed(rows, np.where(weak[:, None], own, np.maximum(own, np.abs(rows) @ seen)))


def combinations(a: Array, reach: Array | float = 0.0, mix: Mixed | None = None) -> tuple[Array, Array]:
    """Independent combinations of the rows of A (k × m), and the singular values (k) of A balanced by the sizes `reach`.

    With `reach` a row that vanishes at this configuration differs from one in small units. `mix` replaces the rows by combinations.
    """
    if mix is not None:
        rows, sizes = combinations(mix.rows @ a, mix.reach)
        return rows @ mix.rows, sizes
    scaled = balance(a, reach, order=(1, 0))
    values = singular(scaled.matrix)
    return (values.left / scaled.rows).T[: len(values.values)], values.values


def sure_rows(a: Array, reach: Array | float = 0.0, mix: Mixed | None = None) -> Array:
    """The combinations of the rows of A above the threshold of a motion (rank × m)."""
    rows, values = combinations(a, reach, mix)
    return np.asarray(rows[values > MOTION_RANK * values[0]])


class Spectrum(NamedTuple):
    """Eigenvalues λ (n) of a real A, eigenvectors (n × n, columns), and bounds on the rounding errors of Re λ (n)."""

    values: Complex
    vectors: Complex
    rounding: Array


def spectrum(a: Array) -> Spectrum:
    """The eigenvalues of A, with rounding errors of the balanced matrix.

    With right and left eigenvectors x and y, δA changes Re λ by Re (yᴴ δA x / yᴴx) to first order. As δA is real, rounding changes the
    frequency of an oscillation but hardly its damping, even beside much larger frequencies.
    """
    if not a.size:
        return Spectrum(np.zeros(0, complex), np.zeros((0, 0), complex), np.zeros(0))
    from scipy.linalg import eig, matrix_balance  # take their time to import

    alike, (scale, _) = matrix_balance(a, permute=False, separate=True)
    found: Any = eig(a, left=True, right=True)
    values, left, right = found
    x, y = right / scale[:, None], left * scale[:, None]
    with np.errstate(all="ignore"):  # yᴴx is zero for a defective λ
        y = y / np.conj((y.conj() * x).sum(axis=0))
        # ‖Re (ȳ xᵀ)‖ of each
        parts = (y.real**2).sum(axis=0) * (x.real**2).sum(axis=0) + (y.imag**2).sum(axis=0) * (x.imag**2).sum(axis=0)
        crossed = (y.real * y.imag).sum(axis=0) * (x.real * x.imag).sum(axis=0)
        size = np.sqrt(np.maximum(parts + 2 * crossed, 0.0))
        rounding = ROUNDED_TERMS * float(np.linalg.norm(alike)) * size
    return Spectrum(values, right, np.where(np.isfinite(rounding), rounding, np.inf))


def decays(a: Array, found: Spectrum | None = None) -> bool:
    """Whether ẋ = A x is asymptotically stable beyond rounding: Re λ < 0 for A and for all matrices that differ by rounding.

    Each Re λ is below zero by more than its rounding error, or, as for defective λ, A − iω is regular at ω = Im λ. `found` is the
    spectrum, if known.
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


# Minimum norm in the metric of M -------------------------------------------------------------------------------------


_LIGHT = 1e-6
"""Inertia given to a coordinate without mass, as a share of that reflected to it by constraints."""
_DEFINITE = 1e-10
"""The least ratio of eigenvalues of M, scaled to a unit diagonal; smaller eigenvalues are raised to it."""
_EXACT = 1e-14
"""Ratio to the largest singular value below which one is dropped if the rows are known to be independent."""


def least_squares(a: Array, right: Array, share: float = SPEEDS_RANK) -> Array:
    """The minimum-norm least-squares solution x (n) of A x = right; singular values below `share` of the largest count as zero."""
    return np.asarray(np.linalg.lstsq(a, right, rcond=share)[0])


def least_change(m: Array, a: Array, right: Array, reach: Array | float = 0.0, mix: Mixed | None = None) -> Array:
    """The δ (n) of least δᵀM δ with A δ = right, in the least-squares sense if the rows of A are dependent.

    Rank is decided by the sizes `reach` of the entries of A along the motion, and by the combinations `mix` in place of the rows.
    """
    scale = metric(m, np.maximum(reach, np.abs(a)))
    sure = sure_rows(a, reach, mix)
    return np.asarray(scale @ least_squares(sure @ a @ scale, sure @ right, _EXACT))


def least_constraint(
    m: Array, a: Array, f: Array, right: Array, reach: Array | float = 0.0, mix: Mixed | None = None
) -> Array:
    """The x (n) of least ½ xᵀM x − fᵀx with A x = right (Gauss's principle): M x + Aᵀλ = f, M definite on the null space of A."""
    size = np.sqrt(reflected(_diagonal(m), np.maximum(reach, np.abs(a))))
    sure = sure_rows(a, reach, mix)
    rows = sure @ a / size
    tall = np.linalg.norm(rows, axis=1, keepdims=True)
    rows, wanted = rows / tall, sure @ right / tall[:, 0]
    whole = np.block([[m / np.outer(size, size), rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    return np.asarray(least_squares(whole, np.append(f / size, wanted), _EXACT)[: len(size)] / size)


def mobility(m: Array, a: Array) -> Array:
    """S (n × n) with S Sᵀ = M⁻¹, where coordinates without mass have the inertia reflected to them by constraints."""
    return metric(m, a, 1.0)


def row_sizes(m: Array, a: Array) -> Array:
    """The largest |a_i| / √m_i of each row of A (k × n), with reflected masses m, to compare rows (k); infinite for zero rows."""
    sizes = (np.abs(a) / np.sqrt(reflected(_diagonal(m), np.abs(a)))).max(axis=1, initial=0)
    return np.asarray(np.where(sizes > 0, sizes, np.inf))


def sizes(a: Array, root: Array) -> Array:
    """The sizes that the entries of A (m × n) may have: a row's largest |a_i| s_i, divided by s_i, the norm of row i of S = `root`.

    Near a dead centre a row has one small entry alone, which division by its own size would hide.
    """
    mobile = np.linalg.norm(root, axis=1)
    mobile = np.where(mobile > 0, mobile, 1.0)
    return np.asarray((np.abs(a) * mobile).max(axis=1, keepdims=True, initial=0) / mobile)


def metric(m: Array, a: Array | None = None, light: float = _LIGHT) -> Array:
    """S (n × n) with S Sᵀ = M⁻¹, where directions without mass get a small one, so that their changes are determined.

    A coordinate gets at least `light` times the inertia reflected to it by constraints, independent of units. Negative masses count
    as zero.
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
    """The diagonal of M (n), with zeros for entries within the square of rounding, as partial velocities enter squared."""
    own = np.diag(m)
    return np.where(own > ROUNDED**2 * own.max(initial=0), own, 0.0)


def reflected(mass: Array, a: Array) -> Array:
    """The inertia of each x (n): its mass or, without one, the reflected inertia m (a_i/a)² of the lightest m coupled by a row a of A.

    Applied repeatedly, through chains of massless parts. An x coupled to no mass gets the square of its share in its rows.
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
    """x (n) with the Euler parameters at the indices of each set divided by their length."""
    x = x.copy()
    for places in map(list, sets):
        x[places] /= np.linalg.norm(x[places])
    return x
