# SPDX-License-Identifier: BSD-3-Clause
"""Programs as the text of one LLVM module.

Its functions are, for each Program, `hoist(parameters, h)`, and for each routine

    <name>(ports, h, out)       the kernel
    <name>.call(block)          one evaluation in a caller's private block (see `Block`)
    <name>.batch(n, …)          many, with a stride in rows for each port

Vectors are passed as pointers to doubles. Sines and cosines of angles that are known at the same time are computed side by side
in the lanes of a vector.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from kane.expr.ops import COS, DIV, REGULAR, SIN, Op
from kane.program.emit import walk
from kane.program.emit.llvm_entries import batch_entry, call_entry, pointer, shared
from kane.program.emit.llvm_forms import INTRINSICS, LIBRARY, divided, guard, lines
from kane.program.emit.llvm_lanes import Lanes, bits
from kane.program.emit.llvm_limbs import limbs_text
from kane.program.emit.llvm_near import Near, pointed
from kane.program.emit.llvm_sincos import llvm_sincos
from kane.program.passes.split import WHOLE
from kane.program.program import Program, Routine

_ONE = Lanes(1)
_NOWHERE: Mapping[str, Near] = {}
_WHOLE, _MATRIX = 2_500, 6_000
"""Instructions up to which a routine is one function, and one whose results are a matrix: it runs up to a fifth faster than in pieces,
and is compiled as soon up to there; the columns of a matrix have little to tell each other. Longer ones no longer fit the cache."""
_SHORT = 600
"""Statements up to which the time of a piece is that of what waits for each other."""


def emit_llvm(programs: Sequence[Program], contract: bool = True, lanes: int = 4) -> str:
    """The module's text; the same programs and options give the same text. The names of all routines must differ.

    `contract` allows a·b + c in one rounding, `lanes` is the width of the machine's vectors in doubles.
    """
    module = _Module(contract, lanes)
    texts = [shared()]
    for program, hoist in zip(programs, hoists(programs), strict=True):
        texts.append(module.function(program, walk.hoisting(program), hoist, WHOLE))
        for routine in program.routines:
            texts.append(module.limbs(program, routine) if routine.packs else module.routine(program, routine))
            texts += [call_entry(program, routine, hoist), batch_entry(program, routine, hoist)]
    sines = [llvm_sincos(width, contract) for width in sorted(module.widths)]
    called = module.called | ({"sin": 1, "cos": 1} if sines else {})
    declared = [f"declare double @{name}({', '.join(['double'] * n)})" for name, n in sorted(called.items())]
    return "\n".join([*declared, *sines, *texts])


def hoists(programs: Sequence[Program]) -> list[str]:
    """The names of the functions that hoist, one a Program."""
    return [f"hoist{k or ''}" for k in range(len(programs))]  # its pieces are hoist.0, hoist.1, …


@dataclass(frozen=True, slots=True)
class _Module:
    """What the functions written so far call: the library's with their numbers of arguments, sines of so many angles."""

    contract: bool
    lanes: int
    called: dict[str, int] = field(default_factory=dict)
    widths: set[int] = field(default_factory=set)
    common: dict[Program, dict[int, str]] = field(default_factory=dict)

    def routine(self, program: Program, routine: Routine) -> str:
        """The kernel of a routine."""
        whole = _MATRIX if len(routine.shape) > 1 else _WHOLE
        return self.function(program, walk.function_of(program, routine), routine.name, whole)

    def limbs(self, program: Program, routine: Routine) -> str:
        """The kernel of a routine with its limbs side by side."""
        signature = _signature(_arguments(walk.function_of(program, routine)))
        text, widths, called = limbs_text(program, routine, signature, "contract " if self.contract else "")
        self.widths.update(widths)
        self.called.update(called)
        return text

    def function(self, program: Program, function: walk.Function, name: str, whole: float) -> str:
        """One function, or several with one that calls them in turn."""
        style = walk.Style(lazy=True, lanes=self.lanes, whole=whole)
        parts = walk.pieces(program, function, style)
        signature = _signature(_arguments(function))
        if len(parts.chunks) == 1:
            body = walk.statements(program, function, parts.chunks[0], style)
            return self._piece(f"define void @{name}({signature}) nounwind", program, body)
        texts, calls, scalars = [], [], _scalars(program)
        for k, part in enumerate(parts.chunks):
            body = walk.statements(program, function, part, style)
            near = pointed(body)
            given = [*_passed(scalars, body, near)]
            head = f"define internal void @{name}.{k}({_signature((kind, value) for kind, value, _ in given)}) nounwind noinline"
            texts.append(self._piece(head, program, body, near))
            calls += [f"  {value}.{k} = {address}" for _, value, address in given if address]
            passed = ", ".join(f"{kind} {value}{f'.{k}' * bool(address)}" for kind, value, address in given)
            calls.append(f"  call void @{name}.{k}({passed})")
        head = f"define void @{name}({signature}) nounwind {{"
        work = f"  %w = alloca [{max(1, parts.slots)} x double], align 64"
        return "\n".join([*texts, head, work, *calls, "  ret void", "}"])

    def _piece(
        self, head: str, program: Program, body: Sequence[walk.Statement], near: Mapping[str, Near] = _NOWHERE
    ) -> str:
        if program not in self.common:
            self.common[program] = _common(program)
        writer = _Writer(self.common[program], self, body, near)
        for statement in body:
            writer.write(statement)
        return "\n".join([f"{head} {{", *writer.lines, "  ret void", "}"])


class _Names(dict[int, str]):
    """Names of values in one piece, beside those that all pieces have in `common`."""

    def __init__(self, common: Mapping[int, str]) -> None:
        super().__init__()
        self.common = common

    def __missing__(self, value: int) -> str:
        return self.common[value]


def _common(program: Program) -> dict[int, str]:
    """Constants, and ports that are scalars."""
    first = len(program.inputs)
    return {first + k: bits(value) for k, value in enumerate(program.constants)} | _scalars(program)


def _scalars(program: Program) -> dict[int, str]:
    """Ports that are scalars."""
    ports = (port for port in program.ports for _ in port.symbols)
    return {i: pointer(port.name) for i, port in enumerate(ports) if port.scalar}


def _passed(
    scalars: Mapping[int, str], body: Sequence[walk.Statement], near: Mapping[str, Near]
) -> Iterator[tuple[str, str, str]]:
    """The arguments of a piece: kind, name, and for those that the caller computes how. Scalars that it does not read are left out."""
    for base, own in near.items():
        vector = _vector(base)
        for k, place in enumerate(own.places):
            yield "ptr", f"{vector}.{k}", f"getelementptr double, ptr {vector}, i64 {place}"
    read = {a for s in body for a in _read(s)}
    yield from (("double", name, "") for i, name in scalars.items() if i in read)


def _read(s: walk.Statement) -> tuple[int, ...]:
    """The values that a statement reads."""
    if isinstance(s, walk.Assign):
        return s.arguments
    return s.angles if isinstance(s, walk.SinCos) else (s.value,)


def _vector(base: str) -> str:
    """What the pointer to a vector is called."""
    return f"%{walk.VECTORS[base]}" if base in walk.VECTORS else pointer(base)


def _arguments(function: walk.Function) -> list[tuple[str, str]]:
    kinds = [("double" if p.scalar else "ptr", pointer(p.name)) for p in function.ports]
    return kinds + [("ptr", f"%{walk.VECTORS[base]}") for base in dict.fromkeys((walk.KEPT, function.target))]


def _signature(arguments: Iterable[tuple[str, str]]) -> str:
    return ", ".join(f"{kind}{' noalias' * (kind == 'ptr')} {value}" for kind, value in arguments)


class _Writer:
    """The lines of one piece."""

    def __init__(
        self, common: Mapping[int, str], module: _Module, body: Sequence[walk.Statement], near: Mapping[str, Near]
    ) -> None:
        self.near = near
        self.module, self.flags = module, "contract " if module.contract else ""
        self.lines: list[str] = []
        self.names = _Names(common)
        # Else LLVM would load neighbours as one vector, which waits where they have just been stored one by one.
        self.volatile = {a for s in body if isinstance(s, walk.SinCos) for a in s.angles}
        # A divisor's guard is looked at while the quotient is on its way. In long code nothing waits, and registers are wanted.
        self.late, self.answers = _divisors(body) if len(body) <= _SHORT else set[int](), dict[int, str]()

    def write(self, s: walk.Statement) -> None:
        """The lines of one statement."""
        if isinstance(s, walk.Assign):
            name = self.names[s.value] = f"%v{s.value}"
            operands = [self.names[a] for a in s.arguments]
            if s.value in self.late:
                found, self.answers[s.value] = guard(name, operands)
                self.names[s.value] = operands[0]
            elif s.op is DIV and s.arguments[1] in self.answers:
                found = divided(name, operands, self.answers[s.arguments[1]], self.flags)
            else:
                found = self._compute(name, s.op, operands)
            self.lines += [f"  {line}" for line in found]
        elif isinstance(s, walk.Read):
            name = self.names[s.value] = f"%v{s.value}"
            address = self._address(f"%a{s.value}", s)
            volatile = " volatile" if s.value in self.volatile else ""
            self.lines.append(f"  {name} = load{volatile} double, ptr {address}, align 8")
        elif isinstance(s, walk.Write):
            address = self._address(f"%s{len(self.lines)}", s)
            self.lines.append(f"  store double {self.names[s.value]}, ptr {address}, align 8")
        else:
            self._sincos(s.angles, s.values)

    def _compute(self, name: str, op: Op, operands: Sequence[str]) -> list[str]:
        called = LIBRARY.get(op) or (f"{INTRINSICS[op]}.f64" if op in INTRINSICS else "")
        if not called:
            return lines(op, name, operands, _ONE, self.flags)
        self.module.called[called] = op.arity
        return [f"{name} = call double @{called}({', '.join(f'double {o}' for o in operands)})"]

    def _address(self, name: str, s: walk.Read | walk.Write) -> str:
        """`name`, after the line that makes it the address of what is read or written."""
        vector, place = _vector(s.base), s.place
        if s.base in self.near:
            k, place = self.near[s.base].nearest(place)
            vector = f"{vector}.{k}"
        self.lines.append(f"  {name} = getelementptr double, ptr {vector}, i64 {place}")
        return name

    def _sincos(self, angles: Sequence[int], values: Sequence[Mapping[Op, int]]) -> None:
        """Sines and cosines in a vector as wide as the angles fill."""
        width = 1 << (len(angles) - 1).bit_length()
        kind = Lanes(width).double
        self.module.widths.add(width)
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


def _divisors(body: Sequence[walk.Statement]) -> set[int]:
    """The guarded values that are read as divisors only."""
    guarded = {s.value for s in body if isinstance(s, walk.Assign) and s.op is REGULAR}
    for s in body if guarded else ():
        if isinstance(s, walk.Assign):
            guarded.difference_update(s.arguments[:1] if s.op is DIV else s.arguments)
        elif isinstance(s, walk.Write):
            guarded.discard(s.value)
    return guarded
