# SPDX-License-Identifier: BSD-3-Clause
"""Rank of a matrix of numbers, whatever the units of its rows and columns."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def null_direction(matrix: Array, slack: float) -> Array | None:
    """x with A x = 0, its entries scaled; None where A is regular (or not finite, so that nothing can be said).

    Rows and columns are balanced first, so that units do not matter; singular means σ_min ≤ slack σ_max.
    """
    if not np.all(np.isfinite(matrix)):
        return None
    a = matrix
    for _ in range(2):
        for axis in (0, 1):
            size = np.abs(a).max(axis=axis, keepdims=True)
            a = a / np.where(size > 0, size, 1.0)
    _, sigma, right = np.linalg.svd(a)
    found: Array = right[-1]
    return found if sigma[-1] <= slack * sigma[0] else None
