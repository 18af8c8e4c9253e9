# SPDX-License-Identifier: BSD-3-Clause
"""A Program as one Python module that needs NumPy only, to be read, changed and carried away.

It does the program's operations as `kane.expr.evaluate` does them, for one state or for arrays of them: x, p and r
have their values on the last axis, and the axes before it are broadcast.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence

from kane.expr.ops import LESS, NEG, POW, WHERE, Op
from kane.expr.symbols import Symbol
from kane.program.emit.names import (
    distinct,
    identifier,
    input_names,
    is_free_in_python,
    python_comment,
    python_docstring,
    stem,
)
from kane.program.program import Program, Routine

_TABLES = {"x": "STATE", "p": "PARAMETERS", "r": "INPUTS"}
_VECTOR = '''\
def _vector(values, table, name):
    """`values` as doubles, one for each entry of the table on the last axis."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != len(table):
        raise ValueError(f"Expected {len(table)} values on the last axis of {name} ({', '.join(table)}), got {array.shape}.")
    return array
'''


def emit_numpy(program: Program, *, version: str = "") -> str:
    """The text of the module: PARAMETERS, STATE, INPUTS, `hoist(p)` and `<routine>(t, x, p, r)` for each routine.

    Parameters
    ----------
    program
        What to compute.
    version
        Kane's version, for the docstring.
    """
    taken = {"np", "hoist", "_vector", "shape", "DEFAULTS", *_TABLES.values()}
    names = distinct([identifier(r.name) or "routine" for r in program.routines], is_free_in_python, taken)
    inputs = input_names(program, lambda name: is_free_in_python(name) and name not in {*taken, *names})
    symbols = {port: next((q.symbols for q in program.ports if q.name == port), ()) for port in _TABLES}
    defaults = all(s.default is not None for s in symbols["p"])
    parts = [
        _docstring(program, names, version),
        "import numpy as np\n",
        _parameters(symbols["p"], defaults),
        _table("STATE", symbols["x"]),
        _table("INPUTS", symbols["r"]),
        f"\n\n{_VECTOR}",
        _hoist(program, inputs),
        *(_routine(program, r, n, inputs, defaults) for r, n in zip(program.routines, names, strict=True)),
    ]
    return "\n".join(parts)


# ---------------------------------------------------------------------------------------------------------- tables


def _docstring(program: Program, names: Sequence[str], version: str) -> str:
    calls = [f"{name}(t, x, p, r)" for name in names]
    width = max(map(len, calls), default=0)
    what = [f"    {c:{width}}  {_shape(r)}: {_few(r.labels)}" for c, r in zip(calls, program.routines, strict=True)]
    lines = [
        f"{program.name}: equations of motion.",
        "",
        f"Made by kane{' ' if version else ''}{version}: derive and emit again instead of editing. Needs NumPy only.",
        "",
        *what,
        "",
        "t is the time, x the state, p the parameters, r the inputs, as in the tables STATE, PARAMETERS and INPUTS. Their values",
        "are on the last axis; the axes before it are broadcast and come first in the results. Division by zero and the like",
        "give infinity or NaN without a warning.",
    ]  # fmt: skip
    return python_docstring("\n".join([*lines, ""])) + "\n"


def _shape(routine: Routine) -> str:
    return " by ".join(map(str, routine.shape)) or "a number"


def _few(labels: Sequence[str], count: int = 6) -> str:
    return ", ".join(labels[:count]) + (", …" if len(labels) > count else "")


def _parameters(symbols: Iterable[Symbol], defaults: bool) -> str:
    rows = []
    for s in symbols:
        default = "None" if s.default is None else _number(float(s.default))
        rows.append(f"    {s.name!r}: ({default}, {s.unit!r}, {s.description!r}),")
    lines = ["# name: (default, unit, description)", "PARAMETERS = {", *rows, "}"]
    if defaults:
        lines.append("DEFAULTS = tuple(default for default, _, _ in PARAMETERS.values())")
    return "\n".join(lines)


def _table(name: str, symbols: Iterable[Symbol]) -> str:
    rows = [f"    {s.name!r}: ({s.unit!r}, {s.description!r})," for s in symbols]
    return "\n".join(["# name: (unit, description)", f"{name} = {{", *rows, "}"])


# ------------------------------------------------------------------------------------------------------- functions


def _hoist(program: Program, inputs: Sequence[str]) -> str:
    results = [(i, "") for i in program.kept]
    lines = [
        "",
        "def hoist(p):",
        '    """What depends on parameters alone: the routines call it themselves."""',
        '    p = _vector(p, PARAMETERS, "p")',
        f"    h = np.empty((*p.shape[:-1], {len(program.kept)}))",
        *_computed(program, inputs, program.hoisted, results, "h", ()),
        "    return h\n",
    ]
    return "\n".join(lines)


def _routine(program: Program, routine: Routine, name: str, inputs: Sequence[str], defaults: bool) -> str:
    results = list(zip(routine.results, routine.labels, strict=True))
    lines = [
        "",
        f"def {name}(t, x, p{'=DEFAULTS' if defaults else ''}, r=()):",
        f"    {python_docstring(f'{_shape(routine)}: {_few(routine.labels)}.')}",
        "    h = hoist(p)",
        "    t = np.asarray(t, dtype=np.float64)",
        *(f'    {port} = _vector({port}, {table}, "{port}")' for port, table in _TABLES.items()),
        "    shape = np.broadcast_shapes(t.shape, x.shape[:-1], p.shape[:-1], r.shape[:-1])",
        f"    out = np.empty((*shape, {len(results)}))",
        *_computed(program, inputs, routine.body, results, "out", program.kept),
        f"    return out.reshape(shape + {routine.shape!r})\n",
    ]
    return "\n".join(lines)


def _computed(
    program: Program,
    inputs: Sequence[str],
    block: Sequence[int],
    results: Sequence[tuple[int, str]],
    target: str,
    kept: Sequence[int],
) -> list[str]:
    """The lines that compute target[..., k] = the value results[k], with its label."""
    text = _sources(program, kept)
    names = dict(enumerate(inputs)) | {i: text[i] for i in range(len(inputs), program.first)}
    h, z = stem("h", inputs), stem("z", inputs)
    names.update({i: f"{h}{k}" for k, i in enumerate(kept)})
    names.update({i: f"{z}{k}" for k, i in enumerate(block, 1)})
    read = {a for i in block for a in program.arguments(i)}.union(i for i, _ in results)
    numbers = range(len(inputs), program.first)
    lines = [f"{names[i]} = {text[i]}" for i in sorted(read) if i in text and text[i] != names[i]]
    for i in block:
        arguments = program.arguments(i)
        operands = [names[a] for a in arguments]
        if all(a in numbers for a in arguments):  # Python's own floats would refuse to divide by zero
            operands = [f"np.float64({o})" for o in operands]
        lines.append(f"{names[i]} = {_expression(program.op(i), operands)}")
    for k, (i, label) in enumerate(results):
        lines.append(f"{target}[..., {k}] = {names[i]}" + (f"  # {python_comment(label)}" if label else ""))
    return ['    with np.errstate(all="ignore"):', *(f"        {line}" for line in lines)] if lines else []


def _sources(program: Program, kept: Sequence[int]) -> dict[int, str]:
    """Where the values come from that a function does not compute: a place in its arguments, or a number."""
    found = []
    for port in program.ports:
        found += ["t"] if port.name == "t" else [f"{port.name}[..., {k}]" for k in range(len(port.symbols))]
    found += map(_number, program.constants)
    return dict(enumerate(found)) | {i: f"h[..., {k}]" for k, i in enumerate(kept)}


def _number(value: float) -> str:
    if math.isfinite(value):
        return repr(value) if math.copysign(1.0, value) > 0 else f"({value!r})"
    return "np.nan" if math.isnan(value) else "np.inf" if value > 0 else "(-np.inf)"


_FORMS: Mapping[Op, str] = {
    NEG: "-{0}",
    LESS: "np.where({0} < {1}, 1.0, 0.0)",
    WHERE: "np.where({0} != 0.0, {1}, {2})",
}


def _expression(op: Op, operands: Collection[str]) -> str:
    """The operation as the reference evaluator does it; `**` has short cuts that round differently, np.power has none."""
    if op in _FORMS:
        return _FORMS[op].format(*operands)
    if op.infix and op is not POW:
        return f" {op.infix} ".join(operands)
    assert op.ufunc is not None
    return f"np.{op.ufunc.__name__}({', '.join(operands)})"
