# SPDX-License-Identifier: BSD-3-Clause
"""Statements as lines of Python that need NumPy only, with the roundings of the reference evaluator, `kane.expr.evaluation`."""

from collections.abc import Collection, Mapping

from kane.expr import ops
from kane.expr.ops import OPS, Op
from kane.program.emit.names import ARITHMETIC, decimal, python_comment
from kane.program.emit.printer import NamedPrinter, shared
from kane.program.kernel import language

_ORDERED = "np.where(({{0}} {} {{1}}) | ({{0}} != {{0}}), {{0}}, {{1}})[()]"
_FORMS: Mapping[Op | str, str] = {
    **{op: f"np.{op.ufunc.__name__}({{0}}{', {1}' * (op.arity > 1)})" for op in OPS.values() if op.ufunc},
    **shared(ARITHMETIC),
    **shared({"sqrt": "np.sqrt({0})", "abs": "np.absolute({0})"}),
    ops.LESS: "np.where({0} < {1}, 1.0, 0.0)",
    OPS["floor"]: "np.floor({0})",
    ops.WHERE: "np.where({0} != 0.0, {1}, {2})",
    ops.REGULAR: f"np.where(np.absolute({{0}}) > {ops.GONE!r} * {{1}}, {{0}}, np.nan)",
    "min": _ORDERED.format("<"),
    "max": _ORDERED.format(">"),
    "less": "{0} < {1}",
    "at_most": "{0} <= {1}",
    "and": "np.logical_and({0}, {1})",
    "or": "np.logical_or({0}, {1})",
    "not": "np.logical_not({0})",
    "select": "np.where({0}, {1}, {2})[()]",
    "float": "np.float64({0})",
    "int": "int({0})",
    "splat4": "np.full(4, {0})",
    "splat8": "np.full(8, {0})",
    "lane": "{0}[{lane}]",
    "any": "np.any({0})",
}
"""An operation as the reference evaluator does it; `**` has short cuts that round differently, np.power has none."""
_FOLDS = {"sum": "add", "largest": "max"}


def python_number(value: float) -> str:
    """An operand of Python that is exactly `value`."""
    return decimal(value, "np.nan", "np.inf")


class NumPyPrinter(NamedPrinter):
    """The lines of one function."""

    def __init__(
        self,
        names: Mapping[int, str] | None = None,
        vectors: Mapping[str, str] | None = None,
        constants: Collection[object] = (),
    ) -> None:
        super().__init__(2, names, vectors)
        self.constants = constants

    def within(self, head: str, block: language.Block) -> None:
        """An indented block."""
        self.add(head, *([] if block else ["    pass"]))
        self.indented(block)

    def text(self, operand: language.Operand) -> str:
        """An operand; constants of kernels are NumPy's numbers, as Python's own refuse to divide by zero."""
        if isinstance(operand, int):
            return self.names[operand]
        if not isinstance(operand, language.Immediate):
            return f"v{operand}"
        if isinstance(operand.value, tuple):
            return f"np.array([{', '.join(map(python_number, operand.value))}])"
        return str(operand.value) if operand.type.kind == "int" else f"np.float64({python_number(operand.value)})"

    def at(self, s: language.Read | language.Write) -> str:
        """Numbers of an array: of Programs on the last axis."""
        base = self.vectors.get(s.base, s.base)
        if isinstance(s.offset, int):
            return f"{base}[..., {s.offset}]"
        index, width = self.text(s.offset), language.type_of(s.value).width
        return f"{base}[{index} : {index} + {width}]" if width > 1 else f"{base}[{index}]"

    def compute(self, s: language.Compute) -> None:
        """An operation."""
        name, operands = self.text(s.value), [self.text(a) for a in s.arguments]
        if s.op in _FOLDS:
            form, half = _FORMS[_FOLDS[str(s.op)]], language.type_of(s.arguments[0]).width // 2
            while half:
                self.add(f"{name} = {form.format(f'{operands[0]}[:{half}]', f'{operands[0]}[{half}:]')}")
                operands, half = [name], half // 2
            self.add(f"{name} = {name}[0]")
            return
        if self.constants and all(a in self.constants for a in s.arguments):
            operands = [f"np.float64({o})" for o in operands]
        self.add(f"{name} = {_FORMS[s.op].format(*operands, lane=s.lane)}")

    def load(self, s: language.Read) -> None:
        """A value from an array."""
        self.add(f"{self.text(s.value)} = {self.at(s)}{'.copy()' * (language.type_of(s.value).width > 1)}")

    def store(self, s: language.Write) -> None:
        """A value to an array."""
        comment = f"  # {python_comment(s.label)}" if s.label else ""
        self.add(f"{self.at(s)} = {self.text(s.value)}{comment}")

    def get(self, s: language.Get) -> None:
        """A value from a cell."""
        self.add(f"v{s.value} = cell_{s.cell.name}")

    def put(self, s: language.Put) -> None:
        """A value to a cell."""
        self.add(f"cell_{s.cell.name} = {self.text(s.value)}")

    def call(self, s: language.CallRoutine) -> None:
        """A routine, which is given arrays from a place on."""
        given = [
            f"{a.base}[{self.text(a.offset)} :]" if isinstance(a, language.Address) else self.text(a)
            for a in s.arguments
        ]
        self.add(f"{s.callee.name}({', '.join(given)})")

    def choice(self, s: language.If) -> None:
        """One of two blocks."""
        self.within(f"if {self.text(s.condition)}:", s.then)
        if s.other:
            self.within("else:", s.other)

    def loop(self, s: language.While) -> None:
        """A block as long as a condition holds."""
        self.add("while True:")
        self.indented(s.head)
        self.add(f"    if not {self.text(s.condition)}:", "        break")
        self.indented(s.body)

    def count(self, s: language.Count) -> None:
        """A block for each integer."""
        index, start, stop = (self.text(x) for x in (s.counter, s.start, s.stop))
        self.within(f"for {index} in range({start}, {stop}):", s.body)
