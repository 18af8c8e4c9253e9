# SPDX-License-Identifier: BSD-3-Clause
"""Kernels for several instances side by side, one a lane: which values may differ from lane to lane.

What is read from an array differs, unless all instances share the array, and so does what is computed of that, what a cell holds that
is written by some lanes alone, and which statements run where a condition differs. The rest is computed once for all lanes:
sizes, counters of loops of such sizes, places in arrays.
"""

from collections.abc import Collection
from dataclasses import dataclass, field
from itertools import chain

from kane.program.kernel.language import (
    Block,
    Cell,
    Compute,
    Count,
    Get,
    If,
    Kernel,
    Operand,
    Put,
    Read,
    Value,
    While,
)


@dataclass(slots=True)
class Varying:
    """The numbers of values, and the cells, that may differ between lanes; those of `shared` arrays are the same in all."""

    shared: frozenset[str]
    values: set[int] = field(default_factory=set)
    cells: set[Cell] = field(default_factory=set)

    def __contains__(self, operand: Operand) -> bool:
        return isinstance(operand, Value) and operand.number in self.values


def varying(kernel: Kernel, shared: Collection[str]) -> Varying:
    """What differs between the lanes of a kernel."""
    found, before = Varying(frozenset(shared)), -1
    while before < (before := len(found.values) + len(found.cells)):  # what is put into a cell is read before it, too
        _note(found, kernel.body, apart=False)
    return found


def _note(found: Varying, block: Block, apart: bool) -> None:
    """What differs in a block, which some lanes alone may run where they are `apart`."""
    for s in block:
        if isinstance(s, Compute):
            _mark(found, s.value, any(a in found for a in s.arguments))
        elif isinstance(s, Read):
            _mark(found, s.value, s.base not in found.shared or s.offset in found)
        elif isinstance(s, Get):
            _mark(found, s.value, s.cell in found.cells)
        elif isinstance(s, Put):
            if apart or s.value in found:
                found.cells.add(s.cell)
        elif isinstance(s, If):
            _note(found, tuple(chain(s.then, s.other)), apart or s.condition in found)
        elif isinstance(s, While):
            _note(found, tuple(chain(s.head, s.body)), apart or s.condition in found)
        elif isinstance(s, Count):
            _mark(found, s.counter, s.start in found)
            _note(found, s.body, apart or s.start in found or s.stop in found)


def _mark(found: Varying, value: Operand, differs: bool) -> None:
    if differs and isinstance(value, Value):
        found.values.add(value.number)
