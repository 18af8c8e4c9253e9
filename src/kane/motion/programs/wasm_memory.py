# SPDX-License-Identifier: BSD-3-Clause
"""A motion in the memory of a module of WebAssembly: where arrays stand, kernels bound to them, rates by the dependent speeds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from types import MappingProxyType
from typing import Any, cast

import numpy as np

from kane import expect
from kane.equations.compiled import Compiled
from kane.equations.equations import Equations
from kane.errors import ProgramError
from kane.motion.programs.simulator_parts import SimulatorPart, stepping_kernel
from kane.motion.projection import is_constrained
from kane.motion.steppers.begin import Begun
from kane.motion.steppers.context import ReturnCode, Slot
from kane.motion.steppers.table import INTEGRATORS
from kane.numeric.arrays import Array
from kane.program.emit.wasm_kernels import add_kernel
from kane.program.emit.wasm_module import F64, I32, Module, WasmFunction, int32, leb, read
from kane.program.kernel.language import ArrayOf, Callee, Integer, Kernel
from kane.program.kernel.specialized import specialized
from kane.program.program import Program

ADDRESSES = 2**30
"""Bytes of samples at most: places in memory are integers of 32 bits with a sign."""


def symbols_of(program: Program) -> dict[str, list[list[Any]]]:
    """Of each port its symbols: name, unit, default."""
    return {
        port.name: [[s.name, s.unit or "", None if s.default is None else float(s.default)] for s in port.symbols]
        for port in program.ports
        if not port.scalar
    }


@dataclass(slots=True)
class Memory:
    """Where arrays stand, those that are `shared` with others among them, and the integers among the tables."""

    module: Module
    program: Program
    shared: Mapping[str, int]
    arrays: dict[str, int]
    integers: dict[str, int]

    def __init__(
        self,
        module: Module,
        program: Program,
        lengths: Mapping[str, int],
        shared: Mapping[str, int] = MappingProxyType({}),
    ) -> None:
        self.module, self.program, self.shared = module, program, shared
        self.arrays = {**shared, **{name: module.room(length, 64) for name, length in lengths.items()}}
        self.integers = {}

    def give(self, parts: Sequence[SimulatorPart]) -> None:
        """The tables of parts, with numbers where they have some; what is hoisted is one array for all."""
        for part in parts:
            self.arrays |= dict.fromkeys(part.hoisted, self.arrays["h"])
            for name, what in part.given.items():
                if isinstance(what, int):
                    self.integers[name] = what
                elif name not in self.shared:
                    self.put(name, cast(Array, what))
            if "leaves" in part.given:
                self.integers["leaving"] = len(cast(Array, part.given["leaves"]))

    def put(self, name: str, values: Array) -> None:
        """An array with numbers."""
        self.arrays[name] = self.module.room(len(values), 64)
        if np.any(values):
            self.module.numbers(self.arrays[name], values.tolist())


RATE = (F64, I32, I32, I32, I32, I32)
"""What a routine takes: t, and the places of x, p, r, h and of the results."""


def bind(
    memory: Memory, kernel: Kernel, calls: Mapping[str, int], integers: Mapping[str, int], name: str = ""
) -> tuple[int, list[str]]:
    """The number of a kernel with its arrays, routines and integers, and the integers that it takes, as 32 bits; `name` exports it."""
    module, kernel = memory.module, specialized(kernel, integers)
    routines = {
        a.name: calls[a.name] if a.name in calls else nothing(module, a)
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
    asked = [a.name for a in kernel.arguments if isinstance(a, Integer)]
    bound = WasmFunction([I32] * len(asked), [I32])
    bound.code += b"".join(read(k) + b"\xac" for k in range(len(asked))) + call(number)
    return module.add(bound, name), asked


def call(number: int) -> bytes:
    """The instruction that calls a function."""
    return b"\x10" + leb(number)


def load(at: int) -> bytes:
    """The instructions that read a double at a place."""
    return int32(0) + b"\x2b\x03" + leb(at)


def nothing(module: Module, callee: Callee) -> int:
    """What the motion does not ask for."""
    return module.add(WasmFunction([F64 if a == "float" else I32 for a in callee.takes]))


def one_of(module: Module, takes: Sequence[int], numbers: Sequence[int], at: int) -> int:
    """The function that calls one of some with what it is given: which one a double at a place says."""
    function = WasmFunction(takes)
    given = b"".join(map(read, range(len(takes))))
    for k, number in enumerate(numbers):
        if k < len(numbers) - 1:
            function.code += load(at) + b"\xfc\x02" + int32(k) + b"\x46\x04\x40" + given + call(number) + b"\x0f\x0b"
        else:
            function.code += given + call(number)
    return module.add(function)


def stepping(
    memory: Memory, eom: Equations, method: str, parts: Sequence[SimulatorPart], functions: Mapping[str, int]
) -> tuple[Kernel, dict[str, int]]:
    """The kernel of a method, and the functions that it calls: those of the parts, the rates, what hoists."""
    held = is_constrained(eom)
    kernel = stepping_kernel(method, held, bool(eom.events))
    calls = {a: functions[task] for part in parts for a, task in part.routines.items()}
    calls |= {a.name: functions["hoist"] for a in kernel.arguments if a.name.startswith("hoist_")}
    return kernel, calls | {"hoist": functions["hoist"], "rhs": rates_of(memory, functions, held)}


def rates_of(memory: Memory, functions: Mapping[str, int], held: bool) -> int:
    """The rates, where constraints are held by the choice of dependent speeds, which stands behind the parameters."""
    if not held:
        return functions["rates"]
    own = [functions[name] for name in functions if name.startswith("rates_")]
    return one_of(memory.module, RATE, own, memory.arrays["p"] + 8 * memory.integers["held_choice_at"])


def checked_samples(samples: int, state: int) -> int:
    """How many samples a module has room for, if its memory has that; `state` is how many doubles one takes."""
    most = ADDRESSES // (8 * (state + 1))
    told = f"samples= a whole number from 2, the start and the end, to {most}"
    return expect.whole(samples, told, least=2, most=most, error=ProgramError)


def module_description(memory: Memory, compiled: Compiled, method: str, samples: int) -> dict[str, Any]:
    """What the section of the module of any motion says."""
    return {
        "kane": version("kane"),
        "name": compiled.name,
        "method": method,
        "fixed": INTEGRATORS[method].fixed,
        "samples": samples,
        "n": len(cast(Equations, compiled.equations).state) + 1,
        "at": memory.arrays,
        "slots": {slot.name: int(slot) for slot in Slot},
        "codes": {code.name: int(code) for code in ReturnCode},
        "begun": {code.name: int(code) for code in Begun},
        "symbols": symbols_of(memory.program),
        "library": [name for name in memory.module.imported if name not in ("sin", "cos")],
    }
