# SPDX-License-Identifier: BSD-3-Clause
"""What holds of every kernel: values defined once and before they are used, types that fit, names that differ."""

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from kane.errors import ProgramError
from kane.expr.ops import Op
from kane.program.kernel import language

Rule: TypeAlias = Callable[[Sequence[language.Type]], language.Type | None]


def _same(*kinds: str) -> Rule:
    return lambda t: t[0] if len(set(t)) == 1 and t[0].kind in kinds else None


def _compared(t: Sequence[language.Type]) -> language.Type | None:
    return language.Type("bool", t[0].width) if len(set(t)) == 1 and t[0].kind != "bool" else None


def _selected(t: Sequence[language.Type]) -> language.Type | None:
    return t[1] if t[0] == language.Type("bool", t[1].width) and t[1] == t[2] else None


def _from(kind: language.Type, result: language.Type) -> Rule:
    return lambda t: result if t[0] == kind else None


def _one_of_lanes(kind: str) -> Rule:
    return lambda t: language.Type(t[0].kind) if t[0].kind == kind and t[0].width > 1 else None


RULES: dict[str, tuple[int, Rule]] = {
    **dict.fromkeys(("add", "sub", "mul"), (2, _same("float", "int"))),
    **dict.fromkeys(("div", "min", "max"), (2, _same("float"))),
    **dict.fromkeys(("neg", "sqrt", "abs"), (1, _same("float"))),
    **dict.fromkeys(("less", "at_most"), (2, _compared)),
    **dict.fromkeys(("and", "or"), (2, _same("bool"))),
    "not": (1, _same("bool")),
    "select": (3, _selected),
    "float": (1, _from(language.INT, language.FLOAT)),
    "int": (1, _from(language.FLOAT, language.INT)),
    "splat4": (1, _from(language.FLOAT, language.Type("float", 4))),
    "splat8": (1, _from(language.FLOAT, language.Type("float", 8))),
    **dict.fromkeys(("lane", "sum", "largest"), (1, _one_of_lanes("float"))),
    "any": (1, _one_of_lanes("bool")),
}
"""The operations: how many operands they take, and the type of the result for theirs, None where they do not fit.

Each is exact or rounded once, so that every language gives the same bits where a·b + c is not contracted. Sums and largest values over
lanes are taken in halves, lane k with lane k + width/2, down to one. The smaller and the larger one of two are
NaN where one is.
"""


def result_type(op: str | Op, types: Sequence[language.Type]) -> language.Type:
    """The type of an operation's result.

    Raises
    ------
    ProgramError
        if there is no such operation, or it does not take operands of these types
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


def verified_kernel(kernel: language.Kernel) -> language.Kernel:
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
    if kernel.result.type != language.INT or kernel.result not in kernel.cells:
        raise _wrong(kernel, "one of its cells, an integer, as result", str(kernel.result))
    _Check(kernel).block(
        kernel.body, {a.value.number: a.value for a in kernel.arguments if isinstance(a, language.Integer)}
    )
    return kernel


def _wrong(kernel: language.Kernel, expected: str, got: str) -> ProgramError:
    return ProgramError(f"Expected {expected} in the kernel {kernel.name!r}, got {got}.")


_Typed: TypeAlias = tuple[language.Type | None, language.Operand]
_TYPES: dict[type[Any], Callable[[Any], tuple[Sequence[_Typed], Sequence[_Typed]]]] = {
    language.Compute: lambda s: (
        [(None, a) for a in s.arguments],
        [(result_type(s.op, list(map(language.type_of, s.arguments))), s.value)],
    ),
    language.Read: lambda s: ([(language.INT, s.offset)], [(_doubles(s.value), s.value)]),
    language.Write: lambda s: ([(language.INT, s.offset), (_doubles(s.value), s.value)], []),
    language.Get: lambda s: ([], [(s.cell.type, s.value)]),
    language.Put: lambda s: ([(s.cell.type, s.value)], []),
    language.CallRoutine: lambda s: (
        [(language.INT, a.offset) if isinstance(a, language.Address) else (None, a) for a in s.arguments],
        [],
    ),
    language.If: lambda s: ([(language.BOOL, s.condition)], []),
    language.Count: lambda s: ([(language.INT, s.start), (language.INT, s.stop)], [(language.INT, s.counter)]),
    language.While: lambda s: ([], []),
}
"""What a statement reads, but for its blocks and the condition of a loop, and what it defines, with the types that these must have."""


def _doubles(value: language.Operand) -> language.Type:
    return language.Type("float", language.type_of(value).width)


class _Check:
    """One kernel; `defined` are the numbers of all values so far."""

    def __init__(self, kernel: language.Kernel) -> None:
        self.kernel = kernel
        self.arrays = {a.name for a in kernel.arguments if isinstance(a, language.ArrayOf)}
        self.defined = {a.value.number for a in kernel.arguments if isinstance(a, language.Integer)}

    def block(self, block: language.Block, known: dict[int, language.Value]) -> dict[int, language.Value]:
        """A block, with the values that are known before it; those that are known at its end."""
        known = dict(known)
        for s in block:
            if type(s) not in _TYPES:
                raise _wrong(self.kernel, "statements of kernels", type(s).__name__)
            self.names(s)
            operands, values = _TYPES[type(s)](s)
            for _, operand in operands:
                self.operand(operand, known)
            for expected, operand in (*operands, *values):
                if expected not in (None, language.type_of(operand)):
                    raise _wrong(self.kernel, str(expected), f"{language.type_of(operand)} in {type(s).__name__}")
            if isinstance(s, language.If):
                self.block(s.then, known)
                self.block(s.other, known)
            elif isinstance(s, language.While):
                inside = self.block(s.head, known)
                self.operand(s.condition, inside)
                if language.type_of(s.condition) != language.BOOL:
                    raise _wrong(
                        self.kernel, "a truth value as condition of a loop", str(language.type_of(s.condition))
                    )
                self.block(s.body, inside)
            elif isinstance(s, language.Count):
                self.block(s.body, known | self.define(s.counter))
            else:
                for _, value in values:
                    known |= self.define(value)
        return known

    def define(self, value: language.Operand) -> dict[int, language.Value]:
        """A value that is new."""
        if not isinstance(value, language.Value) or value.number in self.defined:
            raise _wrong(self.kernel, "values that are defined once", f"value {value} again")
        if value.type.width not in language.WIDTHS or (value.type.kind == "int" and value.type.width > 1):
            raise _wrong(
                self.kernel, f"values of width {', '.join(map(str, language.WIDTHS))}, integers of 1", str(value.type)
            )
        self.defined.add(value.number)
        return {value.number: value}

    def operand(self, operand: language.Operand, known: dict[int, language.Value]) -> None:
        """A value that is known as what it is, or a constant that has a number for each lane."""
        if isinstance(operand, language.Immediate):
            if isinstance(operand.value, tuple) != (operand.type.width > 1):
                raise _wrong(self.kernel, f"a number for each lane of {operand.type}", str(operand.value))
        elif isinstance(operand, int) or known.get(operand.number) != operand:
            raise _wrong(self.kernel, "values that are defined where they are used", f"value {operand}")

    def names(self, s: language.Statement) -> None:
        """Arrays, cells and routines are the kernel's, and a routine takes what it is given."""
        if isinstance(s, language.Get | language.Put) and s.cell not in self.kernel.cells:
            raise _wrong(self.kernel, "cells of its own", s.cell.name)
        places = s.arguments if isinstance(s, language.CallRoutine) else (s,)
        for base in (a.base for a in places if isinstance(a, language.Read | language.Write | language.Address)):
            if base not in self.arrays:
                raise _wrong(self.kernel, "arrays of its own", base)
        if isinstance(s, language.CallRoutine):
            kinds = tuple("array" if isinstance(a, language.Address) else str(language.type_of(a)) for a in s.arguments)
            if s.callee not in self.kernel.arguments or kinds != s.callee.takes:
                expected = ", ".join(s.callee.takes)
                raise _wrong(self.kernel, f"a routine of its own, {s.callee.name}({expected})", ", ".join(kinds))
