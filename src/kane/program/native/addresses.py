# SPDX-License-Identifier: BSD-3-Clause
"""Where the memory of an array begins."""

import ctypes

from kane.numeric.arrays import Array

_view = ctypes.c_char.from_buffer


def address(array: Array) -> int:
    """The address of the first element of a contiguous array, which must be kept as long as it is used.

    `array.ctypes` makes several objects, which takes longer than many a right-hand side; it is left to what cannot be written to, and
    to what is empty.
    """
    try:
        return ctypes.addressof(_view(array))  # type: ignore[arg-type]  # arrays have a buffer
    except (TypeError, ValueError):
        return int(array.ctypes.data)
