# SPDX-License-Identifier: BSD-3-Clause
"""Kernels as functions of C99: values side by side are arrays, and an operation on them a loop over the lanes."""

from collections.abc import Sequence
from functools import singledispatchmethod

from kane.program.emit.names import decimal
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
    Value,
    While,
)

_C = {"float": "double", "int": "int64_t", "bool": "int"}
_FORMS = {
    "add": "{0} + {1}",
    "sub": "{0} - {1}",
    "mul": "{0} * {1}",
    "div": "{0} / {1}",
    "neg": "-{0}",
    "sqrt": "sqrt({0})",
    "abs": "fabs({0})",
    "min": "{0} < {1} || {0} != {0} ? {0} : {1}",
    "max": "{0} > {1} || {0} != {0} ? {0} : {1}",
    "less": "{0} < {1}",
    "at_most": "{0} <= {1}",
    "and": "{0} & {1}",
    "or": "{0} | {1}",
    "not": "!{0}",
    "select": "{0} ? {1} : {2}",
    "float": "(double){0}",
    "int": "(int64_t){0}",
    "splat4": "{0}",
    "splat8": "{0}",
}
"""An operation of {0}, {1}, …, in each lane."""
_FOLDS = {"sum": "add", "largest": "max"}


def emit_kernel_c(kernel: Kernel) -> str:
    """The text of the function `int64_t <name>(arguments)`; it needs <math.h> and <stdint.h>."""
    writer = _Writer()
    for c in kernel.cells:
        writer.add(f"{_C[c.type.kind]} cell_{c.name}{_extent(c.type)} = {'{0}' if c.type.width > 1 else '0'};")
    writer.block(kernel.body)
    arguments = ", ".join(map(_argument, kernel.arguments))
    unused = [f"    (void){a.name};" for a in kernel.arguments if not isinstance(a, Number)]
    unused += [f"    (void)v{a.value.number};" for a in kernel.arguments if isinstance(a, Number)]
    back = f"    return cell_{kernel.result.name};"
    return "\n".join([f"int64_t {kernel.name}({arguments})", "{", *unused, *writer.lines, back, "}", ""])


def _argument(a: Argument) -> str:
    if isinstance(a, Number):
        return f"int64_t v{a.value.number}"
    if isinstance(a, ArrayOf):
        return f"double *restrict {a.name}"
    return f"void (*{a.name})({', '.join('double' if t == 'float' else 'double *' for t in a.takes)})"


def _extent(type_: Type) -> str:
    return f"[{type_.width}]" if type_.width > 1 else ""


def _text(operand: Operand, lane: str = "") -> str:
    """A scalar operand, or the lane of another one."""
    if not isinstance(operand, Constant):
        return f"v{operand.number}{f'[{lane}]' * (operand.type.width > 1)}"
    if isinstance(operand.value, tuple):
        numbers = ", ".join(decimal(v, "NAN", "INFINITY") for v in operand.value)
        return f"((const double[]){{{numbers}}})[{lane}]"
    if operand.type.kind == "int":
        return f"INT64_C({operand.value})" if operand.value >= 0 else f"(-INT64_C({-operand.value}))"
    return decimal(float(operand.value), "(double)NAN", "(double)INFINITY")


class _Writer:
    """The lines so far; `depth` is that of the blocks."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.depth = 1
        self.folds = 0

    def add(self, *lines: str) -> None:
        """Lines of the block at hand."""
        self.lines += [f"{'    ' * self.depth}{line}" for line in lines]

    def block(self, block: Block) -> None:
        """The statements in order."""
        for s in block:
            self.write(s)

    def within(self, head: str, block: Block) -> None:
        """A block in braces."""
        self.add(f"{head} {{")
        self.depth += 1
        self.block(block)
        self.depth -= 1
        self.add("}")

    def define(self, value: Value, text: str) -> None:
        """A value, of a text that holds the lane k where it has several."""
        kind = _C[value.type.kind]
        if value.type.width == 1:
            self.add(f"const {kind} v{value.number} = {text};")
        else:
            self.add(
                f"{kind} v{value.number}[{value.type.width}];", f"{_each(value.type)} v{value.number}[k] = {text};"
            )

    def place(self, place: Place, lane: str = "0") -> str:
        """What stands at a place."""
        more = "" if lane == "0" else f" + {lane}"
        return f"{place.array.name}[{_text(place.index)}{more}]"

    @singledispatchmethod
    def write(self, s: Statement) -> None:
        """The lines of one statement."""
        raise NotImplementedError(type(s))

    @write.register
    def _(self, s: Compute) -> None:
        if s.op in _FOLDS:
            self.define(s.value, self.fold(_FOLDS[s.op], s.arguments[0]))
        elif s.op == "any":
            lanes = range(s.arguments[0].type.width)
            self.define(s.value, " | ".join(_text(s.arguments[0], str(k)) for k in lanes))
        else:
            lane = str(s.lane) if s.op == "lane" else "k"
            self.define(s.value, _FORMS.get(s.op, "{0}").format(*(_text(a, lane) for a in s.arguments)))

    def fold(self, op: str, operand: Operand) -> str:
        """The halves combined, in names of their own."""
        names: Sequence[str] = [_text(operand, str(k)) for k in range(operand.type.width)]
        self.folds += 1
        while len(names) > 1:
            half = len(names) // 2
            pairs = list(zip(names[:half], names[half:], strict=True))
            names = [f"f{self.folds}_{half}_{k}" for k in range(half)]
            self.add(*(f"const double {n} = {_FORMS[op].format(*pair)};" for n, pair in zip(names, pairs, strict=True)))
        return names[0]

    @write.register
    def _(self, s: Load) -> None:
        self.define(s.value, self.place(s.place, "k" if s.value.type.width > 1 else "0"))

    @write.register
    def _(self, s: Store) -> None:
        if s.value.type.width == 1:
            self.add(f"{self.place(s.place)} = {_text(s.value)};")
        else:
            self.add(f"{_each(s.value.type)} {self.place(s.place, 'k')} = {_text(s.value, 'k')};")

    @write.register
    def _(self, s: Get) -> None:
        self.define(s.value, f"cell_{s.cell.name}{'[k]' * (s.cell.type.width > 1)}")

    @write.register
    def _(self, s: Put) -> None:
        if s.cell.type.width == 1:
            self.add(f"cell_{s.cell.name} = {_text(s.value)};")
        else:
            self.add(f"{_each(s.cell.type)} cell_{s.cell.name}[k] = {_text(s.value, 'k')};")

    @write.register
    def _(self, s: Call) -> None:
        given = [f"&{self.place(a)}" if isinstance(a, Place) else _text(a) for a in s.arguments]
        self.add(f"{s.callee.name}({', '.join(given)});")

    @write.register
    def _(self, s: If) -> None:
        self.within(f"if ({_text(s.condition)})", s.then)
        if s.other:
            self.within("else", s.other)

    @write.register
    def _(self, s: While) -> None:
        self.add("for (;;) {")
        self.depth += 1
        self.block(s.head)
        self.add(f"if (!{_text(s.condition)}) break;")
        self.block(s.body)
        self.depth -= 1
        self.add("}")

    @write.register
    def _(self, s: Count) -> None:
        index = f"v{s.index.number}"
        head = f"for (int64_t {index} = {_text(s.start)}; {index} < {_text(s.stop)}; {index}++)"
        self.within(head, s.body)


def _each(type_: Type) -> str:
    return f"for (int k = 0; k < {type_.width}; k++)"
