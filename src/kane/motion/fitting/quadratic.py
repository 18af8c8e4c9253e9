# SPDX-License-Identifier: BSD-3-Clause
"""Small quadratic programs: min ½ d·H d + g·d subject to E d = e and A d ≥ b.

On the null space of E, eigenvalues of H are replaced by their magnitudes; the remaining least-distance problem is solved by
non-negative least squares (Lawson & Hanson 1974, ch. 23).
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import nnls

from kane.numeric.arrays import Array, by_substitution

_LEAST = 1e-8
"""Least eigenvalue, relative to the largest."""
_FLAT = 1e-6
"""If all eigenvalues are below this fraction of the gradient, they are replaced by it: the program is linear, solved by bounds."""
_NONE = 1e-10


class QuadraticStep(NamedTuple):
    """d, and the multipliers with H d + g + Eᵀ y − Aᵀ w = 0, w ≥ 0."""

    d: Array
    equal: Array
    above: Array


def least(H: Array, g: Array, equal: tuple[Array, Array], above: tuple[Array, Array]) -> QuadraticStep | None:
    """The solution and its multipliers; None if no d satisfies the conditions."""
    (E, e), (A, b) = equal, above
    first = np.linalg.lstsq(E, e)[0] if len(E) else np.zeros(len(g))
    free = null_space(E) if len(E) else np.eye(len(g))
    if len(E) and np.abs(E @ first - e).max() > 1e-6 * (1 + np.abs(e).max()):
        return None
    values, vectors = np.linalg.eigh(free.T @ H @ free)
    most, slope = float(np.abs(values).max(initial=0.0)), float(np.abs(g).max(initial=0.0))
    size = np.maximum(np.abs(values), _LEAST * most if most > _FLAT * slope else (_FLAT * slope or 1.0))
    root = vectors * np.sqrt(size)
    lower = np.linalg.cholesky(root @ root.T)
    toward = -by_substitution(lower, free.T @ (g + H @ first))
    u, w = toward, np.zeros(len(A))
    if len(A):
        C = by_substitution(lower, (A @ free).T).T
        need = b - A @ first - C @ toward
        if need.max() > 0:
            found = _nearest(C, need)
            if found is None:
                return None
            u, w = toward + found[0], found[1]
    d = first + free @ np.linalg.solve(lower.T, u)
    rest = H @ d + g - A.T @ w
    y = -np.linalg.lstsq(E.T, rest)[0] if len(E) else np.zeros(0)
    return QuadraticStep(np.asarray(d), np.asarray(y), w)


def _nearest(C: Array, h: Array) -> tuple[Array, Array] | None:
    """The u of least norm with C u ≥ h, and its multipliers; None if there is none."""
    size = max(float(np.abs(h).max()), 1e-300)
    E = np.vstack([C.T, h / size])
    y, left = nnls(E, np.append(np.zeros(C.shape[1]), 1.0), maxiter=30 * len(h))
    if left <= _NONE:
        return None
    r = E @ y
    r[-1] -= 1.0
    return size * r[:-1] / -r[-1], size * y / -r[-1]
