# SPDX-License-Identifier: BSD-3-Clause
"""Compiled routines callable from Python, with one argument for each port of the program.

Arguments are converted to arrays of doubles; an error names an argument of the wrong length.
"""

import ctypes
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite
from struct import Struct
from typing import Any, Generic, Literal, TypeAlias, TypeVar

import numpy as np
from numpy import vdot

from kane.errors import ArgumentError, Attributes, NotFiniteError, ValueMissingError, cut, warn
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array
from kane.numeric.sampling import finite_number, named_values
from kane.program.emit.llvm import block
from kane.program.from_expressions import Bundle
from kane.program.native.machine import Library, Settings, build_library
from kane.program.program import Port, Program, Routine, explain

R = TypeVar("R")
NotFinite = Literal["warn", "raise", "ignore"]
Block: TypeAlias = tuple[Any, ...]
"""The memory of one call: its address, a view of each port's values, and the results. A bare tuple is fastest to unpack."""

_ALIGNMENT = 64
_ARRAY: Any = np.ndarray
_DOUBLE = np.dtype(np.float64)
_NUMBERS = frozenset((float, int, np.float64))
_MOST_KEYS = 1000
"""The maximum number of remembered sets of keys."""
ALL = slice(None)
_view = ctypes.c_char.from_buffer
_FEW = 4096
"""The number of elements up to which finiteness is checked by the sum of squares."""


def new_block(program: Program, routine: Routine) -> Block:
    """A new block of memory, followed by room for the h of a batch; its first call computes the hoisted values."""
    at = block(program, routine)
    size = 8 * (at.size + max(1, len(program.kept)))
    raw = np.zeros(size + _ALIGNMENT, np.uint8)
    skip = -raw.ctypes.data % _ALIGNMENT
    memory = raw[skip : skip + size].view(np.float64)
    memory[at.hoisted : at.h].view(np.int64)[:] = -1  # a NaN pattern that arithmetic does not produce
    ports: list[Any] = []
    for port, start in zip(program.ports, at.ports, strict=True):
        own = memory[start : start + len(port.symbols)]
        ports.append(ctypes.c_double.from_buffer(own) if port.scalar else own.data)  # type: ignore[arg-type]  # arrays have a buffer
    results = memory[at.out : at.out + len(routine.results)].reshape(routine.shape)
    return (ctypes.c_void_p(memory.ctypes.data), *ports, results)


def address(array: Array) -> int:
    """The address of the first element of a contiguous array, which the caller must keep alive.

    `array.ctypes` creates several objects, which can take longer than a right-hand side; it is used only for read-only and empty
    arrays.
    """
    try:
        return ctypes.addressof(_view(array))  # type: ignore[arg-type]  # arrays have a buffer
    except (TypeError, ValueError):
        return int(array.ctypes.data)


def _is_finite(a: Array) -> bool:
    """Whether all elements are finite; false too if there are few elements and the sum of their squares overflows.

    The sum takes a third of the time, but for many elements BLAS uses threads, which may take longer than all evaluations.
    """
    return isfinite(vdot(a, a)) if a.size <= _FEW else bool(np.isfinite(a).all())


class CompiledRoutine(Attributes):
    """A compiled routine: `routine(*values)` with one argument for each port of its program, by position or name.

    A scalar port takes a number; a vector port takes values (…, n) or a mapping by symbol or name. Omitted parameters have their
    defaults. Leading axes are broadcast; the result, always a new array, has them, followed by `shape`. Calls are thread-safe: each
    uses its own block of memory.

    NaN or infinity in the arguments is an `ArgumentError`. If a result is not finite, `not_finite` decides: "warn" (`KaneWarning`)
    or "raise" (`NotFiniteError`); both name the first intermediate that is not. With "ignore" nothing is checked.
    """

    __slots__ = (
        "__weakref__",
        "_batch",
        "_call",
        "_defaults",
        "_free",
        "_layout",
        "_library",
        "_named",
        "_places",
        "_standard",
        "more",
        "not_finite",
        "program",
        "routine",
        "settings",
    )

    def __init__(
        self,
        program: Program,
        name: str,
        settings: Settings,
        defaults: Mapping[str, Array] | None = None,
        not_finite: NotFinite = "warn",
        library: Library | None = None,
    ) -> None:
        if not_finite not in ("warn", "raise", "ignore"):
            raise ArgumentError(f'Expected not_finite to be "warn", "raise" or "ignore", got {not_finite!r}.')
        self.program, self.routine, self.settings = program, program.routine(name), settings
        self.not_finite = not_finite
        own = {port.name: port_defaults(port) for port in program.hoisted_ports} | dict(defaults or {})
        self._defaults = {name: np.array(values) for name, values in own.items()}
        self._free: list[Block] = []
        self._named: dict[tuple[Any, ...], tuple[tuple[int, ...], Callable[..., None] | None]] = {}
        """The indices of values in mappings, by port and keys, for keys that have been validated; and, if the keys are all symbols in
        order, the function that writes all values at once."""
        self.more: dict[str, Library] = {}
        """Libraries of other versions of the routine, by the names of their functions."""
        self._places = range(len(program.ports))
        self._standard = tuple(self._without_values(port.name, len(port.symbols)) for port in program.ports)
        self._layout = self._laid_out()
        library = self._library = library or build_library([program], settings)
        pointer, count = ctypes.c_void_p, ctypes.c_int64
        self._call: Callable[[Any], int] = library.function(f"{name}.call", ctypes.c_int32, pointer, brief=True)
        ports = [pointer, count] * len(program.ports)
        self._batch = library.function(f"{name}.batch", count, count, *ports, pointer, pointer)

    def _without_values(self, port: str, count: int) -> Any:
        """The values used for a port that a call omits; None if it cannot be omitted."""
        return self._defaults[port].data if port in self._defaults else None if count else np.zeros(0).data

    def _laid_out(self) -> tuple[tuple[tuple[int, int, bool, Any], ...], int]:
        """For each port: offset in the block (bytes), size, whether it is scalar, defaults if finite; and the size of the block."""
        at, kept = block(self.program, self.routine), []
        for start, port, standard in zip(at.ports, self.program.ports, self._standard, strict=True):
            usual = standard if standard is not None and np.isfinite(standard).all() else None
            kept.append((8 * start, len(port.symbols), port.scalar, usual))
        return tuple(kept), 8 * at.size

    @property
    def library(self) -> Library:
        """The library of the machine code."""
        return self._library

    def run(self, own: Block) -> bool:
        """Evaluates on a block whose inputs are set; whether an input or a result is not finite."""
        return bool(self._call(own[0]))

    @property
    def name(self) -> str:
        """The routine's name."""
        return self.routine.name

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the result of one evaluation."""
        return self.routine.shape

    @property
    def labels(self) -> tuple[str, ...]:
        """The label of each result, in row-major order."""
        return self.routine.labels

    def __call__(self, *values: Any, **named: Any) -> Array:
        """The results at the given values of the ports."""
        inputs = self._by_port(values, named) if named or len(values) < len(self._standard) else values
        free = self._free
        try:  # take a block that no other call uses: calls may be nested, also in hooks and signal handlers
            own = free.pop()
        except IndexError:
            own = new_block(self.program, self.routine)
        try:  # fast path without conversion: a memoryview accepts only doubles of the same shape
            for port, view, value, standard in zip(self._places, own[1:-1], inputs, self._standard, strict=True):
                kind = type(value)
                if kind is _ARRAY:
                    view[ALL] = value
                elif kind is float or kind is np.float64:
                    view.value = value
                elif value is None:
                    view[ALL] = standard
                elif kind is dict:
                    self._put(port, view, value, standard)
                else:
                    raise TypeError
        except (AttributeError, KeyError, OverflowError, TypeError, ValueError, NotImplementedError):
            free.append(own)
            rows = self._in_rows(inputs)
            return self._general(*inputs) if rows is None else rows
        if self._call(own[0]):
            return self._doubtful(own, inputs)
        results: Array = own[-1].copy()
        free.append(own)
        return results

    def _put(self, port: int, view: Any, given: dict[Any, Any], standard: Any) -> None:
        """Writes values given by symbol or name to the memory of a port; KeyError if the keys have not been validated."""
        places, pack = self._named[port, *given]
        values = given.values()
        if not _NUMBERS.issuperset(map(type, values)):
            raise TypeError
        if pack is not None:
            pack(view, 0, *values)
            return
        if standard is not None:
            view[ALL] = standard
        for place, value in zip(places, values, strict=True):
            view[place] = value

    def _in_rows(self, inputs: tuple[Any, ...]) -> Array | None:
        """The results for rows of values in some ports and shared ones in others; None if an argument needs conversion or an error."""
        try:
            own = self._free.pop()
        except IndexError:
            own = new_block(self.program, self.routine)
        layout, end = self._layout
        base, count = own[0].value, -1
        pairs, alive = list[int](), list[Array]()
        try:
            for port, (at, width, scalar, usual), view, value in zip(
                self._places, layout, own[1:-1], inputs, strict=True
            ):
                rows = type(value) is _ARRAY and value.ndim - (not scalar)
                if rows == 1 and value.dtype == _DOUBLE and (scalar or value.shape[1] == width):
                    if count not in (-1, len(value)) or not len(value) or not _is_finite(value):
                        return None
                    whole = value if value.flags.carray else np.require(value, requirements=["C", "A"])
                    count = len(value)
                    alive.append(whole)
                    pairs += (address(whole), width)
                elif self._is_put(port, view, value, usual):
                    pairs += (base + at, 0)
                else:
                    return None
            if count < 0:
                return None
            out = np.empty((count, *self.shape))
            first = self._batch(count, *pairs, base + end, address(out))
        except (AttributeError, KeyError, OverflowError, TypeError, ValueError, NotImplementedError):
            return None
        finally:
            self._free.append(own)
        return out if first < 0 or self.not_finite == "ignore" else None

    def on_rows(self, *places: tuple[Array, int], out: Array) -> Callable[[], int]:
        """A function that evaluates at the rows that arrays contain when it is called, and writes rows of results; not thread-safe.

        Each port has an array and the stride of its rows in doubles, 0 if all share one row. Nothing is checked.
        """
        own = new_block(self.program, self.routine)
        pairs = [x for array, apart in places for x in (address(array), apart)]
        given = (len(out), *pairs, own[0].value + self._layout[1], address(out))
        kept = own, places, out  # keeps the memory alive that the call reads and writes

        def evaluate(batch: Any = self._batch, given: tuple[int, ...] = given, kept: Any = kept) -> int:
            return int(batch(*given))

        return evaluate

    def _is_put(self, port: int, view: Any, value: Any, usual: Any) -> bool:
        """Writes values shared by all rows to the memory of a port, `usual` for None; whether their type is plain, all finite."""
        kind = type(value)
        if kind is _ARRAY:
            view[ALL] = value
            return _is_finite(value)
        if kind in _NUMBERS:
            view.value = value
            return isfinite(value)
        if kind is dict:
            self._put(port, view, value, usual)
            return isfinite(sum(value.values()))
        if value is None and usual is not None:
            view[ALL] = usual
            return True
        return False

    def _remember(self, inputs: tuple[Any, ...]) -> None:
        """Remembers the validated keys of mappings."""
        for at, port, given in zip(self._places, self.program.ports, inputs, strict=True):
            if type(given) is dict and not port.scalar and len(self._named) < _MOST_KEYS:
                place = {s: k for k, s in enumerate(port.symbols)} | {s.name: k for k, s in enumerate(port.symbols)}
                if all(key in place for key in given):
                    places = tuple(place[key] for key in given)
                    whole = places == tuple(range(len(port.symbols)))
                    self._named[at, *given] = places, Struct(f"{len(places)}d").pack_into if whole else None

    def _doubtful(self, own: Block, inputs: tuple[Any, ...]) -> Array:
        """The results of a call with NaN or infinity; the error or warning names the argument or the intermediate."""
        ports = self.program.ports
        results: Array = own[-1].copy()
        met = [np.array(view.value if p.scalar else view) for p, view in zip(ports, own[1:-1], strict=True)]
        self._free.append(own)
        for port, value in zip(ports, inputs, strict=True):
            if value is None and port.hoisted:
                check_complete(port, self._defaults[port.name])
        if self.not_finite != "ignore":
            for port, values in zip(ports, met, strict=True):
                check_finite(port, values)
            self._refuse_not_finite([float(v) for a in met for v in a.flat], "")
        return results

    def _by_port(self, values: tuple[Any, ...], named: Mapping[str, Any]) -> tuple[Any, ...]:
        """Arguments in the order of the ports, None for omitted ones."""
        names = [port.name for port in self.program.ports]
        by_name = dict(zip(names, values, strict=False))
        wrong = [name for name in named if name not in names or name in by_name]
        if wrong or len(values) > len(names):
            raise ArgumentError(
                f"Expected the arguments {', '.join(names)}, each once, got {', '.join(wrong) or len(values)}."
            )
        by_name.update(named)
        return tuple(by_name.get(name) for name in names)

    def _general(self, *inputs: Any) -> Array:
        """The results for arguments of any kind, which are converted, checked and broadcast."""
        ports, arrays = self.program.ports, self._arrays(inputs)
        self._remember(inputs)
        leading = [a.shape if port.scalar else a.shape[:-1] for port, a in zip(ports, arrays, strict=True)]
        try:
            rows = np.broadcast_shapes(*leading)
        except ValueError as error:
            shapes = ", ".join(f"{port.name} {a.shape}" for port, a in zip(ports, arrays, strict=True))
            raise ArgumentError(f"Expected leading axes that broadcast, got {shapes}.") from error
        if self.not_finite != "ignore":
            for port, a in zip(ports, arrays, strict=True):
                check_finite(port, a)
        return self._rows(rows, leading, arrays)

    def _arrays(self, inputs: tuple[Any, ...]) -> list[Array]:
        """The arguments as arrays of doubles, with defaults for omitted parameters."""
        return [
            port_values(port, value, self._defaults.get(port.name))
            for port, value in zip(self.program.ports, inputs, strict=True)
        ]

    def _rows(self, rows: tuple[int, ...], leading: list[tuple[int, ...]], inputs: list[Array]) -> Array:
        """Evaluates many rows in one native loop; values shared by all rows are passed once, with stride 0."""
        count = math.prod(rows)
        flat: list[Array] = []
        for port, lead, a in zip(self.program.ports, leading, inputs, strict=True):
            width = len(port.symbols)
            shared = math.prod(lead) == 1
            wide = a if shared else np.broadcast_to(a.reshape(*lead, width), (*rows, width))
            flat.append(np.require(wide.reshape(1 if shared else count, width), requirements=["C", "A"]))
        out = np.empty((*rows, *self.shape))
        h = np.empty(max(1, len(self.program.kept)))
        strides = [0 if len(a) == 1 else a.shape[1] for a in flat]
        pairs = [v for a, stride in zip(flat, strides, strict=True) for v in (address(a), stride)]
        first_bad = self._batch(count, *pairs, address(h), address(out))
        if first_bad >= 0 and self.not_finite != "ignore":
            where = tuple(map(int, np.unravel_index(first_bad, rows)))
            self._refuse_not_finite([float(v) for a in flat for v in a[first_bad % len(a)]], f" at {where}")
        return out

    def _refuse_not_finite(self, inputs: list[float], where: str) -> None:
        reason = explain(self.program, self.routine, inputs) or (
            "NaN or infinity where separate roundings give none: a difference of equal numbers is not quite zero with fused "
            "multiply-adds or shared reciprocals. Use compile(contract=False)"
        )
        message = f"Expected finite results of {self.name}{where}, got {reason}."
        if self.not_finite == "raise":
            raise NotFiniteError(message)
        warn(message)

    def explain(self, *inputs: Any) -> str:
        """A message about the first intermediate that is not finite at one state, and its operands; "" if all are finite."""
        arrays = self._arrays(inputs)
        if any(a.ndim > (not port.scalar) for port, a in zip(self.program.ports, arrays, strict=True)):
            raise ArgumentError(f"Expected one state to explain, got shapes {', '.join(str(a.shape) for a in arrays)}.")
        return explain(self.program, self.routine, [float(v) for a in arrays for v in a.flat])

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.program, self.name, self.settings, self._defaults, self.not_finite)

    def __repr__(self) -> str:
        few = f"{', '.join(self.labels[:8])}{', …' if len(self.labels) > 8 else ''}"
        return f"<{self.name}({self.program.signature}) -> {list(self.shape)}: {few}>"


@dataclass(frozen=True, slots=True, eq=False)
class BundleRoutine(Generic[R]):
    """A compiled bundle: a call with values of its ports returns the record; `flat` returns the results as one vector."""

    bundle: Bundle[R]
    flat: CompiledRoutine

    def __call__(self, *values: Any) -> R:
        """The record at the given values of the ports."""
        return self.bundle.split(self.flat(*values))


# Arguments -----------------------------------------------------------------------------------------------------------


_REAL = "biuf"


def port_values(port: Port, argument: Any, base: Array | None = None) -> Array:
    """The values of a port: a number or array of numbers for a scalar port, else (…, n), or a mapping by symbol or name.

    `base` supplies omitted values.

    Raises
    ------
    ArgumentError
        if the shape or the type is wrong
    ValueMissingError
        if a name is unknown or a value is missing
    """
    if argument is None and port.scalar and base is not None:
        return check_complete(port, base)[:1].reshape(())
    if argument is None and (port.optional or base is not None or not port.symbols) and not port.scalar:
        argument = {}
    if isinstance(argument, Mapping) and not port.scalar:
        return _by_name(port, argument, base)
    array = _real(port.name, argument)
    if not port.scalar and (array.ndim < 1 or array.shape[-1] != len(port.symbols)):
        raise ArgumentError(
            f"Expected {port.name} of shape (…, {len(port.symbols)}), got shape {array.shape}. The order is {listed(port.symbols)}."
        )
    return array


def port_defaults(port: Port) -> Array:
    """The defaults of all parameters, NaN for those without one."""
    return np.array([np.nan if s.default is None else float(s.default) for s in port.symbols])


def replaced_values(port: Port, argument: Mapping[Any, Any], base: Array) -> Array:
    """`base` with the values given by symbol or name replaced."""
    own = named_values(port.nouns, port.symbols, argument)
    pairs = zip(port.symbols, base, strict=True)
    return np.array([finite_number("value", s.name, own[s]) if s in own else b for s, b in pairs])


def check_complete(port: Port, values: Array) -> Array:
    """`values`; raises if one is missing (NaN)."""
    missing = [s.name for s, v in zip(port.symbols, values, strict=True) if np.isnan(v)]
    if missing:
        by_name = f", {{{', '.join(f'{n!r}: value' for n in missing)}}}"
        cure = ", or declare a default, kn.parameter(name, default)" if port.hoisted else by_name * port.optional
        raise ValueMissingError(
            f"Expected a value for every one of the {port.nouns}, got none for {', '.join(missing)}: pass them as "
            f"{port.name}{cure}."
        )
    return values


def check_finite(port: Port, values: Array) -> None:
    """Raises an error that names values that are NaN or infinite."""
    if np.isfinite(values).all():
        return
    bad = np.argwhere(~np.isfinite(values))
    first = tuple(bad[0])
    name = port.symbols[0 if port.scalar else first[-1]].name
    row = first if port.scalar else first[:-1]
    where = f" at {tuple(map(int, row))}" if row else ""
    raise ArgumentError(f"Expected finite {port.nouns}, got {name} = {values[first]}{where}.")


def listed(symbols: tuple[Symbol, ...]) -> str:
    """Names in order, with the middle of a long list omitted."""
    names = [s.name for s in symbols]
    return ", ".join(names if len(names) <= 12 else [*names[:6], "…", *names[-3:]]) or "none"


def _real(name: str, value: Any) -> Array:
    if type(value).__module__.startswith("numpy.ma") and np.ma.is_masked(value):  # numpy.ma is slow to import
        raise ArgumentError(f"Expected {name} without masked values, got a masked array: fill or drop them.")
    try:
        array = np.asarray(value)
        if array.dtype.kind not in _REAL:
            raise TypeError
        return array.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError) as error:
        got = type(value).__name__ if not isinstance(value, np.ndarray) else f"an array of {value.dtype}"
        raise ArgumentError(f"Expected real numbers as {name}, got {got}: {cut(repr(value))}.") from error


def _by_name(port: Port, argument: Mapping[Any, Any], base: Array | None) -> Array:
    values = named_values(port.nouns, port.symbols, argument)
    filled = np.full(len(port.symbols), np.nan) if base is None else base
    columns = [_real(s.name, values[s]) if s in values else b for s, b in zip(port.symbols, filled, strict=True)]
    check_complete(port, np.array([0.0 if s in values else b for s, b in zip(port.symbols, filled, strict=True)]))
    try:
        return np.stack(np.broadcast_arrays(*columns), axis=-1) if columns else np.zeros(0)
    except ValueError as error:
        shapes = ", ".join(f"{s.name} {np.shape(c)}" for s, c in zip(port.symbols, columns, strict=True) if np.ndim(c))
        raise ArgumentError(f"Expected {port.nouns} whose shapes broadcast, got {shapes}.") from error
