# SPDX-License-Identifier: BSD-3-Clause
"""Motions in WebAssembly beside the same motions in machine code, both without contraction: `python -m benchmarks.wasm`.

Both give the same bits, by the same kernel, with 601 samples. Processor time of the thread is compared, pair by pair. wasmtime is as
it comes: memory is reserved, so that no access is checked.
"""

from __future__ import annotations

import gc
import sys
import time
from collections.abc import Callable, Iterable
from importlib.metadata import version
from typing import Any, NamedTuple

import numpy as np
import wasmtime

import kane as kn
from benchmarks.machine import processor
from benchmarks.paired import paired
from kane.gallery import load
from kane.motion import emit_simulator_wasm
from tests.motion.hosted import Engine

EXACT = kn.Settings(contract=False)
CASES: dict[str, tuple[Callable[[], kn.System], dict[str, Any], float]] = {
    "double pendulum": (lambda: load("double_pendulum").system(), {"q": [0.5, 0.7], "u": [0.0, 0.0]}, 200.0),
    "four-bar": (lambda: load("four_bar").system(), load("four_bar").START, 100.0),
    "ten rods": (lambda: load("pendulums").system(10), {"q": [0.5] * 10, "u": [0.0] * 10}, 30.0),
}
"""By name the system, its start, and the end of the motion (s)."""
PAIRS, SAMPLES = 31, 601


class Both(NamedTuple):
    """One motion, in machine code and in WebAssembly."""

    native: Callable[[], object]
    wasm: Callable[[], object]


def case(make: Callable[[], kn.System], start: dict[str, Any], end: float) -> Both:
    """What runs in machine code, and what in WebAssembly, once they have been found to give the same bits."""
    eom = kn.derive(make())
    state = kn.assemble(eom, **start)
    given = {"q": state.q, "u": state.u}
    run = kn.prepare(eom, (0, end), samples=SAMPLES, method="dop853", rtol=1e-9, atol=1e-9, settings=EXACT)
    sol = run(**given)
    host: Any = Engine  # the tests' own, without annotations
    engine = host(emit_simulator_wasm(eom.compile(contract=False), "dop853", SAMPLES), wasmtime.Config())
    asked: tuple[Any, ...] = (sol.states[0], [sol.parameters[s] for s in eom.parameters], [], end, SAMPLES)
    found = engine.motion(*asked)
    assert run.in_one_call
    assert np.array_equal(found.states.view(np.int64), np.asarray(sol.states).view(np.int64))
    return Both(lambda: run(**given), lambda: engine.motion(*asked, limit=1_000_000))


def main(names: Iterable[str]) -> None:
    """A line a system."""
    print(processor(), f"wasmtime {version('wasmtime')}", sep=", ")
    gc.disable()
    for name in names or CASES:
        both = case(*CASES[name])
        pairs = paired(both.native, both.wasm, PAIRS, clock=time.thread_time)
        print(pairs.line(f"{name}: native", "wasm"), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
