# SPDX-License-Identifier: BSD-3-Clause
"""Kernels as WebAssembly functions: one per kernel, and one for each long block within it.

Arrays have fixed addresses in memory. A cell is a local if one function uses it, else a global of the module.

Vectorized loops run two iterations at a time by instructions on two doubles (`v128`, `f64x2`). These are loops over rows of arrays
that write no element which they also read: the iterations commute and may be repeated. If their number is odd, the first pair is
iterations 1 and 2, the next 2 and 3. Each operation rounds as on scalars, so that the results are the same bits.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, cast

from kane.expr.ops import OPS, Op
from kane.program.emit import wasm_module as wasm
from kane.program.emit.walk import values_read
from kane.program.emit.wasm_module import read
from kane.program.emit.wasm_printer import KINDS, Folded, Key, Places, WasmPrinter, joined
from kane.program.kernel import language
from kane.program.kernel.language import FLOAT, INT, Block, Integer, Kernel, Operand, Statement, Value

LONGEST = 250
"""The number of statements beyond which a block becomes a function."""


def add_kernel(module: wasm.Module, kernel: Kernel, arrays: Mapping[str, int], routines: Mapping[str, int]) -> int:
    """Adds the function of a kernel, which takes its integers as i64 and returns an i32; returns its index.

    `arrays` maps arrays to addresses, `routines` maps routines to function indices.
    """
    sizes = _Sizes(kernel)
    integers = [a.value for a in kernel.arguments if isinstance(a, Integer)]
    function = wasm.WasmFunction([wasm.I64] * len(integers), [wasm.I32])
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
            printer.emit(wasm.ZEROS[module.globals[at]], b"\x24" + wasm.leb(at))
    printer.sequence(kernel.body)
    printer.emit(Folded(_get(cells[kernel.result.name, 0])), b"\xa7")
    return module.add(function)


def _get(at: tuple[bool, int]) -> bytes:
    return (b"\x23" if at[0] else b"\x20") + wasm.leb(at[1])


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
            for inner in language.blocks(s):
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
        inner = [v for b in language.blocks(s) for v in self.outer[id(b)]]
        return own + [v for v in inner if not (isinstance(s, language.For) and v == s.counter)]

    def _own(self, block: Block, owner: int) -> None:
        for s in block:
            if isinstance(s, language.Get | language.Put):
                self._owners.setdefault(s.cell.name, set()).add(owner)
            for inner in language.blocks(s):
                self._own(inner, id(inner) if id(inner) in self.apart else owner)


def _operands(s: Statement) -> list[Value]:
    """The values that a statement reads, without its blocks."""
    return [a for a in language.operands_of(s) if isinstance(a, Value)]


def _defined(s: Statement) -> list[Value]:
    value = s.value if isinstance(s, language.Compute | language.Read | language.Get) else None
    return [value] if isinstance(value, Value) else []


_OPERATIONS: Mapping[Op | str, bytes] = {key: wasm.WIDE[name] for name in wasm.WIDE for key in (name, OPS[name])}


class RowIndex(NamedTuple):
    """An index: `start`, if not None, plus `distance`, plus the loop counter if `goes`."""

    start: Value | None
    distance: int
    goes: bool


class Pairs(NamedTuple):
    """The indices of a loop, by the integer values in it, and its number of iterations."""

    indices: dict[Value, RowIndex]
    length: int


_LEAST = 6
"""The minimum number of iterations for vectorization."""


def in_pairs(s: language.For) -> Pairs | None:
    """The indices and length of a loop that can be vectorized, else None."""
    length = s.stop.value if isinstance(s.stop, language.Immediate) else 0
    if s.few or s.start != language.Immediate(INT, 0) or not isinstance(length, int) or length < _LEAST:
        return None
    found = {s.counter: RowIndex(None, 0, True)}
    rows: dict[type, list[tuple[str, RowIndex]]] = {language.Read: [], language.Write: []}
    for one in s.body:
        if isinstance(one, language.Read | language.Write) and language.type_of(one.value) == FLOAT:
            rows[type(one)].append((one.base, _index(one.offset, found)))
        elif (
            isinstance(one, language.Compute)
            and one.op == "add"
            and isinstance(one.value, Value)
            and one.value.type == INT
        ):
            a, b = (_index(x, found) for x in one.arguments)
            if (a.goes and b.goes) or (a.start and b.start):
                return None
            found[one.value] = RowIndex(a.start or b.start, a.distance + b.distance, a.goes or b.goes)
        elif not (isinstance(one, language.Compute) and one.op in _OPERATIONS and language.type_of(one.value) == FLOAT):
            return None
    written, read_ = rows[language.Write], rows[language.Read]
    beside = [(w, o) for w in written for o in read_ + [x for x in written if x != w] if w[0] == o[0]]
    if all(w.goes for _, w in written) and all(_apart(w, o, length) for (_, w), (_, o) in beside):
        return Pairs(found, length)
    return None


def _index(offset: Operand, known: Mapping[Value, RowIndex]) -> RowIndex:
    if isinstance(offset, Value):
        return known.get(offset, RowIndex(offset, 0, False))
    return RowIndex(None, cast(int, offset.value) if isinstance(offset, language.Immediate) else offset, False)


def _apart(written: RowIndex, other: RowIndex, length: int) -> bool:
    """Whether the elements that are written at one index and those accessed at the other are disjoint."""
    between = other.distance - written.distance
    return written.start == other.start and (between >= length or between <= -(length if other.goes else 1))


class PairPrinter(WasmPrinter):
    """Prints two iterations at a time; `at` is the local that holds the counter as an offset in bytes."""

    def __init__(self, module: wasm.Module, function: wasm.WasmFunction, places: Places, pairs: Pairs, at: int) -> None:
        super().__init__(module, function, places)
        self.pairs, self.counter = pairs, at
        self.kinds = {**KINDS, "float": wasm.V128}
        self.last: list[language.Read] = []

    def loop(self, block: Block, outer: Mapping[Value, int]) -> None:
        """Adds the loop over pairs; `outer` maps values from outside to locals that hold them."""
        self.emit(wasm.int32(0), wasm.local_set(self.counter), b"\x03\x40")
        self.turns(block, {(v.number, 0): local for v, local in outer.items()})
        step = wasm.int32(8) + b"\x6a" + wasm.int32(8) + b"\x72" if self.pairs.length % 2 else wasm.int32(16) + b"\x6a"
        ahead = b"\x22" + wasm.leb(self.counter) + wasm.int32(8 * (self.pairs.length - 1)) + b"\x49"
        self.emit(read(self.counter), step, ahead, b"\x0d\x00\x0b")

    def turns(self, block: Block, outer: dict[Key, int]) -> None:
        """Adds one pair of iterations; the last read uses two scalar loads, because its elements have just been stored as scalars."""
        self.locals |= outer
        for v in (v for s in block for v in values_read(s) if isinstance(v, Value)):
            self.left[v.number, 0] = self.left.get((v.number, 0), 0) + 1
        for key in outer:
            self.left.pop(key, None)
        self.last = [s for s in block if isinstance(s, language.Read)][-1:]
        for s in block:
            self._print[type(s)](s)

    def compute(self, s: language.Compute) -> None:
        """Adds an operation on two doubles; integer operations are indices, which `in_pairs` has resolved."""
        if language.type_of(s.value) != INT:
            self.define(s.value, joined(*map(self.operand, s.arguments), _OPERATIONS[s.op]))

    def operand(self, operand: Operand, lane: int = 0) -> Folded:
        """The instructions that give an operand."""
        if isinstance(operand, language.Immediate):
            return Folded(wasm.both(float(cast(float, operand.value))))
        return super().operand(operand, lane)

    def location_of(self, s: language.Read | language.Write) -> tuple[RowIndex, bytes, int]:
        """The index of an access, the instructions of its base address, and its constant offset in bytes."""
        index = _index(s.offset, self.pairs.indices)
        steps = [read(self.counter)] * index.goes
        if index.start is not None:
            steps.append(read(self.locals[index.start.number, 0]) + b"\xa7" + wasm.int32(3) + b"\x74")
        code = b"".join(steps) + b"\x6a" * (len(steps) - 1) if steps else wasm.int32(0)
        offset = self.places.fixed[s.base] + 8 * index.distance
        return (index, code, offset) if offset >= 0 else (index, code + wasm.int32(offset) + b"\x6a", 0)

    def load(self, s: language.Read) -> None:
        """Adds a load of two consecutive doubles, or of one double to both lanes."""
        index, address, offset = self.location_of(s)
        code = address + (wasm.LOAD if index.goes else wasm.LOAD_ONE) + wasm.leb(offset)
        if index.goes and s in self.last:
            code = address + address + wasm.FIRST + wasm.leb(offset) + wasm.SECOND + wasm.leb(offset + 8) + b"\x01"
        self.define(s.value, Folded(code))

    def store(self, s: language.Write) -> None:
        """Adds a store of two consecutive doubles."""
        _, address, offset = self.location_of(s)
        self.emit(address, self.operand(s.value), wasm.STORE + wasm.leb(offset))


class KernelPrinter(WasmPrinter):
    """Prints a kernel, or a block of it that is a function."""

    def __init__(self, module: wasm.Module, function: wasm.WasmFunction, places: Places, sizes: _Sizes) -> None:
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
        if language.blocks(s):
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
            self.emit(one, (b"\x24" if is_shared else b"\x21") + wasm.leb(at))

    def call(self, s: language.CallRoutine) -> None:
        """Adds a call of a routine."""
        given = []
        for a in s.arguments:
            if isinstance(a, language.Address):
                address, offset = self.at(a)
                given.append(joined(address, wasm.int32(offset) + b"\x6a"))
            else:
                given.append(self.operand(a))
        self.flush()
        self.emit(*given, b"\x10" + wasm.leb(self.places.routines[s.callee.name]))

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
        counter = self.function.local(wasm.I64)
        self.locals[s.counter.number, 0] = counter
        self.emit(start, b"\x22" + wasm.leb(counter))
        stop = self.operand(s.stop)
        self.emit(stop.code, b"\x53\x04\x40\x03\x40")
        self.within(s.body)
        self.emit(read(counter), wasm.integer(1), b"\x7c\x22", wasm.leb(counter), stop.code, b"\x53\x0d\x00\x0b\x0b")
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
        at = self.function.local(wasm.I32)
        own = {v: self.twice(v) if v.type == FLOAT else self.locals[v.number, 0] for v in outer}
        PairPrinter(self.module, self.function, self.places, pairs, at).loop(s.body, own)
        for local in (at, *(local for v, local in own.items() if v.type == FLOAT)):
            self.function.give_back(local)
        self.leave(s)

    def twice(self, value: Value) -> int:
        """A local that holds a value in both lanes."""
        local = self.function.local(wasm.V128)
        self.emit(read(self.locals[value.number, 0]), wasm.SPLAT, wasm.local_set(local))
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
        function = wasm.WasmFunction([kind for _, kind in given])
        printer = KernelPrinter(self.module, function, self.places, self.sizes)
        printer.locals = {key: k for k, (key, _) in enumerate(given)}
        printer.sequence(block)
        index = self.module.add(function)
        self.emit(*(read(self.locals[key]) for key, _ in given), b"\x10" + wasm.leb(index))
