# SPDX-License-Identifier: BSD-3-Clause
"""Programs as the text of one LLVM module.

Its functions are, for each Program, `hoist(parameters, h)`, and for each routine

    <name>(ports, h, out)       the kernel
    <name>.call(block)          one evaluation in a caller's private block (see `Block`)
    <name>.batch(n, …)          many, with a stride in rows for each port

Vectors are passed as pointers to doubles. Sines and cosines of angles that are known at the same time are computed side by side
in the lanes of a vector.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache

from kane.expr import ops
from kane.expr.ops import COS, OPS, SIN, Op
from kane.program.emit import walk
from kane.program.emit.llvm_entries import batch_entry, call_entry, pointer, shared
from kane.program.emit.llvm_lanes import Lanes, bits
from kane.program.emit.llvm_sincos import llvm_sincos
from kane.program.passes.split import Chunk
from kane.program.program import Program

_SCALAR = Lanes(1)
_BINARY = {ops.ADD: "fadd", ops.SUB: "fsub", ops.MUL: "fmul", ops.DIV: "fdiv"}
_LIBRARY = {OPS[n]: n for n in ["pow", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log"]}
_INTRINSIC = {ops.SQRT: "llvm.sqrt", OPS["abs"]: "llvm.fabs"}
_ORDERED = (
    "{r}.a = fcmp %s {v} {0}, {1}\n{r}.b = fcmp uno {v} {0}, {0}\n"
    "{r}.c = or {b} {r}.a, {r}.b\n{r} = select {b} {r}.c, {v} {0}, {v} {1}"
)
"""The argument that compares so with the other; a NaN is passed on, as NumPy does."""
_FORMS = {
    **{op: f"{{r}} = {name} {{f}}{{v}} {{0}}, {{1}}" for op, name in _BINARY.items()},
    ops.NEG: "{r} = fneg {f}{v} {0}",
    OPS["min"]: _ORDERED % "olt",
    OPS["max"]: _ORDERED % "ogt",
    OPS["sign"]: (
        "{r}.a = fcmp ogt {v} {0}, {zero}\n{r}.b = select {b} {r}.a, {v} {one}, {v} {0}\n"
        "{r}.c = fcmp olt {v} {0}, {zero}\n{r}.d = select {b} {r}.c, {v} {minus}, {v} {r}.b\n"
        "{r} = fadd {v} {r}.d, {zero}"
    ),
    ops.LESS: "{r}.c = fcmp olt {v} {0}, {1}\n{r} = uitofp {b} {r}.c to {v}",
    ops.WHERE: "{r}.c = fcmp une {v} {0}, {zero}\n{r} = select {b} {r}.c, {v} {1}, {v} {2}",
}
"""The lines for the value {r} of {0}, {1}, …, with {f} for flags of contraction, {v} and {b} for the types of numbers and truths."""


@dataclass(frozen=True, slots=True)
class Options:
    """How to emit: `contract` allows a·b + c in one rounding, `lanes` is the width of the machine's vectors in doubles."""

    contract: bool = True
    lanes: int = 4


def emit_llvm(programs: Sequence[Program], options: Options) -> str:
    """The module's text; the same programs and options give the same text. The names of all routines must differ."""
    module = _Module(options)
    texts = [shared()]
    for program, hoist in zip(programs, hoists(programs), strict=True):
        texts.append(module.function(program, walk.hoisting(program), hoist))
        for routine in program.routines:
            texts.append(module.function(program, walk.kernel(program, routine), routine.name))
            texts += [call_entry(program, routine, hoist), batch_entry(program, routine, hoist)]
    sines = [llvm_sincos(width, options.contract) for width in sorted(module.widths)]
    called = module.called | ({"sin": 1, "cos": 1} if sines else {})
    declared = [f"declare double @{name}({', '.join(['double'] * n)})" for name, n in sorted(called.items())]
    return "\n".join([*declared, *sines, *texts])


def hoists(programs: Sequence[Program]) -> list[str]:
    """The names of the functions that hoist, one a Program."""
    return [f"hoist{f'.{k}' if k else ''}" for k in range(len(programs))]


def _spelled(op: Op, value: str, operands: Sequence[str], flags: str, lanes: Lanes = _SCALAR) -> tuple[str, str]:
    """The lines of an operation and the function that they call, "" if none. The C library's functions take one double."""
    callee = _LIBRARY.get(op) or (f"{_INTRINSIC[op]}.{lanes.suffix}" if op in _INTRINSIC else "")
    if callee:
        return f"{value} = call {lanes.double} @{callee}({', '.join(f'{lanes.double} {o}' for o in operands)})", callee
    return _FORMS[op].format(*operands, r=value, f=flags, **_kinds(lanes)), ""


@cache
def _kinds(lanes: Lanes) -> dict[str, str]:
    """The types and numbers that forms of operations hold."""
    numbers = {name: lanes.all("double", text) for name, text in (("zero", "0.0"), ("one", "1.0"), ("minus", "-1.0"))}
    return {"v": lanes.double, "b": lanes.of("i1"), **numbers}


@dataclass(frozen=True, slots=True)
class _Module:
    """What the functions written so far call: the library's with their numbers of arguments, sines of so many angles."""

    options: Options
    called: dict[str, int] = field(default_factory=dict)
    widths: set[int] = field(default_factory=set)

    def function(self, program: Program, function: walk.Function, name: str) -> str:
        """One function, or several with one that calls them in turn."""
        style = walk.Style(lazy=True, lanes=self.options.lanes)
        parts = walk.pieces(program, function, style)
        kinds = [("double" if p.scalar else "ptr", pointer(p.name)) for p in function.ports]
        kinds += [("ptr", f"%{walk.VECTORS[base]}") for base in dict.fromkeys((walk.KEPT, function.target))]
        signature = ", ".join(f"{kind}{' noalias' * (kind == 'ptr')} {value}" for kind, value in kinds)
        if len(parts.chunks) == 1:
            return self._piece(f"define void @{name}({signature}) nounwind", program, function, parts.chunks[0], style)
        texts = []
        for k, part in enumerate(parts.chunks):
            head = f"define internal void @{name}.{k}({signature}, ptr noalias %w) nounwind noinline"
            texts.append(self._piece(head, program, function, part, style))
        passed = ", ".join(f"{kind} {value}" for kind, value in kinds)
        calls = [f"  call void @{name}.{k}({passed}, ptr %w)" for k in range(len(parts.chunks))]
        head = f"define void @{name}({signature}) nounwind {{"
        work = f"  %w = alloca [{max(1, parts.slots)} x double], align 64"
        return "\n".join([*texts, head, work, *calls, "  ret void", "}"])

    def _piece(self, head: str, program: Program, function: walk.Function, piece: Chunk, style: walk.Style) -> str:
        body = walk.statements(program, function, piece, style)
        writer = _Writer(program, self.options, body)
        for statement in body:
            writer.write(statement)
        self.called.update(writer.called)
        self.widths.update(writer.widths)
        return "\n".join([f"{head} {{", *writer.lines, "  ret void", "}"])


class _Writer:
    """The lines of one piece."""

    def __init__(self, program: Program, options: Options, body: Sequence[walk.Statement]) -> None:
        self.flags = "contract " if options.contract else ""
        self.lines: list[str] = []
        self.called: dict[str, int] = {}
        self.widths: set[int] = set()
        first = len(program.inputs)
        self.names = {first + k: bits(value) for k, value in enumerate(program.constants)}
        scalars = [(port.scalar, pointer(port.name)) for port in program.ports for _ in port.symbols]
        self.names |= {i: name for i, (scalar, name) in enumerate(scalars) if scalar}
        # Else LLVM would load neighbours as one vector, which waits where they have just been stored one by one.
        self.volatile = {a for s in body if isinstance(s, walk.SinCos) for a in s.angles}

    def write(self, s: walk.Statement) -> None:
        """The lines of one statement."""
        if isinstance(s, walk.Read):
            self._read(s)
        elif isinstance(s, walk.Compute):
            name = f"%v{s.value}"
            text, callee = _spelled(s.op, name, [self.names[a] for a in s.arguments], self.flags)
            self.lines += [f"  {line}" for line in text.split("\n")]
            self.names[s.value] = name
            self.called |= {callee: s.op.arity} if callee else {}
        elif isinstance(s, walk.SinCos):
            self._sincos(s.angles, s.values)
        else:
            self._store(s)

    def _read(self, s: walk.Read) -> None:
        load = "load volatile" if s.value in self.volatile else "load"
        base = _base(s.base)
        self.names[s.value] = f"%v{s.value}"
        self.lines += [
            f"  %a{s.value} = getelementptr inbounds double, ptr {base}, i64 {s.place}",
            f"  %v{s.value} = {load} double, ptr %a{s.value}, align 8",
        ]

    def _store(self, s: walk.Write) -> None:
        address = f"%s{len(self.lines)}"
        self.lines += [
            f"  {address} = getelementptr inbounds double, ptr {_base(s.base)}, i64 {s.place}",
            f"  store double {self.names[s.value]}, ptr {address}, align 8",
        ]

    def _sincos(self, angles: Sequence[int], values: Sequence[Mapping[Op, int]]) -> None:
        """Sines and cosines in a vector as wide as the angles fill."""
        width = 1 << (len(angles) - 1).bit_length()
        kind = Lanes(width).double
        self.widths.add(width)
        operands = [self.names[a] for a in angles]
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
        for k, own in enumerate(values):
            for op, i in own.items():
                if width == 1:
                    self.names[i] = f"{label}.{op.name}"
                else:
                    self.names[i] = f"%v{i}"
                    self.lines.append(f"  %v{i} = extractelement {kind} {label}.{op.name}, i32 {k}")


def _base(name: str) -> str:
    return f"%{walk.VECTORS[name]}" if name in walk.VECTORS else pointer(name)
