# SPDX-License-Identifier: BSD-3-Clause
"""Long blocks cut into chunks, so that the time to compile grows with their length and no faster.

Values that a later chunk reads pass through slots of a work array; a slot is free again after its last reader.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from kane.program.program import Program

WHOLE = 1500
"""A block of at most this many instructions stays whole: one function is what LLVM schedules best."""
CHUNK = 600
"""Instructions in a chunk of a longer block; from about a thousand, LLVM's time grows faster than the length."""


@dataclass(frozen=True, slots=True, eq=False)
class Chunk:
    """Instructions in order; slots to read before and to write after, and places among the results, by value."""

    instructions: tuple[int, ...]
    loads: dict[int, int]
    stores: dict[int, int]
    writes: dict[int, list[int]]


@dataclass(frozen=True, slots=True, eq=False)
class Split:
    """The chunks of a block and the length of the work array."""

    chunks: tuple[Chunk, ...]
    slots: int


def split(
    program: Program, block: Sequence[int], whole: float = WHOLE, chunk: int = CHUNK, results: Sequence[int] = ()
) -> Split:
    """`block` as it is, or in chunks of nearly equal length, at most `chunk`.

    Results are written where they are computed, in the last chunk where they are not computed at all.
    """
    count = 1 if len(block) <= whole else -(-len(block) // chunk)
    size = max(1, -(-len(block) // count))
    pieces = [tuple(block[k : k + size]) for k in range(0, len(block), size)] or [()]
    home = {i: k for k, piece in enumerate(pieces) for i in piece}
    writes: list[dict[int, list[int]]] = [{} for _ in pieces]
    for place, i in enumerate(results):
        writes[home.get(i, len(pieces) - 1)].setdefault(i, []).append(place)
    if len(pieces) == 1:
        return Split((Chunk(pieces[0], {}, {}, writes[0]),), 0)

    readers: dict[int, list[int]] = {}
    for k, piece in enumerate(pieces):
        for i in piece:
            for a in program.arguments(i):
                if home.get(a, k) != k:
                    chunks = readers.setdefault(a, [])
                    if not chunks or chunks[-1] != k:
                        chunks.append(k)

    loads: list[dict[int, int]] = [{} for _ in pieces]
    stores: list[dict[int, int]] = [{} for _ in pieces]
    released: list[list[int]] = [[] for _ in pieces]
    free: list[int] = []
    slots = 0
    for k, piece in enumerate(pieces):
        for i in piece:
            if i not in readers:
                continue
            if free:
                slot = free.pop()
            else:
                slot, slots = slots, slots + 1
            stores[k][i] = slot
            for reader in readers[i]:
                loads[reader][i] = slot
            released[readers[i][-1]].append(slot)
        free.extend(released[k])  # not earlier: this chunk reads them and may write others in the meantime
    return Split(tuple(map(Chunk, pieces, loads, stores, writes)), slots)
