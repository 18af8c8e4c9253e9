# SPDX-License-Identifier: BSD-3-Clause
"""Kernels as machine code, and the entries and hoisted values of the routines that they call.

A table of calls in memory (`KeptCalls`) lets a kernel run one of several others, each with its arguments, hoisting functions and two
routines. A row of the table has the addresses of the call of the kernel, of the list of hoisting functions and of the routines. The
first number of the table selects the row; the second receives the kernel's result.
"""

import ctypes
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.errors import ProgramError
from kane.numeric.arrays import Array
from kane.program.emit import llvm
from kane.program.emit.llvm import block, hoists
from kane.program.emit.xla_handler import emit_xla
from kane.program.kernel.language import Argument, ArrayOf, Integer, Kernel
from kane.program.native import store
from kane.program.native.compiled_routine import CompiledRoutine, new_block
from kane.program.native.machine import Library, Settings, compile_text, target
from kane.program.program import Program
from kane.progress import working

_ALIGNMENT = 64
_INTEGER, _POINTER = ctypes.c_int64, ctypes.c_void_p


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A function of a library, which the entry keeps alive."""

    library: Library
    symbol: str

    @property
    def address(self) -> int:
        """Its address."""
        return self.library.address(self.symbol)


class Hook:
    """A Python function that a kernel calls as a routine (t, x, p, r, h, out); it receives t and the addresses of x and out.

    Exceptions cannot propagate through machine code: the first one is stored in `raised`, after which the function is not called.
    """

    __slots__ = ("_function", "raised")

    def __init__(self, function: Callable[[float, int, int], None]) -> None:
        self.raised: BaseException | None = None

        def call(t: float, x: int, p: int, r: int, h: int, out: int) -> None:
            if self.raised is None:
                try:
                    function(t, x, out)
                except BaseException as error:  # including KeyboardInterrupt
                    self.raised = error

        self._function = ctypes.CFUNCTYPE(None, ctypes.c_double, *[ctypes.c_void_p] * 5)(call)

    @property
    def address(self) -> int:
        """The address of the C callback."""
        return int(ctypes.cast(self._function, ctypes.c_void_p).value or 0)


def doubles(address: int, count: int) -> Array:
    """The `count` doubles at an address as an array, without a copy."""
    block: Any = (ctypes.c_double * count).from_address(address)
    result: Array = np.frombuffer(block)
    return result


def entry(routine: CompiledRoutine) -> Entry:
    """The function of one evaluation, with its ports, h and the results as arguments."""
    return Entry(routine.library, routine.name)


def hoist_entry(routine: CompiledRoutine) -> Entry:
    """The function that computes h of the routine's program; its arguments are the parameter ports and h."""
    return Entry(routine.library, hoists([routine.program])[0])


def wide_entry(routine: CompiledRoutine, width: int) -> Entry:
    """The function of `width` evaluations at once, compiled on first use; see `emit_wide`."""
    (run,) = _more(routine, [llvm.wide_name(routine.name, width)], width, llvm.emit_wide)
    return run


def masked_entries(routine: CompiledRoutine, width: int) -> tuple[Entry, Entry]:
    """The function of `width` evaluations at once, each with its own parameters, and its hoisting function; see `emit_masked`."""
    symbols = [llvm.masked_name(name, width) for name in (routine.name, hoists([routine.program])[0])]
    run, hoist = _more(routine, symbols, width, llvm.emit_masked)
    return run, hoist


def _more(routine: CompiledRoutine, symbols: Sequence[str], width: int, emit: Callable[..., str]) -> list[Entry]:
    if symbols[0] not in routine.more:
        text = emit(routine.program, routine.routine, width, routine.settings.contract)
        routine.more[symbols[0]] = _library_for(routine.settings, text, symbols)
    return [Entry(routine.more[symbols[0]], symbol) for symbol in symbols]


def _library_for(settings: Settings, text: str, symbols: Sequence[str], loops: bool = False) -> Library:
    """The library of an LLVM module for the processor in the settings."""
    return compile_text(text, target(settings.cpu, settings.features), symbols, settings.cache, loops)


class Selection:
    """Several routines with the same ports as one, selected by a number in p; `table` is its h.

    All `count` entries are initially empty; `put` sets one. `at` is the index of the number in p. If `masked`, each lane selects its
    own routine.
    """

    def __init__(self, count: int, at: int, width: int, settings: Settings, masked: bool = False) -> None:
        self.table, self.width, self.masked = np.zeros(2 + 3 * count), width, masked
        self._rows = self.table.view(np.int64)
        self._rows[:2] = at, count
        self._kept: dict[int, tuple[Entry, Entry, Array]] = {}
        text = llvm.masked_selection(width) if masked else llvm.selection()
        own = [llvm.masked_name(f"select{name}", width) for name in ("", ".hoist")]
        one = "select.wide" if width > 1 else "select.one"
        self._names = own if masked else [one, "select.hoist"]
        self._library = _library_for(settings, text, self._names)

    @property
    def call(self) -> Entry:
        """The selecting routine."""
        return Entry(self._library, self._names[0])

    @property
    def hoist(self) -> Entry:
        """The hoisting function, which runs those of all routines that are set."""
        return Entry(self._library, self._names[1])

    def put(self, k: int, routine: CompiledRoutine, h: Array) -> None:
        """Sets the kth routine and its hoisted values."""
        if self.masked:
            own, hoist = masked_entries(routine, self.width)
        else:
            own, hoist = entry(routine) if self.width == 1 else wide_entry(routine, self.width), hoist_entry(routine)
        self._kept[k] = own, hoist, h
        self._rows[2 + 3 * k : 5 + 3 * k] = own.address, hoist.address, h.ctypes.data


def aligned(count: int) -> Array:
    """Zeros, aligned for vectors of any width."""
    raw = np.zeros(count + _ALIGNMENT // 8)
    skip = -raw.ctypes.data % _ALIGNMENT // 8
    return raw[skip : skip + count]


def aligned_copy(values: Array) -> Array:
    """The numbers as an aligned array, with at least one element."""
    copy = aligned(max(1, values.size))
    copy[: values.size] = values.reshape(-1)
    return copy


class Hoisting:
    """Computes h of a routine from values of all ports, arrays and numbers of the right sizes; h depends only on parameters."""

    __slots__ = ("_block", "_h", "_run")

    def __init__(self, routine: CompiledRoutine) -> None:
        self._block, self._run = new_block(routine.program, routine.routine), routine.run
        at = block(routine.program, routine.routine)
        memory = np.ctypeslib.as_array(ctypes.cast(self._block[0], ctypes.POINTER(ctypes.c_double)), (at.size,))
        self._h = memory[at.h : at.h + max(1, len(routine.program.kept))]

    def __call__(self, *values: Any) -> Array:
        """h for these values."""
        for view, value in zip(self._block[1:-1], values, strict=True):
            if isinstance(view, ctypes.c_double):
                view.value = value
            elif len(value):
                view[:] = np.asarray(value, dtype=float)
        self._run(self._block)
        return self._h.copy()


Hoisted = Sequence[tuple[Entry, Array]]
"""Hoisting functions, and the h of each."""


def hoists_of(given: Mapping[str, Any]) -> Hoisted:
    """The hoisting functions among the arguments of a kernel."""
    return [(given[f"hoist_{name}"], given[name]) for name in given if f"hoist_{name}" in given]


def hoisting(pairs: Hoisted) -> Callable[[Array], None]:
    """A function of the parameters p (aligned doubles) that computes h of each pair."""
    calls = [(f.library.function(f.symbol, None, _POINTER, _POINTER), h.ctypes.data) for f, h in pairs]

    def hoist(p: Array) -> None:
        for call, h in calls:
            call(p.ctypes.data, h)

    return hoist


def hoisted(routine: CompiledRoutine, *values: Any) -> Array:
    """h for values of all ports; see `Hoisting`."""
    return Hoisting(routine)(*values)


class CompiledKernel:
    """A compiled kernel, called with a mapping from each argument to an array, integer, `Entry` or `Hook`.

    It is thread-safe with separate arrays, and runs without the GIL. `loops` requests LLVM's loop passes, for kernels with long loops.
    With a `width` it runs that many instances at once (`emit_kernel_lanes`), which have `shared` arrays in common.
    """

    __slots__ = ("_function", "entry", "kernel")

    def __init__(
        self, kernel: Kernel, settings: Settings, loops: bool = True, width: int = 0, shared: Collection[str] = ()
    ) -> None:
        self.kernel = kernel
        if width:
            text, name = (
                llvm.emit_kernel_lanes(kernel, width, shared, settings.contract),
                llvm.masked_name(kernel.name, width),
            )
        else:
            text, name = llvm.emit_kernel_llvm(kernel, settings.contract), kernel.name
        library = _library_for(settings, text, [name], loops)
        kinds = [_INTEGER if isinstance(a, Integer) else _POINTER for a in kernel.arguments]
        self.entry = Entry(library, name)
        self._function = library.function(name, _INTEGER, *kinds)

    def __call__(self, given: Mapping[str, Array | int | Entry | Hook]) -> int:
        """Runs the kernel, which writes to the arrays, and returns its result.

        Raises
        ------
        ProgramError
            if an argument has the wrong kind
        """
        return self.bound(given)()

    def bound(self, given: Mapping[str, Array | int | Entry | Hook]) -> "Bound":
        """The kernel with arguments that are checked once: finding the addresses takes as long as a hundred short steps.

        Raises
        ------
        ProgramError
            if an argument has the wrong kind
        """
        return Bound(self._function, self.kernel, dict(given))


class Bound:
    """A kernel with its arguments, which it keeps alive: `bound(limit=1000)` calls it with other values of the integers."""

    __slots__ = ("_function", "_given", "_places", "passed")

    def __init__(self, function: Any, kernel: Kernel, given: Mapping[str, Array | int | Entry | Hook]) -> None:
        self._function, self._given = function, given
        self.passed = [_passed(a, given.get(a.name)) for a in kernel.arguments]
        self._places = {a.name: k for k, a in enumerate(kernel.arguments) if isinstance(a, Integer)}

    def __call__(self, **integers: int) -> int:
        """Runs the kernel and returns its result."""
        for name, value in integers.items():
            self.passed[self._places[name]] = value
        return int(self._function(*self.passed))


def _passed(argument: Argument, given: Array | int | Entry | Hook | None) -> int:
    if isinstance(argument, Integer) and isinstance(given, int):
        return given
    if isinstance(argument, ArrayOf) and isinstance(given, np.ndarray):
        if given.dtype == np.float64 and given.flags.c_contiguous and given.flags.writeable:
            return int(given.ctypes.data)
    elif not isinstance(argument, Integer | ArrayOf) and isinstance(given, Entry | Hook):
        return given.address
    kind = "an integer" if isinstance(argument, Integer) else "an array of doubles without gaps, to be written to"
    raise ProgramError(
        f"Expected {kind if isinstance(argument, Integer | ArrayOf) else 'a routine'} as {argument.name}, got {given!r}."
    )


_ROW, _FIRST = 3, 2
_KEPT = ("make", "hoist", "look", "drive")
RESULT = 1
"""The index of the kernel's result in the table."""


class KeptCalls:
    """A table of calls, which a kernel makes by the routines `make`, `hoist`, `look` and `drive`, whose h is `table`."""

    def __init__(self, most: int, settings: Settings) -> None:
        self.table, self._settings = np.zeros(_FIRST + _ROW * most), settings
        self._rows = self.table.view(np.int64)
        self._kept: list[Any] = []
        self._library = _library_for(settings, llvm.bound_calls(), [f"kept.{name}" for name in _KEPT])
        self.make, self.hoist, self.look, self.drive = (Entry(self._library, f"kept.{name}") for name in _KEPT)

    def put(
        self,
        k: int,
        kernel: tuple[CompiledKernel, Mapping[str, Any]],
        hoists: Hoisted,
        routines: Sequence[tuple[Entry, Array]],
        p: Array,
    ) -> None:
        """Sets the kth call: a kernel with arguments, hoisting functions and their h for parameters p, two routines and their h."""
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
        """The function that calls a kernel with `count` arguments."""
        symbol = f"kept.call{count}"
        return Entry(_library_for(self._settings, llvm.bound_call(count), [symbol]), symbol)


def xla_function(program: Program, settings: Settings) -> tuple[str, Entry]:
    """A unique name, and the function, which keeps its code alive; `program` has one routine.

    The name is the digest of the code's text, so that programs in XLA's cache on disk find the function again.
    """
    (routine,) = program.routines
    on = target(settings.cpu, settings.features)
    text = emit_xla(program, routine, settings.contract, on.lanes)
    symbol = f"{routine.name}.xla"
    with working("Compiling"):
        library = _library_for(settings, text, [symbol])
    return f"kane.{routine.name}.{store.key(text)[:32]}", Entry(library, symbol)
