# SPDX-License-Identifier: BSD-3-Clause
"""The types of arrays, a product that every machine rounds alike, and where in an array something is wrong."""

from typing import Any, NamedTuple

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


class First(NamedTuple):
    """The first `place` of several, () of a single number, `written` as an index, and how many `others` there are."""

    place: tuple[int, ...]
    written: str
    others: int

    def __str__(self) -> str:
        return f"index {self.written}{f' and {self.others} more' if self.others else ''}"


def first_place(mask: Any) -> First:
    """The first place at which a mask holds somewhere."""
    place = tuple(int(i) for i in np.argwhere(mask)[0])
    return First(place, str(place[0] if len(place) == 1 else place), int(np.sum(mask)) - 1)
