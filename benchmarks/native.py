# SPDX-License-Identifier: BSD-3-Clause
"""Compiled right-hand sides timed in a native loop (`native.c`), whatever made them."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import count
from pathlib import Path

import numpy as np
import numpy.typing as npt

import kane as kn
from kane.program.emit.llvm import hoists

Array = npt.NDArray[np.float64]

CC = "cc"
FLAGS = ("-O3", "-march=native")
_SOURCE = Path(__file__).with_name("native.c")
_numbers = count()
LANES = 8


@dataclass(frozen=True)
class Kernel:
    """A compiled right-hand side with its buffers: `loop(n)` calls it n times and returns the seconds, `out` is ẋ after it."""

    loop: Callable[[int], float]
    out: Array


@dataclass(frozen=True)
class KaneKernel:
    """kane's side: f(t, x, p, r, h, out) and hoist(p, h) by address, their buffers, and the same as a Python callable.

    `x` is the state (q, u), `p` the parameters in the program's order; h is filled by a call of hoist.
    """

    address: int
    hoist: int
    x: Array
    p: Array
    r: Array
    h: Array
    out: Array
    rhs: Callable[[float, Array, Array], Array]
    t: float = 0.0


def kane_kernel(eom: kn.Equations, x: Array, parameters: Mapping[str, float]) -> KaneKernel:
    """The right-hand side compiled by kane, at a state (q, u) and parameters by name."""
    compiled = eom.compile()
    rhs = compiled.rhs
    library = rhs._library
    h, out = np.empty(max(1, len(rhs.program.kept))), np.empty(rhs.shape)
    p = compiled.parameters(parameters)
    hoist = library.address(hoists([rhs.program])[0])
    ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(hoist)(p.ctypes.data, h.ctypes.data)
    return KaneKernel(library.address("rhs"), hoist, x.copy(), p, np.zeros(len(eom.inputs)), h, out, rhs)


def kernel_of(routine: kn.Handle, x: Array) -> Kernel:
    """A compiled routine at a state, parameters at their defaults and inputs zero."""
    library, program = routine._library, routine.program
    h, out = np.empty(max(1, len(program.kept))), np.empty(routine.shape).ravel()
    p = np.array([0.0 if s.default is None else s.default for s in program.port("p").symbols])
    hoist = library.address(hoists([program])[0])
    ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(hoist)(p.ctypes.data, h.ctypes.data)
    r = np.zeros(len(program.port("r").symbols))
    return kane_loop(KaneKernel(library.address(routine.name), hoist, x.copy(), p, r, h, out, routine))


def lanes_loop(routine: kn.Handle, x: Array) -> Callable[[int], float]:
    """The loop over a compiled routine at eight states at once (n × 8), parameters at their defaults and inputs zero."""
    from kane.program import aligned, hoisted, wide_entry  # older versions have none of them, see `against`

    program = routine.program
    p = np.array([0.0 if s.default is None else s.default for s in program.port("p").symbols])
    r = np.zeros(len(program.port("r").symbols))
    h, out, rows = hoisted(routine, 0.0, x[:, 0], p, r), aligned(LANES * len(x)), aligned(x.size)
    rows[:] = x.ravel()
    code = wide_entry(routine, LANES)
    return _loop("loop_lanes", code.address, aligned(LANES), rows, p, aligned(LANES * (len(r) + 1)), h, out, owner=code)


def kane_compile(eom: kn.Equations) -> float:
    """Seconds to compile the right-hand side, nothing read from a cache or left in one; LLVM itself is loaded before."""
    from kane.program.native import machine

    machine.host()
    start = time.perf_counter()
    eom.compile(cache=False)
    return time.perf_counter() - start


# Shared objects ------------------------------------------------------------------------------------------------------------


@cache
def scratch() -> tempfile.TemporaryDirectory[str]:
    """Where this process compiles; removed at its end."""
    return tempfile.TemporaryDirectory(prefix="kane-bench-")


def link(content: str | bytes, flags: Sequence[str] = FLAGS) -> ctypes.CDLL:
    """C source (or an object file's bytes) as a loaded shared object."""
    place = Path(scratch().name) / f"k{next(_numbers)}"
    if isinstance(content, str):
        source = place.with_suffix(".c")
        source.write_text(content)
    else:
        source = place.with_suffix(".o")
        source.write_bytes(content)
    library = place.with_suffix(".so")
    subprocess.run([CC, *flags, "-shared", "-fPIC", str(source), "-o", str(library), "-lm"], check=True)
    return ctypes.CDLL(str(library))


def address(library: ctypes.CDLL, name: str) -> int:
    """The address of a function of a loaded library."""
    found = ctypes.cast(getattr(library, name), ctypes.c_void_p).value
    if found is None:
        raise LookupError(f"Expected the function {name} in {library}.")
    return found


@cache
def _driver() -> ctypes.CDLL:
    return link(_SOURCE.read_text(), ("-O2",))


def _loop(name: str, *arguments: int | float | Array, owner: object = None) -> Callable[[int], float]:
    """The driver's loop with its arguments bound; arrays, and the owner of the code, are kept alive by the closure."""
    function = getattr(_driver(), name)
    function.restype = ctypes.c_double
    kinds = [ctypes.c_double if isinstance(a, float) else ctypes.c_void_p for a in arguments]
    function.argtypes = [ctypes.c_long, *kinds]
    plain = [a.ctypes.data if isinstance(a, np.ndarray) else a for a in arguments]

    def run(n: int, alive: object = (arguments, owner)) -> float:
        return float(function(n, *plain))

    return run


# The pointer shapes --------------------------------------------------------------------------------------------------------


def kane_loop(k: KaneKernel) -> Kernel:
    """One evaluation of kane's state tier a call."""
    return Kernel(_loop("loop_program", k.address, k.t, k.x, k.p, k.r, k.h, k.out, owner=k), k.out)


def kane_hoisting_loop(k: KaneKernel) -> Kernel:
    """kane's parameter tier and state tier, both at every call."""
    return Kernel(_loop("loop_program_hoisting", k.address, k.hoist, k.t, k.x, k.p, k.r, k.h, k.out, owner=k), k.out)


def casadi_loop(f: int, x: Array, p: Array, iw: int, w: int) -> Kernel:
    """A function of CasADi's generated C with the inputs x, p and one output; iw and w are its work sizes."""
    out = np.empty_like(x)
    integers, reals = np.zeros(iw + 1, dtype=np.int64), np.zeros(w + 1)
    return Kernel(_loop("loop_casadi", f, x.copy(), p, out, integers.view(np.float64), reals), out)


def heyoka_loop(f: int, x: Array, p: Array) -> Kernel:
    """The unbatched function of a heyoka cfunc."""
    out = np.empty_like(x)
    return Kernel(_loop("loop_heyoka", f, 0.0, x.copy(), p, out), out)
