# SPDX-License-Identifier: BSD-3-Clause
"""How two routes are compared.

Relative to the largest number, or to 1 where all are smaller: all inputs are of order one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def tolerance(stated: float, condition: float) -> float:
    """max(stated, 100 eps cond)."""
    return max(stated, 100.0 * float(np.finfo(float).eps) * condition)


def error(value: ArrayLike, expected: ArrayLike) -> float:
    """Largest difference over the largest expected magnitude, at least 1."""
    reference = np.asarray(expected, dtype=float)
    difference = np.abs(np.asarray(value, dtype=float) - reference)
    if difference.shape != reference.shape:
        raise ValueError(f"shapes {np.shape(value)} and {reference.shape}")
    return float(difference.max() / max(1.0, float(np.abs(reference).max())))
