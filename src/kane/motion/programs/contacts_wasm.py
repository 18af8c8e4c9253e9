# SPDX-License-Identifier: BSD-3-Clause
"""A motion with contacts as one WebAssembly module: the stepping kernels of its modes, and the kernel of the hybrid automaton.

The kernels are those of `simulate`, without contraction. A host writes the inputs to memory, calls `begin`, then `run` as long as
there are records to collect. A mode that the module does not contain, or a decision that requires Python, ends the motion.
"""

from collections.abc import Mapping, Sequence
from typing import cast

import numpy as np

from kane.equations.compiled import Compiled
from kane.equations.equations import Equations
from kane.motion.hybrid.contact_automaton import Back, Record, automaton_kernel
from kane.motion.hybrid.contact_tables import (
    KNOWN,
    LIMIT,
    row_of,
    structure,
    symbols,
)
from kane.motion.programs.program_modes import (
    ModeOfProgram,
    check_events,
    parameters_from,
    programs_of,
    tables_of,
    words,
)
from kane.motion.programs.wasm_memory import Memory, bind, call, load, module_description, one_of, stepping
from kane.motion.right_hand_side import Given
from kane.motion.steppers.begin import begin_kernel
from kane.motion.steppers.context import SIZE, Slot
from kane.motion.steppers.held import CHANGES
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.steppers.watched import rooms
from kane.numeric.arrays import Array
from kane.program.emit.wasm import add_program, library
from kane.program.emit.wasm_module import F64, I32, Module, WasmFunction, int32, leb, read
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Writer
from kane.program.native.entry import RESULT
from kane.program.program import Program

_SAMPLES = 2
"""Index in `calls` of the number of requested samples, after the mode and the return code of its kernel."""


def contacts_module(compiled: Compiled, modes: Sequence[ModeOfProgram], method: str, samples: int) -> bytes:
    """The module for equations whose contacts have these modes."""
    eom = cast(Equations, compiled.equations)
    check_events(eom)
    touch, programs = programs_of(compiled, modes)
    module, tables = Module(library([touch, *programs])), structure(eom)
    memory = _shared(module, touch, eom, tables, samples, INTEGRATORS[method].work(tables["n"]))
    own = tables_of(eom, modes, tables)
    most = own["held_reach"].shape[1]
    own["held_first"], own["held_reach"] = own["held_reach"], np.zeros_like(own["held_reach"])
    for name, array in own.items():
        memory.put(name, array.reshape(-1))
    pairs = zip(modes, programs, strict=True)
    functions = [_mode(memory, own, m, one, program, method) for m, (one, program) in enumerate(pairs)]
    touching = add_program(module, touch, exported=False)["functions"]
    calls = {
        name: one_of(module, takes, [f[k] for f in functions], memory.arrays["calls"])
        for k, (name, takes) in enumerate(_CALLS.items())
    }
    integers = {**memory.integers, "known": len(modes), "driven": 0, "alone": 0, "at_once": tables["room_for"]}
    _, asked = bind(memory, automaton_kernel(), {**calls, "touch": touching["contacts"]}, integers, "run")
    _begin(memory, modes, touch, touching["hoist"], INTEGRATORS[method].fixed, most)
    contacts = {
        "names": [c.name for c in eom.system.contacts],
        "words": [words(eom, one.modes) for one in modes],
        "events": [[e.name for e in one.equations.events] for one in modes],
        "numbers": [None if s is None else s.name for row in symbols(eom) for s in row],
        "row": {place_.name: int(place_) for place_ in Record},
        "width": row_of(tables["contacts"], tables["dimension"], tables["n"]),
        "back": {back.name: int(back) for back in Back},
        "asked": asked,
    }
    return module.raw(
        module_description(memory, compiled, method, samples) | {"events": [], "constraints": [], "contacts": contacts}
    )


def _shared(module: Module, touch: Program, eom: Equations, tables: Given, samples: int, work: int) -> Memory:
    """The memory of the data common to all modes."""
    n, count = tables["n"], tables["event_count"]
    lengths = rooms(count, count, 0, n)
    memory = Memory(module, touch, {
        "s": SIZE, "y": n, "p": len(touch.ports[2].symbols) + 1, "r": len(eom.inputs) + 1, "h": len(touch.kept) + 1,
        "numbers": len(touch.routines[0].results) + 1, "told": 3, "times": samples + 1, "states": samples * n,
        "held_marks": samples + 1, "held_log": 2 * CHANGES + 3, "log": lengths["log"] + 2 * count,
        "jumps": lengths["jumps"] + 2 * count, "calls": 3, "tolerances": 3, "work": work,
    })  # fmt: skip
    memory.arrays["rows"] = memory.arrays["states"] + 8 * n
    for name, what in tables.items():
        if isinstance(what, int):
            memory.integers[name] = what
        else:
            memory.put(name, cast(Array, what))
    return memory


_SHARED = ("s", "y", "lag", "times", "rows", "states", "held_marks", "held_log", "log", "jumps", "r", "work")
_CALLS = {"make": (I32,), "hoist": (I32,), "look": (F64, I32, I32, I32, I32)}
"""The functions of each mode that the automaton kernel calls, with their parameter types."""


def _mode(
    whole: Memory, own: Mapping[str, Array], m: int, mode: ModeOfProgram, program: Program, method: str
) -> tuple[int, int, int]:
    """The indices of the functions of a mode: the stepping kernel, the evaluation of h from parameters, and the event functions."""
    module = whole.module
    shared = {name: whole.arrays[name] for name in _SHARED}
    for name, to in (("p", "ps"), *((name, name) for name in ("seen", "largest", "least", "leaves", "held_reach"))):
        shared[name] = whole.arrays[to] + 8 * m * own[to][0].size
    functions = add_program(module, program, exported=False)["functions"]
    memory = Memory(module, program, {"h": len(program.kept) + 1}, shared)
    memory.give(mode.parts)
    kernel, calls = stepping(memory, mode.equations, method, mode.parts, functions)
    integers = {"n": whole.integers["n"], "driven": 0, "breakpoints": 0, "limit": LIMIT} | memory.integers
    run, asked = bind(memory, kernel, calls, integers)
    assert asked == ["samples"]
    made, hoisted, looked = (WasmFunction(takes) for takes in _CALLS.values())
    at = whole.arrays["calls"]
    made.code += int32(0) + load(at + 8 * _SAMPLES) + b"\xfc\x02" + call(run) + b"\xb7\x39\x03" + leb(at + 8 * RESULT)
    p, h = int32(memory.arrays["p"]), int32(memory.arrays["h"])
    hoisted.code += p + h + call(functions["hoist"])
    if "glance" in calls:
        looked.code += read(0) + read(1) + p + read(2) + h + read(4) + call(calls["glance"])
    one, two, three = (module.add(f) for f in (made, hoisted, looked))
    return one, two, three


def _begin(
    memory: Memory, modes: Sequence[ModeOfProgram], touch: Program, hoist: int, fixed: bool, entries_: int
) -> None:
    """Exports `begin`, which starts any motion after copying the parameters to all modes."""
    module, parameters = memory.module, len(touch.ports[2].symbols)
    memory.put("p_from", parameters_from(touch, modes, memory.integers["p_count"]).reshape(-1))
    integers = {**memory.integers, "known": len(modes), "parameters": parameters, "entries": entries_}
    begin, asked = bind(memory, begin_kernel(fixed, False, False), {"hoist": hoist}, integers)
    spread, also = bind(memory, _spread(), {}, integers)
    assert asked == also == ["samples"]
    both = WasmFunction([I32], [I32])
    both.code += read(0) + call(spread) + b"\x1a" + read(0) + call(begin)
    module.add(both, "begin")


def _spread() -> Kernel:
    """A kernel that sets the parameters of each mode, the initial state of contacts, and the number of samples."""
    w = Writer("spread")
    known, count, contacts, samples = (w.number(name) for name in ("known", "p_count", "contacts", "samples"))
    entries_ = w.number("entries")
    p, ps, at, s, tolerances, calls, log, reach, first = (
        w.array(name)
        for name in ("p", "ps", "p_from", "s", "tolerances", "calls", "held_log", "held_reach", "held_first")
    )
    back = w.variable("done", INT)
    with w.count(known * count) as k, w.when(at[k] > -0.5):
        ps[k] = p[w.compute("int", at[k])]
    with w.count(known * entries_) as k:
        reach[k] = first[k]
    for name in KNOWN:
        array = w.array(name)
        with w.count(contacts) as i:
            array[i] = 0.0
    tolerances[0], tolerances[1] = s[int(Slot.ATOL)], s[int(Slot.RTOL)]
    calls[0], calls[_SAMPLES], log[0] = 0.0, w.compute("float", samples - 1), 0.0
    back.put(0)
    return w.finished(back)
