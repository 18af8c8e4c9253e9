# SPDX-License-Identifier: BSD-3-Clause
"""Kernels in LLVM for several instances at once, one in each lane of vectors (single program, multiple data).

An element of an array is `width` consecutive doubles, one for each instance, except in `shared` arrays. A value that is equal in all
lanes is a scalar (`varying` finds the others): a read from an array that is not shared varies, and so do the values computed from it,
a cell that only some lanes write, and statements under a varying condition. Sizes, loop counters and array indices are usually equal
in all lanes and computed once. Under a varying condition a branch or loop runs with a mask of the lanes for which the condition holds;
the other lanes keep their values. A block for which the mask is empty is skipped.

A routine receives the mask as bits; each number passed to it is the address of one per lane.
"""

from collections.abc import Collection
from dataclasses import dataclass, field
from itertools import chain

from kane.errors import ProgramError
from kane.program.emit.llvm_printer import Calls, LlvmPrinter, lines, masked_store, typed, vector
from kane.program.kernel import language
from kane.program.kernel.language import INT, Kernel, Operand, Type, Value


@dataclass(slots=True)
class Varying:
    """The values (by number) and cells that may differ between lanes; elements of `shared` arrays are equal in all lanes."""

    shared: frozenset[str]
    values: set[int] = field(default_factory=set)
    cells: set[language.Cell] = field(default_factory=set)

    def __contains__(self, operand: Operand) -> bool:
        return isinstance(operand, Value) and operand.number in self.values


def varying(kernel: Kernel, shared: Collection[str]) -> Varying:
    """The values and cells of a kernel that differ between lanes: the fixed point of a dataflow analysis."""
    result, before = Varying(frozenset(shared)), -1
    while before < (before := len(result.values) + len(result.cells)):  # a loop reads cells before it writes them
        _note(result, kernel.body, apart=False)
    return result


def _note(found: Varying, block: language.Block, apart: bool) -> None:
    """Marks the values and cells that differ in a block; `apart`: only some lanes may run it."""
    for s in block:
        if isinstance(s, language.Compute):
            _mark(found, s.value, any(a in found for a in s.arguments))
        elif isinstance(s, language.Read):
            _mark(found, s.value, s.base not in found.shared or s.offset in found)
        elif isinstance(s, language.Get):
            _mark(found, s.value, s.cell in found.cells)
        elif isinstance(s, language.Put):
            if apart or s.value in found:
                found.cells.add(s.cell)
        elif isinstance(s, language.If):
            _note(found, tuple(chain(s.then, s.other)), apart or s.condition in found)
        elif isinstance(s, language.While):
            _note(found, tuple(chain(s.head, s.body)), apart or s.condition in found)
        elif isinstance(s, language.For):
            _mark(found, s.counter, s.start in found)
            _note(found, s.body, apart or s.start in found or s.stop in found)


def _mark(found: Varying, value: Operand, differs: bool) -> None:
    if differs and isinstance(value, Value):
        found.values.add(value.number)


class LanesPrinter(LlvmPrinter):
    """Prints a kernel for several lanes; `mask` is the name of the vector of truth values of the running lanes, "" if all run."""

    def __init__(self, calls: Calls, flags: str, width: int, varying: Varying) -> None:
        super().__init__(calls, flags, width=width, shared=varying.shared)
        self.varying, self.width = varying, width
        self.mask = ""
        self.rooms: list[str] = []
        self.some = self.lanes.of("i1")

    # ------------------------------------------------------------------------------------------------------- values

    def new(self, what: str) -> str:
        """A unique name."""
        return f"%{what}{len(self.lines)}"

    def wide_type(self, type_: Type) -> str:
        """The vector type with one value of a type per lane."""
        return typed(Type(type_.kind, self.width))

    def wide(self, operand: Operand) -> str:
        """An operand as a vector over lanes."""
        if operand in self.varying:
            return self.names[operand]
        type_ = language.type_of(operand)
        if isinstance(operand, language.Immediate):
            return self.lanes.all(typed(type_), self.names[operand])
        return self.splatted(self.names[operand], type_)

    def splatted(self, value: str, type_: Type) -> str:
        """A vector with one value in every lane."""
        name = self.new("all")
        self.add(*lines("splat", name, [value], "", type_, Type(type_.kind, self.width)))
        return name

    def room(self, what: str, type_: str) -> str:
        """A variable on the stack."""
        name = self.new(what)
        self.rooms.append(f"  {name} = alloca {type_}")
        return name

    def choose(self, type_: str, value: str, before: str, mask: str) -> str:
        """The value in running lanes, and `before` in the others."""
        if not mask:
            return value
        name = self.new("kept")
        self.add(f"{name} = select {self.some} {mask}, {type_} {value}, {type_} {before}")
        return name

    def where(self, condition: str) -> str:
        """The running lanes for which a condition holds; not an `and`, because the condition may be undefined in other lanes."""
        return self.choose(self.some, condition, "zeroinitializer", self.mask)

    def compute(self, s: language.Compute) -> None:
        """Adds an operation, on scalars or in all lanes."""
        if s.value not in self.varying:
            super().compute(s)
            return
        given, made = (Type(language.type_of(x).kind, self.width) for x in (s.arguments[0], s.value))
        self.operation(self.names[s.value], s.op, [self.wide(a) for a in s.arguments], given, made)

    # ------------------------------------------------------------------------------------------------------- memory

    def place(self, base: str, offset: Operand) -> str:
        """The address of a scalar element, or of the elements of all lanes."""
        if offset in self.varying:
            raise ProgramError(f"Expected a place in {base} that all lanes share: a routine takes one address.")
        name, kind = self.new("a"), "double" if base in self.shared else self.kind
        self.add(f"{name} = getelementptr inbounds {kind}, ptr {vector(base)}, i64 {self.names[offset]}")
        return name

    def places(self, base: str, offset: Operand) -> str:
        """The addresses of array elements at an index that varies between lanes."""
        name, at, kind = self.new("a"), self.wide(offset), self.lanes.of("i64")
        if base not in self.shared:
            lane = ", ".join(f"i64 {k}" for k in range(self.width))
            self.add(f"{name}.row = mul {kind} {at}, {self.lanes.all('i64', self.width)}")
            self.add(f"{name}.at = add {kind} {name}.row, <{lane}>")
            at = f"{name}.at"
        self.add(f"{name} = getelementptr double, ptr {vector(base)}, {kind} {at}")
        return name

    def scattered(self, action: str, given: str) -> str:
        """A gather or scatter: a call that reads or writes the lanes' elements at a vector of addresses."""
        pointers, kind = self.lanes.of("ptr"), f"v{self.width}f64.v{self.width}p0"
        reads = action == "gather"
        takes = f"{pointers}, i32, {self.some}, {self.kind}" if reads else f"{self.kind}, {pointers}, i32, {self.some}"
        result = self.kind if reads else "void"
        self.calls.declared.add(f"declare {result} @llvm.masked.{action}.{kind}({takes})")
        return f"call {result} @llvm.masked.{action}.{kind}({given})"

    def load(self, s: language.Read) -> None:
        """Adds a load."""
        name, mask = self.names[s.value], self.mask or self.lanes.all("i1", "true")
        if s.offset in self.varying:
            at = f"{self.lanes.of('ptr')} {self.places(s.base, s.offset)}"
            given = f"{at}, i32 8, {self.some} {mask}, {self.kind} zeroinitializer"
            self.add(f"{name} = {self.scattered('gather', given)}")
        else:
            kind = self.kind if s.value in self.varying else "double"
            self.add(f"{name} = load {kind}, ptr {self.place(s.base, s.offset)}, align 8")

    def store(self, s: language.Write) -> None:
        """Adds a store in the running lanes."""
        if s.base in self.shared:
            raise ProgramError(
                f"Expected {s.base}, which all lanes share, to be read alone, got a kernel that writes to it."
            )
        value = self.wide(s.value)
        if s.offset in self.varying:
            mask = self.mask or self.lanes.all("i1", "true")
            at = f"{self.lanes.of('ptr')} {self.places(s.base, s.offset)}"
            self.add(self.scattered("scatter", f"{self.kind} {value}, {at}, i32 8, {self.some} {mask}"))
            return
        self.lines += masked_store(self.new("at"), self.lanes, value, self.place(s.base, s.offset), self.mask)

    def cell_type(self, cell: language.Cell) -> str:
        """The type of a cell."""
        return self.wide_type(cell.type) if cell in self.varying.cells else typed(cell.type)

    def get(self, s: language.Get) -> None:
        """Adds a read of a cell."""
        self.add(f"{self.names[s.value]} = load {self.cell_type(s.cell)}, ptr %cell.{s.cell.name}")

    def put(self, s: language.Put) -> None:
        """Adds an assignment to a cell in the running lanes."""
        if s.cell not in self.varying.cells:
            super().put(s)
            return
        kind, cell, before = self.cell_type(s.cell), f"%cell.{s.cell.name}", self.new("before")
        if self.mask:
            self.add(f"{before} = load {kind}, ptr {cell}")
        self.add(f"store {kind} {self.choose(kind, self.wide(s.value), before, self.mask)}, ptr {cell}")

    # ------------------------------------------------------------------------------------------------------ control

    def call(self, s: language.CallRoutine) -> None:
        """Adds a call of a routine for the running lanes."""
        given, bits = [], str(2**self.width - 1)
        if self.mask:
            bits = self.new("bits")
            self.add(f"{bits}.own = bitcast {self.some} {self.mask} to i{self.width}")
            self.add(f"{bits} = zext i{self.width} {bits}.own to i64")
        for a in s.arguments:
            if isinstance(a, language.Address):
                given.append(self.place(a.base, a.offset))
            else:
                given.append(self.room("number", self.kind))
                self.add(f"store {self.kind} {self.wide(a)}, ptr {given[-1]}, align {8 * self.width}")
        self.add(f"call void %{s.callee.name}(i64 {bits}{''.join(f', ptr {x}' for x in given)})")

    def under(self, mask: str, label: str, block: language.Block, after: str) -> None:
        """Adds a labelled block under a mask, which then continues at the label `after`."""
        outer, self.mask = self.mask, mask
        self.labelled(label, block)
        self.mask = outer
        self.add(f"br label %{after}")

    def jump(self, mask: str, label: str, other: str, told: str = "") -> None:
        """Adds a branch to `label` if any lane of the mask is set, else to `other`; `told` is its metadata."""
        bits, any_ = self.new("bits"), self.new("any")
        self.add(
            f"{bits} = bitcast {self.some} {mask} to i{self.width}",
            f"{any_} = icmp ne i{self.width} {bits}, 0",
            f"br i1 {any_}, label %{label}, label %{other}{told}",
        )

    def choice(self, s: language.If) -> None:
        """Adds an if statement: each branch runs under its mask, unless that is empty."""
        if s.condition not in self.varying:
            super().choice(s)
            return
        condition = self.names[s.condition]
        for block, holds in ((s.then, True), (s.other, False)):
            if not block:
                continue
            if not holds:
                condition = self.new("not")
                true = self.lanes.all("i1", "true")
                self.add(f"{condition} = xor {self.some} {self.names[s.condition]}, {true}")
            mask = self.where(condition)
            then, end = self.labels("then", "end")
            self.jump(mask, then, end)
            self.under(mask, then, block, end)
            self.labelled(end)

    def loop(self, s: language.While) -> None:
        """Adds a while loop: it runs under the mask of the lanes for which the condition still holds."""
        if s.condition not in self.varying:
            super().loop(s)
            return
        head, body, end = self.labels("head", "body", "end")
        outer, room = self.mask, self.room("live", self.some)
        self.add(f"store {self.some} {outer or self.lanes.all('i1', 'true')}, ptr {room}", f"br label %{head}")
        self.lines.append(f"{head}:")
        self.mask = self.new("running")
        self.add(f"{self.mask} = load {self.some}, ptr {room}")
        self.block(s.head)
        mask = self.where(self.names[s.condition])
        self.add(f"store {self.some} {mask}, ptr {room}")
        self.jump(mask, body, end)
        self.under(mask, body, s.body, head)
        self.mask = outer
        self.labelled(end)

    def count(self, s: language.For) -> None:
        """Adds a for loop: it runs under the mask of the lanes whose range contains the counter."""
        if s.start not in self.varying and s.stop not in self.varying:
            super().count(s)
            return
        before, body, last, end, more = self.labels("before", "body", "last", "end", "next")
        wide = s.counter in self.varying
        kind = self.wide_type(INT) if wide else "i64"
        index, one = self.names[s.counter], self.lanes.all("i64", 1) if wide else "1"
        start, stop = self.wide(s.start) if wide else self.names[s.start], self.wide(s.stop)
        outer, room = self.mask, self.room("live", self.some)

        def tested(index: str, told: str = "") -> None:
            on = self.new("on")
            self.add(f"{on} = icmp slt {self.wide_type(INT)} {index}, {stop}")
            running = self.where(on)
            self.add(f"store {self.some} {running}, ptr {room}")
            self.jump(running, body, end, told)

        self.add(f"br label %{before}")
        self.labelled(before)
        tested(self.wide(s.start))
        self.labelled(body)
        self.add(f"{index} = phi {kind} [ {start}, %{before} ], [ %{more}, %{last} ]")
        self.mask = self.new("running")
        self.add(f"{self.mask} = load {self.some}, ptr {room}")
        self.block(s.body)
        self.mask = outer
        self.add(f"br label %{last}")
        self.labelled(last)
        self.add(f"%{more} = add {kind} {index}, {one}")
        tested(f"%{more}" if wide else self.splatted(f"%{more}", INT), ", !llvm.loop !0" * s.few)
        self.labelled(end)

    def largest(self, cell: language.Cell) -> list[str]:
        """The lines that assign the largest value of an integer cell over the lanes to %result."""
        kind = self.cell_type(cell)
        if cell not in self.varying.cells:
            return [f"  %result = load i64, ptr %cell.{cell.name}"]
        function = f"@llvm.vector.reduce.smax.v{self.width}i64"
        self.calls.declared.add(f"declare i64 {function}({kind})")
        return [f"  %results = load {kind}, ptr %cell.{cell.name}", f"  %result = call i64 {function}({kind} %results)"]
