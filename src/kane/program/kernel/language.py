# SPDX-License-Identifier: BSD-3-Clause
"""The statements of Programs and kernels, an intermediate language that one printer for each target language prints.

A kernel is a function of integers, of arrays of doubles that do not overlap, and of routines that it calls; it returns an integer. Its
body is a block of statements. A value is defined once, and is visible after its definition in its block and in nested blocks; mutable
data are cells and arrays. Control flow is structured: branches and loops contain blocks.

A function of a Program (`emit/walk.py`) is a block of arithmetic, loads and stores only; its values are doubles, identified by their
numbers in the Program.

`verified_kernel` checks every kernel: each value is defined once and before its use, types match, names are distinct.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, TypeAlias

from kane.errors import ProgramError
from kane.expr.ops import Op

Kind = Literal["float", "int", "bool"]
WIDTHS = (1, 4, 8)
"""The numbers of lanes that a value may have."""


@dataclass(frozen=True, slots=True)
class Type:
    """The type of a value: double, 64-bit integer or truth value, with `width` lanes; integers have one."""

    kind: Kind
    width: int = 1

    def __str__(self) -> str:
        return self.kind if self.width == 1 else f"{self.kind}×{self.width}"


FLOAT, INT, BOOL = Type("float"), Type("int"), Type("bool")


@dataclass(frozen=True, slots=True)
class Immediate:
    """A constant: a number, or one for each lane."""

    type: Type
    value: float | int | tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Value:
    """A value of a kernel, with a unique number."""

    number: int
    type: Type

    def __str__(self) -> str:
        return str(self.number)


Operand: TypeAlias = Immediate | Value | int
"""In kernels a value or constant, in Programs the number of a value."""


def type_of(operand: Operand) -> Type:
    """The type of an operand; the numbers of Programs denote doubles."""
    return FLOAT if isinstance(operand, int) else operand.type


@dataclass(frozen=True, slots=True)
class Cell:
    """A mutable variable of the kernel."""

    name: str
    type: Type


@dataclass(frozen=True, slots=True)
class ArrayOf:
    """An argument: a pointer to doubles."""

    name: str


@dataclass(frozen=True, slots=True)
class Integer:
    """An argument: an integer; `value` denotes it in the body."""

    name: str
    value: Value


@dataclass(frozen=True, slots=True)
class Callee:
    """An argument: a pointer to a routine; `takes` are the kinds of its arguments, "float" (a double) or "array" (a pointer)."""

    name: str
    takes: tuple[Literal["float", "array"], ...]


Argument: TypeAlias = ArrayOf | Integer | Callee


class Compute(NamedTuple):
    """`value` = `op` of `arguments`; `lane` selects the lane for the operation "lane"."""

    value: Operand
    op: str | Op
    arguments: tuple[Operand, ...]
    lane: int = 0


class SinCos(NamedTuple):
    """Sines and cosines of `angles`; `values` maps, for each angle, SIN and COS to the values that they define."""

    angles: tuple[int, ...]
    values: tuple[dict[Op, int], ...]


class Address(NamedTuple):
    """A pointer into an array, at an index; in Programs the index is a constant."""

    base: str
    offset: Operand


class Read(NamedTuple):
    """`value` = the consecutive doubles of `base` from index `offset`."""

    value: Operand
    base: str
    offset: Operand


class Write(NamedTuple):
    """Stores `value` to the consecutive doubles of `base` from index `offset`."""

    value: Operand
    base: str
    offset: Operand
    label: str = ""


class Get(NamedTuple):
    """`value` = the current value of a cell."""

    value: Value
    cell: Cell


class Put(NamedTuple):
    """Assigns `value` to a cell."""

    cell: Cell
    value: Operand


class If(NamedTuple):
    """Runs `then` if `condition` is true, else `other`."""

    condition: Operand
    then: "Block"
    other: "Block"


class While(NamedTuple):
    """Repeats `head`, which defines `condition`, and `body`; ends after `head` if the condition is false."""

    head: "Block"
    condition: Operand
    body: "Block"


class For(NamedTuple):
    """Runs `body` for `counter` = `start`, …, `stop` − 1; if iterations are `few`, emitters neither unroll nor vectorize the loop."""

    counter: Value
    start: Operand
    stop: Operand
    body: "Block"
    few: bool = False


class CallRoutine(NamedTuple):
    """Calls a routine with numbers and pointers."""

    callee: Callee
    arguments: tuple[Operand | Address, ...]


Statement: TypeAlias = Compute | SinCos | Read | Write | Get | Put | If | While | For | CallRoutine
Block: TypeAlias = tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Kernel:
    """A function of `arguments`; its `cells` are initially zero, and it returns the integer in the cell `result`."""

    name: str
    arguments: tuple[Argument, ...]
    cells: tuple[Cell, ...]
    body: Block
    result: Cell


Rule: TypeAlias = Callable[[Sequence[Type]], Type | None]


def _same(*kinds: str) -> Rule:
    return lambda t: t[0] if len(set(t)) == 1 and t[0].kind in kinds else None


def _compared(t: Sequence[Type]) -> Type | None:
    return Type("bool", t[0].width) if len(set(t)) == 1 and t[0].kind != "bool" else None


def _selected(t: Sequence[Type]) -> Type | None:
    return t[1] if t[0] == Type("bool", t[1].width) and t[1] == t[2] else None


def _from(kind: Type, result: Type) -> Rule:
    return lambda t: result if t[0] == kind else None


def _one_of_lanes(kind: str) -> Rule:
    return lambda t: Type(t[0].kind) if t[0].kind == kind and t[0].width > 1 else None


RULES: dict[str, tuple[int, Rule]] = {
    **dict.fromkeys(("add", "sub", "mul"), (2, _same("float", "int"))),
    **dict.fromkeys(("div", "min", "max"), (2, _same("float"))),
    **dict.fromkeys(("neg", "sqrt", "abs"), (1, _same("float"))),
    **dict.fromkeys(("less", "at_most"), (2, _compared)),
    **dict.fromkeys(("and", "or"), (2, _same("bool"))),
    "not": (1, _same("bool")),
    "select": (3, _selected),
    "float": (1, _from(INT, FLOAT)),
    "int": (1, _from(FLOAT, INT)),
    "splat4": (1, _from(FLOAT, Type("float", 4))),
    "splat8": (1, _from(FLOAT, Type("float", 8))),
    **dict.fromkeys(("lane", "sum", "largest"), (1, _one_of_lanes("float"))),
    "any": (1, _one_of_lanes("bool")),
}
"""The operations: the number of operands, and the type of the result as a function of theirs, None if they are invalid.

Each is exact or correctly rounded, so that every language gives the same bits if a·b + c is not contracted. "sum" and "largest" reduce
lanes by repeated halving, lane k with lane k + width/2. "min" and "max" are NaN if an operand is.
"""


def result_type(op: str | Op, types: Sequence[Type]) -> Type:
    """The type of an operation's result.

    Raises
    ------
    ProgramError
        if the operation does not exist or does not accept operands of these types
    """
    if not isinstance(op, str) or op not in RULES:
        raise ProgramError(f"Expected one of the operations {', '.join(RULES)}, got {op!r}.")
    count, rule = RULES[op]
    result = rule(types) if len(types) == count else None
    if result is None:
        raise ProgramError(
            f"Expected {count} operand{'s' * (count > 1)} that {op!r} takes, got {', '.join(map(str, types)) or 'none'}: "
            "convert them, or splat numbers to the lanes of the others."
        )
    return result


def verified_kernel(kernel: Kernel) -> Kernel:
    """The kernel, unchanged.

    Raises
    ------
    ProgramError
        if it violates a rule of the language
    """
    names = [a.name for a in (*kernel.arguments, *kernel.cells)]
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise _wrong(kernel, "names that differ", f"{', '.join(twice)} more than once")
    if kernel.result.type != INT or kernel.result not in kernel.cells:
        raise _wrong(kernel, "one of its cells, an integer, as result", str(kernel.result))
    _Check(kernel).block(kernel.body, {a.value.number: a.value for a in kernel.arguments if isinstance(a, Integer)})
    return kernel


def without_unused(kernel: Kernel) -> Kernel:
    """The kernel without dead code: values and cells that nothing reads, branches and for loops without effect."""
    body, read = kernel.body, {*kernel.cells, kernel.result}
    while True:
        still = {kernel.result}
        body = _used(body, set(), read, still)
        if still == read:
            return replace(kernel, body=body, cells=tuple(c for c in kernel.cells if c in read))
        read = still


def blocks(s: Statement) -> tuple[Block, ...]:
    """The blocks of a statement."""
    if isinstance(s, If):
        return s.then, s.other
    return (s.head, s.body) if isinstance(s, While) else (s.body,) if isinstance(s, For) else ()


def _used(block: Block, used: set[int], read: set[Cell], still: set[Cell]) -> Block:
    """The live statements of a block; `read` are the cells that are read anywhere.

    Statements are visited in reverse, so that all readers of a value come before it: live statements add the numbers of the values
    that they read to `used`, and the cells to `still`.
    """
    kept: list[Statement] = []
    for s in reversed(block):
        if isinstance(s, Compute | Read | Get) and isinstance(s.value, Value) and s.value.number not in used:
            continue
        if isinstance(s, Put) and s.cell not in read:
            continue
        if isinstance(s, If):
            s = s._replace(then=_used(s.then, used, read, still), other=_used(s.other, used, read, still))
            if not (s.then or s.other):
                continue
        elif isinstance(s, While):
            body = _used(s.body, used, read, still)
            used.update(_numbers([s.condition]))
            s = s._replace(head=_used(s.head, used, read, still), body=body)
        elif isinstance(s, For):
            s = s._replace(body=_used(s.body, used, read, still))
            if not s.body:
                continue
        elif isinstance(s, Get):
            still.add(s.cell)
        used.update(_numbers(operands_of(s)))
        kept.append(s)
    return tuple(reversed(kept))


def operands_of(s: Statement) -> Sequence[Any]:
    """The operands of a statement, without its blocks and the condition of a while loop; an address counts as its offset."""
    if isinstance(s, Compute):
        return s.arguments
    if isinstance(s, CallRoutine):
        return [a.offset if isinstance(a, Address) else a for a in s.arguments]
    return [operand for _, operand in _TYPES[type(s)](s)[0]]


def numbers(block: Block) -> set[int]:
    """The numbers of the values that a block defines."""
    own = (s.counter if isinstance(s, For) else getattr(s, "value", None) for s in block)
    return set(_numbers(own)).union(*(numbers(inner) for s in block for inner in blocks(s)))


def _numbers(operands: Iterable[Any]) -> list[int]:
    return [operand.number for operand in operands if isinstance(operand, Value)]


def _wrong(kernel: Kernel, expected: str, got: str) -> ProgramError:
    return ProgramError(f"Expected {expected} in the kernel {kernel.name!r}, got {got}.")


_Typed: TypeAlias = tuple[Type | None, Operand]
_TYPES: dict[type[Any], Callable[[Any], tuple[Sequence[_Typed], Sequence[_Typed]]]] = {
    Compute: lambda s: (
        [(None, a) for a in s.arguments],
        [(result_type(s.op, list(map(type_of, s.arguments))), s.value)],
    ),
    Read: lambda s: ([(INT, s.offset)], [(_doubles(s.value), s.value)]),
    Write: lambda s: ([(INT, s.offset), (_doubles(s.value), s.value)], []),
    Get: lambda s: ([], [(s.cell.type, s.value)]),
    Put: lambda s: ([(s.cell.type, s.value)], []),
    CallRoutine: lambda s: ([(INT, a.offset) if isinstance(a, Address) else (None, a) for a in s.arguments], []),
    If: lambda s: ([(BOOL, s.condition)], []),
    For: lambda s: ([(INT, s.start), (INT, s.stop)], [(INT, s.counter)]),
    While: lambda s: ([], []),
}
"""The operands of a statement, without blocks and a while loop's condition, and the values that it defines, with required types."""


def _doubles(value: Operand) -> Type:
    return Type("float", type_of(value).width)


class _Check:
    """Verifies one kernel; `defined` are the numbers of all values so far."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self.arrays = {a.name for a in kernel.arguments if isinstance(a, ArrayOf)}
        self.defined = {a.value.number for a in kernel.arguments if isinstance(a, Integer)}

    def block(self, block: Block, known: dict[int, Value]) -> dict[int, Value]:
        """Verifies a block, given the values visible before it; returns those visible at its end."""
        known = dict(known)
        for s in block:
            if type(s) not in _TYPES:
                raise _wrong(self.kernel, "statements of kernels", type(s).__name__)
            self.names(s)
            operands, values = _TYPES[type(s)](s)
            for _, operand in operands:
                self.operand(operand, known)
            for expected, operand in (*operands, *values):
                if expected not in (None, type_of(operand)):
                    raise _wrong(self.kernel, str(expected), f"{type_of(operand)} in {type(s).__name__}")
            if isinstance(s, If):
                self.block(s.then, known)
                self.block(s.other, known)
            elif isinstance(s, While):
                inside = self.block(s.head, known)
                self.operand(s.condition, inside)
                if type_of(s.condition) != BOOL:
                    raise _wrong(self.kernel, "a truth value as condition of a loop", str(type_of(s.condition)))
                self.block(s.body, inside)
            elif isinstance(s, For):
                self.block(s.body, known | self.define(s.counter))
            else:
                for _, value in values:
                    known |= self.define(value)
        return known

    def define(self, value: Operand) -> dict[int, Value]:
        """Checks that a value is new, and adds it."""
        if not isinstance(value, Value) or value.number in self.defined:
            raise _wrong(self.kernel, "values that are defined once", f"value {value} again")
        if value.type.width not in WIDTHS or (value.type.kind == "int" and value.type.width > 1):
            raise _wrong(self.kernel, f"values of width {', '.join(map(str, WIDTHS))}, integers of 1", str(value.type))
        self.defined.add(value.number)
        return {value.number: value}

    def operand(self, operand: Operand, known: dict[int, Value]) -> None:
        """Checks that an operand is a visible value or a constant with one number for each lane."""
        if isinstance(operand, Immediate):
            if isinstance(operand.value, tuple) != (operand.type.width > 1):
                raise _wrong(self.kernel, f"a number for each lane of {operand.type}", str(operand.value))
        elif isinstance(operand, int) or known.get(operand.number) != operand:
            raise _wrong(self.kernel, "values that are defined where they are used", f"value {operand}")

    def names(self, s: Statement) -> None:
        """Checks that arrays, cells and routines belong to the kernel, and that a routine gets arguments of the right kinds."""
        if isinstance(s, Get | Put) and s.cell not in self.kernel.cells:
            raise _wrong(self.kernel, "cells of its own", s.cell.name)
        places = s.arguments if isinstance(s, CallRoutine) else (s,)
        for base in (a.base for a in places if isinstance(a, Read | Write | Address)):
            if base not in self.arrays:
                raise _wrong(self.kernel, "arrays of its own", base)
        if isinstance(s, CallRoutine):
            kinds = tuple("array" if isinstance(a, Address) else str(type_of(a)) for a in s.arguments)
            if s.callee not in self.kernel.arguments or kinds != s.callee.takes:
                expected = ", ".join(s.callee.takes)
                raise _wrong(self.kernel, f"a routine of its own, {s.callee.name}({expected})", ", ".join(kinds))
