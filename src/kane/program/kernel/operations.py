# SPDX-License-Identifier: BSD-3-Clause
"""The operations of the kernel language: how many operands, of which types, and what NumPy makes of them.

Each is exact or rounded once, so that every language gives the same bits where a·b + c is not contracted. Sums and largest values over
lanes are taken in halves, lane k with lane k + width/2, down to one.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.errors import ProgramError
from kane.program.kernel.language import FLOAT, INT, Type

Rule = Callable[[Sequence[Type]], Type | None]


@dataclass(frozen=True, slots=True, eq=False)
class Operation:
    """`rule` gives the result's type for those of the operands, None where they do not fit; `numpy` is the reference."""

    rule: Rule
    numpy: Callable[..., Any]


def _same(*kinds: str) -> Rule:
    return lambda t: t[0] if len(set(t)) == 1 and t[0].kind in kinds else None


def _compared(t: Sequence[Type]) -> Type | None:
    return Type("bool", t[0].width) if len(set(t)) == 1 and t[0].kind != "bool" else None


def _chosen(t: Sequence[Type]) -> Type | None:
    return t[1] if t[0] == Type("bool", t[1].width) and t[1] == t[2] else None


def _from(kind: Type, result: Type) -> Rule:
    return lambda t: result if t[0] == kind else None


def _splat(width: int) -> Rule:
    return lambda t: Type("float", width) if t[0] == FLOAT else None


def _one_of_lanes(kind: str) -> Rule:
    return lambda t: Type(t[0].kind) if t[0].kind == kind and t[0].width > 1 else None


def _where(c: Any, a: Any, b: Any) -> Any:
    chosen: Any = np.where(c, a, b)
    return chosen[()]


def larger(a: Any, b: Any) -> Any:
    """The larger one; NaN where there is one."""
    return _where((a > b) | (a != a), a, b)


def _smaller(a: Any, b: Any) -> Any:
    return _where((a < b) | (a != a), a, b)


def _halves(combine: Callable[[Any, Any], Any]) -> Callable[[Any], Any]:
    def folded(x: Any) -> Any:
        while len(x) > 1:
            half = len(x) // 2
            x = combine(x[:half], x[half:])
        return x[0]

    return folded


def _add(a: Any, b: Any) -> Any:
    return a + b


OPERATIONS: dict[str, tuple[int, Operation]] = {
    "add": (2, Operation(_same("float", "int"), _add)),
    "sub": (2, Operation(_same("float", "int"), lambda a, b: a - b)),
    "mul": (2, Operation(_same("float", "int"), lambda a, b: a * b)),
    "div": (2, Operation(_same("float"), lambda a, b: a / b)),
    "neg": (1, Operation(_same("float"), lambda a: -a)),
    "sqrt": (1, Operation(_same("float"), np.sqrt)),
    "abs": (1, Operation(_same("float"), np.abs)),
    "min": (2, Operation(_same("float"), _smaller)),
    "max": (2, Operation(_same("float"), larger)),
    "less": (2, Operation(_compared, lambda a, b: a < b)),
    "at_most": (2, Operation(_compared, lambda a, b: a <= b)),
    "and": (2, Operation(_same("bool"), np.logical_and)),
    "or": (2, Operation(_same("bool"), np.logical_or)),
    "not": (1, Operation(_same("bool"), np.logical_not)),
    "select": (3, Operation(_chosen, _where)),
    "float": (1, Operation(_from(INT, FLOAT), np.float64)),
    "int": (1, Operation(_from(FLOAT, INT), int)),
    "splat4": (1, Operation(_splat(4), lambda a: np.full(4, a))),
    "splat8": (1, Operation(_splat(8), lambda a: np.full(8, a))),
    "lane": (1, Operation(_one_of_lanes("float"), lambda a: a)),
    "sum": (1, Operation(_one_of_lanes("float"), _halves(_add))),
    "largest": (1, Operation(_one_of_lanes("float"), _halves(larger))),
    "any": (1, Operation(_one_of_lanes("bool"), np.any)),
}
"""By name: the number of operands, and the operation."""


def result_type(op: str, types: Sequence[Type]) -> Type:
    """The type of an operation's result.

    Raises
    ------
    ProgramError
        if there is no such operation, or it does not take operands of these types
    """
    if op not in OPERATIONS:
        raise ProgramError(f"Expected one of the operations {', '.join(OPERATIONS)}, got {op!r}.")
    count, operation = OPERATIONS[op]
    found = operation.rule(types) if len(types) == count else None
    if found is None:
        raise ProgramError(
            f"Expected {count} operand{'s' * (count > 1)} that {op!r} takes, got {', '.join(map(str, types)) or 'none'}: "
            "convert them, or splat numbers to the lanes of the others."
        )
    return found
