# SPDX-License-Identifier: BSD-3-Clause
"""Statements as LLVM text: values are registers; cells of kernels are stack variables, which LLVM promotes to registers.

Values of Programs are doubles, or vectors if several states are evaluated at once: then an element of a vector is `width` consecutive
doubles, one for each state, except in `shared` vectors, which have one value for all states. Library functions are called lane by
lane.

A piece of a long function receives pointers into its vectors, which makes its code shorter: an x86 memory operand has a one-byte
offset if it is less than 16 doubles, else a four-byte one. Long code is limited by instruction fetch, and half of its instructions
access memory. So a piece has several pointers into the vectors that it uses most; each element is addressed from the nearest pointer,
and the ranges of the pointers into one vector do not overlap.
"""

import itertools
import math
import struct
from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from kane.expr import ops
from kane.expr.ops import COS, DIV, OPS, REGULAR, SIN, Op
from kane.program.emit import walk
from kane.program.emit.walk import LIBRARY, Printer, shared
from kane.program.kernel import language
from kane.program.kernel.language import Read, Statement, Type, Write


@dataclass(frozen=True, slots=True)
class Lanes:
    """The type of `width` numbers: a vector, or a scalar if `width` is 1."""

    width: int

    def of(self, kind: str) -> str:
        """The LLVM type of `width` values of a kind."""
        return f"<{self.width} x {kind}>" if self.width > 1 else kind

    @property
    def double(self) -> str:
        """The LLVM type of `width` doubles."""
        return self.of("double")

    @property
    def suffix(self) -> str:
        """The suffix of LLVM intrinsics for this type."""
        return f"v{self.width}f64" if self.width > 1 else "f64"

    def all(self, kind: str, value: object) -> str:
        """A constant with the same value in every lane."""
        return f"splat ({kind} {value})" if self.width > 1 else str(value)

    def number(self, value: float) -> str:
        """A constant with the same number in every lane."""
        return self.all("double", bits(value))

    def numbers(self, values: Sequence[float]) -> str:
        """A constant with a number for each lane; the last one is repeated in lanes beyond them."""
        lanes = [*values, *[values[-1]] * (self.width - len(values))]
        return bits(lanes[0]) if self.width == 1 else f"<{', '.join(f'double {bits(v)}' for v in lanes)}>"

    def padded(self, count: int) -> int:
        """`count` doubles rounded up to a multiple of the width."""
        return -(-count // self.width) * self.width


def bits(value: float) -> str:
    """An exact LLVM literal of a double."""
    return f"0x{struct.pack('>d', value).hex().upper()}"


_KINDS = {"float": "double", "int": "i64", "bool": "i1"}


@cache
def typed(type_: Type) -> str:
    """The LLVM type of a type of the kernel language."""
    return Lanes(type_.width).of(_KINDS[type_.kind])


CALLS: Mapping[Op | str, str] = {
    **LIBRARY,
    **shared({"sqrt": "llvm.sqrt", "abs": "llvm.fabs"}),
    OPS["floor"]: "llvm.floor",
}
"""Operations that are calls of the library or of LLVM intrinsics."""
BINARY: Mapping[Op | str, str] = shared({n: f"f{n}" for n in ("add", "sub", "mul", "div")})
_ORDERED = (
    "{r}.a = fcmp %s {t} {0}, {1}\n{r}.b = fcmp uno {t} {0}, {0}\n"
    "{r}.c = or {b} {r}.a, {r}.b\n{r} = select {b} {r}.c, {t} {0}, {t} {1}"
)
"""The minimum or maximum of two numbers; NaN if either is, as in NumPy."""
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
        "splat": _SPLAT,
    },
    "bool": {
        "and": "{r} = and {t} {0}, {1}",
        "or": "{r} = or {t} {0}, {1}",
        "not": "{r} = xor {t} {0}, {true}",
        "select": "{r} = select {t} {0}, {v} {1}, {v} {2}",
        "splat": _SPLAT,
        "any": "{r}.bits = bitcast {t} {0} to i{lanes}\n{r} = icmp ne i{lanes} {r}.bits, 0",
    },
}
"""The LLVM lines of the value {r} of {0}, {1}, …, by the kind of the first operand; {f} are contraction flags, {t} the type of the
first operand, {b} the vector of as many truth values, {v} the type of the result."""
_NUMBERS = {"zero": 0.0, "one": 1.0, "minus": -1.0, "gone": ops.GONE, "nan": math.nan}
_GUARD = (
    "{r}.gone = fmul double {1}, {gone}\n{r}.bits = bitcast double {0} to i64\n{r}.unsigned = and i64 {r}.bits, {unsigned}\n"
    "{r}.size = bitcast i64 {r}.unsigned to double\n{r}.ok = fcmp ogt double {r}.size, {r}.gone"
)
_DIVIDED = "{r}.quotient = fdiv {f}double {0}, {1}\n{r} = select i1 {2}, double {r}.quotient, double {nan}"


def lines(
    op: Op | str, result: str, operands: Sequence[str], flags: str, type_: Type, made: Type, lane: int = 0
) -> list[str]:
    """The lines of an operation that is not a call; `type_` is the type of the first operand, `made` that of the result."""
    form = _FORMS[type_.kind][op]
    return form.format(*operands, r=result, f=flags, lane=lane, **_fields(type_, made)).split("\n")


def guard(result: str, operands: Sequence[str]) -> tuple[list[str], str]:
    """The lines of the test whether REGULAR returns its first operand, a double, and the name of the truth value."""
    text = _GUARD.format(*operands, r=result, gone=bits(ops.GONE), unsigned=2**63 - 1)
    return text.split("\n"), f"{result}.ok"


def divided(result: str, operands: Sequence[str], answer: str, flags: str) -> list[str]:
    """The lines of a division by a guarded divisor: the result of the guard's test is applied after the division."""
    return _DIVIDED.format(*operands, answer, r=result, f=flags, nan=bits(math.nan)).split("\n")


def masked_store(name: str, lanes: Lanes, value: str, address: str, mask: str) -> list[str]:
    """The lines that store a vector in the lanes of a mask, or in all if it is ""; temporaries begin with `name`."""
    kind = lanes.double
    if not mask:
        return [f"  store {kind} {value}, ptr {address}, align 8"]
    # `volatile` prevents one masked store, from which a subsequent load could not be forwarded
    return [
        f"  {name}.old = load volatile {kind}, ptr {address}, align 8",
        f"  {name}.new = select {lanes.of('i1')} {mask}, {kind} {value}, {kind} {name}.old",
        f"  store {kind} {name}.new, ptr {address}, align 8",
    ]


@cache
def _fields(type_: Type, made: Type) -> dict[str, object]:
    """The fields of a form: LLVM types and vector constants."""
    lanes = Lanes(type_.width)
    numbers = {name: lanes.number(value) for name, value in _NUMBERS.items()}
    types = {"t": typed(type_), "v": typed(made), "b": lanes.of("i1"), "true": lanes.all("i1", "true")}
    return {**numbers, **types, "width": made.width, "lanes": lanes.width}


REACH = 16
"""The number of doubles before a pointer, and from it on, that a one-byte offset reaches."""
_MOST = 8
"""The maximum number of pointers of a piece: about as many as there are registers for arguments."""
_WORTH = 6
"""The minimum number of accesses that justifies another pointer."""


@dataclass(frozen=True, slots=True)
class Near:
    """Pointers into a vector: their ascending indices `places`, and for each but the last the `last` index to which it is nearest."""

    places: tuple[int, ...]
    last: tuple[int, ...]

    def nearest(self, place: int) -> tuple[int, int]:
        """The pointer nearest to an index, and the offset from it."""
        k = bisect_left(self.last, place)
        return k, place - self.places[k]


def pointed(body: Iterable[Statement]) -> dict[str, Near]:
    """For each vector that statements access, the indices at which pointers shorten the most instructions."""
    used: dict[str, Counter[int]] = {}
    for s in body:
        if isinstance(s, Read | Write) and isinstance(s.offset, int):
            used.setdefault(s.base, Counter())[s.offset] += 1
    chosen: dict[str, list[int]] = {base: [] for base in used}
    best = {base: _window(count) for base, count in used.items()}
    while best:
        # the first pointer of each vector is required
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
    """The start of the range of one pointer with the most accesses, and their number."""
    places: Sequence[int] = sorted(count)
    total = [0]
    for place in places:
        total.append(total[-1] + count[place])
    ends = [bisect_right(places, place + 2 * REACH - 1) for place in places]
    saved, k = max((total[end] - total[k], -k) for k, end in enumerate(ends))
    return places[-k], saved


_SHORT = 600
"""The number of statements up to which latency, not instruction fetch, limits a piece."""
FEW = (
    "!0 = distinct !{!0, !1, !2}",
    '!1 = !{!"llvm.loop.unroll.disable"}',
    '!2 = !{!"llvm.loop.vectorize.enable", i1 false}',
)
"""Loop metadata for loops known to be short: LLVM shall neither unroll nor vectorize them."""


def vector(base: str) -> str:
    """The name of the pointer to a vector, with a prefix that no other value has."""
    return f"%{walk.VECTORS[base]}" if base in walk.VECTORS else f"%in.{base}"


class Calls:
    """Functions to declare, and the widths of the vectors of sines in use."""

    __slots__ = ("declared", "sines")

    def __init__(self) -> None:
        self.declared: set[str] = set()
        self.sines: set[int] = set()

    def declare(self, function: str, kind: str, arity: int) -> None:
        """Declares a function of `arity` arguments of one kind."""
        self.declared.add(f"declare {kind} @{function}({', '.join([kind] * arity)})")


class _Names(dict[language.Operand, str]):
    """Names of values: literals of constants, `common` names, and numbered names of the others."""

    def __init__(self, common: Mapping[int, str]) -> None:
        super().__init__()
        self.common = common

    def __missing__(self, value: language.Operand) -> str:
        if isinstance(value, int):
            return self.common[value]
        if not isinstance(value, language.Immediate):
            return f"%v{value}"
        if isinstance(value.value, tuple):
            return Lanes(len(value.value)).numbers(value.value)
        return bits(float(value.value)) if value.type.kind == "float" else str(value.value)


class LlvmPrinter(Printer):
    """Prints the lines of one function, or of a piece of it."""

    def __init__(
        self,
        calls: Calls,
        flags: str,
        common: Mapping[int, str] | None = None,
        width: int = 1,
        shared: Collection[str] = (),
        near: Mapping[str, Near] | None = None,
        masked: str = "",
    ) -> None:
        super().__init__()
        self.masked = masked
        self.calls, self.flags, self.shared, self.near = calls, flags, shared, near or {}
        self.type, self.lanes = language.Type("float", width), Lanes(width)
        self.kind = self.lanes.double
        self.names = _Names(common or {})
        self.volatile: set[int] = set()
        self.late: set[language.Operand] = set()
        self.answers: dict[language.Operand, str] = {}

    def body(self, body: Sequence[language.Statement]) -> list[str]:
        """The lines of a piece of a Program."""
        if self.lanes.width == 1:
            # Otherwise LLVM would load neighbours as one vector, which stalls if they have just been stored one by one.
            self.volatile = {a for s in body if isinstance(s, language.SinCos) for a in s.angles}
            # The guard is tested while the division runs. In long code latency is hidden, and registers are scarce.
            self.late = _divisors(body) if len(body) <= _SHORT else set()
        self.block(body)
        return self.lines

    def add(self, *lines: str) -> None:
        """Adds lines to the body, indented, as labels are not."""
        self.lines += [f"  {line}" for line in lines]

    def typed(self, operand: language.Operand) -> str:
        """An operand preceded by its type."""
        return f"{typed(language.type_of(operand))} {self.names[operand]}"

    # --------------------------------------------------------------------------------------------------- arithmetic

    def compute(self, s: language.Compute) -> None:
        """Adds an operation."""
        value, op, arguments = s.value, s.op, s.arguments
        operands = [self.names[a] for a in arguments]
        name = self.names[value] = f"%v{value}"
        if type(value) is not int:
            self.operation(name, op, operands, language.type_of(arguments[0]), language.type_of(value), s.lane)
        elif value in self.late:
            texts, self.answers[value] = guard(name, operands)
            self.names[value] = operands[0]
            self.add(*texts)
        elif op is DIV and arguments[1] in self.answers:
            self.add(*divided(name, operands, self.answers[arguments[1]], self.flags))
        else:
            self.operation(name, op, operands, self.type, self.type)

    def operation(
        self, name: str, op: Op | str, operands: Sequence[str], type_: language.Type, made: language.Type, lane: int = 0
    ) -> None:
        """Adds an operation of the tables; `type_` is the type of the first operand, `made` that of the result."""
        word = BINARY.get(op) if type_.kind == "float" else None
        if word:  # fast path for most operations
            kind = self.kind if type_ is self.type else typed(type_)
            self.lines.append(f"  {name} = {word} {self.flags}{kind} {operands[0]}, {operands[1]}")
        elif op in CALLS:
            self.call_function(name, CALLS[op], operands, Lanes(type_.width))
        elif op == "sum" or op == "largest":
            self.fold(name, "add" if op == "sum" else "max", operands[0], type_.width)
        else:
            self.lines += [f"  {line}" for line in lines(op, name, operands, self.flags, type_, made, lane)]

    def call_function(self, name: str, function: str, operands: Sequence[str], lanes: Lanes) -> None:
        """Adds a call of an LLVM intrinsic, or of a library function lane by lane."""
        own = function.startswith("llvm.")
        function, kind = f"{function}.{lanes.suffix}" if own else function, lanes.double
        if own or lanes.width == 1:
            self.calls.declare(function, kind, len(operands))
            self.add(f"{name} = call {kind} @{function}({', '.join(f'{kind} {o}' for o in operands)})")
            return
        self.calls.declare(function, "double", len(operands))
        for k in range(lanes.width):
            for j, operand in enumerate(operands):
                self.add(f"{name}.{k}.{j} = extractelement {kind} {operand}, i32 {k}")
            given = ", ".join(f"double {name}.{k}.{j}" for j in range(len(operands)))
            self.add(f"{name}.of{k} = call double @{function}({given})")
        self.gather(name, [f"{name}.of{k}" for k in range(lanes.width)], lanes)

    def fold(self, name: str, op: str, operand: str, width: int) -> None:
        """Adds a reduction of a vector by repeated halving."""
        while width > 1:
            half, kind = width // 2, Lanes(width).double
            parts = [f"{name}.{part}{half}" for part in ("low", "high")]
            for part, first in zip(parts, (0, half), strict=True):
                mask = ", ".join(f"i32 {first + j}" for j in range(half))
                self.add(f"{part} = shufflevector {kind} {operand}, {kind} poison, <{half} x i32> <{mask}>")
                if half == 1:
                    self.add(f"{part}.s = extractelement <1 x double> {part}, i32 0")
            folded = language.Type("float", half)
            operand = name if half == 1 else f"{name}.{half}"
            self.operation(operand, op, [f"{part}{'.s' * (half == 1)}" for part in parts], folded, folded)
            width = half

    def splat(self, name: str, number: str, lanes: Lanes) -> None:
        """Adds a vector with one double in every lane."""
        self.add(*lines("splat", name, [number], "", language.FLOAT, language.Type("float", lanes.width)))

    def gather(self, name: str, numbers: Sequence[str], lanes: Lanes) -> None:
        """Adds a vector of given doubles; the last is repeated in lanes beyond them."""
        before = "poison"
        for k in range(lanes.width):
            number, made = numbers[min(k, len(numbers) - 1)], name if k == lanes.width - 1 else f"{name}.{k}"
            self.add(f"{made} = insertelement {lanes.double} {before}, double {number}, i32 {k}")
            before = made

    def sines(self, name: str, angles: str, lanes: Lanes) -> None:
        """Adds `name`.sin and `name`.cos of a vector of angles."""
        pair = f"{{{lanes.double}, {lanes.double}}}"
        self.calls.sines.add(lanes.width)
        self.add(f"{name} = call {pair} @kane.sincos.{lanes.width}({lanes.double} {angles})")
        self.add(*(f"{name}.{op.name} = extractvalue {pair} {name}, {k}" for k, op in enumerate((SIN, COS))))

    def sincos(self, s: language.SinCos) -> None:
        """Adds sines and cosines of angles, in a vector of sufficient width."""
        label, count = f"%p{len(self.lines)}", len(s.angles)
        lanes = self.lanes if count == 1 else Lanes(1 << (count - 1).bit_length())
        angles = self.names[s.angles[0]]
        if count > 1:
            angles = f"{label}.angles"
            self.gather(angles, [self.names[a] for a in s.angles], lanes)
        self.sines(label, angles, lanes)
        for k, own in enumerate(s.values):
            for op, i in own.items():
                self.names[i] = f"{label}.{op.name}"
                if count > 1:
                    self.names[i] = f"%v{i}"
                    self.add(f"%v{i} = extractelement {lanes.double} {label}.{op.name}, i32 {k}")

    # ------------------------------------------------------------------------------------------------------- memory

    def address(self, s: language.Read | language.Write | language.Address) -> str:
        """The name of an address; adds the line that computes it."""
        offset, inbounds, base = s.offset, " inbounds", vector(s.base)
        if isinstance(offset, int):
            if s.base in self.near:  # the index relative to a pointer may be negative
                k, offset = self.near[s.base].nearest(offset)
                base, inbounds = f"{base}.{k}", ""
            elif s.base not in self.shared:
                offset *= self.lanes.width
        index = offset if isinstance(offset, int) else self.names[offset]
        name = f"%a{len(self.lines)}"
        self.lines.append(f"  {name} = getelementptr{inbounds} double, ptr {base}, i64 {index}")
        return name

    def load(self, s: language.Read) -> None:
        """Adds a load."""
        address, name = self.address(s), f"%v{s.value}"
        self.names[s.value] = name
        if type(s.value) is not int:
            self.add(f"{name} = load {typed(language.type_of(s.value))}, ptr {address}, align 8")
        elif s.base in self.shared and self.lanes.width > 1:
            self.add(f"{name}.shared = load double, ptr {address}, align 8")
            self.splat(name, f"{name}.shared", self.lanes)
        else:
            volatile = " volatile" if s.value in self.volatile else ""
            self.lines.append(f"  {name} = load{volatile} {self.kind}, ptr {address}, align 8")

    def store(self, s: language.Write) -> None:
        """Adds a store."""
        address = self.address(s)
        kind = self.kind if isinstance(s.value, int) else typed(language.type_of(s.value))
        value = self.names[s.value]
        if s.base == self.masked:
            self.lines += masked_store(address, self.lanes, value, address, "%lanes")
        else:
            self.lines.append(f"  store {kind} {value}, ptr {address}, align 8")

    def get(self, s: language.Get) -> None:
        """Adds a read of a cell."""
        self.add(f"%v{s.value} = load {typed(s.value.type)}, ptr %cell.{s.cell.name}")

    def put(self, s: language.Put) -> None:
        """Adds an assignment to a cell."""
        self.add(f"store {self.typed(s.value)}, ptr %cell.{s.cell.name}")

    # ------------------------------------------------------------------------------------------------------ control

    def call(self, s: language.CallRoutine) -> None:
        """Adds a call of a routine among the kernel's arguments."""
        given = [f"ptr {self.address(a)}" if isinstance(a, language.Address) else self.typed(a) for a in s.arguments]
        self.add(f"call void %{s.callee.name}({', '.join(given)})")

    def labels(self, *names: str) -> list[str]:
        """Unique labels."""
        return [f"{name}{len(self.lines)}" for name in names]

    def choice(self, s: language.If) -> None:
        """Adds an if statement."""
        then, other, end = self.labels("then", "other", "end")
        self.add(f"br i1 {self.names[s.condition]}, label %{then}, label %{other}")
        for label, block in ((then, s.then), (other, s.other)):
            self.labelled(label, block)
            self.add(f"br label %{end}")
        self.labelled(end)

    def labelled(self, label: str, block: language.Block = ()) -> None:
        """Adds a labelled block."""
        self.lines.append(f"{label}:")
        self.block(block)

    def loop(self, s: language.While) -> None:
        """Adds a while loop."""
        head, body, end = self.labels("head", "body", "end")
        self.add(f"br label %{head}")
        self.labelled(head, s.head)
        self.add(f"br i1 {self.names[s.condition]}, label %{body}, label %{end}")
        self.labelled(body, s.body)
        self.add(f"br label %{head}")
        self.labelled(end)

    def count(self, s: language.For) -> None:
        """Adds a for loop, whose end is tested before the first turn and after each: it is one block shorter a turn."""
        before, body, last, end, more, on = self.labels("before", "body", "last", "end", "next", "on")
        index, start, stop = (self.names[x] for x in (s.counter, s.start, s.stop))
        self.add(f"%{on}.0 = icmp slt i64 {start}, {stop}", f"br i1 %{on}.0, label %{before}, label %{end}")
        self.labelled(before)
        self.add(f"br label %{body}")
        self.labelled(body)
        self.add(f"{index} = phi i64 [ {start}, %{before} ], [ %{more}, %{last} ]")
        self.block(s.body)
        self.add(f"br label %{last}")
        self.labelled(last)
        self.add(
            f"%{more} = add i64 {index}, 1",
            f"%{on} = icmp slt i64 %{more}, {stop}",
            f"br i1 %{on}, label %{body}, label %{end}{', !llvm.loop !0' * s.few}",
        )
        self.labelled(end)


def _divisors(body: Sequence[language.Statement]) -> set[language.Operand]:
    """The guarded values that are used only as divisors."""
    guarded: set[language.Operand] = {s.value for s in body if isinstance(s, language.Compute) and s.op is REGULAR}
    for s in body if guarded else ():
        if isinstance(s, language.Compute):
            guarded.difference_update(s.arguments[:1] if s.op is DIV else s.arguments)
        elif isinstance(s, language.Write):
            guarded.discard(s.value)
    return guarded
