# SPDX-License-Identifier: BSD-3-Clause
"""A Program as the text of an LLVM module.

Its functions are `hoist(p, h)`, and for each routine

    <name>(t, x, p, r, h, out)      the kernel
    <name>.call(block)              one evaluation in a caller's private block (see `Block`)
    <name>.batch(n, …)              many, with a stride in rows for each input

Vectors are passed as pointers to doubles. Sines and cosines of angles that are known at the same time are computed side by side
in the lanes of a vector.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from dataclasses import dataclass

from kane.expr.ops import COS, SIN, Op
from kane.program.emit.entries import SHARED, batch_entry, call_entry
from kane.program.emit.sincos import llvm_sincos
from kane.program.passes.split import Chunk, Split, split
from kane.program.program import Program, Routine

_ARGUMENTS = "double %t, ptr noalias %x, ptr noalias %p, ptr noalias %r, ptr noalias %h, ptr noalias %out"
_CALLED = re.compile(r"call double @(\w+|llvm\.sqrt\.f64|llvm\.fabs\.f64)\(([^()]*)\)")


@dataclass(frozen=True, slots=True)
class Options:
    """How to emit: `contract` allows a·b + c in one rounding, `lanes` is the width of the machine's vectors in doubles."""

    contract: bool = True
    lanes: int = 4


def emit_llvm(program: Program, options: Options) -> str:
    """The module's text; the same program and options give the same text."""
    functions = [SHARED, _hoist(program, options)]
    for routine in program.routines:
        functions += [_kernel(program, routine, options), call_entry(program, routine), batch_entry(program, routine)]
    text = "\n".join(functions)
    widths = sorted({int(w) for w in re.findall(r"@kane\.sincos\.(\d+)\(", text)})
    text = "\n".join([*(llvm_sincos(w, options.contract) for w in widths), text])
    return "\n".join([*_declarations(text), text])


def _declarations(text: str) -> list[str]:
    """A declaration for every function of the C library or LLVM that the text calls."""
    arity = {name: arguments.count("double") for name, arguments in _CALLED.findall(text)}
    return [f"declare double @{name}({', '.join(['double'] * n)})" for name, n in sorted(arity.items())]


def _hoist(program: Program, options: Options) -> str:
    signature = "double %t, ptr noalias %x, ptr noalias %p, ptr noalias %r, ptr noalias %out"  # out is h
    body = _function(program, "hoist.all", signature, program.hoisted, _places(program.kept), {}, options)
    return (
        f"{body}\ndefine void @hoist(ptr noalias %p, ptr noalias %h) nounwind {{\n"
        "  call void @hoist.all(double 0.0, ptr null, ptr %p, ptr null, ptr %h)\n  ret void\n}"
    )


def _kernel(program: Program, routine: Routine, options: Options) -> str:
    kept = {i: k for k, i in enumerate(program.kept)}
    return _function(program, routine.name, _ARGUMENTS, routine.body, _places(routine.results), kept, options)


def _places(results: Sequence[int]) -> dict[int, list[int]]:
    """Where in the results each value goes: one may stand there more than once."""
    found: dict[int, list[int]] = {}
    for k, i in enumerate(results):
        found.setdefault(i, []).append(k)
    return found


def _function(
    program: Program,
    name: str,
    signature: str,
    block: Sequence[int],
    places: dict[int, list[int]],
    kept: dict[int, int],
    options: Options,
) -> str:
    """One function, or several with one that calls them in turn; `places` says where in `out` each value goes."""
    parts = split(program, block)
    if len(parts.chunks) == 1:
        return _chunk(
            program, f"define void @{name}({signature}) nounwind", parts.chunks[0], places, kept, options, True
        )
    passed = re.sub(r" noalias", "", signature)
    texts = [
        _chunk(
            program,
            f"define internal void @{name}.{k}({signature}, ptr noalias %w) nounwind noinline",
            chunk,
            places,
            kept,
            options,
            k == len(parts.chunks) - 1,
        )
        for k, chunk in enumerate(parts.chunks)
    ]
    return "\n".join([*texts, _caller(name, signature, passed, parts)])


def _caller(name: str, signature: str, passed: str, parts: Split) -> str:
    calls = [f"  call void @{name}.{k}({passed}, ptr %w)" for k in range(len(parts.chunks))]
    return "\n".join(
        [
            f"define void @{name}({signature}) nounwind {{",
            f"  %w = alloca [{max(1, parts.slots)} x double], align 64",
            *calls,
            "  ret void",
            "}",
        ]
    )


def _chunk(
    program: Program,
    head: str,
    chunk: Chunk,
    places: dict[int, list[int]],
    kept: dict[int, int],
    options: Options,
    last: bool,
) -> str:
    writer = _Writer(program, kept, chunk, options)
    for i in chunk.instructions:
        writer.compute(i)
        if i in chunk.stores:
            writer.store("%w", chunk.stores[i], i)
        for k in places.get(i, ()):
            writer.store("%out", k, i)
    if last:
        for i, ks in places.items():
            if i < program.first or i in kept:
                for k in ks:
                    writer.store("%out", k, i)
    return "\n".join([f"{head} {{", *writer.lines, "  ret void", "}"])


class _Writer:
    """The lines of one function: each value is loaded where it is first read."""

    def __init__(self, program: Program, kept: dict[int, int], chunk: Chunk, options: Options) -> None:
        self.program, self.kept, self.loads, self.options = program, kept, chunk.loads, options
        self.lines: list[str] = []
        self.names: dict[int, str] = {}
        self.flags = "contract " if options.contract else ""
        self.sources = _sources(program)
        self.angles: dict[int, dict[Op, int]] = {}
        for i in chunk.instructions:
            op = program.op(i)
            if op is SIN or op is COS:
                self.angles.setdefault(program.arguments(i)[0], {})[op] = i
        # Else LLVM would load neighbours as one vector, which waits where they have just been stored one by one.
        self.volatile = frozenset(self.angles)

    def name(self, i: int) -> str:
        """The operand of value i, loaded if need be."""
        known = self.names.get(i)
        if known is not None:
            return known
        if i in self.loads:
            base, k = "%w", self.loads[i]
        elif i in self.kept:
            base, k = "%h", self.kept[i]
        else:
            base, k = self.sources[i]
        if base in ("", "%t"):
            found = base or _hex(self.program.constants[k])
        else:
            found = f"%v{i}"
            load = "load volatile" if i in self.volatile else "load"
            self.lines += [
                f"  %a{i} = getelementptr inbounds double, ptr {base}, i64 {k}",
                f"  {found} = {load} double, ptr %a{i}, align 8",
            ]
        self.names[i] = found
        return found

    def store(self, base: str, k: int, i: int) -> None:
        """Value i to base[k]."""
        value = self.name(i)
        address = f"%s{len(self.lines)}"
        self.lines += [
            f"  {address} = getelementptr inbounds double, ptr {base}, i64 {k}",
            f"  store double {value}, ptr {address}, align 8",
        ]

    def compute(self, i: int) -> None:
        """The instruction of value i, unless it came with another one's sine and cosine."""
        if i in self.names:
            return
        op = self.program.op(i)
        if op is SIN or op is COS:
            self._sines_and_cosines()
            return
        operands = [self.name(a) for a in self.program.arguments(i)]
        text = op.llvm.format(*operands, r=f"%v{i}", f=self.flags)
        self.lines += [f"  {line}" for line in text.split("\n")]
        self.names[i] = f"%v{i}"

    def _sines_and_cosines(self) -> None:
        """Those of all angles of the chunk that are known by now, in vectors as wide as they fill."""
        first = self.program.first
        known = [a for a in self.angles if a < first or a in self.names or a in self.loads or a in self.kept]
        while known:
            width = min(self.options.lanes, 1 << (len(known) - 1).bit_length())
            self._pack(known[:width], width)
            known = known[width:]

    def _pack(self, angles: list[int], width: int) -> None:
        """Sines and cosines of at most `width` angles."""
        kind = "double" if width == 1 else f"<{width} x double>"
        operands = [self.name(a) for a in angles]
        label = f"%p{angles[0]}"
        packed = operands[0]
        if width > 1:
            packed = "poison"
            for k in range(width):  # what is left over repeats the last angle
                value = operands[min(k, len(operands) - 1)]
                self.lines.append(f"  {label}.{k} = insertelement {kind} {packed}, double {value}, i32 {k}")
                packed = f"{label}.{k}"
        self.lines.append(f"  {label} = call {{{kind}, {kind}}} @kane.sincos.{width}({kind} {packed})")
        for position, op in enumerate((SIN, COS)):
            self.lines.append(f"  {label}.{op.name} = extractvalue {{{kind}, {kind}}} {label}, {position}")
        for k, a in enumerate(angles):
            for op, i in self.angles.pop(a).items():
                if width == 1:
                    self.names[i] = f"{label}.{op.name}"
                else:
                    self.names[i] = f"%v{i}"
                    self.lines.append(f"  %v{i} = extractelement {kind} {label}.{op.name}, i32 {k}")


def _sources(program: Program) -> dict[int, tuple[str, int]]:
    """Where each input and constant is read from: an argument and an index."""
    found: dict[int, tuple[str, int]] = {}
    i = 0
    for port in program.ports:
        for k in range(len(port.symbols)):
            found[i] = (f"%{port.name}", k)
            i += 1
    found.update({i + k: ("", k) for k in range(len(program.constants))})
    return found


def _hex(value: float) -> str:
    return f"0x{struct.pack('>d', value).hex().upper()}"
