# SPDX-License-Identifier: BSD-3-Clause
"""Kernels as WebAssembly functions: one per kernel, and one for each long block within it.

Arrays have fixed addresses in memory. A cell is a local if one function uses it, else a global of the module.
"""

from collections.abc import Mapping, Sequence

from kane.program.emit.wasm_module import (
    F64,
    I32,
    I64,
    SPLAT,
    V128,
    Module,
    WasmFunction,
    int32,
    integer,
    leb,
    local_set,
    number,
    read,
)
from kane.program.emit.wasm_pairs import PairPrinter, Pairs, in_pairs
from kane.program.emit.wasm_printer import KINDS, Folded, Key, Places, WasmPrinter, joined
from kane.program.kernel import language
from kane.program.kernel.language import FLOAT, Block, Integer, Kernel, Operand, Statement, Value

LONGEST = 250
"""The number of statements beyond which a block becomes a function."""


def add_kernel(module: Module, kernel: Kernel, arrays: Mapping[str, int], routines: Mapping[str, int]) -> int:
    """Adds the function of a kernel, which takes its integers as i64 and returns an i32; returns its index.

    `arrays` maps arrays to addresses, `routines` maps routines to function indices.
    """
    sizes = _Sizes(kernel)
    integers = [a.value for a in kernel.arguments if isinstance(a, Integer)]
    function = WasmFunction([I64] * len(integers), [I32])
    cells: dict[tuple[str, int], tuple[bool, int]] = {}
    for cell in kernel.cells:
        for k in range(cell.type.width):
            kind = KINDS[cell.type.kind]
            is_shared = cell.name in sizes.shared
            cells[cell.name, k] = is_shared, module.variable(kind) if is_shared else function.local(kind)
    places = Places(fixed=arrays, routines=routines, cells=cells)
    printer = KernelPrinter(module, function, places, sizes)
    printer.locals = {(v.number, 0): k for k, v in enumerate(integers)}
    for is_shared, at in cells.values():
        if is_shared:
            printer.emit(_ZEROS[module.globals[at]], b"\x24" + leb(at))
    printer.sequence(kernel.body)
    printer.emit(Folded(_get(cells[kernel.result.name, 0])), b"\xa7")
    return module.add(function)


_ZEROS = {F64: number(0.0), I64: integer(0), I32: int32(0)}


def _get(at: tuple[bool, int]) -> bytes:
    return (b"\x23" if at[0] else b"\x20") + leb(at[1])


class _Sizes:
    """The blocks that become functions (`apart`), the values that each block reads from outside, the cells that functions share."""

    def __init__(self, kernel: Kernel) -> None:
        self.apart: set[int] = set()
        self.outer: dict[int, tuple[Value, ...]] = {}
        self._owners: dict[str, set[int]] = {}
        self._measure(kernel.body)
        self._own(kernel.body, 0)
        self.shared = {name for name, owners in self._owners.items() if owners != {0}}

    def _measure(self, block: Block) -> int:
        """The number of statements of a block in its function, not counting the blocks that become functions."""
        count = 0
        for s in block:
            count += 1
            for inner in parts(s):
                own = self._measure(inner)
                if own > LONGEST:
                    self.apart.add(id(inner))
                    own = 1
                count += own
        self.outer[id(block)] = tuple(self._free(block))
        return count

    def _free(self, block: Block) -> dict[Value, None]:
        result: dict[Value, None] = {}
        defined: set[Value] = set()
        for s in block:
            result |= dict.fromkeys(v for v in self.read(s) if v not in defined)
            defined.update(_defined(s))
        return result

    def read(self, s: Statement) -> list[Value]:
        """The values that a statement reads, including the blocks in it."""
        own = _operands(s)
        if isinstance(s, language.While):
            within = {v for head in s.head for v in _defined(head)}
            more = [*self.outer[id(s.head)], s.condition, *self.outer[id(s.body)]]
            return [v for v in more if isinstance(v, Value) and v not in within]
        inner = [v for b in parts(s) for v in self.outer[id(b)]]
        return own + [v for v in inner if not (isinstance(s, language.For) and v == s.counter)]

    def _own(self, block: Block, owner: int) -> None:
        for s in block:
            if isinstance(s, language.Get | language.Put):
                self._owners.setdefault(s.cell.name, set()).add(owner)
            for inner in parts(s):
                self._own(inner, id(inner) if id(inner) in self.apart else owner)


def parts(s: Statement) -> tuple[Block, ...]:
    """The blocks of a statement."""
    if isinstance(s, language.If):
        return s.then, s.other
    return (s.head, s.body) if isinstance(s, language.While) else (s.body,) if isinstance(s, language.For) else ()


def _operands(s: Statement) -> list[Value]:
    """The values that a statement reads, without its blocks."""
    found: Sequence[Operand | language.Address] = ()
    if isinstance(s, language.Compute | language.CallRoutine):
        found = s.arguments
    elif isinstance(s, language.Read):
        found = (s.offset,)
    elif isinstance(s, language.Write):
        found = (s.offset, s.value)
    elif isinstance(s, language.Put):
        found = (s.value,)
    elif isinstance(s, language.If):
        found = (s.condition,)
    elif isinstance(s, language.For):
        found = (s.start, s.stop)
    plain = [a.offset if isinstance(a, language.Address) else a for a in found]
    return [a for a in plain if isinstance(a, Value)]


def _defined(s: Statement) -> list[Value]:
    value = s.value if isinstance(s, language.Compute | language.Read | language.Get) else None
    return [value] if isinstance(value, Value) else []


class KernelPrinter(WasmPrinter):
    """Prints a kernel, or a block of it that is a function."""

    def __init__(self, module: Module, function: WasmFunction, places: Places, sizes: _Sizes) -> None:
        super().__init__(module, function, places)
        self.sizes = sizes
        self._print |= {
            language.Get: self.get,
            language.Put: self.put,
            language.CallRoutine: self.call,
            language.If: self.choice,
            language.While: self.loop,
            language.For: self.count,
        }

    def sequence(self, *blocks: Block, condition: Operand | None = None) -> None:
        """Adds blocks in order; between the first and the second, the loop ends unless the condition holds."""
        outer = self.left, self.nested
        self.left, self.nested = {}, set()
        behind = blocks[1:] if len(blocks) > 1 and id(blocks[1]) in self.sizes.apart else ()
        plain = blocks[: len(blocks) - len(behind)]
        own = {v for block in plain for s in block for v in _defined(s)}
        for block in plain:
            for s in block:
                self._count(s, own)
        for block in behind:
            self._count_within(self.sizes.outer[id(block)], own)
        if isinstance(condition, Value):
            self.left[condition.number, 0] = self.left.get((condition.number, 0), 0) + 1
        for k, block in enumerate(blocks):
            if k:
                assert condition is not None
                self.emit(self.operand(condition), b"\x45\x0d\x01")
            if block in behind:
                self.flush()
                self.apart(block)
                self._leave(self.sizes.outer[id(block)])
            else:
                for s in block:
                    self._print[type(s)](s)
        self.left, self.nested = outer

    def _count(self, s: Statement, own: set[Value]) -> None:
        """Counts the reads of the values in `own` by a statement."""
        direct = _operands(s)
        lane = s.lane if isinstance(s, language.Compute) and s.op == "lane" else None
        for v in direct:
            for k in range(v.type.width) if lane is None else (lane,):
                if v in own:
                    self.left[v.number, k] = self.left.get((v.number, k), 0) + 1
        if parts(s):
            self._count_within(self._within(s), own)

    def _count_within(self, read: Sequence[Value], own: set[Value]) -> None:
        """Counts one read for each value that nested blocks read, so that it stays available until they end."""
        for key in ((v.number, k) for v in read if v in own for k in range(v.type.width)):
            self.left[key] = self.left.get(key, 0) + 1
            self.nested.add(key)

    def _within(self, s: Statement) -> list[Value]:
        """The values that the blocks of a statement read from outside, without repetition."""
        direct = _operands(s)
        found = list(self.sizes.read(s))
        for v in direct:
            found.remove(v)
        return list(dict.fromkeys(found))

    def leave(self, s: Statement) -> None:
        """Counts down, after a statement with blocks, the values that these read from outside."""
        self._leave(self._within(s))

    def _leave(self, read: Sequence[Value]) -> None:
        for key in ((v.number, k) for v in read for k in range(v.type.width)):
            if key in self.left:
                self.count_down(key)

    # -------------------------------------------------------------------------------------------------- statements

    def get(self, s: language.Get) -> None:
        """Adds a read of a cell."""
        for k in range(s.cell.type.width):
            code = _get(self.places.cells[s.cell.name, k])
            self.define(s.value, Folded(code, (), frozenset([f"cell {s.cell.name}"])), k)

    def put(self, s: language.Put) -> None:
        """Adds an assignment to a cell."""
        found = [self.operand(s.value, k) for k in range(s.cell.type.width)]
        self.flush(f"cell {s.cell.name}")
        for k, one in enumerate(found):
            is_shared, at = self.places.cells[s.cell.name, k]
            self.emit(one, (b"\x24" if is_shared else b"\x21") + leb(at))

    def call(self, s: language.CallRoutine) -> None:
        """Adds a call of a routine."""
        given = []
        for a in s.arguments:
            if isinstance(a, language.Address):
                address, offset = self.at(a)
                given.append(joined(address, int32(offset) + b"\x6a"))
            else:
                given.append(self.operand(a))
        self.flush()
        self.emit(*given, b"\x10" + leb(self.places.routines[s.callee.name]))

    def choice(self, s: language.If) -> None:
        """Adds an if statement."""
        condition = self.operand(s.condition)
        self.flush()
        self.emit(condition, b"\x04\x40")
        self.within(s.then)
        if s.other:
            self.emit(b"\x05")
            self.within(s.other)
        self.emit(b"\x0b")
        self.leave(s)

    def loop(self, s: language.While) -> None:
        """Adds a while loop."""
        self.flush()
        self.emit(b"\x02\x40\x03\x40")
        self.sequence(s.head, s.body, condition=s.condition)
        self.emit(b"\x0c\x00\x0b\x0b")
        self.leave(s)

    def count(self, s: language.For) -> None:
        """Adds a for loop."""
        found = in_pairs(s)
        if found is not None:
            self.pairs(s, found)
            return
        start = self.operand(s.start)
        self.settle(s.stop)
        self.flush()
        counter = self.function.local(I64)
        self.locals[s.counter.number, 0] = counter
        self.emit(start, b"\x22" + leb(counter))
        stop = self.operand(s.stop)
        self.emit(stop.code, b"\x53\x04\x40\x03\x40")
        self.within(s.body)
        self.emit(read(counter), integer(1), b"\x7c\x22", leb(counter), stop.code, b"\x53\x0d\x00\x0b\x0b")
        for key in stop.gets:
            self.count_down(key)
        del self.locals[s.counter.number, 0]
        self.function.give_back(counter)
        self.leave(s)

    def pairs(self, s: language.For, pairs: Pairs) -> None:
        """Adds a for loop with two iterations at a time."""
        outer = [v for v in self.sizes.outer[id(s.body)] if v != s.counter]
        for v in outer:
            self.settle(v)
        self.flush()
        at = self.function.local(I32)
        own = {v: self.twice(v) if v.type == FLOAT else self.locals[v.number, 0] for v in outer}
        PairPrinter(self.module, self.function, self.places, pairs, at).loop(s.body, own)
        for local in (at, *(local for v, local in own.items() if v.type == FLOAT)):
            self.function.give_back(local)
        self.leave(s)

    def twice(self, value: Value) -> int:
        """A local that holds a value in both lanes."""
        local = self.function.local(V128)
        self.emit(read(self.locals[value.number, 0]), SPLAT, local_set(local))
        return local

    def within(self, block: Block) -> None:
        """Adds a block, or the call of its function."""
        if id(block) in self.sizes.apart:
            self.apart(block)
        else:
            self.sequence(block)

    def apart(self, block: Block) -> None:
        """Adds a block as a function of the values that it reads from outside, and its call."""
        given: list[tuple[Key, int]] = [
            ((v.number, k), KINDS[v.type.kind]) for v in self.sizes.outer[id(block)] for k in range(v.type.width)
        ]
        function = WasmFunction([kind for _, kind in given])
        printer = KernelPrinter(self.module, function, self.places, self.sizes)
        printer.locals = {key: k for k, (key, _) in enumerate(given)}
        printer.sequence(block)
        index = self.module.add(function)
        self.emit(*(read(self.locals[key]) for key, _ in given), b"\x10" + leb(index))
