# SPDX-License-Identifier: BSD-3-Clause
"""A motion as one WebAssembly module: the equations, the stepping kernel of `simulate`, its tables, and functions to start and run.

It requires no toolchain, and reproduces `simulate` without contraction bit for bit. A page or another host writes initial values to
the memory of the module, calls `begin`, then `run` until it is finished, and reads the samples.
"""

from collections.abc import Sequence
from typing import cast

from kane.equations.compiled import Compiled
from kane.equations.equations import Equations
from kane.model.contacts import Modes
from kane.motion.hybrid.contact_tables import MODES
from kane.motion.programs.contacts_wasm import contacts_module
from kane.motion.programs.program_modes import modes_of
from kane.motion.programs.simulator_parts import checked, motion_program, parts_of
from kane.motion.programs.wasm_memory import Memory, bind, checked_samples, module_description, stepping
from kane.motion.projection import is_constrained
from kane.motion.steppers.begin import begin_kernel, look_kernel
from kane.motion.steppers.context import SIZE
from kane.motion.steppers.table import INTEGRATORS
from kane.program.emit.wasm import add_program, library
from kane.program.emit.wasm_module import Module

MOST = 10_000
"""Default limit of the number of samples."""


def emit_simulator_wasm(
    compiled: Compiled, method: str = "dop853", samples: int = MOST, modes: Sequence[Modes] = ()
) -> bytes:
    """Generate a WebAssembly module that simulates, with the steps of `simulate` by this method without contraction, bit for bit.

    The section "kane" contains the memory layout as JSON. Up to `samples` samples can be requested. The last digits of functions
    other than sin, cos and √ are those of the engine's `Math`. With contacts, the module has these `modes`, by default all modes if
    there are few.

    Raises
    ------
    ProgramError
        if the motion has features that require Python, the method is unknown, or the number of samples is inadmissible
    """
    eom = cast(Equations, compiled.equations)
    samples = checked_samples(samples, len(eom.state) + 1)
    if eom.system.modes_change:
        return contacts_module(compiled, modes_of(compiled, method, modes, 0 if modes else MODES), method, samples)
    checked(compiled, method, "a module of WebAssembly", lambda one: f"{one.quantity} switches rates over time")
    integrator, parts, held = INTEGRATORS[method], parts_of(eom), is_constrained(eom)
    program = motion_program(compiled, parts, contract=False)
    n = len(eom.state) + 1
    module = Module(library([program]))
    functions = add_program(module, program, exported=False)["functions"]
    memory = Memory(module, program, {
        "s": SIZE, "y": n, "lag": n, "work": integrator.work(n), "p": len(eom.parameters) + 1, "r": len(eom.inputs) + 1,
        "h": len(program.kept) + 1, "told": 3, "beside": 2 * len(eom.events) + 1, "times": samples + 1,
        "states": samples * n, "held_marks": samples + 1,
    })  # fmt: skip
    memory.give(parts)
    memory.arrays["rows"] = memory.arrays["states"] + 8 * n
    kernel, calls = stepping(memory, eom, method, parts, functions)
    integers = {"n": n, "driven": 0, "breakpoints": 0, "parameters": len(eom.parameters)} | memory.integers
    integers |= {"held_speeds": len(eom.speeds), "held_coordinates": len(eom.coordinates)}
    begin = begin_kernel(integrator.fixed, bool(eom.events), held)
    kernels = {"run": kernel, "begin": begin} | ({"look": look_kernel()} if held else {})
    for name, one in kernels.items():
        bind(memory, one, calls, integers, name)
    return module.raw(module_description(memory, compiled, method, samples) | {
        "events": [e.name for e in eom.events],
        "constraints": [c.name for c in eom.derived.constraints.constraints],
    })  # fmt: skip
