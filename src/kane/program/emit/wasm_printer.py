# SPDX-License-Identifier: BSD-3-Clause
"""Statements as instructions of WebAssembly, a stack machine.

A value that is read once in its block is computed where it is read, on the stack; others are in locals, which are released after the
last read. A pending value that reads memory or a cell is computed before that memory or cell changes. Vector values are computed lane
by lane, with the same operations.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

from kane.errors import ProgramError
from kane.expr import ops
from kane.expr.ops import COS, OPS, SIN, Op
from kane.program.emit import wasm_module as wasm
from kane.program.emit.walk import LIBRARY, shared, values_read
from kane.program.kernel import language
from kane.program.kernel.language import Immediate, Value

KINDS = {"float": wasm.F64, "int": wasm.I64, "bool": wasm.I32}
"""Value types by the kinds of values."""
_PLAIN: Mapping[str, Mapping[Op | str, bytes]] = {
    "float": {
        **{k: bytes([int(v, 16)]) for k, v in shared({"add": "a0", "sub": "a1", "mul": "a2", "div": "a3"}).items()},
        **{k: bytes([int(v, 16)]) for k, v in shared({"neg": "9a", "sqrt": "9f", "abs": "99"}).items()},
        OPS["floor"]: b"\x9c",
        "less": b"\x63",
        "at_most": b"\x65",
        OPS["less"]: b"\x63\xb8",
        "int": b"\xfc\x06",
    },
    "int": {"add": b"\x7c", "sub": b"\x7d", "mul": b"\x7e", "less": b"\x53", "at_most": b"\x57", "float": b"\xb9"},
    "bool": {"and": b"\x71", "or": b"\x72", "not": b"\x45"},
}
"""Instructions after the operands, by the kind of the first operand."""
_ORDERED = shared({"min": "63", "max": "64"})
_GREATER, _OR, _SELECT, _NOT_EQUAL, _ADD, _ABS, _MUL = b"\x64", b"\x72", b"\x1b", b"\x62", b"\xa0", b"\x99", b"\xa2"
_NONE: frozenset[str] = frozenset()
Key: TypeAlias = int | tuple[int, int]
"""A value: its number in a Program; its number and a lane in a kernel."""


class Folded(NamedTuple):
    """Instructions that give a value, the counted values whose locals they read, and the arrays and cells that they read.

    If an integer is at a constant `distance` from another one, the first `base` bytes of the code give the latter.
    """

    code: bytes
    gets: tuple[Key, ...] = ()
    reads: frozenset[str] = frozenset()
    base: int = 0
    distance: int = 0


@dataclass(slots=True)
class Places:
    """Where the operands of a function are: `fixed` addresses and `pointers` (locals) of arrays, indices of `routines` and `cells`.

    A cell is a local, or a global of the module if several functions use it.
    """

    fixed: Mapping[str, int] = field(default_factory=dict)
    pointers: Mapping[str, int] = field(default_factory=dict)
    routines: Mapping[str, int] = field(default_factory=dict)
    cells: Mapping[tuple[str, int], tuple[bool, int]] = field(default_factory=dict)
    scalars: Mapping[int, bytes] = field(default_factory=dict)
    stable: bool = False


class WasmPrinter:
    """Prints one function; `sincos` is the index of the function that computes sine and cosine."""

    def __init__(self, module: wasm.Module, function: wasm.WasmFunction, places: Places, sincos: int = -1) -> None:
        self.module, self.function, self.places, self.sines = module, function, places, sincos
        self.locals: dict[Key, int] = {}
        self.left: dict[Key, int] = {}
        self.nested: set[Key] = set()
        self.waiting: dict[Key, tuple[Folded, int]] = {}
        self.scratches, self.kinds = 0, KINDS
        self._print: dict[type[Any], Any] = {
            language.Compute: self.compute,
            language.SinCos: self.sincos,
            language.Read: self.load,
            language.Write: self.store,
        }

    def program(self, block: Iterable[language.Statement]) -> None:
        """Prints a piece of a Program, in which no array is read after it is written."""
        block, left = list(block), self.left
        for i in (i for s in block for i in values_read(s)):
            left[i] = left.get(i, 0) + 1
        for i in self.places.scalars:
            left.pop(i, None)
        for s in block:
            self._print[type(s)](s)

    # ----------------------------------------------------------------------------------------------------- operands

    def operand(self, operand: language.Operand, lane: int = 0) -> Folded:
        """The instructions that give an operand."""
        if isinstance(operand, Immediate):
            return Folded(_immediate(operand, lane))
        key: Key = operand if isinstance(operand, int) else (operand.number, lane)
        if key in self.waiting:
            return self.waiting.pop(key)[0]
        if key in self.locals:
            return Folded(wasm.read(self.locals[key]), (key,) if key in self.left else ())
        return Folded(self.places.scalars[key])  # type: ignore[index]

    def emit(self, *parts: Folded | bytes) -> None:
        """Adds instructions; locals that they read for the last time are released."""
        for part in parts:
            if isinstance(part, bytes):
                self.function.code += part
            else:
                self.function.code += part.code
                for key in part.gets:
                    self.count_down(key)

    def count_down(self, key: Key) -> None:
        """Counts one read of a value, and releases its local after the last one."""
        self.left[key] -= 1
        if not self.left[key]:
            self.function.give_back(self.locals.pop(key))

    def define(self, value: language.Operand, folded: Folded, lane: int = 0) -> None:
        """Defines a value: pending if it is read once, else stored in a local."""
        assert not isinstance(value, Immediate)
        key: Key = value if isinstance(value, int) else (value.number, lane)
        kind = wasm.F64 if isinstance(value, int) else self.kinds[value.type.kind]
        if self.left.get(key) == 1 and key not in self.nested:
            self.waiting[key] = folded, kind
        else:
            self.put_away(key, folded, kind)

    def put_away(self, key: Key, folded: Folded, kind: int) -> None:
        """Stores a value in a local, which is released immediately if nothing reads the value."""
        self.emit(folded)
        local = self.locals[key] = self.function.local(kind)
        self.function.code += wasm.local_set(local)
        if not self.left.get(key):
            self.function.give_back(self.locals.pop(key))

    def flush(self, *names: str) -> None:
        """Computes the pending values that read the named arrays or cells, or any memory."""
        for key, (folded, kind) in list(self.waiting.items()):
            if folded.reads and (not names or not folded.reads.isdisjoint(names)):
                del self.waiting[key]
                self.put_away(key, folded, kind)

    def again(self, folded: Folded) -> tuple[Folded, bytes]:
        """A value, and instructions that give it again; a value that is not a local or constant is stored in a temporary."""
        code = folded.code
        if _is_leaf(code):
            return folded, code
        local, key = self.scratch(wasm.F64)
        return Folded(code + b"\x22" + wasm.leb(local), (*folded.gets, key), folded.reads), wasm.read(local)

    def scratch(self, kind: int, uses: int = 1) -> tuple[int, Key]:
        """A temporary local within the computation of one value, released after `uses` reads."""
        self.scratches -= 1
        key: Key = (self.scratches, 0)
        local = self.locals[key] = self.function.local(kind)
        self.left[key] = uses
        return local, key

    # --------------------------------------------------------------------------------------------------- arithmetic

    def compute(self, s: language.Compute) -> None:
        """Adds an operation, lane by lane."""
        type_ = language.type_of(s.arguments[0])
        if s.op in ("sum", "largest", "any"):
            self.define(s.value, self.fold(str(s.op), s.arguments[0], type_.width))
        elif s.op == "lane":
            self.define(s.value, self.operand(s.arguments[0], s.lane))
        elif isinstance(s.op, str) and s.op.startswith("splat"):
            assert isinstance(s.value, Value)
            local, key = self.scratch(wasm.F64)
            self.emit(self.operand(s.arguments[0]), wasm.local_set(local))
            for k in range(s.value.type.width):
                self.put_away((s.value.number, k), Folded(wasm.read(local)), wasm.F64)
            self.count_down(key)
        else:
            for k in range(language.type_of(s.value).width):
                operands = [self.operand(a, k) for a in s.arguments]
                found = self.operation(s.op, type_.kind, operands)
                last = s.arguments[-1]
                if s.op == "add" and isinstance(last, Immediate) and isinstance(last.value, int):
                    found = found._replace(base=len(operands[0].code), distance=last.value)
                self.define(s.value, found, k)

    def operation(self, op: Op | str, kind: str, operands: Sequence[Folded]) -> Folded:
        """The instructions of an operation on one lane."""
        plain = _PLAIN[kind].get(op)
        if plain is not None:
            return joined(*operands, plain)
        if op in LIBRARY:
            return joined(*operands, b"\x10" + wasm.leb(self.module.imports(LIBRARY[op])))
        if op == "select":
            return joined(operands[1], operands[2], operands[0], _SELECT)
        if op is ops.WHERE:
            return joined(operands[1], operands[2], operands[0], wasm.number(0.0), _NOT_EQUAL, _SELECT)
        x, once_more = self.again(operands[0])
        if op in _ORDERED:
            y, other = self.again(operands[1])
            order = bytes([int(_ORDERED[op], 16)])
            return joined(x, y, once_more, other, order, once_more, once_more, _NOT_EQUAL, _OR, _SELECT)
        if op is OPS["sign"]:
            above = joined(wasm.number(-1.0), wasm.number(1.0), x, once_more, wasm.number(0.0), _GREATER, _SELECT)
            return joined(above, once_more, wasm.number(0.0), _LESS, _SELECT, wasm.number(0.0), _ADD)
        if op is ops.REGULAR:
            return joined(x, _NAN, once_more, _ABS, operands[1], wasm.number(ops.GONE), _MUL, _GREATER, _SELECT)
        raise ProgramError(f"Expected an operation that WebAssembly has, got {op!r}.")

    def fold(self, op: str, operand: language.Operand, width: int) -> Folded:
        """The instructions of a reduction by repeated halving."""
        own = {"sum": "add", "largest": "max", "any": "or"}[op]
        lanes = [self.operand(operand, k) for k in range(width)]
        while len(lanes) > 1:
            half = len(lanes) // 2
            pairs = zip(lanes[:half], lanes[half:], strict=True)
            lanes = [self.operation(own, "bool" if op == "any" else "float", pair) for pair in pairs]
        return lanes[0]

    def sincos(self, s: language.SinCos) -> None:
        """Adds sines and cosines of two angles, or of one angle in both lanes."""
        first, *others = map(self.operand, s.angles)
        call = b"\x10" + wasm.leb(self.sines)
        self.emit(first, wasm.SPLAT, *(part for one in others for part in (one, wasm.with_lane(1))), call)
        for op in (COS, SIN):
            local, key = self.scratch(wasm.V128, sum(op in own for own in s.values))
            self.function.code += wasm.local_set(local)
            for lane, own in enumerate(s.values):
                if op in own:
                    self.define(own[op], Folded(wasm.read(local) + wasm.lane_of(lane), (key,)))

    # ------------------------------------------------------------------------------------------------------- memory

    def at(self, s: language.Address | language.Read | language.Write, lane: int = 0) -> tuple[Folded, int]:
        """The instructions of an address, and a constant offset in bytes."""
        offset, pointer = s.offset, self.places.pointers.get(s.base)
        base = self.places.fixed[s.base] if pointer is None else 0
        if isinstance(offset, Immediate):
            assert isinstance(offset.value, int)
            offset = offset.value
        if isinstance(offset, int):
            return Folded(wasm.int32(0) if pointer is None else wasm.read(pointer)), base + 8 * (offset + lane)
        found = self.operand(offset)
        if found.base and base + 8 * (found.distance + lane) >= 0:
            base += 8 * found.distance
            found = Folded(found.code[: found.base], found.gets, found.reads)
        index = joined(found, _IN_BYTES)
        return (index if pointer is None else joined(index, wasm.read(pointer), b"\x6a")), base + 8 * lane

    def load(self, s: language.Read) -> None:
        """Adds a load from an array."""
        reads = frozenset() if self.places.stable else frozenset([s.base])
        width = language.type_of(s.value).width
        if width == 1:
            address, offset = self.at(s)
            code = address.code + b"\x2b\x03" + wasm.leb(offset)
            self.define(s.value, Folded(code, address.gets, address.reads | reads))
            return
        assert isinstance(s.value, Value)
        self.settle(s.offset)
        for k in range(width):
            address, offset = self.at(s, k)
            code = address.code + b"\x2b\x03" + wasm.leb(offset)
            self.put_away((s.value.number, k), Folded(code, address.gets if k == width - 1 else ()), wasm.F64)

    def store(self, s: language.Write) -> None:
        """Adds a store to an array."""
        width = language.type_of(s.value).width
        if width > 1:
            self.settle(s.offset)
        for k in range(width):
            address, offset = self.at(s, k)
            value = self.operand(s.value, k)
            if not self.places.stable:
                self.flush(s.base)
            code = Folded(address.code, address.gets if k == width - 1 else (), address.reads)
            self.emit(code, value, b"\x39\x03" + wasm.leb(offset))

    def settle(self, operand: language.Operand) -> None:
        """Stores a pending value in a local, because each lane will read it."""
        if isinstance(operand, Value) and (operand.number, 0) in self.waiting:
            folded, kind = self.waiting.pop((operand.number, 0))
            self.put_away((operand.number, 0), folded, kind)


_IN_BYTES = b"\xa7" + wasm.int32(3) + b"\x74"
_LESS = b"\x63"
_NAN = wasm.number(math.nan)


def joined(*parts: Folded | bytes) -> Folded:
    """Instructions in sequence."""
    code, reads = b"", _NONE
    gets: tuple[Key, ...] = ()
    for part in parts:
        if isinstance(part, bytes):
            code += part
        else:
            code += part.code
            gets += part.gets
            if part.reads:
                reads |= part.reads
    return Folded(code, gets, reads)


def _is_leaf(code: bytes) -> bool:
    """Whether the code is one instruction that reads a local or pushes a constant."""
    if code[0] == 0x20:
        return code[-1] < 0x80 and min(code[1:-1], default=0x80) >= 0x80
    return code[0] == 0x44 and len(code) == 9


def _immediate(operand: Immediate, lane: int) -> bytes:
    value = operand.value[lane] if isinstance(operand.value, tuple) else operand.value
    if operand.type.kind == "float":
        return wasm.number(float(value))
    return wasm.integer(int(value)) if operand.type.kind == "int" else wasm.int32(int(value))
