# SPDX-License-Identifier: BSD-3-Clause
"""How LLVM writes each operation, on doubles and on vectors of them."""

import math
from collections.abc import Sequence
from functools import cache

from kane.expr import ops
from kane.expr.ops import OPS, Op
from kane.program.emit.llvm_lanes import Lanes, bits

_BINARY = {ops.ADD: "fadd", ops.SUB: "fsub", ops.MUL: "fmul", ops.DIV: "fdiv"}
LIBRARY = {OPS[n]: n for n in ["pow", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log"]}
"""Operations that are calls of the library, of doubles alone."""
INTRINSICS = {ops.SQRT: "llvm.sqrt", OPS["abs"]: "llvm.fabs", OPS["floor"]: "llvm.floor"}
_ORDERED = (
    "{r}.a = fcmp %s {t} {0}, {1}\n{r}.b = fcmp uno {t} {0}, {0}\n"
    "{r}.c = or {b} {r}.a, {r}.b\n{r} = select {b} {r}.c, {t} {0}, {t} {1}"
)
"""The argument that compares so with the other; a NaN is passed on, as NumPy does."""
_GUARD = (
    "{r}.gone = fmul double {1}, {gone}\n{r}.bits = bitcast double {0} to i64\n{r}.unsigned = and i64 {r}.bits, {unsigned}\n"
    "{r}.size = bitcast i64 {r}.unsigned to double\n{r}.ok = fcmp ogt double {r}.size, {r}.gone"
)
_DIVIDED = "{r}.quotient = fdiv {f}double {0}, {1}\n{r} = select i1 {2}, double {r}.quotient, double {nan}"
_FORMS = {
    ops.NEG: "{r} = fneg {f}{t} {0}",
    OPS["min"]: _ORDERED % "olt",
    OPS["max"]: _ORDERED % "ogt",
    OPS["sign"]: (
        "{r}.a = fcmp ogt {t} {0}, {zero}\n{r}.b = select {b} {r}.a, {t} {one}, {t} {0}\n"
        "{r}.c = fcmp olt {t} {0}, {zero}\n{r}.d = select {b} {r}.c, {t} {minus}, {t} {r}.b\n"
        "{r} = fadd {t} {r}.d, {zero}"
    ),
    ops.LESS: "{r}.c = fcmp olt {t} {0}, {1}\n{r} = uitofp {b} {r}.c to {t}",
    ops.WHERE: "{r}.c = fcmp une {t} {0}, {zero}\n{r} = select {b} {r}.c, {t} {1}, {t} {2}",
    ops.REGULAR: (
        "{r}.a = fmul {t} {1}, {gone}\n{r}.b = fneg {t} {0}\n"
        "{r}.c = fcmp ogt {t} {0}, {r}.a\n{r}.d = fcmp ogt {t} {r}.b, {r}.a\n{r}.e = or {b} {r}.c, {r}.d\n"
        "{r} = select {b} {r}.e, {t} {0}, {t} {nan}"
    ),
}
"""The lines for the value {r} of {0}, {1}, …, with {f} for flags of contraction; {t} is the type, {b} that of truth values."""
_NUMBERS = {"zero": 0.0, "one": 1.0, "minus": -1.0, "gone": ops.GONE, "nan": math.nan}


def lines(op: Op, result: str, operands: Sequence[str], lanes: Lanes, flags: str) -> list[str]:
    """The lines of an operation that is no call."""
    word = _BINARY.get(op)
    if word:  # nearly all there is, written sooner
        return [f"{result} = {word} {flags}{lanes.double} {operands[0]}, {operands[1]}"]
    return _FORMS[op].format(*operands, r=result, f=flags, **_fields(lanes)).split("\n")


def guard(result: str, operands: Sequence[str]) -> tuple[list[str], str]:
    """The lines that say whether REGULAR passes on its first operand, a double, and the name of the answer."""
    text = _GUARD.format(*operands, r=result, gone=bits(ops.GONE), unsigned=2**63 - 1)
    return text.split("\n"), f"{result}.ok"


def divided(result: str, operands: Sequence[str], answer: str, flags: str) -> list[str]:
    """The lines of a division by what a guard passes on, that asks for the answer when the quotient is known."""
    return _DIVIDED.format(*operands, answer, r=result, f=flags, nan=bits(math.nan)).split("\n")


@cache
def _fields(lanes: Lanes) -> dict[str, str]:
    """The types and the numbers."""
    numbers = {name: lanes.number(value) for name, value in _NUMBERS.items()}
    return {"t": lanes.double, "b": lanes.of("i1"), **numbers}
