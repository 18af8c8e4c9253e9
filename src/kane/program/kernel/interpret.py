# SPDX-License-Identifier: BSD-3-Clause
"""Kernels run statement by statement in Python: what every emitted text must give, bit by bit where nothing is contracted."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from kane.numeric.arrays import Array
from kane.program.kernel.language import (
    ArrayOf,
    Block,
    Call,
    Callee,
    Compute,
    Constant,
    Count,
    Get,
    If,
    Kernel,
    Load,
    Number,
    Operand,
    Place,
    Put,
    Statement,
    Store,
    While,
)
from kane.program.kernel.operations import OPERATIONS

Routine = Callable[..., None]
"""Takes a number for each double, and for each address the array from there on."""


def interpret(kernel: Kernel, given: Mapping[str, int | Array | Routine]) -> int:
    """What the kernel returns; `given` holds a value for each of its arguments, and its arrays are written to."""
    run = _Run(kernel, given)
    with np.errstate(all="ignore"):
        run.block(kernel.body)
    return int(run.cells[kernel.result.name])


class _Run:
    """One run: the arrays and routines, and what values and cells hold."""

    def __init__(self, kernel: Kernel, given: Mapping[str, Any]) -> None:
        self.arrays = {a: given[a.name].reshape(-1) for a in kernel.arguments if isinstance(a, ArrayOf)}
        self.routines = {a: given[a.name] for a in kernel.arguments if isinstance(a, Callee)}
        self.values: dict[int, Any] = {
            a.value.number: int(given[a.name]) for a in kernel.arguments if isinstance(a, Number)
        }
        self.cells: dict[str, Any] = {c.name: _zero(c.type.kind, c.type.width) for c in kernel.cells}

    def block(self, block: Block) -> None:
        """The statements in order."""
        for statement in block:
            self.statement(statement)

    def statement(self, s: Statement) -> None:
        """One statement."""
        if isinstance(s, Compute):
            found = [self.of(a) for a in s.arguments]
            self.values[s.value.number] = found[0][s.lane] if s.op == "lane" else OPERATIONS[s.op][1].numpy(*found)
        elif isinstance(s, Load):
            array, at = self.place(s.place)
            width = s.value.type.width
            self.values[s.value.number] = array[at : at + width].copy() if width > 1 else array[at]
        elif isinstance(s, Store):
            array, at = self.place(s.place)
            array[at : at + s.value.type.width] = self.of(s.value)
        elif isinstance(s, Get):
            self.values[s.value.number] = self.cells[s.cell.name]
        elif isinstance(s, Put):
            self.cells[s.cell.name] = self.of(s.value)
        elif isinstance(s, Call):
            self.routines[s.callee](*(self.passed(a) for a in s.arguments))
        else:
            self.structure(s)

    def structure(self, s: If | While | Count) -> None:
        """Choices and loops."""
        if isinstance(s, If):
            self.block(s.then if self.of(s.condition) else s.other)
        elif isinstance(s, Count):
            for k in range(self.of(s.start), self.of(s.stop)):
                self.values[s.index.number] = k
                self.block(s.body)
        else:
            self.block(s.head)
            while self.of(s.condition):
                self.block(s.body)
                self.block(s.head)

    def of(self, operand: Operand) -> Any:
        """The value of an operand."""
        if not isinstance(operand, Constant):
            return self.values[operand.number]
        kind, value = operand.type.kind, operand.value
        return value if kind == "int" else np.array(value) if isinstance(value, tuple) else np.float64(value)

    def place(self, place: Place) -> tuple[Any, int]:
        """An array and the index into it."""
        return self.arrays[place.array], self.of(place.index)

    def passed(self, argument: Operand | Place) -> Any:
        """What a routine is given."""
        if isinstance(argument, Place):
            array, at = self.place(argument)
            return array[at:]
        return self.of(argument)


def _zero(kind: str, width: int) -> Any:
    one: Any = {"float": np.float64(0.0), "int": 0, "bool": False}[kind]
    return one if width == 1 else np.full(width, one)
