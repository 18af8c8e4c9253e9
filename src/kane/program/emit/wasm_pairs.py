# SPDX-License-Identifier: BSD-3-Clause
"""Vectorized loops of kernels: two iterations at a time by instructions on two doubles (`v128`, `f64x2`).

These are loops over rows of arrays that write no element which they also read: the iterations commute and may be repeated. If their
number is odd, the first pair is iterations 1 and 2, the next 2 and 3. Each operation rounds as on scalars, so that the results are the
same bits.
"""

from collections.abc import Mapping
from typing import NamedTuple, cast

from kane.expr.ops import OPS, Op
from kane.program.emit.wasm_module import (
    FIRST,
    LOAD,
    LOAD_ONE,
    SECOND,
    STORE,
    V128,
    WIDE,
    Module,
    WasmFunction,
    both,
    int32,
    leb,
    local_set,
    read,
)
from kane.program.emit.wasm_printer import KINDS, Folded, Key, Places, WasmPrinter, joined
from kane.program.kernel import language
from kane.program.kernel.language import (
    FLOAT,
    INT,
    Block,
    Compute,
    For,
    Immediate,
    Operand,
    Read,
    Value,
    Write,
    type_of,
)

_OPERATIONS: Mapping[Op | str, bytes] = {key: WIDE[name] for name in WIDE for key in (name, OPS[name])}


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


def in_pairs(s: For) -> Pairs | None:
    """The indices and length of a loop that can be vectorized, else None."""
    length = s.stop.value if isinstance(s.stop, Immediate) else 0
    if s.few or s.start != Immediate(INT, 0) or not isinstance(length, int) or length < _LEAST:
        return None
    found = {s.counter: RowIndex(None, 0, True)}
    rows: dict[type, list[tuple[str, RowIndex]]] = {Read: [], Write: []}
    for one in s.body:
        if isinstance(one, Read | Write) and type_of(one.value) == FLOAT:
            rows[type(one)].append((one.base, _index(one.offset, found)))
        elif isinstance(one, Compute) and one.op == "add" and isinstance(one.value, Value) and one.value.type == INT:
            a, b = (_index(x, found) for x in one.arguments)
            if (a.goes and b.goes) or (a.start and b.start):
                return None
            found[one.value] = RowIndex(a.start or b.start, a.distance + b.distance, a.goes or b.goes)
        elif not (isinstance(one, Compute) and one.op in _OPERATIONS and type_of(one.value) == FLOAT):
            return None
    written, read_ = rows[Write], rows[Read]
    beside = [(w, o) for w in written for o in read_ + [x for x in written if x != w] if w[0] == o[0]]
    if all(w.goes for _, w in written) and all(_apart(w, o, length) for (_, w), (_, o) in beside):
        return Pairs(found, length)
    return None


def _index(offset: Operand, known: Mapping[Value, RowIndex]) -> RowIndex:
    if isinstance(offset, Value):
        return known.get(offset, RowIndex(offset, 0, False))
    return RowIndex(None, cast(int, offset.value) if isinstance(offset, Immediate) else offset, False)


def _apart(written: RowIndex, other: RowIndex, length: int) -> bool:
    """Whether the elements that are written at one index and those accessed at the other are disjoint."""
    between = other.distance - written.distance
    return written.start == other.start and (between >= length or between <= -(length if other.goes else 1))


def _operands(s: language.Statement) -> list[Value]:
    found = s.arguments if isinstance(s, Compute) else (s.value,) if isinstance(s, Write) else ()
    return [a for a in found if isinstance(a, Value)]


class PairPrinter(WasmPrinter):
    """Prints two iterations at a time; `at` is the local that holds the counter as an offset in bytes."""

    def __init__(self, module: Module, function: WasmFunction, places: Places, pairs: Pairs, at: int) -> None:
        super().__init__(module, function, places)
        self.pairs, self.counter = pairs, at
        self.kinds = {**KINDS, "float": V128}
        self.last: list[Read] = []

    def loop(self, block: Block, outer: Mapping[Value, int]) -> None:
        """Adds the loop over pairs; `outer` maps values from outside to locals that hold them."""
        self.emit(int32(0), local_set(self.counter), b"\x03\x40")
        self.turns(block, {(v.number, 0): local for v, local in outer.items()})
        step = int32(8) + b"\x6a" + int32(8) + b"\x72" if self.pairs.length % 2 else int32(16) + b"\x6a"
        ahead = b"\x22" + leb(self.counter) + int32(8 * (self.pairs.length - 1)) + b"\x49"
        self.emit(read(self.counter), step, ahead, b"\x0d\x00\x0b")

    def turns(self, block: Block, outer: dict[Key, int]) -> None:
        """Adds one pair of iterations; the last read uses two scalar loads, because its elements have just been stored as scalars."""
        self.locals |= outer
        for v in (v for s in block for v in _operands(s)):
            self.left[v.number, 0] = self.left.get((v.number, 0), 0) + 1
        for key in outer:
            self.left.pop(key, None)
        self.last = [s for s in block if isinstance(s, Read)][-1:]
        for s in block:
            self._print[type(s)](s)

    def compute(self, s: Compute) -> None:
        """Adds an operation on two doubles; integer operations are indices, which `in_pairs` has resolved."""
        if type_of(s.value) != INT:
            self.define(s.value, joined(*map(self.operand, s.arguments), _OPERATIONS[s.op]))

    def operand(self, operand: Operand, lane: int = 0) -> Folded:
        """The instructions that give an operand."""
        if isinstance(operand, Immediate):
            return Folded(both(float(cast(float, operand.value))))
        return super().operand(operand, lane)

    def location_of(self, s: Read | Write) -> tuple[RowIndex, bytes, int]:
        """The index of an access, the instructions of its base address, and its constant offset in bytes."""
        index = _index(s.offset, self.pairs.indices)
        steps = [read(self.counter)] * index.goes
        if index.start is not None:
            steps.append(read(self.locals[index.start.number, 0]) + b"\xa7" + int32(3) + b"\x74")
        code = b"".join(steps) + b"\x6a" * (len(steps) - 1) if steps else int32(0)
        offset = self.places.fixed[s.base] + 8 * index.distance
        return (index, code, offset) if offset >= 0 else (index, code + int32(offset) + b"\x6a", 0)

    def load(self, s: Read) -> None:
        """Adds a load of two consecutive doubles, or of one double to both lanes."""
        index, address, offset = self.location_of(s)
        code = address + (LOAD if index.goes else LOAD_ONE) + leb(offset)
        if index.goes and s in self.last:
            code = address + address + FIRST + leb(offset) + SECOND + leb(offset + 8) + b"\x01"
        self.define(s.value, Folded(code))

    def store(self, s: Write) -> None:
        """Adds a store of two consecutive doubles."""
        _, address, offset = self.location_of(s)
        self.emit(address, self.operand(s.value), STORE + leb(offset))
