# SPDX-License-Identifier: BSD-3-Clause
"""What holds of every kernel: values defined once and before they are used, types that fit, names that differ."""

from collections.abc import Iterator

from kane.errors import ProgramError
from kane.program.kernel.language import (
    BOOL,
    INT,
    WIDTHS,
    Block,
    Call,
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
    Type,
    Value,
    While,
)
from kane.program.kernel.operations import result_type


def verified_kernel(kernel: Kernel) -> Kernel:
    """The kernel itself.

    Raises
    ------
    ProgramError
        if it is no kernel of the language
    """
    names = [a.name for a in (*kernel.arguments, *kernel.cells)]
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise _wrong(kernel, "names that differ", f"{', '.join(twice)} more than once")
    if kernel.result.type != INT or kernel.result not in kernel.cells:
        raise _wrong(kernel, "one of its cells, an integer, as result", str(kernel.result))
    _Check(kernel).block(kernel.body, {a.value.number: a.value for a in kernel.arguments if isinstance(a, Number)})
    return kernel


def _wrong(kernel: Kernel, expected: str, got: str) -> ProgramError:
    return ProgramError(f"Expected {expected} in the kernel {kernel.name!r}, got {got}.")


class _Check:
    """One kernel; `defined` are the numbers of all values so far."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self.defined = {a.value.number for a in kernel.arguments if isinstance(a, Number)}

    def block(self, block: Block, known: dict[int, Value]) -> None:
        """A block, with the values that are known before it."""
        known = dict(known)
        for s in block:
            for operand in _operands(s):
                self.operand(operand, known)
            self.types(s)
            if isinstance(s, If):
                self.block(s.then, known)
                self.block(s.other, known)
            elif isinstance(s, While):
                self.loop(s, known)
            elif isinstance(s, Count):
                self.block(s.body, known | self.define(s.index))
            elif isinstance(s, Compute | Load | Get):
                known |= self.define(s.value)

    def loop(self, s: While, known: dict[int, Value]) -> None:
        """What the head defines, the condition and the body know."""
        self.block(s.head, known)
        inside = known | {v.number: v for v in _defined(s.head)}
        self.operand(s.condition, inside)
        if s.condition.type != BOOL:
            raise _wrong(self.kernel, "a truth value as condition of a loop", str(s.condition.type))
        self.block(s.body, inside)

    def define(self, value: Value) -> dict[int, Value]:
        """A value that is new."""
        if value.number in self.defined:
            raise _wrong(self.kernel, "values that are defined once", f"value {value.number} again")
        if value.type.width not in WIDTHS or (value.type.kind == "int" and value.type.width > 1):
            raise _wrong(self.kernel, f"values of width {', '.join(map(str, WIDTHS))}, integers of 1", str(value.type))
        self.defined.add(value.number)
        return {value.number: value}

    def operand(self, operand: Operand, known: dict[int, Value]) -> None:
        """A value that is known as what it is."""
        if isinstance(operand, Value) and known.get(operand.number) != operand:
            raise _wrong(self.kernel, "values that are defined where they are used", f"value {operand.number}")
        if isinstance(operand, Constant) and isinstance(operand.value, tuple) != (operand.type.width > 1):
            raise _wrong(self.kernel, f"a number for each lane of {operand.type}", str(operand.value))

    def types(self, s: Statement) -> None:
        """The types that a statement puts together."""
        pairs: list[tuple[Type, Type]] = []
        if isinstance(s, Compute):
            pairs.append((result_type(s.op, [a.type for a in s.arguments]), s.value.type))
        elif isinstance(s, Get | Put):
            if s.cell not in self.kernel.cells:
                raise _wrong(self.kernel, "cells of its own", s.cell.name)
            pairs.append((s.cell.type, s.value.type))
        elif isinstance(s, Load | Store):
            pairs.append((Type("float", s.value.type.width), s.value.type))
        elif isinstance(s, If):
            pairs.append((BOOL, s.condition.type))
        elif isinstance(s, Count):
            pairs += [(INT, s.index.type), (INT, s.start.type), (INT, s.stop.type)]
        elif isinstance(s, Call):
            self.call(s)
        for place in _places(s):
            pairs.append((INT, place.index.type))
            if place.array not in self.kernel.arguments:
                raise _wrong(self.kernel, "arrays of its own", place.array.name)
        for expected, got in pairs:
            if expected != got:
                raise _wrong(self.kernel, str(expected), f"{got} in {type(s).__name__}")

    def call(self, s: Call) -> None:
        """What the routine takes."""
        kinds = tuple("array" if isinstance(a, Place) else str(a.type) for a in s.arguments)
        if s.callee not in self.kernel.arguments or kinds != s.callee.takes:
            expected = ", ".join(s.callee.takes)
            raise _wrong(self.kernel, f"a routine of its own, {s.callee.name}({expected})", ", ".join(kinds))


def _places(s: Statement) -> list[Place]:
    if isinstance(s, Load | Store):
        return [s.place]
    return [a for a in s.arguments if isinstance(a, Place)] if isinstance(s, Call) else []


def _operands(s: Statement) -> Iterator[Operand]:
    """The operands of a statement, but for those of its blocks and of a loop's condition."""
    yield from (p.index for p in _places(s))
    if isinstance(s, Compute):
        yield from s.arguments
    elif isinstance(s, Call):
        yield from (a for a in s.arguments if not isinstance(a, Place))
    elif isinstance(s, Store | Put):
        yield s.value
    elif isinstance(s, If):
        yield s.condition
    elif isinstance(s, Count):
        yield from (s.start, s.stop)


def _defined(block: Block) -> Iterator[Value]:
    """The values that a block's own statements define."""
    return (s.value for s in block if isinstance(s, Compute | Load | Get))
