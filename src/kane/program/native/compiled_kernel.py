# SPDX-License-Identifier: BSD-3-Clause
"""Kernels as machine code: called with arrays of doubles, integers and routines."""

import ctypes
from collections.abc import Mapping
from typing import Any

import numpy as np

from kane.errors import ProgramError
from kane.numeric.arrays import Array
from kane.program.emit.llvm import emit_kernel_llvm
from kane.program.kernel.language import Argument, ArrayOf, Kernel, Number
from kane.program.native.entry import Entry, Hook
from kane.program.native.machine import Settings
from kane.program.native.machine_code import compile_text, target

_INTEGER, _POINTER = ctypes.c_int64, ctypes.c_void_p


class CompiledKernel:
    """One compiled kernel: `kernel(**given)` with an array, integer or `Entry` for each of its arguments.

    Threads may call it at the same time with arrays of their own; it runs without the interpreter's lock.
    """

    __slots__ = ("_function", "kernel")

    def __init__(self, kernel: Kernel, settings: Settings) -> None:
        self.kernel = kernel
        on = target(settings.cpu, settings.features)
        text = emit_kernel_llvm(kernel, settings.contract)
        library = compile_text(text, on, [kernel.name], settings.cache, loops=True)
        kinds = [_INTEGER if isinstance(a, Number) else _POINTER for a in kernel.arguments]
        self._function = library.function(kernel.name, _INTEGER, *kinds)

    def __call__(self, given: Mapping[str, Array | int | Entry | Hook]) -> int:
        """What the kernel returns; it writes to the arrays.

        Raises
        ------
        ProgramError
            if something else is given for an argument than what it is
        """
        return self.bound(given)()

    def bound(self, given: Mapping[str, Array | int | Entry | Hook]) -> "Bound":
        """The kernel with what is given, which is looked at once: finding the addresses takes as long as a hundred short steps.

        Raises
        ------
        ProgramError
            if something else is given for an argument than what it is
        """
        return Bound(self._function, self.kernel, dict(given))


class Bound:
    """A kernel with its arguments, which it keeps alive: `bound(limit=1000)` calls it, with other integers than were given."""

    __slots__ = ("_function", "_given", "_passed", "_places")

    def __init__(self, function: Any, kernel: Kernel, given: Mapping[str, Array | int | Entry | Hook]) -> None:
        self._function, self._given = function, given
        self._passed = [_passed(a, given.get(a.name)) for a in kernel.arguments]
        self._places = {a.name: k for k, a in enumerate(kernel.arguments) if isinstance(a, Number)}

    def __call__(self, **integers: int) -> int:
        """What the kernel returns."""
        for name, value in integers.items():
            self._passed[self._places[name]] = value
        return int(self._function(*self._passed))


def _passed(argument: Argument, given: Array | int | Entry | Hook | None) -> int:
    if isinstance(argument, Number) and isinstance(given, int):
        return given
    if isinstance(argument, ArrayOf) and isinstance(given, np.ndarray):
        if given.dtype == np.float64 and given.flags.c_contiguous and given.flags.writeable:
            return int(given.ctypes.data)
    elif not isinstance(argument, Number | ArrayOf) and isinstance(given, Entry | Hook):
        return given.address
    kind = "an integer" if isinstance(argument, Number) else "an array of doubles without gaps, to be written to"
    raise ProgramError(
        f"Expected {kind if isinstance(argument, Number | ArrayOf) else 'a routine'} as {argument.name}, got {given!r}."
    )
