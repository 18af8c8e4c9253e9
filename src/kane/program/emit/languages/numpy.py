# SPDX-License-Identifier: BSD-3-Clause
"""A Program as one self-contained Python module that needs NumPy only.

It performs the operations of the program as `kane.expr.evaluation` does, for one state or for arrays of states: a vector has its
values on the last axis, and the axes before it are broadcast.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from kane.expr.ops import OPS
from kane.program.emit import identifiers
from kane.program.emit.languages.straight import GONE_TEXT, Emitted, File, Language, file_of, forms
from kane.program.program import Port, Program, Routine


def python_number(value: float) -> str:
    """A Python expression of exactly `value`."""
    return identifiers.decimal(value, "np.nan", "np.inf")


_NUMPY = Language(
    forms(
        {
            **{
                op.name: f"np.{op.ufunc.__name__}({{0}}{', {1}' * (op.arity > 1)})"
                for op in OPS.values()
                if op.ufunc and op.name not in identifiers.ARITHMETIC
            },
            "less": "np.where({0} < {1}, 1.0, 0.0)",
            "floor": "np.floor({0})",
            "where": "np.where({0} != 0.0, {1}, {2})",
            "regular": f"np.where(np.absolute({{0}}) > {GONE_TEXT} * {{1}}, {{0}}, np.nan)",
        }
    ),
    python_number,
    identifiers.is_free_in_python,
    " #",
    at="{0}[..., {1}]",
    wrapped="np.float64({0})",
)
"""Operations as in the reference evaluator; np.power instead of `**`, whose shortcuts round differently."""
_VECTOR = '''\
def _vector(values, table, name):
    """`values` as doubles, one for each entry of the table on the last axis."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != len(table):
        raise ValueError(f"Expected {len(table)} values on the last axis of {name} ({', '.join(table)}), got {array.shape}.")
    return array
'''


def emit_numpy(program: Program, *, version: str = "") -> str:
    """The text of the module: a table for each vector, `hoist(parameters)` and `<routine>(ports)` for each routine.

    NumPy rounds each operation separately.
    """
    module = python_module(program, _NUMPY, ("np", "_vector", "shape"), depth=2)
    vectors = sorted(module.tables, key=lambda port: not port.hoisted)
    hoist, *routines = module.file.functions
    parts = [
        _docstring(module, version),
        "import numpy as np\n",
        *(python_table(module, port) for port in vectors),
        f"\n\n{_VECTOR}",
        _hoist(module, hoist),
        *(_routine(module, r, f) for r, f in zip(program.routines, routines, strict=True)),
    ]
    return "\n".join(parts)


@dataclass(frozen=True, slots=True, eq=False)
class PythonModule:
    """The functions in the module, and the names of the tables of vectors and of the defaults of parameters."""

    file: File
    tables: dict[Port, str]
    defaults: dict[Port, str]

    def arguments(self, ports: Iterable[Port]) -> str:
        """The names of ports, separated by commas."""
        return ", ".join(self.file.names.arguments[port.name] for port in ports)

    def converted(self, port: Port, scalar: str) -> str:
        """The line that converts an argument to an array, a scalar as in the form `scalar`."""
        name = self.arguments([port])
        vector = f'_vector({name}, {self.tables.get(port)}, "{name}")'
        return f"    {name} = {scalar.format(name) if port.scalar else vector}"


def python_module(program: Program, spoken: Language, own: Sequence[str], depth: int = 1) -> PythonModule:
    """A Python module whose fixed lines use the names `own`."""
    vectors = [port for port in program.ports if not port.scalar]
    tables = identifiers.distinct(
        [identifiers.identifier(p.noun).upper() for p in vectors], identifiers.is_free_in_python, ["hoist", *own]
    )
    whole = [p for p in vectors if p.hoisted and all(s.default is not None for s in p.symbols)]
    lone = len(program.hoisted_ports) == 1
    by_port = dict(zip(vectors, tables, strict=True))
    defaults = {p: "DEFAULTS" if lone else f"{by_port[p]}_DEFAULTS" for p in whole}
    file = file_of(program, spoken, (*own, "DEFAULTS", *tables, *defaults.values()), depth)
    return PythonModule(file, by_port, defaults)


# ---------------------------------------------------------------------------------------------------------- tables


def _docstring(module: PythonModule, version: str) -> str:
    program = module.file.program
    calls = [f"{f.name}({module.arguments(program.ports)})" for f in module.file.functions[1:]]
    width = max(map(len, calls), default=0)
    what = [f"    {c:{width}}  {shape_text(r)}: {few(r.labels)}" for c, r in zip(calls, program.routines, strict=True)]
    nouns = [f"{module.arguments([port])} {'' if k else 'is '}the {port.noun}" for k, port in enumerate(program.ports)]
    *most, last = module.tables.values() if module.tables else ("none",)
    lines = [
        f"{program.name}: {program.subject}.",
        "",
        f"{identifiers.made_by(version)} Needs NumPy only.",
        "",
        *what,
        "",
        f"{', '.join(nouns)}, as in the tables {', '.join(most)}{' and ' if most else ''}{last}. Their values",
        "are on the last axis; the axes before it are broadcast and come first in the results. Division by zero and the like",
        "give infinity or NaN without a warning.",
        *(["", *program.lost] if program.lost else []),
    ]
    return identifiers.python_docstring("\n".join([*lines, ""])) + "\n"


def shape_text(routine: Routine) -> str:
    """The shape of a routine's result in words."""
    return " by ".join(map(str, routine.shape)) or "a number"


def described(routine: Routine) -> str:
    """The docstring of a routine, indented."""
    return f"    {identifiers.python_docstring(f'{shape_text(routine)}: {few(routine.labels)}.')}"


def few(labels: Sequence[str], count: int = 6) -> str:
    """The first `count` labels."""
    return ", ".join(labels[:count]) + (", …" if len(labels) > count else "")


def python_table(module: PythonModule, port: Port, number: Callable[[float], str] = python_number) -> str:
    """The table of a vector: names, defaults, units and descriptions."""
    name, rows = module.tables[port], []
    for s in port.symbols:
        default = "None" if s.default is None else number(float(s.default))
        rows.append(f"    {s.name!r}: ({f'{default}, ' * port.hoisted}{s.unit!r}, {s.description!r}),")
    lines = [f"# name: ({'default, ' * port.hoisted}unit, description)", f"{name} = {{", *rows, "}"]
    if port in module.defaults:
        lines.append(f"{module.defaults[port]} = tuple(default for default, _, _ in {name}.values())")
    return "\n".join(lines)


# ------------------------------------------------------------------------------------------------------- functions


_SCALAR = "np.asarray({0}, dtype=np.float64)"


def _hoist(module: PythonModule, f: Emitted) -> str:
    program, ports = module.file.program, f.function.ports
    shapes = [leading(module, port) for port in ports]
    shape = shapes[0] if len(shapes) == 1 else f"np.broadcast_shapes({', '.join(shapes)})"
    lines = [
        "",
        f"def hoist({f.given}):",
        '    """What depends on parameters alone: the routines call it themselves."""',
        *(module.converted(port, _SCALAR) for port in ports),
        f"    h = np.empty((*{shape}, {len(program.kept)}))",
        *_computed(f),
        "    return h\n",
    ]
    return "\n".join(lines)


def _routine(module: PythonModule, routine: Routine, f: Emitted) -> str:
    ports = f.function.ports
    shapes = ", ".join(leading(module, port) for port in ports)
    lines = [
        "",
        f"def {f.name}({signature(module)}):",
        described(routine),
        f"    h = {f.hoisting}",
        *(module.converted(port, _SCALAR) for port in ports),
        f"    shape = np.broadcast_shapes({shapes})",
        f"    out = np.empty((*shape, {len(routine.results)}))",
        *_computed(f),
        f"    return out.reshape(shape + {routine.shape!r})\n",
    ]
    return "\n".join(lines)


def signature(module: PythonModule) -> str:
    """The argument list; the last arguments have defaults if they may be omitted."""
    arguments: list[str] = []
    for port in reversed(module.file.program.ports):
        name = module.arguments([port])
        default = module.defaults.get(port, "()" if port.optional and not port.hoisted else "")
        open_ = default and all("=" in g for g in arguments)
        arguments.append(f"{name}={default}" if open_ else name)
    return ", ".join(reversed(arguments))


def leading(module: PythonModule, port: Port) -> str:
    """The leading axes of an argument, to be broadcast."""
    return f"{module.arguments([port])}.shape{'' if port.scalar else '[:-1]'}"


def _computed(f: Emitted) -> list[str]:
    """The lines that compute the results of a function, each with its label as a comment."""
    return ['    with np.errstate(all="ignore"):', *f.lines] if f.lines else []
