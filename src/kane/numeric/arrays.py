# SPDX-License-Identifier: BSD-3-Clause
"""The types of arrays, and a product that every machine rounds alike."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]
Mask = npt.NDArray[np.bool_]
Entries = npt.NDArray[Any]
"""Numbers or expressions."""


def product(a: Array, b: Array) -> Array:
    """A B (l × m, m × n), each entry summed in order: BLAS rounds as the machine has it, which numbers in equations must not."""
    total = np.zeros((a.shape[0], b.shape[1]))
    for column, row in zip(a.T, b, strict=True):
        total += np.multiply.outer(column, row)
    return total
