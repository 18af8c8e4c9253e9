# SPDX-License-Identifier: BSD-3-Clause
"""The binary format of WebAssembly: a module with imported and defined functions, one memory with initial data, and a custom section.

Source: WebAssembly Core Specification 2.0, W3C 2022, ch. 5. Floating-point operations round each result to nearest, ties to even, and
none is contracted (sec. 4.3.3), so that a module gives the same bits on every machine. Vector instructions on two doubles round each
lane as a scalar.
"""

import json
import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import groupby
from typing import Any

F64, I64, I32, V128 = 0x7C, 0x7E, 0x7F, 0x7B
"""Value types; V128 holds two doubles."""
PAGE = 65_536
"""The page size of memory in bytes."""


@cache
def leb(number: int) -> bytes:
    """An unsigned integer in LEB128."""
    out = bytearray()
    while number > 0x7F:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*out, number])


@cache
def signed(number: int) -> bytes:
    """A signed integer in LEB128."""
    out = bytearray()
    while not -64 <= number < 64:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*out, number & 0x7F])


def number(value: float) -> bytes:
    """The instruction that pushes a double; not cached by value, because 0 and −0 are equal."""
    return b"\x44" + struct.pack("<d", value)


@cache
def read(local: int) -> bytes:
    """The instruction that pushes a local."""
    return b"\x20" + leb(local)


@cache
def local_set(local: int) -> bytes:
    """The instruction that pops a local."""
    return b"\x21" + leb(local)


@cache
def integer(value: int) -> bytes:
    """The instruction that pushes an i64."""
    return b"\x42" + signed(value)


@cache
def int32(value: int) -> bytes:
    """The instruction that pushes an i32, the type of addresses."""
    return b"\x41" + signed(value)


def _vector(items: Iterable[bytes]) -> bytes:
    found = list(items)
    return leb(len(found)) + b"".join(found)


def _text(text: str) -> bytes:
    raw = text.encode()
    return leb(len(raw)) + raw


def _section(kind: int, raw: bytes) -> bytes:
    return bytes([kind]) + leb(len(raw)) + raw


@dataclass(slots=True)
class WasmFunction:
    """A function under construction: `code`, its `parameters`, and locals that are allocated and released."""

    parameters: Sequence[int]
    results: Sequence[int] = ()
    code: bytearray = field(default_factory=bytearray)
    types: list[int] = field(default_factory=list)
    free: dict[int, list[int]] = field(default_factory=lambda: {F64: [], I64: [], I32: [], V128: []})

    def local(self, kind: int) -> int:
        """An unused local of a type."""
        if self.free[kind]:
            return self.free[kind].pop()
        self.types.append(kind)
        return len(self.parameters) + len(self.types) - 1

    def give_back(self, local: int) -> None:
        """Releases a local."""
        if local >= len(self.parameters):
            self.free[self.types[local - len(self.parameters)]].append(local)

    def raw(self) -> bytes:
        """The encoded body of the function."""
        runs = [(kind, len(list(own))) for kind, own in groupby(self.types)]
        body = _vector(leb(count) + bytes([kind]) for kind, count in runs) + bytes(self.code) + b"\x0b"
        return leb(len(body)) + body


@dataclass(slots=True)
class Module:
    """A module under construction. `imported` functions from "Math", by name with their numbers of double arguments, come first."""

    imported: Mapping[str, int]
    functions: list[WasmFunction] = field(default_factory=list)
    exports: dict[str, int] = field(default_factory=dict)
    globals: list[int] = field(default_factory=list)
    data: list[tuple[int, bytes]] = field(default_factory=list)
    size: int = 0
    own: dict[str, int] = field(default_factory=dict)
    _types: dict[bytes, int] = field(default_factory=dict)

    def add(self, function: WasmFunction, name: str = "") -> int:
        """Adds a function, exported if it has a name; returns its index."""
        self.functions.append(function)
        index = len(self.imported) + len(self.functions) - 1
        if name:
            self.exports[name] = index
        return index

    def imports(self, name: str) -> int:
        """The index of an imported function."""
        return list(self.imported).index(name)

    def variable(self, kind: int) -> int:
        """Adds a global, initially zero; returns its index."""
        self.globals.append(kind)
        return len(self.globals) - 1

    def room(self, doubles: int, aligned: int = 8) -> int:
        """Reserves memory for doubles; returns its address."""
        at = -(-self.size // aligned) * aligned
        self.size = at + 8 * doubles
        return at

    def numbers(self, at: int, values: Sequence[float]) -> None:
        """Adds initial data at an address."""
        self.data.append((at, struct.pack(f"<{len(values)}d", *values)))

    def raw(self, tells: Mapping[str, Any]) -> bytes:
        """The encoded module; `tells` is written to the custom section "kane" in JSON."""
        types = [self._type(f.parameters, f.results) for f in self.functions]
        imported = [(name, self._type([F64] * count, [F64])) for name, count in self.imported.items()]
        pages = leb(-(-self.size // PAGE) + 1)
        named = [_text(name) + b"\x00" + leb(k) for name, k in self.exports.items()]
        parts = [
            b"\0asm\x01\0\0\0",
            _section(0, _text("kane") + json.dumps(tells, separators=(",", ":")).encode()),
            _section(1, _vector(self._types)),
            _section(2, _vector(_text("Math") + _text(name) + b"\x00" + leb(t) for name, t in imported)),
            _section(3, _vector(map(leb, types))),
            _section(5, _vector([b"\x00" + pages])),
            _section(6, _vector(bytes([kind, 1]) + ZEROS[kind] + b"\x0b" for kind in self.globals)),
            _section(7, _vector([*named, _text("memory") + b"\x02\x00"])),
            _section(10, _vector(f.raw() for f in self.functions)),
            _section(11, _vector(b"\x00" + int32(at) + b"\x0b" + leb(len(raw)) + raw for at, raw in self.data)),
        ]
        return b"".join(parts)

    def _type(self, parameters: Sequence[int], results: Sequence[int]) -> int:
        key = b"\x60" + leb(len(parameters)) + bytes(parameters) + leb(len(results)) + bytes(results)
        return self._types.setdefault(key, len(self._types))


ZEROS = {F64: number(0.0), I64: integer(0), I32: int32(0)}
"""The instructions that push zero, by type."""

WIDE = {
    name: b"\xfd" + leb(number)
    for name, number in {
        "add": 0xF0,
        "sub": 0xF1,
        "mul": 0xF2,
        "div": 0xF3,
        "neg": 0xED,
        "sqrt": 0xEF,
        "abs": 0xEC,
    }.items()
}
"""Vector instructions by the names of operations."""
LOAD, LOAD_ONE, SECOND, STORE = b"\xfd\x00\x03", b"\xfd\x0a\x03", b"\xfd\x57\x03", b"\xfd\x0b\x03"
SPLAT, FIRST = b"\xfd\x14", b"\xfd\x5d\x03"
"""Instructions on two doubles with the alignment of one: load, load one to both lanes, store; a scalar to both lanes."""


def both(value: float) -> bytes:
    """A constant in both lanes; Cranelift uses it as a memory operand of the instruction that reads it."""
    return b"\xfd\x0c" + 2 * struct.pack("<d", value)


def lane_of(lane: int) -> bytes:
    """The instruction that extracts a lane."""
    return b"\xfd\x21" + leb(lane)


def with_lane(lane: int) -> bytes:
    """The instruction that replaces a lane."""
    return b"\xfd\x22" + leb(lane)
