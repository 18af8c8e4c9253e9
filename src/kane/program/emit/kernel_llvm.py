# SPDX-License-Identifier: BSD-3-Clause
"""Kernels as LLVM text: values in registers, cells on the stack, from where LLVM's own passes lift them."""

from collections.abc import Sequence
from functools import singledispatchmethod

from kane.program.emit.llvm_lanes import Lanes, bits
from kane.program.kernel.language import (
    Argument,
    ArrayOf,
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
    While,
)

_LLVM = {"float": "double", "int": "i64", "bool": "i1"}
_FLOATS = {
    "add": "{r} = fadd {f}{t} {0}, {1}",
    "sub": "{r} = fsub {f}{t} {0}, {1}",
    "mul": "{r} = fmul {f}{t} {0}, {1}",
    "div": "{r} = fdiv {t} {0}, {1}",
    "neg": "{r} = fneg {t} {0}",
    "sqrt": "{r} = call {t} @llvm.sqrt.{s}({t} {0})",
    "abs": "{r} = call {t} @llvm.fabs.{s}({t} {0})",
    "less": "{r} = fcmp olt {t} {0}, {1}",
    "at_most": "{r} = fcmp ole {t} {0}, {1}",
    "int": "{r} = fptosi {t} {0} to i64",
    "lane": "{r} = extractelement {t} {0}, i32 {lane}",
}
_ORDERED = (
    "{r}.a = fcmp %s {t} {0}, {1}\n{r}.b = fcmp uno {t} {0}, {0}\n"
    "{r}.c = or {b} {r}.a, {r}.b\n{r} = select {b} {r}.c, {t} {0}, {t} {1}"
)
_FLOATS |= {"min": _ORDERED % "olt", "max": _ORDERED % "ogt"}
_INTS = {
    "add": "{r} = add i64 {0}, {1}",
    "sub": "{r} = sub i64 {0}, {1}",
    "mul": "{r} = mul i64 {0}, {1}",
    "less": "{r} = icmp slt i64 {0}, {1}",
    "at_most": "{r} = icmp sle i64 {0}, {1}",
    "float": "{r} = sitofp i64 {0} to double",
}
_BOOLS = {
    "and": "{r} = and {t} {0}, {1}",
    "or": "{r} = or {t} {0}, {1}",
    "not": "{r} = xor {t} {0}, {ones}",
}
_FEW = (
    "!0 = distinct !{!0, !1, !2}",
    '!1 = !{!"llvm.loop.unroll.disable"}',
    '!2 = !{!"llvm.loop.vectorize.enable", i1 false}',
)
"""What is said of loops that are known to be short: copies and lanes would be compiled for nothing."""
_FORMS = {"float": _FLOATS, "int": _INTS, "bool": _BOOLS}
"""By the kind of the first operand: the lines for the result {r} of {0}, {1}, …; {t} is their type, {f} flags of contraction."""


def emit_kernel_llvm(kernel: Kernel, contract: bool = True) -> str:
    """The text of a module with the one function `i64 @<name>(arguments)`; addresses of arrays and routines are pointers."""
    writer = _Writer("contract " if contract else "")
    cells = [f"  %cell.{c.name} = alloca {_type(c.type)}" for c in kernel.cells]
    zeros = [f"  store {_type(c.type)} zeroinitializer, ptr %cell.{c.name}" for c in kernel.cells]
    writer.block(kernel.body)
    arguments = ", ".join(map(_argument, kernel.arguments))
    head = f"define i64 @{kernel.name}({arguments}) nounwind {{"
    back = [f"  %result = load i64, ptr %cell.{kernel.result.name}", "  ret i64 %result", "}"]
    return "\n".join([*sorted(writer.declared), head, *cells, *zeros, *writer.lines, *back, *_FEW, ""])


def _argument(a: Argument) -> str:
    if isinstance(a, Number):
        return f"i64 {_name(a.value)}"
    return f"ptr {'noalias ' * isinstance(a, ArrayOf)}%{a.name}"


def _type(type_: Type) -> str:
    return Lanes(type_.width).of(_LLVM[type_.kind])


def _name(operand: Operand) -> str:
    if not isinstance(operand, Constant):
        return f"%v{operand.number}"
    value = operand.value
    if isinstance(value, tuple):
        return f"<{', '.join(f'double {bits(v)}' for v in value)}>"
    return bits(float(value)) if operand.type.kind == "float" else str(value)


def _typed(operand: Operand) -> str:
    return f"{_type(operand.type)} {_name(operand)}"


class _Writer:
    """The lines so far, what they call, and how many labels and helping names there are."""

    def __init__(self, flags: str) -> None:
        self.flags = flags
        self.lines: list[str] = []
        self.declared: set[str] = set()
        self.labels = 0

    def block(self, block: Block) -> None:
        """The statements in order."""
        for s in block:
            self.write(s)

    def fresh(self) -> int:
        """A number that no label or helping name has."""
        self.labels += 1
        return self.labels

    def add(self, *lines: str) -> None:
        """Lines of the function's body."""
        self.lines += [f"  {line}" for line in lines]

    def address(self, place: Place) -> str:
        """The name of a place's address, after the line that computes it."""
        name = f"%at{self.fresh()}"
        self.add(f"{name} = getelementptr inbounds double, ptr %{place.array.name}, i64 {_name(place.index)}")
        return name

    @singledispatchmethod
    def write(self, s: Statement) -> None:
        """The lines of one statement."""
        raise NotImplementedError(type(s))

    @write.register
    def _(self, s: Compute) -> None:
        result = _name(s.value)
        if s.op == "select":
            self.add(f"{result} = select {', '.join(map(_typed, s.arguments))}")
        elif s.op in ("sum", "largest"):
            self.fold(result, s.arguments[0], "add" if s.op == "sum" else "max")
        elif s.op.startswith("splat"):
            one, wide = f"%one{self.fresh()}", _type(s.value.type)
            self.add(f"{one} = insertelement {wide} poison, {_typed(s.arguments[0])}, i32 0")
            mask = f"<{s.value.type.width} x i32> zeroinitializer"
            self.add(f"{result} = shufflevector {wide} {one}, {wide} poison, {mask}")
        elif s.op == "any":
            width, packed = s.arguments[0].type.width, f"%bits{self.fresh()}"
            self.add(f"{packed} = bitcast {_typed(s.arguments[0])} to i{width}")
            self.add(f"{result} = icmp ne i{width} {packed}, 0")
        else:
            self.form(result, s.op, s.arguments[0].type, [_name(a) for a in s.arguments], s.lane)

    def form(self, result: str, op: str, type_: Type, names: Sequence[str], lane: int = 0) -> None:
        """An operation of the tables, on operands of one type."""
        lanes, text = Lanes(type_.width), _type(type_)
        if op in ("sqrt", "abs"):
            intrinsic = f"llvm.{'sqrt' if op == 'sqrt' else 'fabs'}.{lanes.suffix}"
            self.declared.add(f"declare {text} @{intrinsic}({text})")
        fields = {"r": result, "t": text, "s": lanes.suffix, "b": lanes.of("i1"), "lane": lane, "f": self.flags}
        ones = lanes.all("i1", "true")
        self.add(*_FORMS[type_.kind][op].format(*names, **fields, ones=ones).split("\n"))

    def fold(self, result: str, operand: Operand, op: str) -> None:
        """The halves of a vector combined, until one number is left."""
        name, width = _name(operand), operand.type.width
        while width > 1:
            half, k = width // 2, self.fresh()
            wide, narrow = Lanes(width).double, Type("float", half)
            for part, first in (("low", 0), ("high", half)):
                mask = ", ".join(f"i32 {first + j}" for j in range(half))
                self.add(f"%{part}{k} = shufflevector {wide} {name}, {wide} poison, <{half} x i32> <{mask}>")
                if half == 1:
                    self.add(f"%{part}{k}.s = extractelement <1 x double> %{part}{k}, i32 0")
            names = [f"%{part}{k}{'.s' * (half == 1)}" for part in ("low", "high")]
            folded = result if half == 1 else f"%fold{k}"
            self.form(folded, op, narrow, names)
            name, width = folded, half

    @write.register
    def _(self, s: Load) -> None:
        self.add(f"{_name(s.value)} = load {_type(s.value.type)}, ptr {self.address(s.place)}, align 8")

    @write.register
    def _(self, s: Store) -> None:
        self.add(f"store {_typed(s.value)}, ptr {self.address(s.place)}, align 8")

    @write.register
    def _(self, s: Get) -> None:
        self.add(f"{_name(s.value)} = load {_type(s.value.type)}, ptr %cell.{s.cell.name}")

    @write.register
    def _(self, s: Put) -> None:
        self.add(f"store {_typed(s.value)}, ptr %cell.{s.cell.name}")

    @write.register
    def _(self, s: Call) -> None:
        given = [f"ptr {self.address(a)}" if isinstance(a, Place) else _typed(a) for a in s.arguments]
        self.add(f"call void %{s.callee.name}({', '.join(given)})")

    @write.register
    def _(self, s: If) -> None:
        k = self.fresh()
        self.add(f"br i1 {_name(s.condition)}, label %then{k}, label %other{k}")
        for label, block in (("then", s.then), ("other", s.other)):
            self.lines.append(f"{label}{k}:")
            self.block(block)
            self.add(f"br label %end{k}")
        self.lines.append(f"end{k}:")

    @write.register
    def _(self, s: While) -> None:
        k = self.fresh()
        self.add(f"br label %head{k}")
        self.lines.append(f"head{k}:")
        self.block(s.head)
        self.add(f"br i1 {_name(s.condition)}, label %body{k}, label %end{k}")
        self.lines.append(f"body{k}:")
        self.block(s.body)
        self.add(f"br label %head{k}")
        self.lines.append(f"end{k}:")

    @write.register
    def _(self, s: Count) -> None:
        k, index = self.fresh(), _name(s.index)
        self.add(f"br label %before{k}")
        self.lines.append(f"before{k}:")
        self.add(f"br label %head{k}")
        self.lines.append(f"head{k}:")
        self.add(f"{index} = phi i64 [ {_name(s.start)}, %before{k} ], [ %next{k}, %last{k} ]")
        self.add(f"%on{k} = icmp slt i64 {index}, {_name(s.stop)}")
        self.add(f"br i1 %on{k}, label %body{k}, label %end{k}")
        self.lines.append(f"body{k}:")
        self.block(s.body)
        self.add(f"br label %last{k}")
        self.lines.append(f"last{k}:")
        self.add(f"%next{k} = add i64 {index}, 1", f"br label %head{k}{', !llvm.loop !0' * s.few}")
        self.lines.append(f"end{k}:")
