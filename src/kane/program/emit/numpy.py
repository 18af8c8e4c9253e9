# SPDX-License-Identifier: BSD-3-Clause
"""A Program as one Python module that needs NumPy only, to be read, changed and carried away.

It does the program's operations as `kane.expr.evaluation` does them, for one state or for arrays of them: a vector has its values on
the last axis, and the axes before it are broadcast.

Statements as lines of Python that need NumPy only, with the roundings of the reference evaluator, `kane.expr.evaluation`.
"""

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

from kane.expr import ops
from kane.expr.ops import OPS, Op
from kane.program.emit.names import (
    ARITHMETIC,
    Names,
    decimal,
    distinct,
    identifier,
    is_free_in_python,
    local_names,
    made_by,
    python_comment,
    python_docstring,
)
from kane.program.emit.walk import Function, NamedPrinter, Style, function_of, hoisting, pieces, shared, statements
from kane.program.kernel import language
from kane.program.kernel.language import Integer, Kernel
from kane.program.program import Port, Program, Routine

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


_STYLE = Style(whole=math.inf)
_VECTOR = '''\
def _vector(values, table, name):
    """`values` as doubles, one for each entry of the table on the last axis."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != len(table):
        raise ValueError(f"Expected {len(table)} values on the last axis of {name} ({', '.join(table)}), got {array.shape}.")
    return array
'''


def emit_numpy(program: Program, *, contract: bool = False, version: str = "") -> str:
    """The text of the module: a table for each vector, `hoist(parameters)` and `<routine>(ports)` for each routine.

    `contract` is there as in other emitters; NumPy rounds each operation by itself.
    """
    module = python_module(program)
    vectors = sorted(module.tables, key=lambda port: not port.hoisted)
    parts = [
        _docstring(module, version),
        "import numpy as np\n",
        *(python_table(module, port) for port in vectors),
        f"\n\n{_VECTOR}",
        _hoist(module),
        *(_routine(module, r, n) for r, n in zip(program.routines, module.routines, strict=True)),
    ]
    return "\n".join(parts)


def emit_kernel_numpy(kernel: Kernel) -> str:
    """The text of a module with the one function `<name>(arguments)`, of arrays with one axis, from a place on for routines."""
    printer = NumPyPrinter()
    for c in kernel.cells:
        zero = {"float": "np.float64(0.0)", "int": "0", "bool": "False"}[c.type.kind]
        printer.add(f"cell_{c.name} = {f'np.full({c.type.width}, {zero})' if c.type.width > 1 else zero}")
    printer.block(kernel.body)
    arguments = ", ".join(f"v{a.value}" if isinstance(a, Integer) else a.name for a in kernel.arguments)
    head = ["import numpy as np", "", "", f"def {kernel.name}({arguments}):", '    with np.errstate(all="ignore"):']
    return "\n".join([*head, *printer.lines, f"    return int(cell_{kernel.result.name})", ""])


@dataclass(frozen=True, slots=True, eq=False)
class PythonModule:
    """Names in the module: of values, of the vectors' tables, of the defaults of hoisted ones, of routines."""

    program: Program
    names: Names
    tables: dict[Port, str]
    defaults: dict[Port, str]
    routines: tuple[str, ...]

    def arguments(self, ports: Iterable[Port]) -> str:
        """The names of ports, one after the other."""
        return ", ".join(self.names.arguments[port.name] for port in ports)


def python_module(program: Program, own: Sequence[str] = ("np", "_vector", "shape")) -> PythonModule:
    """The names in a module of Python whose own lines use the names `own`."""
    vectors = [port for port in program.ports if not port.scalar]
    own = ["hoist", *own]
    tables = distinct([identifier(p.noun).upper() for p in vectors], is_free_in_python, own)
    whole = [p for p in vectors if p.hoisted and all(s.default is not None for s in p.symbols)]
    lone = len(program.hoisted_ports) == 1
    by_port = dict(zip(vectors, tables, strict=True))
    defaults = {p: "DEFAULTS" if lone else f"{by_port[p]}_DEFAULTS" for p in whole}
    taken = {*own, "DEFAULTS", *tables, *defaults.values()}
    routines = distinct([identifier(r.name) or "routine" for r in program.routines], is_free_in_python, taken)
    names = local_names(program, lambda name: is_free_in_python(name) and name not in {*taken, *routines})
    return PythonModule(program, names, by_port, defaults, tuple(routines))


# ---------------------------------------------------------------------------------------------------------- tables


def _docstring(module: PythonModule, version: str) -> str:
    program = module.program
    calls = [f"{name}({module.arguments(program.ports)})" for name in module.routines]
    width = max(map(len, calls), default=0)
    what = [f"    {c:{width}}  {shape_text(r)}: {few(r.labels)}" for c, r in zip(calls, program.routines, strict=True)]
    nouns = [f"{module.arguments([port])} {'' if k else 'is '}the {port.noun}" for k, port in enumerate(program.ports)]
    *most, last = module.tables.values() if module.tables else ("none",)
    lines = [
        f"{program.name}: {program.subject}.",
        "",
        f"{made_by(version)} Needs NumPy only.",
        "",
        *what,
        "",
        f"{', '.join(nouns)}, as in the tables {', '.join(most)}{' and ' if most else ''}{last}. Their values",
        "are on the last axis; the axes before it are broadcast and come first in the results. Division by zero and the like",
        "give infinity or NaN without a warning.",
        *(["", *program.lost] if program.lost else []),
    ]
    return python_docstring("\n".join([*lines, ""])) + "\n"


def shape_text(routine: Routine) -> str:
    """The size of a routine's results in words."""
    return " by ".join(map(str, routine.shape)) or "a number"


def few(labels: Sequence[str], count: int = 6) -> str:
    """The first labels."""
    return ", ".join(labels[:count]) + (", …" if len(labels) > count else "")


def python_table(module: PythonModule, port: Port, number: Callable[[float], str] = python_number) -> str:
    """The table of a vector: names, defaults, units, descriptions."""
    name, rows = module.tables[port], []
    for s in port.symbols:
        default = "None" if s.default is None else number(float(s.default))
        rows.append(f"    {s.name!r}: ({f'{default}, ' * port.hoisted}{s.unit!r}, {s.description!r}),")
    lines = [f"# name: ({'default, ' * port.hoisted}unit, description)", f"{name} = {{", *rows, "}"]
    if port in module.defaults:
        lines.append(f"{module.defaults[port]} = tuple(default for default, _, _ in {name}.values())")
    return "\n".join(lines)


# ------------------------------------------------------------------------------------------------------- functions


def _hoist(module: PythonModule) -> str:
    program, ports = module.program, module.program.hoisted_ports
    shapes = [leading(module, port) for port in ports]
    shape = shapes[0] if len(shapes) == 1 else f"np.broadcast_shapes({', '.join(shapes)})"
    lines = [
        "",
        f"def hoist({module.arguments(ports)}):",
        '    """What depends on parameters alone: the routines call it themselves."""',
        *(_converted(module, port) for port in ports),
        f"    h = np.empty((*{shape}, {len(program.kept)}))",
        *_computed(module, hoisting(program)),
        "    return h\n",
    ]
    return "\n".join(lines)


def _routine(module: PythonModule, routine: Routine, name: str) -> str:
    program = module.program
    shapes = ", ".join(leading(module, port) for port in program.ports)
    lines = [
        "",
        f"def {name}({signature(module)}):",
        f"    {python_docstring(f'{shape_text(routine)}: {few(routine.labels)}.')}",
        f"    h = hoist({module.arguments(program.hoisted_ports)})",
        *(_converted(module, port) for port in program.ports),
        f"    shape = np.broadcast_shapes({shapes})",
        f"    out = np.empty((*shape, {len(routine.results)}))",
        *_computed(module, function_of(program, routine)),
        f"    return out.reshape(shape + {routine.shape!r})\n",
    ]
    return "\n".join(lines)


def signature(module: PythonModule) -> str:
    """The ports; the last of them that may be left out have defaults."""
    arguments: list[str] = []
    for port in reversed(module.program.ports):
        name = module.arguments([port])
        default = module.defaults.get(port, "()" if port.optional and not port.hoisted else "")
        open_ = default and all("=" in g for g in arguments)
        arguments.append(f"{name}={default}" if open_ else name)
    return ", ".join(reversed(arguments))


def _converted(module: PythonModule, port: Port) -> str:
    """The line that makes an argument an array."""
    name = module.arguments([port])
    if port.scalar:
        return f"    {name} = np.asarray({name}, dtype=np.float64)"
    return f'    {name} = _vector({name}, {module.tables[port]}, "{name}")'


def leading(module: PythonModule, port: Port) -> str:
    """The axes before an argument's own."""
    return f"{module.arguments([port])}.shape{'' if port.scalar else '[:-1]'}"


def _computed(module: PythonModule, function: Function) -> list[str]:
    """The lines that compute what a function gives, each result with its label."""
    program = module.program
    (piece,) = pieces(program, function, _STYLE).chunks
    names, numbers = module.names.of(function, python_number), range(len(program.inputs), program.first)
    printer = NumPyPrinter(names, module.names.arguments, numbers)
    printer.block(statements(program, function, piece, _STYLE))
    return ['    with np.errstate(all="ignore"):', *printer.lines] if printer.lines else []
