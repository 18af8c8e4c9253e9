# SPDX-License-Identifier: BSD-3-Clause
"""The statements of Programs and kernels, which one printer a language prints.

A kernel is a function of integers, of arrays of doubles that do not overlap, and of routines that it calls; it returns an integer.
Its body is a block of statements. A value is defined once, and is known after its definition in its block and in the blocks within;
what changes on the way is kept in cells and arrays. There are no jumps: choices and loops hold blocks.

A function of a Program (`emit/walk.py`) is a block of arithmetic, loads and stores alone; its values are doubles, which are told by
their numbers in the Program.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

from kane.expr.ops import Op

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
class Immediate:
    """A number, or one for each lane."""

    type: Type
    value: float | int | tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Value:
    """A value of a kernel, with a number that no other has."""

    number: int
    type: Type

    def __str__(self) -> str:
        return str(self.number)


Operand: TypeAlias = Immediate | Value | int
"""Of kernels a value or constant, of Programs the number of a value."""


def type_of(operand: Operand) -> Type:
    """Numbers of values of a Program stand for doubles."""
    return FLOAT if isinstance(operand, int) else operand.type


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
class Integer:
    """An argument: an integer; `value` is what it is called in the body."""

    name: str
    value: Value


@dataclass(frozen=True, slots=True)
class Callee:
    """An argument: the address of a routine, by what it takes: "float" a double, "array" the address of doubles."""

    name: str
    takes: tuple[Literal["float", "array"], ...]


Argument: TypeAlias = ArrayOf | Integer | Callee


class Compute(NamedTuple):
    """`value` = `op` of `arguments`; `lane` says which, of operations that take one lane."""

    value: Operand
    op: str | Op
    arguments: tuple[Operand, ...]
    lane: int = 0


class SinCos(NamedTuple):
    """Sines and cosines of `angles`: of each, the values that its SIN and COS are, where they are wanted."""

    angles: tuple[int, ...]
    values: tuple[dict[Op, int], ...]


class Address(NamedTuple):
    """The doubles of an array from an index on; in Programs the index is known."""

    base: str
    offset: Operand


class Read(NamedTuple):
    """`value` = the doubles of `base` from `offset` on."""

    value: Operand
    base: str
    offset: Operand


class Write(NamedTuple):
    """The doubles of `base` from `offset` on become those of `value`."""

    value: Operand
    base: str
    offset: Operand
    label: str = ""


class Get(NamedTuple):
    """`value` = what a cell holds."""

    value: Value
    cell: Cell


class Put(NamedTuple):
    """A cell holds `value` from now on."""

    cell: Cell
    value: Operand


class If(NamedTuple):
    """One of two blocks, as `condition` says."""

    condition: Operand
    then: "Block"
    other: "Block"


class While(NamedTuple):
    """`head`, then `body` and again from the beginning, as long as `condition`, which `head` defines, is true."""

    head: "Block"
    condition: Operand
    body: "Block"


class Count(NamedTuple):
    """`body` for `counter` = `start`, …, `stop` − 1; where these are `few`, no work is spent on making many of them fast."""

    counter: Value
    start: Operand
    stop: Operand
    body: "Block"
    few: bool = False


class CallRoutine(NamedTuple):
    """A routine is called with numbers and addresses."""

    callee: Callee
    arguments: tuple[Operand | Address, ...]


Statement: TypeAlias = Compute | SinCos | Read | Write | Get | Put | If | While | Count | CallRoutine
Block: TypeAlias = tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Kernel:
    """A function of `arguments`; `cells` begin with zero, and `result` is the one whose integer is returned."""

    name: str
    arguments: tuple[Argument, ...]
    cells: tuple[Cell, ...]
    body: Block
    result: Cell
