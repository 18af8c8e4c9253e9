# SPDX-License-Identifier: BSD-3-Clause
"""A routine with packs as LLVM text: packs of isomorphic instructions are vectors, other values are doubles (see `passes/limbs.py`).

A lane may hold the negative of its value; the sign is known at compile time and applied where the value is read.
"""

from collections.abc import Sequence
from typing import TypeAlias

from kane.expr.ops import ADD, COS, DIV, MUL, SIN, Op
from kane.program.emit import walk
from kane.program.emit.llvm_printer import Lanes, LlvmPrinter, vector
from kane.program.kernel.language import FLOAT, Read, Type, Write
from kane.program.program import Operand, Pack, Program

Signs: TypeAlias = tuple[int, ...]


def limbs_body(program: Program, function: walk.Function, packs: Sequence[Pack], printer: LlvmPrinter) -> list[str]:
    """The lines of a routine's function; `printer` names the constants and scalar ports."""
    limbs = _Limbs(program, function, packs, printer)
    for i in function.results:
        limbs.reach(i)
    for place, i in enumerate(function.results):
        limbs.scalar(i)
        printer.store(Write(i, walk.RESULTS, place))
    return printer.lines


class _Limbs:
    """The values computed so far: `vectors` by their values, with the signs of lanes, and scalars, which the printer names."""

    def __init__(self, program: Program, function: walk.Function, packs: Sequence[Pack], printer: LlvmPrinter) -> None:
        self.program, self.printer, self.sources = program, printer, function.places
        self.limbs = len(packs[0].values)
        self.lanes = Lanes(1 << (self.limbs - 1).bit_length())
        self.type = Type("float", self.lanes.width)
        self.packs = {p.values: p for p in packs}
        self.home = {i: (p, k) for p in packs for k, i in enumerate(p.values)}
        self.constants = dict(enumerate(program.constants, len(program.inputs)))
        printer.names.update(dict(printer.names.common.items()))
        self.vectors: dict[tuple[int, ...], tuple[str, Signs]] = {}
        self.sines: dict[tuple[int, ...], str] = {}

    def reach(self, result: int) -> None:
        """Computes a value and everything that it depends on, arguments first, without recursion."""
        stack: list[int | Pack | None] = [result]
        while stack:
            unit = stack.pop()
            ready = unit is None
            if unit is None:
                unit = stack.pop()
            if isinstance(unit, int) and unit in self.home:
                unit = self.home[unit][0]
            if unit is None or (unit.values in self.vectors if isinstance(unit, Pack) else unit in self.printer.names):
                continue
            if ready:
                self.compute_pack(unit) if isinstance(unit, Pack) else self.compute(unit)
            elif isinstance(unit, Pack):
                stack += [unit, None, *(x.value for operand in reversed(unit.operands) for x in reversed(operand))]
            elif unit >= self.program.first and unit not in self.sources:
                stack += [unit, None, *reversed(self.program.arguments(unit))]

    def new(self) -> str:
        """A unique name."""
        return f"%t{len(self.printer.lines)}"

    def scalar(self, i: int) -> str:
        """The name of a computed value as a double."""
        names, add = self.printer.names, self.printer.add
        if i in names:
            return names[i]
        if i in self.sources:
            self.printer.load(Read(i, *self.sources[i]))
            return names[i]
        pack, k = self.home[i]
        lanes, signs = self.vectors[pack.values]
        name = self.new()
        add(f"{name} = extractelement {self.lanes.double} {lanes}, i32 {k}")
        if signs[k] < 0:
            add(f"{name}.n = fneg double {name}")
            name = f"{name}.n"
        names[i] = name
        return name

    def compute(self, i: int) -> None:
        """Adds an instruction that is in no pack."""
        op, arguments = self.program.op(i), self.program.arguments(i)
        operands = [self.scalar(a) for a in arguments]
        name = self.new()
        if op is SIN or op is COS:
            name = self.sine(op, arguments, operands[0], Lanes(1))
        else:
            self.printer.operation(name, op, operands, FLOAT, FLOAT)
        self.printer.names[i] = name

    def sine(self, op: Op, angles: tuple[int, ...], operand: str, lanes: Lanes) -> str:
        """A vector of sines or cosines; both are computed by one call."""
        if angles not in self.sines:
            self.sines[angles] = self.new()
            self.printer.sines(self.sines[angles], operand, lanes)
        return f"{self.sines[angles]}.{op.name}"

    # packs -------------------------------------------------------------------------------------------------------------

    def compute_pack(self, pack: Pack) -> None:
        """Adds the vector of a pack, and records the signs of its lanes."""
        operands = [self.operand(operand) for operand in pack.operands]
        texts, signs = [text for text, _ in operands], [own for _, own in operands]
        both = tuple(s * t for s, t in zip(*signs, strict=True)) if len(signs) == 2 else signs[0]
        plain = (1,) * self.limbs
        if pack.op is ADD:
            self.vectors[pack.values] = self.sum(texts[0], texts[1], both), signs[0]
        elif pack.op is MUL or pack.op is DIV:
            self.vectors[pack.values] = self.operation(pack.op, texts), both
        elif pack.op is SIN or pack.op is COS:
            values = tuple(x.value for x in pack.operands[0])
            name = self.sine(pack.op, values, texts[0], self.lanes)
            self.vectors[pack.values] = name, signs[0] if pack.op is SIN else plain
        else:
            signed = [self.signed(text, own) for text, own in operands]
            self.vectors[pack.values] = self.operation(pack.op, signed), plain

    def operation(self, op: Op, operands: Sequence[str]) -> str:
        """Adds an operation on vectors."""
        name = self.new()
        self.printer.operation(name, op, operands, self.type, self.type)
        return name

    def sum(self, x: str, y: str, relative: Signs) -> str:
        """x + y as s_x (X ± Y): one addition or subtraction, or a + (±1) b if the signs differ between lanes."""
        name, kind, add = self.new(), self.lanes.double, self.printer.add
        if len(set(relative)) == 1:
            add(f"{name} = {'fadd' if relative[0] > 0 else 'fsub'} {self.printer.flags}{kind} {x}, {y}")
        else:  # exact: each product is y or −y
            add(f"{name}.y = fmul contract {kind} {y}, {self.lanes.numbers([float(s) for s in relative])}")
            add(f"{name} = fadd contract {kind} {x}, {name}.y")
        return name

    def signed(self, text: str, signs: Signs) -> str:
        """A vector with the signs applied."""
        if min(signs) > 0:
            return text
        name = self.new()
        self.printer.add(f"{name} = fmul {self.lanes.double} {text}, {self.lanes.numbers([float(s) for s in signs])}")
        return name

    def operand(self, operand: tuple[Operand, ...]) -> tuple[str, Signs]:
        """A vector of computed values, and the signs of its lanes."""
        values, signs = tuple(x.value for x in operand), tuple(x.sign for x in operand)
        if all(i in self.constants for i in values):
            numbers = [self.constants[i] * s for i, s in zip(values, signs, strict=True)]
            return self.lanes.numbers(numbers), (1,) * self.limbs
        if values not in self.vectors:
            self.vectors[values] = (self.gathered(values), (1,) * self.limbs)
        text, own = self.vectors[values]
        return text, tuple(s * t for s, t in zip(signs, own, strict=True))

    def gathered(self, values: tuple[int, ...]) -> str:
        """A vector of given doubles, one per lane."""
        printer, sources = self.printer, [self.sources.get(i) for i in values]
        if len(set(values)) == 1:
            number = self.scalar(values[0])
            name = self.new()
            printer.splat(name, number, self.lanes)
            return name
        if self.lanes.width == self.limbs and None not in sources and values not in self.packs:
            bases, places = zip(*(s for s in sources if s is not None), strict=True)
            if len(set(bases)) == 1 and places == tuple(range(places[0], places[0] + self.limbs)):
                name = self.new()
                printer.add(f"{name}.at = getelementptr inbounds double, ptr {vector(bases[0])}, i64 {places[0]}")
                printer.add(f"{name} = load {self.lanes.double}, ptr {name}.at, align 8")
                return name
        numbers = [self.scalar(i) for i in values]
        name = self.new()
        printer.gather(name, numbers, self.lanes)
        return name
