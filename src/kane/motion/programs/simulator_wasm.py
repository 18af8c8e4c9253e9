# SPDX-License-Identifier: BSD-3-Clause
"""A motion as one module of WebAssembly: the equations, the kernel that `simulate` runs, its tables, how it begins and goes on.

It needs no toolchain, and gives the bits of `simulate` without contraction. A page or another host writes what is given to the memory
of the module, calls `begin`, then `run` as long as it comes back for more, and reads the samples.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, cast

import numpy as np

from kane.equations.compiled import Compiled
from kane.equations.equations import Equations
from kane.motion.programs.simulator_parts import Part, checked, motion_program, parts_of
from kane.motion.projection import is_constrained
from kane.motion.steppers.begin import Begun, begin_kernel, look_kernel
from kane.motion.steppers.context import SIZE, ReturnCode, Slot
from kane.motion.steppers.table import INTEGRATORS
from kane.numeric.arrays import Array
from kane.program.emit.wasm import add_program, library
from kane.program.emit.wasm_kernels import add_kernel
from kane.program.emit.wasm_module import F64, I32, Function, Module, leb, place, read
from kane.program.kernel.language import ArrayOf, Callee, Integer, Kernel
from kane.program.kernel.specialized import specialized
from kane.program.program import Program

MOST = 10_000
"""Samples at most, unless told."""


def emit_simulator_wasm(compiled: Compiled, method: str = "dop853", samples: int = MOST) -> bytes:
    """A module of WebAssembly that simulates, by steps of `simulate` with this method and without contraction, bit by bit.

    Its section "kane" says in JSON where in memory what stands. Up to `samples` of them may be asked for. Of functions other than
    sin, cos and √ the last digits are those of the engine's `Math`.

    Raises
    ------
    ProgramError
        if the motion asks for what only Python looks after, or there is no such method
    """
    checked(compiled, method, "a module of WebAssembly", lambda one: f"{one.quantity} turns rates at times")
    eom, integrator = cast(Equations, compiled.equations), INTEGRATORS[method]
    parts = parts_of(eom)
    program = motion_program(compiled, parts, contract=False)
    held, watched = is_constrained(eom), bool(eom.events)
    kernel = integrator.kernel(**({"held": True} if held else {}), **({"watched": True} if watched else {}))
    n = len(eom.state) + 1
    module = Module(library([program]))
    functions = add_program(module, program, exported=False)["functions"]
    memory = _Memory(module, program, {
        "s": SIZE, "y": n, "lag": n, "work": integrator.work(n), "p": len(eom.parameters) + 1, "r": len(eom.inputs) + 1,
        "h": len(program.kept) + 1, "told": 3, "beside": 2 * len(eom.events) + 1, "times": samples + 1,
        "states": samples * n, "held_marks": samples + 1,
    })  # fmt: skip
    memory.give(parts)
    memory.arrays["rows"] = memory.arrays["states"] + 8 * n
    calls = {a: functions[task] for part in parts for a, task in part.routines.items()}
    calls |= {a.name: functions["hoist"] for a in kernel.arguments if a.name.startswith("hoist_")}
    calls |= {
        "hoist": functions["hoist"],
        "rhs": functions["rates"] if not held else _dispatched(module, functions, memory),
    }
    integers = {"n": n, "driven": 0, "breakpoints": 0, "parameters": len(eom.parameters)} | memory.integers
    integers |= {"held_speeds": len(eom.speeds), "held_coordinates": len(eom.coordinates)}
    begin = begin_kernel(integrator.fixed, watched, held)
    kernels = {"run": kernel, "begin": begin} | ({"look": look_kernel()} if held else {})
    for name, one in kernels.items():
        _bind(module, one, name, memory, calls, integers)
    tells = {
        "kane": version("kane"),
        "name": compiled.name,
        "method": method,
        "fixed": integrator.fixed,
        "samples": samples,
        "n": n,
        "at": memory.arrays,
        "slots": {slot.name: int(slot) for slot in Slot},
        "codes": {code.name: int(code) for code in ReturnCode},
        "begun": {code.name: int(code) for code in Begun},
        "symbols": _symbols(program),
        "events": [e.name for e in eom.events],
        "constraints": [c.name for c in eom.derived.constraints.constraints],
        "library": [name for name in module.imported if name not in ("sin", "cos")],
    }
    return module.raw(tells)


def _symbols(program: Program) -> dict[str, list[list[Any]]]:
    return {
        port.name: [[s.name, s.unit or "", None if s.default is None else float(s.default)] for s in port.symbols]
        for port in program.ports
        if not port.scalar
    }


@dataclass(slots=True)
class _Memory:
    """Where arrays stand, and the integers among the tables."""

    module: Module
    program: Program
    arrays: dict[str, int]
    integers: dict[str, int]

    def __init__(self, module: Module, program: Program, lengths: Mapping[str, int]) -> None:
        self.module, self.program = module, program
        self.arrays = {name: module.room(length, 64) for name, length in lengths.items()}
        self.integers = {}

    def give(self, parts: Sequence[Part]) -> None:
        """The tables of parts, with numbers where they have some; what is hoisted is one array for all."""
        for part in parts:
            self.arrays |= dict.fromkeys(part.hoisted, self.arrays["h"])
            for name, what in part.given.items():
                if isinstance(what, int):
                    self.integers[name] = what
                else:
                    self.put(name, cast(Array, what))
            if "leaves" in part.given:
                self.integers["leaving"] = len(cast(Array, part.given["leaves"]))

    def put(self, name: str, values: Array) -> None:
        """An array with numbers."""
        self.arrays[name] = self.module.room(len(values), 64)
        if np.any(values):
            self.module.numbers(self.arrays[name], values.tolist())


_RATE = (F64, I32, I32, I32, I32, I32)


def _bind(
    module: Module,
    kernel: Kernel,
    name: str,
    memory: _Memory,
    calls: Mapping[str, int],
    integers: Mapping[str, int],
) -> None:
    """A kernel with its arrays, routines and integers, exported by a name: it takes those that the host gives, as 32 bits."""
    kernel = specialized(kernel, integers)
    routines = {
        a.name: calls[a.name] if a.name in calls else _nothing(module, a)
        for a in kernel.arguments
        if isinstance(a, Callee)
    }
    for a in kernel.arguments:
        if isinstance(a, ArrayOf) and a.name not in memory.arrays:
            if f"hoist_{a.name}" in routines:
                memory.arrays[a.name] = memory.arrays["h"]
            else:
                memory.put(a.name, np.zeros(1))
    number = add_kernel(module, kernel, memory.arrays, routines)
    asked = [a for a in kernel.arguments if isinstance(a, Integer)]
    bound = Function([I32] * len(asked), [I32])
    bound.code += b"".join(read(k) + b"\xac" for k in range(len(asked))) + b"\x10" + leb(number)
    module.add(bound, name)


def _nothing(module: Module, callee: Callee) -> int:
    """What the motion does not ask for."""
    return module.add(Function([F64 if a == "float" else I32 for a in callee.takes]))


def _dispatched(module: Module, functions: Mapping[str, int], memory: _Memory) -> int:
    """The rates by the choice of dependent speeds, which stands behind the parameters."""
    function = Function(_RATE)
    own = [functions[name] for name in functions if name.startswith("rates_")]
    given = b"".join(map(read, range(len(_RATE))))
    for k, number in enumerate(own):
        call = given + b"\x10" + leb(number)
        if k < len(own) - 1:
            at = memory.arrays["p"] + 8 * memory.integers["held_choice_at"]
            function.code += (
                place(0) + b"\x2b\x03" + leb(at) + b"\xfc\x02" + place(k) + b"\x46\x04\x40" + call + b"\x0f\x0b"
            )
        else:
            function.code += call
    return module.add(function)
