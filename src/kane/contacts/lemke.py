# SPDX-License-Identifier: BSD-3-Clause
"""Lemke's method for w = M z + q, 0 ≤ w ⊥ z ≥ 0, applied to contacts with polyhedral friction cones, which are exact in the plane.

The unknowns z are the normal forces and, for each contact that may stick, the friction forces along the directions of the facets and
the slip speed σ (Stewart & Trinkle 1996, Int. J. Numer. Meth. Engng 39, 2673).
"""

from __future__ import annotations

import numpy as np

from kane.contacts.angles import unit
from kane.contacts.problem import ContactProblem
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED_CHAIN, ROUNDED_SUM

_FACETS = 8
_PIVOTS = 400


def complementary(m: Array, q: Array) -> Array | None:
    """z (n), by lexicographic pivoting, which does not cycle; None on ray termination or after too many pivots."""
    n = len(q)
    if q.min(initial=0) >= 0:
        return np.zeros(n)
    table = np.hstack([np.eye(n), -m, -np.ones((n, 1)), q[:, None]])
    basis = np.arange(n)
    row, enters = int(np.argmin(q)), 2 * n
    for _ in range(_PIVOTS):
        table[row] /= table[row, enters]
        column = table[:, enters].copy()
        column[row] = 0
        table -= np.multiply.outer(column, table[row])
        table[:, enters] = np.arange(n) == row
        left, basis[row] = int(basis[row]), enters
        if left == 2 * n:
            values = np.zeros(2 * n + 1)
            values[basis] = table[:, -1]
            return values[n : 2 * n]
        enters = left + n if left < n else left - n
        pivots = table[:, enters]
        possible = np.flatnonzero(pivots > ROUNDED_SUM)
        if not len(possible):
            return None
        ratios = table[possible, -1] / pivots[possible]
        least = ratios.min()
        ties = possible[ratios <= least + ROUNDED_CHAIN * (1 + abs(least))]
        artificial = ties[basis[ties] == 2 * n]
        order = np.lexsort((table[ties, :n] / pivots[ties, None]).T[::-1])
        row = int(artificial[0]) if len(artificial) else int(ties[order[0]])
    return None


def faceted(problem: ContactProblem) -> Array | None:
    """Forces λ (dk) for one coefficient per contact, with polyhedral cones in space; None if Lemke's method finds none."""
    k, d = problem.count, problem.dimension
    facets = np.array([[1.0], [-1.0]]) if d == 2 else unit(2 * np.pi * np.arange(_FACETS) / _FACETS)
    m, free = len(facets), np.flatnonzero(~problem.slides)
    n = k + (m + 1) * len(free)
    forces, gaps, speeds = np.zeros((d * k, n)), np.zeros((n, d * k)), np.zeros((n, n))
    for i in range(k):
        forces[d * i, i], gaps[i, d * i] = 1.0, 1.0
        forces[d * i + 1 : d * i + d, i] = -problem.kinetic[i] * problem.directions[i]
    for j, i in enumerate(free.tolist()):
        here, sigma, tangents = slice(k + j * m, k + j * m + m), n - len(free) + j, slice(d * i + 1, d * i + d)
        forces[tangents, here], gaps[here, tangents] = facets.T, facets
        speeds[here, sigma], speeds[sigma, i], speeds[sigma, here] = 1.0, problem.static[i], -1.0
    # scaled: accelerations by the largest |b|, forces by the largest |b| over the largest W_ii
    most, bias = np.diag(problem.mobility).max(), np.abs(problem.bias).max()
    if bias <= 0:
        return np.zeros(d * k)
    z = complementary(gaps @ (problem.mobility / most) @ forces + speeds, gaps @ (problem.bias / bias))
    return None if z is None else forces @ z * (bias / most)
