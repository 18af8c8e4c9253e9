# SPDX-License-Identifier: BSD-3-Clause
"""Calls kept in memory, so that a kernel makes one of several: each a kernel with arguments, what hoists for it, two routines.

The table has a row for each: where the call of the kernel, the list of hoists and that of routines begin. The number before them says
which one is made, the next one takes what the kernel returns.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kane.numeric.arrays import Array
from kane.program.emit.llvm import kept_call, kept_calls
from kane.program.native.entry import CompiledKernel, Entry
from kane.program.native.machine import Settings, compile_text, target

_ROW, _FIRST = 3, 2
_KEPT = ("make", "hoist", "look", "drive")
RESULT = 1
"""Where in the table what the kernel returned stands."""


class KeptCalls:
    """Calls that a kernel makes by the routines `make`, `hoist`, `look` and `drive`, which take the `table` as h."""

    def __init__(self, most: int, settings: Settings) -> None:
        self.table, self._settings = np.zeros(_FIRST + _ROW * most), settings
        self._rows = self.table.view(np.int64)
        self._kept: list[Any] = []
        on = target(settings.cpu, settings.features)
        self._library = compile_text(kept_calls(), on, [f"kept.{name}" for name in _KEPT], settings.cache)
        self.make, self.hoist, self.look, self.drive = (Entry(self._library, f"kept.{name}") for name in _KEPT)

    def put(
        self,
        k: int,
        kernel: tuple[CompiledKernel, Mapping[str, Any]],
        hoists: Sequence[tuple[Entry, Array]],
        routines: Sequence[tuple[Entry, Array]],
        p: Array,
    ) -> None:
        """The kth call: a kernel with what it is given, the hoists (function, h) of the parameters p, two routines with their h."""
        own, given = kernel
        bound = own.bound(given)
        call = self._call_of(len(bound.passed))
        words = (
            [call.address, own.entry.address, *bound.passed],
            [len(hoists), p.ctypes.data, *(x for f, h in hoists for x in (f.address, h.ctypes.data))],
            [p.ctypes.data, *(x for f, h in routines for x in (f.address, h.ctypes.data))],
        )
        block, listed, looked = (np.array(row, dtype=np.int64) for row in words)
        self._kept.append((bound, call, hoists, routines, p, block, listed, looked))
        at = _FIRST + _ROW * k
        self._rows[at : at + _ROW] = block.ctypes.data, listed.ctypes.data, looked.ctypes.data

    def _call_of(self, count: int) -> Entry:
        """The function that calls one of so many arguments."""
        symbol, on = f"kept.call{count}", target(self._settings.cpu, self._settings.features)
        return Entry(compile_text(kept_call(count), on, [symbol], self._settings.cache), symbol)
