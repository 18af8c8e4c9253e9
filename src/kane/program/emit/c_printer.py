# SPDX-License-Identifier: BSD-3-Clause
"""Statements as lines of C99, one operation each; values side by side are arrays, and an operation on them a loop over the lanes."""

from collections.abc import Mapping, Sequence

from kane.expr import ops
from kane.expr.ops import COS, OPS, SIN, Op
from kane.program.emit.names import ARITHMETIC, c_comment, decimal
from kane.program.emit.walk import NamedPrinter, shared
from kane.program.kernel import language

KINDS = {"float": "double", "int": "int64_t", "bool": "bool"}
"""Types of C by the kinds of values."""
_FORMS: Mapping[Op | str, str] = {
    **shared(ARITHMETIC),
    **shared({n: f"{f}({{0}})" for n, f in (("sqrt", "sqrt"), ("abs", "fabs"))}),
    **shared({n: f"(({{0}} {s} {{1}}) || ({{0}} != {{0}})) ? {{0}} : {{1}}" for n, s in (("min", "<"), ("max", ">"))}),
    "less": "{0} < {1}",
    "at_most": "{0} <= {1}",
    "and": "{0} && {1}",
    "or": "{0} || {1}",
    "not": "!{0}",
    "select": "{0} ? {1} : {2}",
    "float": "(double){0}",
    "int": "(int64_t){0}",
    **{OPS[n]: f"{n}({{0}})" for n in ("tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "floor")},
    **{OPS[n]: f"{n}({{0}}, {{1}})" for n in ("pow", "atan2")},
    OPS["less"]: "({0} < {1}) ? 1.0 : 0.0",
    OPS["sign"]: "({0} != {0}) ? {0} : (({0} > 0.0) ? 1.0 : (({0} < 0.0) ? -1.0 : 0.0))",
    ops.WHERE: "({0} != 0.0) ? {1} : {2}",
    ops.REGULAR: f"(fabs({{0}}) > ({ops.GONE!r} * {{1}})) ? {{0}} : (double)NAN",
}
"""An operation of {0}, {1}, …, in each lane; what is not here takes its operand as it is. Sines and cosines are ours."""
_FOLDS = {"sum": "add", "largest": "max"}


def extent(type_: language.Type) -> str:
    """What follows the name of a variable in its declaration."""
    return f"[{type_.width}]" if type_.width > 1 else ""


def each(type_: language.Type, statement: str) -> str:
    """A statement for each lane k."""
    return f"for (int k = 0; k < {type_.width}; k++) {{ {statement} }}" if type_.width > 1 else statement


class CPrinter(NamedPrinter):
    """The lines of one function; `helpers` are the functions of angles that it calls."""

    def __init__(self, names: Mapping[int, str] | None = None, vectors: Mapping[str, str] | None = None) -> None:
        super().__init__(1, names, vectors)
        self.folds = 0
        self.helpers: set[str] = set()

    def text(self, operand: language.Operand, lane: str = "k") -> str:
        """A scalar operand, or the lane of another one."""
        if isinstance(operand, int):
            return self.names[operand]
        if not isinstance(operand, language.Immediate):
            return f"v{operand}{f'[{lane}]' * (operand.type.width > 1)}"
        if isinstance(operand.value, tuple):
            numbers = ", ".join(decimal(v, "NAN", "INFINITY") for v in operand.value)
            return f"((const double[]){{{numbers}}})[{lane}]"
        if operand.type.kind == "int":
            return f"INT64_C({operand.value})" if operand.value >= 0 else f"(-INT64_C({-operand.value}))"
        return decimal(float(operand.value), "(double)NAN", "(double)INFINITY")

    def define(self, value: language.Operand, text: str) -> None:
        """A value, of a text that holds the lane k where it has several."""
        type_, name = language.type_of(value), self.text(value)
        if type_.width == 1:
            self.add(f"const {KINDS[type_.kind]} {name} = {text};")
        else:
            self.add(f"{KINDS[type_.kind]} v{value}{extent(type_)};", each(type_, f"{name} = {text};"))

    def at(self, s: language.Address | language.Read | language.Write, type_: language.Type) -> str:
        """A number of an array, or the lane k of several."""
        index = str(s.offset) if isinstance(s.offset, int) else self.text(s.offset)
        return f"{self.vectors.get(s.base, s.base)}[{index}{' + k' * (type_.width > 1)}]"

    def compute(self, s: language.Compute) -> None:
        """An operation, in each lane."""
        op, first = s.op, s.arguments[0]
        if op in _FOLDS:
            self.define(s.value, self.fold(_FORMS[_FOLDS[str(op)]], first))
        elif op == "any":
            self.define(s.value, " || ".join(self.text(first, str(k)) for k in range(language.type_of(first).width)))
        else:
            lane = str(s.lane) if op == "lane" else "k"
            self.define(s.value, _FORMS.get(op, "{0}").format(*(self.text(a, lane) for a in s.arguments)))

    def fold(self, form: str, operand: language.Operand) -> str:
        """The halves combined, in names of their own."""
        names: Sequence[str] = [self.text(operand, str(k)) for k in range(language.type_of(operand).width)]
        self.folds += 1
        while len(names) > 1:
            half = len(names) // 2
            pairs = list(zip(names[:half], names[half:], strict=True))
            names = [f"f{self.folds}_{half}_{k}" for k in range(half)]
            self.add(*(f"const double {n} = {form.format(*pair)};" for n, pair in zip(names, pairs, strict=True)))
        return names[0]

    def sincos(self, s: language.SinCos) -> None:
        """Sine, cosine or both of one angle."""
        ((angle,), (own,)) = s.angles, s.values
        names = {op.name: self.names[i] for op, i in own.items()}
        if len(names) == 1:
            ((function, name),) = names.items()
            self.add(f"const double {name} = kane_{function}({self.names[angle]});")
        else:
            function, (sine, cosine) = "sincos", (names[op.name] for op in (SIN, COS))
            self.add(f"double {sine};", f"double {cosine};", f"kane_sincos({self.names[angle]}, &{sine}, &{cosine});")
        self.helpers.add(function)

    def load(self, s: language.Read) -> None:
        """A value from an array."""
        self.define(s.value, self.at(s, language.type_of(s.value)))

    def store(self, s: language.Write) -> None:
        """A value to an array."""
        type_, comment = language.type_of(s.value), f" /* {c_comment(s.label)} */" if s.label else ""
        self.add(f"{each(type_, f'{self.at(s, type_)} = {self.text(s.value)};')}{comment}")
