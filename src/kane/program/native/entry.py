# SPDX-License-Identifier: BSD-3-Clause
"""Kernels as machine code, and routines as they call them: where their code begins, and what was hoisted for them.

Calls kept in memory let a kernel make one of several: each a kernel with arguments, what hoists for it, two routines. The table has
a row for each: where the call of the kernel, the list of hoists and that of routines begin. The number before them says which one is
made, the next one takes what the kernel returns.
"""

import ctypes
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.errors import ProgramError
from kane.numeric.arrays import Array
from kane.program.emit.llvm import (
    block,
    bound_call,
    bound_calls,
    emit_kernel_lanes,
    emit_kernel_llvm,
    emit_masked,
    emit_wide,
    hoists,
    masked_name,
    masked_selection,
    selection,
    wide_name,
)
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
    """A function of a library, which it keeps alive."""

    library: Library
    symbol: str

    @property
    def address(self) -> int:
        """Where it begins."""
        return self.library.address(self.symbol)


class Hook:
    """A Python function that a kernel calls as a routine of (t, x, p, r, h, out) at one state: it is given t and where x and out are.

    An exception must not pass through machine code: it is kept as `raised`, and the function is not called any more.
    """

    __slots__ = ("_function", "raised")

    def __init__(self, function: Callable[[float, int, int], None]) -> None:
        self.raised: BaseException | None = None

        def call(t: float, x: int, p: int, r: int, h: int, out: int) -> None:
            if self.raised is None:
                try:
                    function(t, x, out)
                except BaseException as error:  # of any kind, an interrupt too
                    self.raised = error

        self._function = ctypes.CFUNCTYPE(None, ctypes.c_double, *[ctypes.c_void_p] * 5)(call)

    @property
    def address(self) -> int:
        """Where it begins."""
        return int(ctypes.cast(self._function, ctypes.c_void_p).value or 0)


def doubles(address: int, count: int) -> Array:
    """So many numbers at an address, as an array that is these and no copy."""
    block: Any = (ctypes.c_double * count).from_address(address)
    result: Array = np.frombuffer(block)
    return result


def entry(routine: CompiledRoutine) -> Entry:
    """The function of one evaluation, which takes its ports, h and what the results are written to."""
    return Entry(routine.library, routine.name)


def hoist_entry(routine: CompiledRoutine) -> Entry:
    """The function that writes h of the routine's program, of its ports of the tier "parameter" and h."""
    return Entry(routine.library, hoists([routine.program])[0])


def wide_entry(routine: CompiledRoutine, width: int) -> Entry:
    """The function of `width` evaluations at once, compiled when it is first asked for; see `emit_wide`."""
    (run,) = _more(routine, [wide_name(routine.name, width)], width, emit_wide)
    return run


def masked_entries(routine: CompiledRoutine, width: int) -> tuple[Entry, Entry]:
    """The function of `width` evaluations at once, each with parameters of its own, and what hoists for it; see `emit_masked`."""
    symbols = [masked_name(name, width) for name in (routine.name, hoists([routine.program])[0])]
    run, hoist = _more(routine, symbols, width, emit_masked)
    return run, hoist


def _more(routine: CompiledRoutine, symbols: Sequence[str], width: int, emit: Callable[..., str]) -> list[Entry]:
    if symbols[0] not in routine.more:
        text = emit(routine.program, routine.routine, width, routine.settings.contract)
        routine.more[symbols[0]] = _library_for(routine.settings, text, symbols)
    return [Entry(routine.more[symbols[0]], symbol) for symbol in symbols]


def _library_for(settings: Settings, text: str, symbols: Sequence[str], loops: bool = False) -> Library:
    """The library of an LLVM module for the processor of the settings."""
    return compile_text(text, target(settings.cpu, settings.features), symbols, settings.cache, loops)


class Selection:
    """Several routines of the same ports as one, of which a number in p says which is called; `table` is what it takes as h.

    At first none of the `count` is known; `put` gives one. `at` is the place of the number in p. Where they are `masked`, each lane
    calls its own.
    """

    def __init__(self, count: int, at: int, width: int, settings: Settings, masked: bool = False) -> None:
        self.table, self.width, self.masked = np.zeros(2 + 3 * count), width, masked
        self._rows = self.table.view(np.int64)
        self._rows[:2] = at, count
        self._kept: dict[int, tuple[Entry, Entry, Array]] = {}
        text = masked_selection(width) if masked else selection()
        own = [masked_name(f"select{name}", width) for name in ("", ".hoist")]
        one = "select.wide" if width > 1 else "select.one"
        self._names = own if masked else [one, "select.hoist"]
        self._library = _library_for(settings, text, self._names)

    @property
    def call(self) -> Entry:
        """The routine."""
        return Entry(self._library, self._names[0])

    @property
    def hoist(self) -> Entry:
        """What hoists for all that are known."""
        return Entry(self._library, self._names[1])

    def put(self, k: int, routine: CompiledRoutine, h: Array) -> None:
        """The kth routine, and what is hoisted for it."""
        if self.masked:
            own, hoist = masked_entries(routine, self.width)
        else:
            own, hoist = entry(routine) if self.width == 1 else wide_entry(routine, self.width), hoist_entry(routine)
        self._kept[k] = own, hoist, h
        self._rows[2 + 3 * k : 5 + 3 * k] = own.address, hoist.address, h.ctypes.data


def aligned(count: int) -> Array:
    """Zeros that begin where a vector of any width may."""
    raw = np.zeros(count + _ALIGNMENT // 8)
    skip = -raw.ctypes.data % _ALIGNMENT // 8
    return raw[skip : skip + count]


class Hoisting:
    """What hoists for a routine, of values of all ports: arrays and numbers of the right sizes; it depends on parameters alone."""

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


def hoisted(routine: CompiledRoutine, *values: Any) -> Array:
    """h for values of all ports; see `Hoisting`."""
    return Hoisting(routine)(*values)


class CompiledKernel:
    """One compiled kernel: `kernel(**given)` with an array, integer or `Entry` for each of its arguments.

    Threads may call it at the same time with arrays of their own; it runs without the interpreter's lock. `loops` says that
    it has long ones, which LLVM may make faster. Where there is a `width` it runs so many instances at once
    (`emit_kernel_lanes`), which have `shared` arrays.
    """

    __slots__ = ("_function", "entry", "kernel")

    def __init__(
        self, kernel: Kernel, settings: Settings, loops: bool = True, width: int = 0, shared: Collection[str] = ()
    ) -> None:
        self.kernel = kernel
        if width:
            text, name = emit_kernel_lanes(kernel, width, shared, settings.contract), masked_name(kernel.name, width)
        else:
            text, name = emit_kernel_llvm(kernel, settings.contract), kernel.name
        library = _library_for(settings, text, [name], loops)
        kinds = [_INTEGER if isinstance(a, Integer) else _POINTER for a in kernel.arguments]
        self.entry = Entry(library, name)
        self._function = library.function(name, _INTEGER, *kinds)

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

    __slots__ = ("_function", "_given", "_places", "passed")

    def __init__(self, function: Any, kernel: Kernel, given: Mapping[str, Array | int | Entry | Hook]) -> None:
        self._function, self._given = function, given
        self.passed = [_passed(a, given.get(a.name)) for a in kernel.arguments]
        self._places = {a.name: k for k, a in enumerate(kernel.arguments) if isinstance(a, Integer)}

    def __call__(self, **integers: int) -> int:
        """What the kernel returns."""
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
"""Where in the table what the kernel returned stands."""


class KeptCalls:
    """Calls that a kernel makes by the routines `make`, `hoist`, `look` and `drive`, which take the `table` as h."""

    def __init__(self, most: int, settings: Settings) -> None:
        self.table, self._settings = np.zeros(_FIRST + _ROW * most), settings
        self._rows = self.table.view(np.int64)
        self._kept: list[Any] = []
        self._library = _library_for(settings, bound_calls(), [f"kept.{name}" for name in _KEPT])
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
        symbol = f"kept.call{count}"
        return Entry(_library_for(self._settings, bound_call(count), [symbol]), symbol)


def xla_function(program: Program, settings: Settings) -> tuple[str, Entry]:
    """A name that no other code has, and the function, which keeps its code alive; `program` has one routine.

    Programs that XLA keeps on disk find the function by this name: it is the digest of the code's text.
    """
    (routine,) = program.routines
    on = target(settings.cpu, settings.features)
    text = emit_xla(program, routine, settings.contract, on.lanes)
    symbol = f"{routine.name}.xla"
    with working("Compiling"):
        library = _library_for(settings, text, [symbol])
    return f"kane.{routine.name}.{store.key(text)[:32]}", Entry(library, symbol)
