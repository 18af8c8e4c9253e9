# SPDX-License-Identifier: BSD-3-Clause
"""A routine whose limbs are computed side by side, as LLVM text: packs are vectors, what limbs share are plain doubles.

A lane may hold the negative of its value; its sign is known here and is made good where the value is read.
"""

from collections.abc import Callable, Iterable, Sequence
from itertools import count

from kane.expr.ops import ADD, COS, DIV, MUL, SIN, Op
from kane.program.emit import walk
from kane.program.emit.llvm_entries import pointer
from kane.program.emit.llvm_forms import INTRINSICS, LIBRARY, lines
from kane.program.emit.llvm_lanes import Lanes, bits
from kane.program.program import Operand, Pack, Program, Routine

Signs = tuple[int, ...]


def limbs_text(program: Program, routine: Routine, signature: str, flags: str) -> tuple[str, set[int], dict[str, int]]:
    """The function, the widths of the sines that it calls, and the library's functions with their numbers of arguments."""
    writer = _Writer(program, routine, flags)
    body = writer.written()
    head = f"define void @{routine.name}({signature}) nounwind {{"
    return "\n".join([head, *body, "  ret void", "}"]), writer.widths, writer.called


class _Writer:
    def __init__(self, program: Program, routine: Routine, flags: str) -> None:
        self.program, self.routine, self.flags = program, routine, flags
        self.limbs = len(routine.packs[0].values)
        self.lanes = Lanes(1 << (self.limbs - 1).bit_length())
        self.packs = {p.values: p for p in routine.packs}
        self.home = {i: (p, k) for p in routine.packs for k, i in enumerate(p.values)}
        function = walk.function_of(program, routine)
        places = ((port, k) for port in program.ports for k in range(len(port.symbols)))
        self.sources = {i: (pointer(port.name), k) for i, (port, k) in enumerate(places) if not port.scalar}
        self.sources |= {i: (f"%{walk.VECTORS[walk.KEPT]}", k) for k, i in enumerate(function.kept)}
        first = len(program.inputs)
        self.constants = dict(enumerate(program.constants, first))
        scalars = [(port.scalar, pointer(port.name)) for port in program.ports for _ in port.symbols]
        self.single = {i: name for i, (scalar, name) in enumerate(scalars) if scalar}
        self.single |= {i: bits(value) for i, value in self.constants.items()}
        self.vectors: dict[tuple[int, ...], tuple[str, Signs]] = {}
        self.sines: dict[tuple[int, ...], str] = {}
        self.lines: list[str] = []
        self.numbers = count()
        self.widths: set[int] = set()
        self.called: dict[str, int] = {}

    def written(self) -> list[str]:
        """The lines: what results need, arguments first."""
        for i in self.routine.results:
            self._reach(i)
        for place, i in enumerate(self.routine.results):
            address = self._name()
            self.lines.append(
                f"  {address} = getelementptr inbounds double, ptr %{walk.VECTORS[walk.RESULTS]}, i64 {place}"
            )
            self.lines.append(f"  store double {self._scalar(i)}, ptr {address}, align 8")
        return self.lines

    def _reach(self, result: int) -> None:
        """Everything below a value, without recursion."""
        stack: list[int | Pack | None] = [result]
        while stack:
            unit = stack.pop()
            ready = unit is None
            if unit is None:
                unit = stack.pop()
            if isinstance(unit, int) and unit in self.home:
                unit = self.home[unit][0]
            if unit is None or (unit.values in self.vectors if isinstance(unit, Pack) else unit in self.single):
                continue
            if ready:
                self._pack(unit) if isinstance(unit, Pack) else self._instruction(unit)
            elif isinstance(unit, Pack):
                stack += [unit, None, *(x.value for operand in reversed(unit.operands) for x in reversed(operand))]
            elif unit >= self.program.first and unit not in self.sources:
                stack += [unit, None, *reversed(self.program.arguments(unit))]

    def _name(self) -> str:
        return f"%t{next(self.numbers)}"

    def _scalar(self, i: int) -> str:
        """The name of a value that has been reached."""
        if i in self.single:
            return self.single[i]
        name = self._name()
        if i in self.sources:
            base, place = self.sources[i]
            self.lines.append(f"  {name}.at = getelementptr inbounds double, ptr {base}, i64 {place}")
            self.lines.append(f"  {name} = load double, ptr {name}.at, align 8")
        else:
            pack, k = self.home[i]
            vector, signs = self.vectors[pack.values]
            self.lines.append(f"  {name} = extractelement {self.lanes.double} {vector}, i32 {k}")
            if signs[k] < 0:
                self.lines.append(f"  {name}.n = fneg double {name}")
                name = f"{name}.n"
        self.single[i] = name
        return name

    def _instruction(self, i: int) -> None:
        op, operands = self.program.op(i), [self._scalar(a) for a in self.program.arguments(i)]
        name = self._name()
        if op is SIN or op is COS:
            name = self._sine(op, (self.program.arguments(i)[0],), operands[0], Lanes(1))
        else:
            self._operation(op, name, operands, Lanes(1))
        self.single[i] = name

    def _operation(self, op: Op, name: str, operands: Sequence[str], lanes: Lanes) -> None:
        called = LIBRARY.get(op) or (f"{INTRINSICS[op]}.{lanes.suffix}" if op in INTRINSICS else "")
        if called:
            if lanes.width == 1:
                self.called[called] = op.arity
            given = ", ".join(f"{lanes.double} {o}" for o in operands)
            self.lines.append(f"  {name} = call {lanes.double} @{called}({given})")
        else:
            self.lines += [f"  {line}" for line in lines(op, name, operands, lanes, self.flags)]

    def _sine(self, op: Op, angles: tuple[int, ...], operand: str, lanes: Lanes) -> str:
        """Sine or cosine of what has no sign; both are computed together."""
        if angles not in self.sines:
            label = self.sines[angles] = self._name()
            self.widths.add(lanes.width)
            pair = f"{{{lanes.double}, {lanes.double}}}"
            self.lines.append(f"  {label} = call {pair} @kane.sincos.{lanes.width}({lanes.double} {operand})")
            self.lines += [f"  {label}.{f.name} = extractvalue {pair} {label}, {k}" for k, f in enumerate((SIN, COS))]
        return f"{self.sines[angles]}.{op.name}"

    # packs -------------------------------------------------------------------------------------------------------------

    def _pack(self, pack: Pack) -> None:
        self.vectors[pack.values] = _KINDS.get(pack.op, _Writer._other)(self, pack)

    def _sum(self, pack: Pack) -> tuple[str, Signs]:
        """x + y as s_x (X ± Y): one addition or subtraction, of mixed signs one a + (±1) b."""
        (x, signs), (y, others) = map(self._operand, pack.operands)
        relative = tuple(s * t for s, t in zip(signs, others, strict=True))
        name, kind = self._name(), self.lanes.double
        if len(set(relative)) == 1:
            word = "fadd" if relative[0] > 0 else "fsub"
            self.lines.append(f"  {name} = {word} {self.flags}{kind} {x}, {y}")
        else:  # exact: each product is y or −y
            self.lines.append(f"  {name}.y = fmul contract {kind} {y}, {self._numbers(map(float, relative))}")
            self.lines.append(f"  {name} = fadd contract {kind} {x}, {name}.y")
        return name, signs

    def _product(self, pack: Pack) -> tuple[str, Signs]:
        (x, signs), (y, others) = map(self._operand, pack.operands)
        name = self._name()
        word = "fmul" if pack.op is MUL else "fdiv"
        self.lines.append(f"  {name} = {word} {self.flags}{self.lanes.double} {x}, {y}")
        return name, tuple(s * t for s, t in zip(signs, others, strict=True))

    def _angle(self, pack: Pack) -> tuple[str, Signs]:
        (operand,) = pack.operands
        vector, signs = self._operand(operand)
        name = self._sine(pack.op, tuple(x.value for x in operand), vector, self.lanes)
        return name, signs if pack.op is SIN else (1,) * self.limbs

    def _other(self, pack: Pack) -> tuple[str, Signs]:
        operands = [self._signed(*self._operand(operand)) for operand in pack.operands]
        name = self._name()
        self._operation(pack.op, name, operands, self.lanes)
        return name, (1,) * self.limbs

    def _signed(self, vector: str, signs: Signs) -> str:
        if min(signs) > 0:
            return vector
        name = self._name()
        self.lines.append(f"  {name} = fmul {self.lanes.double} {vector}, {self._numbers(map(float, signs))}")
        return name

    def _operand(self, operand: tuple[Operand, ...]) -> tuple[str, Signs]:
        """A vector of values that have been reached, with the signs of its lanes."""
        values, signs = tuple(x.value for x in operand), tuple(x.sign for x in operand)
        if all(i in self.constants for i in values):
            return self._numbers(self.constants[i] * s for i, s in zip(values, signs, strict=True)), (1,) * self.limbs
        if values not in self.vectors:
            self.vectors[values] = (self._gathered(values), (1,) * self.limbs)
        vector, own = self.vectors[values]
        return vector, tuple(s * t for s, t in zip(signs, own, strict=True))

    def _gathered(self, values: tuple[int, ...]) -> str:
        """One double in each lane, what is left over repeats the last."""
        name, kind, width = self._name(), self.lanes.double, self.lanes.width
        if len(set(values)) == 1:
            one = self._scalar(values[0])
            name = self._name()
            self.lines.append(f"  {name}.0 = insertelement {kind} poison, double {one}, i32 0")
            mask = f"<{width} x i32> zeroinitializer"
            self.lines.append(f"  {name} = shufflevector {kind} {name}.0, {kind} poison, {mask}")
            return name
        found = [self.sources.get(i) for i in values]
        if width == self.limbs and None not in found and values not in self.packs:
            bases, places = zip(*(f for f in found if f is not None), strict=True)
            if len(set(bases)) == 1 and places == tuple(range(places[0], places[0] + width)):
                self.lines.append(f"  {name}.at = getelementptr inbounds double, ptr {bases[0]}, i64 {places[0]}")
                self.lines.append(f"  {name} = load {kind}, ptr {name}.at, align 8")
                return name
        parts = [self._scalar(i) for i in values]
        before, label = "poison", self._name()
        for k in range(width):
            part = parts[min(k, len(parts) - 1)]
            self.lines.append(f"  {label}.{k} = insertelement {kind} {before}, double {part}, i32 {k}")
            before = f"{label}.{k}"
        return before

    def _numbers(self, values: Iterable[float]) -> str:
        own = list(values)
        own += [own[-1]] * (self.lanes.width - len(own))
        if self.lanes.width == 1:
            return bits(own[0])
        return f"<{', '.join(f'double {bits(v)}' for v in own)}>"


_KINDS: dict[Op, Callable[[_Writer, Pack], tuple[str, Signs]]] = {
    ADD: _Writer._sum,
    MUL: _Writer._product,
    DIV: _Writer._product,
    SIN: _Writer._angle,
    COS: _Writer._angle,
}
