# SPDX-License-Identifier: BSD-3-Clause
"""Instructions of WebAssembly on two doubles side by side, of which each is rounded as one double is: the same bits."""

import struct

from kane.program.emit.wasm_module import leb

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
"""Operations by their names."""
LOAD, LOAD_ONE, SECOND, STORE = b"\xfd\x00\x03", b"\xfd\x0a\x03", b"\xfd\x57\x03", b"\xfd\x0b\x03"
SPLAT, FIRST = b"\xfd\x14", b"\xfd\x5d\x03"
"""Two doubles from a place, one twice, two to a place, each aligned as doubles are; a double twice."""


def both(value: float) -> bytes:
    """A number twice; Cranelift reads it where it is used, as an operand of what uses it."""
    return b"\xfd\x0c" + 2 * struct.pack("<d", value)


def lane_of(lane: int) -> bytes:
    """One of two doubles."""
    return b"\xfd\x21" + leb(lane)


def with_lane(lane: int) -> bytes:
    """One of two doubles is another one."""
    return b"\xfd\x22" + leb(lane)
