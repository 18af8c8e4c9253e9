# SPDX-License-Identifier: BSD-3-Clause
"""The memory of a WebAssembly module for a motion: addresses of arrays, kernels bound to them, rates by choice of dependent speeds."""

from collections.abc import Mapping, Sequence
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
from kane.program.kernel.rewriting import specialized
from kane.program.program import Program

ADDRESSES = 2**30
"""Largest size of the samples (bytes), since addresses are signed 32-bit integers."""


class Memory:
    """The addresses of arrays, including those `shared` with others, and the integers among the tables."""

    def __init__(
        self,
        module: Module,
        program: Program,
        lengths: Mapping[str, int],
        shared: Mapping[str, int] = MappingProxyType({}),
    ) -> None:
        self.module, self.program, self.shared = module, program, shared
        self.arrays: dict[str, int] = {**shared, **{name: module.room(length, 64) for name, length in lengths.items()}}
        self.integers: dict[str, int] = {}

    def give(self, parts: Sequence[SimulatorPart]) -> None:
        """Adds the tables of parts; all h are one array."""
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
        """Allocates an array with initial values."""
        self.arrays[name] = self.module.room(len(values), 64)
        if np.any(values):
            self.module.numbers(self.arrays[name], values.tolist())


RATE = (F64, I32, I32, I32, I32, I32)
"""The parameter types of a routine: t, and the addresses of x, p, r, h and of the results."""


def bind(
    memory: Memory, kernel: Kernel, calls: Mapping[str, int], integers: Mapping[str, int], name: str = ""
) -> tuple[int, list[str]]:
    """The index of a kernel with arrays, routines and integers bound, and its remaining 32-bit parameters; exported as `name`."""
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
    """The instructions that load a double from an address."""
    return int32(0) + b"\x2b\x03" + leb(at)


def nothing(module: Module, callee: Callee) -> int:
    """A function without effect, for a routine that the motion does not need."""
    return module.add(WasmFunction([F64 if a == "float" else I32 for a in callee.takes]))


def one_of(module: Module, takes: Sequence[int], numbers: Sequence[int], at: int) -> int:
    """A function that forwards its arguments to one of several, selected by the double at an address."""
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
    """The kernel of a method, and the functions that it calls: those of the parts, the rates, and the evaluation of h."""
    held = is_constrained(eom)
    kernel = stepping_kernel(method, held, bool(eom.events))
    calls = {a: functions[task] for part in parts for a, task in part.routines.items()}
    calls |= {a.name: functions["hoist"] for a in kernel.arguments if a.name.startswith("hoist_")}
    if held:  # selected by the choice of dependent speeds, stored after the parameters
        own = [functions[name] for name in functions if name.startswith("rates_")]
        rates = one_of(memory.module, RATE, own, memory.arrays["p"] + 8 * memory.integers["held_choice_at"])
    else:
        rates = functions["rates"]
    return kernel, calls | {"hoist": functions["hoist"], "rhs": rates}


def checked_samples(samples: int, state: int) -> int:
    """The number of samples if it fits in memory; `state` is the number of doubles in one. Raises ProgramError."""
    most = ADDRESSES // (8 * (state + 1))
    told = f"samples= a whole number from 2, the start and the end, to {most}"
    return expect.whole(samples, told, least=2, most=most, error=ProgramError)


def module_description(memory: Memory, compiled: Compiled, method: str, samples: int) -> dict[str, Any]:
    """The contents of the section "kane" of the module."""
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
        "symbols": {  # of each port: name, unit, default
            port.name: [[s.name, s.unit or "", None if s.default is None else float(s.default)] for s in port.symbols]
            for port in memory.program.ports
            if not port.scalar
        },
        "library": [name for name in memory.module.imported if name not in ("sin", "cos")],
    }
