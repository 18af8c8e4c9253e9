# SPDX-License-Identifier: BSD-3-Clause
"""How LLVM writes numbers, types and operations, on doubles and on vectors of them.

Which places of its vectors a piece of a long function is given pointers to, so that its code is short.

An instruction that reads memory holds the offset from a pointer: in one byte where that is less than 16 doubles, else in four. Of long
code the processor waits for the bytes of its instructions, and half of them read or write memory. So a piece has several pointers into
the vectors that it uses most: of each place one is the nearest, and no two pointers of one vector are for the same place.
"""

import itertools
import math
import struct
from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from kane.expr import ops
from kane.expr.ops import OPS, Op
from kane.program.emit.walk import shared
from kane.program.kernel.language import Read, Statement, Type, Write


@dataclass(frozen=True, slots=True)
class Lanes:
    """`width` numbers side by side: a vector, or for one a plain number."""

    width: int

    def of(self, kind: str) -> str:
        """The type of `width` values of a kind."""
        return f"<{self.width} x {kind}>" if self.width > 1 else kind

    @property
    def double(self) -> str:
        """The type of the numbers."""
        return self.of("double")

    @property
    def suffix(self) -> str:
        """What the names of LLVM's functions for them end in."""
        return f"v{self.width}f64" if self.width > 1 else "f64"

    def all(self, kind: str, value: object) -> str:
        """A constant with one value in every lane."""
        return f"splat ({kind} {value})" if self.width > 1 else str(value)

    def number(self, value: float) -> str:
        """A number in every lane."""
        return self.all("double", bits(value))

    def numbers(self, values: Sequence[float]) -> str:
        """A constant with a number for each lane; the last one is repeated in what is left over."""
        lanes = [*values, *[values[-1]] * (self.width - len(values))]
        return bits(lanes[0]) if self.width == 1 else f"<{', '.join(f'double {bits(v)}' for v in lanes)}>"

    def padded(self, count: int) -> int:
        """`count` doubles rounded up to whole vectors."""
        return -(-count // self.width) * self.width


def bits(value: float) -> str:
    """A double as LLVM reads it, exactly."""
    return f"0x{struct.pack('>d', value).hex().upper()}"


_KINDS = {"float": "double", "int": "i64", "bool": "i1"}


@cache
def typed(type_: Type) -> str:
    """A type of the kernel language."""
    return Lanes(type_.width).of(_KINDS[type_.kind])


LIBRARY = {OPS[n]: n for n in ["pow", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log"]}
"""Operations that are calls of the library, of doubles alone."""
CALLS: Mapping[Op | str, str] = {
    **{OPS[n]: n for n in LIBRARY.values()},
    **shared({"sqrt": "llvm.sqrt", "abs": "llvm.fabs"}),
    OPS["floor"]: "llvm.floor",
}
"""Operations that are calls, of the library or of LLVM's own functions."""
BINARY: Mapping[Op | str, str] = shared({n: f"f{n}" for n in ("add", "sub", "mul", "div")})
_ORDERED = (
    "{r}.a = fcmp %s {t} {0}, {1}\n{r}.b = fcmp uno {t} {0}, {0}\n"
    "{r}.c = or {b} {r}.a, {r}.b\n{r} = select {b} {r}.c, {t} {0}, {t} {1}"
)
"""The argument that compares so with the other; a NaN is passed on, as NumPy does."""
_SPLAT = (
    "{r}.one = insertelement {v} poison, {t} {0}, i32 0\n"
    "{r} = shufflevector {v} {r}.one, {v} poison, <{width} x i32> zeroinitializer"
)
_FORMS: Mapping[str, Mapping[Op | str, str]] = {
    "float": {
        **shared({"neg": "{r} = fneg {f}{t} {0}", "min": _ORDERED % "olt", "max": _ORDERED % "ogt"}),
        "less": "{r} = fcmp olt {t} {0}, {1}",
        "at_most": "{r} = fcmp ole {t} {0}, {1}",
        "int": "{r} = fptosi {t} {0} to {v}",
        "lane": "{r} = extractelement {t} {0}, i32 {lane}",
        **dict.fromkeys(("splat", "splat4", "splat8"), _SPLAT),
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
    },
    "int": {
        **{n: f"{{r}} = {n} {{t}} {{0}}, {{1}}" for n in ("add", "sub", "mul")},
        "less": "{r} = icmp slt {t} {0}, {1}",
        "at_most": "{r} = icmp sle {t} {0}, {1}",
        "float": "{r} = sitofp {t} {0} to {v}",
    },
    "bool": {
        "and": "{r} = and {t} {0}, {1}",
        "or": "{r} = or {t} {0}, {1}",
        "not": "{r} = xor {t} {0}, {true}",
        "select": "{r} = select {t} {0}, {v} {1}, {v} {2}",
        "any": "{r}.bits = bitcast {t} {0} to i{lanes}\n{r} = icmp ne i{lanes} {r}.bits, 0",
    },
}
"""By the kind of the first operand, the lines for the value {r} of {0}, {1}, …, with {f} for flags of contraction; {t} is the type
of the first operand, {b} that of as many truth values, {v} the result's."""
_NUMBERS = {"zero": 0.0, "one": 1.0, "minus": -1.0, "gone": ops.GONE, "nan": math.nan}
_GUARD = (
    "{r}.gone = fmul double {1}, {gone}\n{r}.bits = bitcast double {0} to i64\n{r}.unsigned = and i64 {r}.bits, {unsigned}\n"
    "{r}.size = bitcast i64 {r}.unsigned to double\n{r}.ok = fcmp ogt double {r}.size, {r}.gone"
)
_DIVIDED = "{r}.quotient = fdiv {f}double {0}, {1}\n{r} = select i1 {2}, double {r}.quotient, double {nan}"


def lines(
    op: Op | str, result: str, operands: Sequence[str], flags: str, type_: Type, made: Type, lane: int = 0
) -> list[str]:
    """The lines of an operation that is no call, on operands of which the first has a type, of a result that has another."""
    form = _FORMS[type_.kind][op]
    return form.format(*operands, r=result, f=flags, lane=lane, **_fields(type_, made)).split("\n")


def guard(result: str, operands: Sequence[str]) -> tuple[list[str], str]:
    """The lines that say whether REGULAR passes on its first operand, a double, and the name of the answer."""
    text = _GUARD.format(*operands, r=result, gone=bits(ops.GONE), unsigned=2**63 - 1)
    return text.split("\n"), f"{result}.ok"


def divided(result: str, operands: Sequence[str], answer: str, flags: str) -> list[str]:
    """The lines of a division by what a guard passes on, that asks for the answer when the quotient is known."""
    return _DIVIDED.format(*operands, answer, r=result, f=flags, nan=bits(math.nan)).split("\n")


@cache
def _fields(type_: Type, made: Type) -> dict[str, object]:
    """The types and the numbers."""
    lanes = Lanes(type_.width)
    numbers = {name: lanes.number(value) for name, value in _NUMBERS.items()}
    types = {"t": typed(type_), "v": typed(made), "b": lanes.of("i1"), "true": lanes.all("i1", "true")}
    return {**numbers, **types, "width": made.width, "lanes": lanes.width}


REACH = 16
"""Doubles before a pointer, and from it on, that an offset of one byte reaches."""
_MOST = 8
"""Pointers of a piece: few more are in registers than those in which arguments are passed."""
_WORTH = 6
"""Reads and writes for which another pointer is worth being computed and passed."""


@dataclass(frozen=True, slots=True)
class Near:
    """The places of a vector to which there are pointers, ascending, and the last place for which each but the last is the nearest."""

    places: tuple[int, ...]
    last: tuple[int, ...]

    def nearest(self, place: int) -> tuple[int, int]:
        """Which pointer is the nearest to a place, and the offset from it."""
        k = bisect_left(self.last, place)
        return k, place - self.places[k]


def pointed(body: Iterable[Statement]) -> dict[str, Near]:
    """Of each vector that statements read or write, the places to which pointers save the most."""
    used: dict[str, Counter[int]] = {}
    for s in body:
        if isinstance(s, Read | Write) and isinstance(s.offset, int):
            used.setdefault(s.base, Counter())[s.offset] += 1
    chosen: dict[str, list[int]] = {base: [] for base in used}
    best = {base: _window(count) for base, count in used.items()}
    while best:
        # the first one of each vector is wanted whatever it saves
        base = max(best, key=lambda b: (not chosen[b], best[b][1]))
        start, saved = best[base]
        if chosen[base] and (saved < _WORTH or sum(map(len, chosen.values())) >= _MOST):
            break
        chosen[base].append(start + REACH)
        for place in range(start, start + 2 * REACH):
            used[base].pop(place, None)
        if used[base]:
            best[base] = _window(used[base])
        else:
            del best[base]
    return {base: _near(sorted(places)) for base, places in chosen.items()}


def _near(places: Sequence[int]) -> Near:
    return Near(tuple(places), tuple((a + b) // 2 for a, b in itertools.pairwise(places)))


def _window(count: Counter[int]) -> tuple[int, int]:
    """The first of as many places in a row as one pointer reaches, and how often those are used, for the most of them."""
    places: Sequence[int] = sorted(count)
    total = [0]
    for place in places:
        total.append(total[-1] + count[place])
    ends = [bisect_right(places, place + 2 * REACH - 1) for place in places]
    saved, k = max((total[end] - total[k], -k) for k, end in enumerate(ends))
    return places[-k], saved
