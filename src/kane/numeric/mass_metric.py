# SPDX-License-Identifier: BSD-3-Clause
"""Least changes that satisfy linear conditions: in the mass metric, or in that of the numbers as they are.

In the metric ½ δᵀM δ the least δ with A δ = r is M⁻¹Aᵀ (A M⁻¹ Aᵀ)⁺ r, with a pseudo-inverse, so that redundant rows do no harm.
What has no mass is made a little heavy, whatever its unit.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from kane.numeric.arrays import Array
from kane.numeric.rank import Mixed, sure_rows
from kane.numeric.scale import ROUNDED, SPEEDS_RANK

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

    For a coordinate alone that means: it has `light` of the inertia that the constraints reflect onto it, whatever its unit.
    """
    own = _diagonal(m)
    added = np.maximum(light * reflected(own, np.zeros((0, len(m))) if a is None else a) - own, 0.0)
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
