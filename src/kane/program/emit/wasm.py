# SPDX-License-Identifier: BSD-3-Clause
"""A Program as a WebAssembly module, encoded directly without a toolchain; it imports only functions of `Math`.

Its functions are `hoist(parameters, h)` and `<routine>(ports, h, out)`, which take addresses in the module's memory; its custom
section "kane" lists these and the contents of the ports in JSON. Every operation is rounded separately, so that the results of + − × ÷
√ and of sines and cosines equal those of NumPy and of uncontracted machine code bit for bit; other functions depend on the engine.
"""

import struct
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from kane.expr.ops import COS, SIN
from kane.program.emit.sincos import LIMIT, STEPS, constant
from kane.program.emit.walk import KEPT, LIBRARY, WORK, Style, function_of, hoisting, pieces, statements
from kane.program.emit.walk import Function as Task
from kane.program.emit.wasm_module import (
    F64,
    I32,
    V128,
    WIDE,
    Module,
    WasmFunction,
    both,
    int32,
    lane_of,
    leb,
    local_set,
    number,
    read,
    with_lane,
)
from kane.program.emit.wasm_printer import Places, WasmPrinter
from kane.program.program import Port, Program

LONGEST = 300
"""Maximum number of instructions in one function: engines compile longer ones slowly and spill their values to memory."""


def emit_wasm(program: Program, *, version: str = "") -> bytes:
    """The module of a Program; WebAssembly has no contracted operations."""
    module = Module(library([program]))
    tells = _description(program, version)
    tells |= add_program(module, program)
    return module.raw(tells | _room(module, program))


def emit_wasms(programs: Sequence[Program]) -> bytes:
    """The module of several Programs with functions of the same names: `k.` prefixes those of the kth."""
    module = Module(library(programs))
    told = []
    for k, program in enumerate(programs):
        prefix = f"{k}."
        add_program(module, program, prefix)
        told.append({**_description(program, ""), **_room(module, program), "prefix": prefix})
    return module.raw({"programs": told})


def _room(module: Module, program: Program) -> dict[str, Any]:
    """Reserves memory for the ports, hoisted values and results of a Program; their addresses."""
    ports = {port.name: module.room(max(1, len(port.symbols)), 64) for port in program.ports if not port.scalar}
    outs = {r.name: module.room(max(1, len(r.results)), 64) for r in program.routines}
    return {"ports": ports, "h": module.room(len(program.kept) + 1, 64), "out": outs}


def library(programs: Iterable[Program]) -> dict[str, int]:
    """The functions of `Math` that Programs call, with their numbers of arguments."""
    used = {op for p in programs for op in p.ops}
    names = {LIBRARY[op]: op.arity for op in used if op in LIBRARY}
    return {"sin": 1, "cos": 1} | dict(sorted(names.items()))


def _description(program: Program, version: str) -> dict[str, Any]:
    """The description of a Program's ports and results in the custom section."""
    symbols = {
        port.name: [[s.name, s.unit or "", None if s.default is None else float(s.default)] for s in port.symbols]
        for port in program.ports
    }
    routines = {r.name: {"shape": r.shape, "labels": r.labels} for r in program.routines}
    return {"kane": version, "name": program.name, "symbols": symbols, "routines": routines}


def add_program(module: Module, program: Program, prefix: str = "", exported: bool = True) -> dict[str, dict[str, int]]:
    """Adds the functions of a Program to a module; returns their indices by name, with "hoist" for the hoisting function."""
    sines = add_sincos(module) if {SIN, COS} & set(program.ops) else -1
    scalars = {len(program.inputs) + k: number(v) for k, v in enumerate(program.constants)}
    found = {}
    for task in (hoisting(program), *(function_of(program, r) for r in program.routines)):
        found[task.name] = _add(module, program, task, scalars, sines, f"{prefix}{task.name}" * exported)
    return {"functions": found}


def parameters(ports: Sequence[Port]) -> list[int]:
    """The types of a function's parameters for its ports: f64 for a number, i32 for an address. Addresses of h and results follow."""
    return [F64 if port.scalar else I32 for port in ports]


def _add(module: Module, program: Program, task: Task, scalars: Mapping[int, bytes], sines: int, name: str) -> int:
    """Adds a function, or, if it is long, one for each piece and one that calls them; returns its index."""
    takes = parameters(task.ports)
    bases = [port.name for port in task.ports]
    own = list(dict.fromkeys((KEPT, task.target)))
    takes += [I32] * len(own)
    pointers = {base: k for k, base in enumerate([*bases, *own])}
    first = 0
    scalars = dict(scalars)
    for port in program.ports:
        if port.scalar and port.name in pointers:
            scalars[first] = read(pointers[port.name])
        first += len(port.symbols)
    style = Style(lazy=True, lanes=2, whole=LONGEST, piece=LONGEST)
    parts = pieces(program, task, style)
    fixed = {WORK: module.room(parts.slots, 64)} if parts.slots else {}
    places = Places(fixed=fixed, pointers=pointers, scalars=scalars, stable=True)
    numbers = []
    for chunk in parts.chunks:
        function = WasmFunction(takes)
        WasmPrinter(module, function, places, sines).program(statements(program, task, chunk, style))
        numbers.append(module.add(function, name if len(parts.chunks) == 1 else ""))
    if len(numbers) == 1:
        return numbers[0]
    whole = WasmFunction(takes)
    for k in numbers:
        whole.code += b"".join(map(read, range(len(takes)))) + b"\x10" + leb(k)
    return module.add(whole, name)


# -------------------------------------------------------------------------------------------------- sine and cosine


def add_sincos(module: Module) -> int:
    """Adds the function that computes sines and cosines of two angles, by the `STEPS` of `sincos`; returns its index."""
    if "sincos" in module.own:
        return module.own["sincos"]
    function = WasmFunction([V128], [V128, V128])
    code, at = function.code, {"x": 0}

    def operand(text: str) -> bytes:
        value = constant(text)
        return read(at[text]) if value is None else both(value)

    for target, form, *operands in STEPS:
        x, y, *added = map(operand, operands)
        at.setdefault(target, function.local(V128))
        code += x + y
        code += WIDE["mul"] + added[0] + WIDE["add"] if added else WIDE[form]
        code += local_set(at[target])
    n, s, c = (read(at[name]) for name in ("t", "sine", "cosine"))
    one, two = (both(one) for one in _BITS)
    change, near, odd = (function.local(V128) for _ in range(3))
    code += n + one + _AND + local_set(odd)
    swap = s + c + _XOR + both(0.0) + read(odd) + _MINUS + _AND  # the bits in which sine and cosine differ, if n is odd
    code += swap + n + two + _AND + int32(62) + _SHIFT + _XOR + local_set(change)
    code += s + read(change) + _XOR + local_set(at["sine"])
    code += c + read(change) + _XOR + read(odd) + int32(63) + _SHIFT + _XOR + local_set(at["cosine"])
    code += read(0) + WIDE["abs"] + both(LIMIT) + _AT_MOST + b"\x22" + leb(near) + _ALL + b"\x45\x04\x40"
    for lane in range(2):
        code += read(near) + _INTEGER_LANE + leb(lane) + b"\x50\x04\x40"
        for name, result in (("sin", "sine"), ("cos", "cosine")):
            code += read(at[result]) + read(0) + lane_of(lane) + b"\x10" + leb(module.imports(name))
            code += with_lane(lane) + local_set(at[result])
        code += b"\x0b"
    code += b"\x0b" + s + c
    module.own["sincos"] = module.add(function)
    return module.own["sincos"]


_BITS = tuple(struct.unpack("<2d", struct.pack("<2q", 1, 2)))
"""Doubles with the bits of the integers 1 and 2."""
_AND, _XOR, _AT_MOST, _INTEGER_LANE = b"\xfd\x4e", b"\xfd\x51", b"\xfd\x4b", b"\xfd\x1d"
_MINUS, _SHIFT, _ALL = b"\xfd\xd1\x01", b"\xfd\xcb\x01", b"\xfd\xc3\x01"
