# SPDX-License-Identifier: BSD-3-Clause
"""A routine at several states at once: one function, `<name>.lanes<width>(ports, h, out)`, whose values are vectors.

Every port is a pointer. Of those of the tier "parameter", and of h, a number stands for all states; of the others, and of the
results, each number is `width` doubles side by side, one a state. What the library computes is called state by state.
"""

from collections.abc import Sequence

from kane.expr.ops import COS, SIN, Op
from kane.program.emit import walk
from kane.program.emit.llvm_entries import pointer
from kane.program.emit.llvm_forms import INTRINSICS, LIBRARY, lines
from kane.program.emit.llvm_lanes import Lanes
from kane.program.emit.llvm_sincos import llvm_sincos
from kane.program.passes.split import Chunk
from kane.program.program import Program, Routine

_STYLE = walk.Style(lazy=True, lanes=1)


def wide_name(routine: str, width: int) -> str:
    """The function's name."""
    return f"{routine}.lanes{width}"


def emit_wide(program: Program, routine: Routine, width: int, contract: bool = True) -> str:
    """The text of a module that holds the function; `contract` allows a·b + c in one rounding."""
    function = walk.function_of(program, routine)
    parts = walk.pieces(program, function, _STYLE)
    names = [pointer(p.name) for p in function.ports] + [
        f"%{walk.VECTORS[base]}" for base in (walk.KEPT, function.target)
    ]
    signature = ", ".join(f"ptr noalias {name}" for name in names)
    name = wide_name(routine.name, width)
    declared = {"declare double @sin(double)", "declare double @cos(double)"}
    texts = [llvm_sincos(width, contract)]
    if len(parts.chunks) == 1:
        writer = _Writer(program, Lanes(width), "contract " * contract)
        texts.append(writer.function(f"define void @{name}({signature}) nounwind", function, parts.chunks[0]))
        declared |= writer.declared
        return "\n".join([*sorted(declared), *texts, ""])
    for k, part in enumerate(parts.chunks):
        writer = _Writer(program, Lanes(width), "contract " * contract)
        head = f"define internal void @{name}.{k}({signature}, ptr noalias %w) nounwind noinline"
        texts.append(writer.function(head, function, part))
        declared |= writer.declared
    calls = [
        f"  call void @{name}.{k}({', '.join(f'ptr {n}' for n in [*names, '%w'])})" for k in range(len(parts.chunks))
    ]
    work = f"  %w = alloca [{width * max(1, parts.slots)} x double], align 64"
    texts.append("\n".join([f"define void @{name}({signature}) nounwind {{", work, *calls, "  ret void", "}"]))
    return "\n".join([*sorted(declared), *texts, ""])


class _Writer:
    """The lines of one piece, and what they call."""

    def __init__(self, program: Program, lanes: Lanes, flags: str) -> None:
        self.program, self.lanes, self.flags = program, lanes, flags
        self.lines: list[str] = []
        self.declared: set[str] = set()
        first = len(program.inputs)
        self.names = {first + k: lanes.number(value) for k, value in enumerate(program.constants)}
        self.shared = {walk.KEPT, *(port.name for port in program.ports if port.hoisted)}
        places = [port for port in program.ports for _ in port.symbols]
        self.scalars = {i: pointer(port.name) for i, port in enumerate(places) if port.scalar}

    def function(self, head: str, function: walk.Function, piece: Chunk) -> str:
        """The text of a piece."""
        for i, name in self.scalars.items():
            self.names[i] = f"%scalar{i}"
            self.lines.append(f"  %scalar{i} = load {self.lanes.double}, ptr {name}, align 8")
        for statement in walk.statements(self.program, function, piece, _STYLE):
            self.write(statement)
        return "\n".join([f"{head} {{", *self.lines, "  ret void", "}"])

    def write(self, s: walk.Statement) -> None:
        """The lines of one statement."""
        kind = self.lanes.double
        if isinstance(s, walk.Read):
            self.names[s.value] = f"%v{s.value}"
            self._read(f"%v{s.value}", s)
        elif isinstance(s, walk.Assign):
            name = self.names[s.value] = f"%v{s.value}"
            self._compute(name, s.op, [self.names[a] for a in s.arguments])
        elif isinstance(s, walk.SinCos):
            (angle,), (own,) = s.angles, s.values
            pair, label = f"{{{kind}, {kind}}}", f"%p{angle}.{len(self.lines)}"
            self.lines.append(f"  {label} = call {pair} @kane.sincos.{self.lanes.width}({kind} {self.names[angle]})")
            for position, op in enumerate((SIN, COS)):
                if op in own:
                    self.names[own[op]] = f"%v{own[op]}"
                    self.lines.append(f"  %v{own[op]} = extractvalue {pair} {label}, {position}")
        else:
            address = self._address(s)
            self.lines.append(f"  store {kind} {self.names[s.value]}, ptr {address}, align 8")

    def _read(self, name: str, s: walk.Read) -> None:
        kind, address = self.lanes.double, self._address(s)
        if s.base not in self.shared:
            self.lines.append(f"  {name} = load {kind}, ptr {address}, align 8")
            return
        mask = f"<{self.lanes.width} x i32> zeroinitializer"
        self.lines.append(f"  {name}.one = load double, ptr {address}, align 8")
        self.lines.append(f"  {name}.first = insertelement {kind} poison, double {name}.one, i32 0")
        self.lines.append(f"  {name} = shufflevector {kind} {name}.first, {kind} poison, {mask}")

    def _address(self, s: walk.Read | walk.Write) -> str:
        """The name of a place's address, after the line that computes it."""
        base = f"%{walk.VECTORS[s.base]}" if s.base in walk.VECTORS else pointer(s.base)
        name = f"%a{len(self.lines)}"
        place = s.place * (1 if s.base in self.shared else self.lanes.width)
        self.lines.append(f"  {name} = getelementptr inbounds double, ptr {base}, i64 {place}")
        return name

    def _compute(self, name: str, op: Op, operands: Sequence[str]) -> None:
        kind = self.lanes.double
        if op in INTRINSICS:
            function = f"{INTRINSICS[op]}.{self.lanes.suffix}"
            self.declared.add(f"declare {kind} @{function}({kind})")
            self.lines.append(f"  {name} = call {kind} @{function}({kind} {operands[0]})")
        elif op in LIBRARY:
            self._call(name, LIBRARY[op], operands)
        else:
            self.lines += [f"  {line}" for line in lines(op, name, operands, self.lanes, self.flags)]

    def _call(self, name: str, function: str, operands: Sequence[str]) -> None:
        """The library's function, lane by lane."""
        kind, whole = self.lanes.double, "poison"
        self.declared.add(f"declare double @{function}({', '.join(['double'] * len(operands))})")
        for k in range(self.lanes.width):
            for j, operand in enumerate(operands):
                self.lines.append(f"  {name}.{k}.{j} = extractelement {kind} {operand}, i32 {k}")
            given = ", ".join(f"double {name}.{k}.{j}" for j in range(len(operands)))
            self.lines.append(f"  {name}.{k} = call double @{function}({given})")
            last = name if k == self.lanes.width - 1 else f"{name}.to{k}"
            self.lines.append(f"  {last} = insertelement {kind} {whole}, double {name}.{k}, i32 {k}")
            whole = last
