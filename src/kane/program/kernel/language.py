# SPDX-License-Identifier: BSD-3-Clause
"""The records of the kernel language.

A kernel is a function of integers, of arrays of doubles that do not overlap, and of routines that it calls; it returns an integer.
Its body is a block of statements. A value is defined once, and is known after its definition in its block and in the blocks within;
what changes on the way is kept in cells and arrays. There are no jumps: choices and loops hold blocks.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

Kind = Literal["float", "int", "bool"]
WIDTHS = (1, 4, 8)
"""How many numbers a value may hold side by side."""


@dataclass(frozen=True, slots=True)
class Type:
    """Doubles, 64-bit integers or truth values; `width` of them side by side, of integers one."""

    kind: Kind
    width: int = 1

    def __str__(self) -> str:
        return self.kind if self.width == 1 else f"{self.kind}×{self.width}"


FLOAT, INT, BOOL = Type("float"), Type("int"), Type("bool")


@dataclass(frozen=True, slots=True)
class Constant:
    """A number, or one for each lane."""

    type: Type
    value: float | int | tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Value:
    """What the statement that holds it defines; `number` is its own in its kernel."""

    number: int
    type: Type


Operand: TypeAlias = Constant | Value


@dataclass(frozen=True, slots=True)
class Cell:
    """A variable of the kernel."""

    name: str
    type: Type


@dataclass(frozen=True, slots=True)
class ArrayOf:
    """An argument: the address of doubles."""

    name: str


@dataclass(frozen=True, slots=True)
class Number:
    """An argument: an integer; `value` is what it is called in the body."""

    name: str
    value: Value


@dataclass(frozen=True, slots=True)
class Callee:
    """An argument: the address of a routine, by what it takes: "float" a double, "array" the address of doubles."""

    name: str
    takes: tuple[Literal["float", "array"], ...]


Argument: TypeAlias = ArrayOf | Number | Callee


@dataclass(frozen=True, slots=True)
class Place:
    """The doubles of an array from an index on."""

    array: ArrayOf
    index: Operand


@dataclass(frozen=True, slots=True)
class Compute:
    """`value` = `op` of `arguments`; `lane` says which, of operations that take one lane."""

    value: Value
    op: str
    arguments: tuple[Operand, ...]
    lane: int = 0


@dataclass(frozen=True, slots=True)
class Load:
    """`value` = the doubles at a place."""

    value: Value
    place: Place


@dataclass(frozen=True, slots=True)
class Store:
    """The doubles at a place become those of `value`."""

    place: Place
    value: Operand


@dataclass(frozen=True, slots=True)
class Get:
    """`value` = what a cell holds."""

    value: Value
    cell: Cell


@dataclass(frozen=True, slots=True)
class Put:
    """A cell holds `value` from now on."""

    cell: Cell
    value: Operand


@dataclass(frozen=True, slots=True)
class If:
    """One of two blocks, as `condition` says."""

    condition: Operand
    then: "Block"
    other: "Block"


@dataclass(frozen=True, slots=True)
class While:
    """`head`, then `body` and again from the beginning, as long as `condition`, which `head` defines, is true."""

    head: "Block"
    condition: Operand
    body: "Block"


@dataclass(frozen=True, slots=True)
class Count:
    """`body` for `index` = `start`, …, `stop` − 1; where these are `few`, no work is spent on making many of them fast."""

    index: Value
    start: Operand
    stop: Operand
    body: "Block"
    few: bool = False


@dataclass(frozen=True, slots=True)
class Call:
    """A routine is called with numbers and places."""

    callee: Callee
    arguments: tuple[Operand | Place, ...]


Statement: TypeAlias = Compute | Load | Store | Get | Put | If | While | Count | Call
Block: TypeAlias = tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Kernel:
    """A function of `arguments`; `cells` begin with zero, and `result` is the one whose integer is returned."""

    name: str
    arguments: tuple[Argument, ...]
    cells: tuple[Cell, ...]
    body: Block
    result: Cell
