# SPDX-License-Identifier: BSD-3-Clause
"""What Python calls: one compiled routine."""

from __future__ import annotations

import ctypes
import math
import warnings
from collections.abc import Callable
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from kane import show
from kane.errors import ArgumentError, KaneWarning, NotFiniteError
from kane.program.emit.llvm_entries import block
from kane.program.machine import Settings, build_library
from kane.program.native import arguments
from kane.program.native.callers import outside
from kane.program.program import Program, Routine
from kane.program.reference import explain

Array = npt.NDArray[np.float64]
NotFinite = Literal["warn", "raise", "ignore"]

_ALIGNMENT = 64
_ARRAY: Any = np.ndarray


_ALL = slice(None)


_Block: TypeAlias = tuple[ctypes.c_void_p, Any, memoryview, memoryview, memoryview, Array]
"""The memory of one call at a time: its address, and views of t, x, p, r and the results. A bare tuple is unpacked fastest."""


def _inputs(own: _Block) -> list[Array]:
    """What a block was called with: t, x, p, r."""
    return [np.array(own[1].value), *map(np.array, own[2:5])]


def _new_block(program: Program, routine: Routine) -> _Block:
    at = block(program, routine)
    raw = np.zeros(8 * at.size + _ALIGNMENT, np.uint8)
    skip = -raw.ctypes.data % _ALIGNMENT
    memory = raw[skip : skip + 8 * at.size].view(np.float64)
    last = memory[at.hoisted : at.h].view(np.int64)
    start = dict(zip((port.name for port in program.ports), at.ports, strict=True))
    last[:] = -1  # the bits of no p that arithmetic makes: the first call hoists
    n = {port.name: len(port.symbols) for port in program.ports}
    view = memory.data
    return (
        ctypes.c_void_p(memory.ctypes.data),
        ctypes.c_double.from_buffer(memory),  # type: ignore[arg-type]  # arrays have a buffer
        view[start["x"] : start["x"] + n["x"]],
        view[start["p"] : start["p"] + n["p"]],
        view[start["r"] : start["r"] + n["r"]],
        memory[at.out : at.out + len(routine.results)].reshape(routine.shape),
    )


class Handle:
    """One compiled routine: `handle(t, x, p, r)`.

    `t` is a number, `x` the state (…, n), `p` the parameters (…, np) or a mapping by symbol or name (those left out keep their
    defaults; all of them where `p` is None), `r` the inputs (…, nr). Leading axes broadcast; the result has them, then `shape`.
    It is always a new array. Threads may call one handle at the same time: each call has a block of memory to itself.

    NaN or infinity in the arguments is an `ArgumentError`. If a result is not finite, `not_finite` says what happens: "warn"
    (`KaneWarning`), "raise" (`NotFiniteError`); both name the first intermediate that is not. With "ignore" nothing is checked.
    """

    __slots__ = (
        "__weakref__",
        "_batch",
        "_call",
        "_default",
        "_driven",
        "_free",
        "_library",
        "_standard",
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
        default: Array | None = None,
        not_finite: NotFinite = "warn",
    ) -> None:
        if not_finite not in ("warn", "raise", "ignore"):
            raise ArgumentError(f'Expected not_finite to be "warn", "raise" or "ignore", got {not_finite!r}.')
        self.program, self.routine, self.settings = program, program.routine(name), settings
        self.not_finite = not_finite
        self._default = np.array(arguments.defaults(program.port("p")) if default is None else default)
        self._free: list[_Block] = []
        self._standard = self._default.data
        self._driven = bool(program.port("r").symbols)
        library = self._library = build_library(program, settings)
        pointer, count = ctypes.c_void_p, ctypes.c_int64
        self._call: Callable[[Any], int] = library.function(f"{name}.call", ctypes.c_int32, pointer, brief=True)
        self._batch = library.function(f"{name}.batch", count, count, *[pointer, count] * 4, pointer, pointer)

    @property
    def name(self) -> str:
        """The routine's name."""
        return self.routine.name

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of one result."""
        return self.routine.shape

    @property
    def labels(self) -> tuple[str, ...]:
        """The name of each result, in row-major order."""
        return self.routine.labels

    def __call__(self, t: Any, x: Any, p: Any = None, r: Any = None) -> Array:
        """The results at t, x, p, r."""
        # The common case without conversions: a memoryview takes doubles of the same shape and nothing else.
        if (
            (type(t) is float or type(t) is np.float64)
            and type(x) is _ARRAY
            and (p is None or type(p) is _ARRAY)
            and (type(r) is _ARRAY or (r is None and not self._driven))
        ):
            free = self._free
            try:  # a block that nobody else uses until it is back: calls may nest, in hooks and signal handlers too
                own = free.pop()
            except IndexError:
                own = _new_block(self.program, self.routine)
            address, time, x_own, p_own, r_own, out = own
            try:
                time.value = t
                x_own[_ALL] = x
                p_own[_ALL] = self._standard if p is None else p
                if r is not None:
                    r_own[_ALL] = r
            except (ValueError, NotImplementedError):
                free.append(own)
            else:
                if self._call(address):
                    given, results = _inputs(own), out.copy()
                    free.append(own)
                    self._not_finite(given, p is None)
                    return results
                results = out.copy()
                free.append(own)
                return results
        return self._general(t, x, p, r)

    def _general(self, t: Any, x: Any, p: Any, r: Any) -> Array:
        ports, given = self.program.ports, self._arrays(t, x, p, r)
        leading = [given[0].shape, *(a.shape[:-1] for a in given[1:])]
        try:
            rows = np.broadcast_shapes(*leading)
        except ValueError as error:
            shapes = ", ".join(f"{port.name} {a.shape}" for port, a in zip(ports, given, strict=True))
            raise ArgumentError(f"Expected leading axes that broadcast, got {shapes}.") from error
        if self.not_finite != "ignore":
            for port, a in zip(ports, given, strict=True):
                arguments.finite(port, a)
        return self._rows(rows, given)

    def _arrays(self, t: Any, x: Any, p: Any, r: Any) -> list[Array]:
        """The arguments as arrays of doubles, the parameters complete."""
        _, states, parameters, inputs = self.program.ports
        return [
            arguments.scalar(t),
            arguments.vector(states, x),
            arguments.vector(parameters, {} if p is None else p, self._default),
            arguments.vector(inputs, ({} if inputs.symbols else ()) if r is None else r),
        ]

    def _rows(self, rows: tuple[int, ...], given: list[Array]) -> Array:
        """Many evaluations in one native loop; what is the same in all rows is passed once, with stride 0."""
        count = math.prod(rows)
        flat: list[Array] = []
        for k, a in enumerate(given):
            width = 1 if k == 0 else a.shape[-1]
            lead = a.shape if k == 0 else a.shape[:-1]
            shared = math.prod(lead) == 1
            wide = a if shared else np.broadcast_to(a.reshape(*lead, width), (*rows, width))
            flat.append(np.require(wide.reshape(1 if shared else count, width), requirements=["C", "A"]))
        out = np.empty((*rows, *self.shape))
        h = np.empty(max(1, len(self.program.kept)))
        strides = [0 if len(a) == 1 else a.shape[1] for a in flat]
        pairs = [v for a, stride in zip(flat, strides, strict=True) for v in (a.ctypes.data, stride)]
        first_bad = self._batch(count, *pairs, h.ctypes.data, out.ctypes.data)
        if first_bad >= 0 and self.not_finite != "ignore":
            where = tuple(map(int, np.unravel_index(first_bad, rows)))
            self._tell([float(v) for a in flat for v in a[first_bad % len(a)]], f" at {where}")
        return out

    def _not_finite(self, given: list[Array], default: bool) -> None:
        """After a call that met NaN or infinity: name the argument, or the intermediate."""
        if default:
            arguments.complete(self.program.port("p"), self._default)
        if self.not_finite == "ignore":
            return
        for port, values in zip(self.program.ports, given, strict=True):
            arguments.finite(port, values)
        self._tell([float(v) for a in given for v in a.flat], "")

    def _tell(self, inputs: list[float], where: str) -> None:
        found = explain(self.program, self.routine, inputs) or (
            "NaN or infinity where separate roundings give none: a difference of equal numbers is not quite zero with fused "
            "multiply-adds or shared reciprocals. Use compile(contract=False)"
        )
        message = f"Expected finite results of {self.name}{where}, got {found}."
        if self.not_finite == "raise":
            raise NotFiniteError(message)
        warnings.warn(message, KaneWarning, stacklevel=outside())

    def explain(self, t: Any, x: Any, p: Any = None, r: Any = None) -> str:
        """Which intermediate is the first that is not finite at one state, and what it is made of; "" where all is finite."""
        given = self._arrays(t, x, p, r)
        if given[0].ndim or any(a.ndim > 1 for a in given[1:]):
            raise ArgumentError(f"Expected one state to explain, got shapes {', '.join(str(a.shape) for a in given)}.")
        return explain(self.program, self.routine, [float(v) for a in given for v in a.flat])

    def __reduce__(self) -> tuple[Any, ...]:
        return Handle, (self.program, self.name, self.settings, self._default, self.not_finite)

    _repr_html_ = show.html

    def __repr__(self) -> str:
        few = f"{', '.join(self.labels[:8])}{', …' if len(self.labels) > 8 else ''}"
        return f"<{self.name}({self.program.signature}) -> {list(self.shape)}: {few}>"
