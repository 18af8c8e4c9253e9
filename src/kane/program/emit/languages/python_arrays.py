# SPDX-License-Identifier: BSD-3-Clause
"""A Program as one Python module of pure functions, for JAX (`jit`, `vmap`, `grad`) or PyTorch (autograd).

As in the NumPy module, a vector has its values on the last axis, and the axes before it are broadcast.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from kane.expr.ops import Op
from kane.program.emit.identifiers import c_number, free_in_module
from kane.program.emit.languages.numpy import PythonModule, described, leading, python_module, python_table, signature
from kane.program.emit.languages.straight import GONE_TEXT, Emitted, Language, forms, head
from kane.program.program import Program

_NAMES = {"asin": "arcsin", "acos": "arccos", "atan": "arctan"}


@dataclass(frozen=True, slots=True, eq=False)
class ArrayLibrary:
    """The spellings of an array library that emitted modules use."""

    language: Language
    imports: str
    vector: str
    shapes: str
    call: tuple[str, str]


def _forms(xp: str) -> Mapping[Op, str]:
    plain = ["sqrt", "sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "abs", "sign", "floor"]
    rows = {name: f"{xp}.{name}({{0}})" for name in plain}
    rows |= {name: f"{xp}.{spelled}({{0}})" for name, spelled in _NAMES.items()}
    return forms(
        {
            **rows,
            "atan2": f"{xp}.arctan2({{0}}, {{1}})",
            "pow": f"{xp}.{'power' if xp == 'jnp' else 'pow'}({{0}}, {{1}})",
            "min": f"{xp}.where(({{0}} < {{1}}) | ({{0}} != {{0}}), {{0}}, {{1}})",
            "max": f"{xp}.where(({{0}} > {{1}}) | ({{0}} != {{0}}), {{0}}, {{1}})",
            "less": f"{xp}.where({{0}} < {{1}}, 1.0, 0.0)",
            "sign": f"{xp}.where({{0}} != {{0}}, {{0}}, {xp}.sign({{0}}))",
            "where": f"{xp}.where({{0}} != 0.0, {{1}}, {{2}})",
            "regular": f"{xp}.where({xp}.abs({{0}}) > {GONE_TEXT} * {{1}}, {{0}}, NAN)",
        }
    )


def _language(xp: str, *own: str, all_wrapped: bool = False) -> Language:
    """The language of the library `xp`; modules import the names `own`."""
    free, at, kept = free_in_module(*own, "NAN", "INFINITY"), "{0}[..., {1}]", "{0}[{1}]"
    given = (_forms(xp), c_number, free, "#")
    return Language(*given, at=at, at_kept=kept, listed=True, wrapped="_number({0})", all_wrapped=all_wrapped)


_VECTOR = '''\
def _number(value):
    return {number}


def _vector(values, table, name):
    """`values`, one for each entry of the table on the last axis."""
    array = _number(values)
    if array.ndim == 0 or array.shape[-1] != len(table):
        raise ValueError(
            f"Expected {{len(table)}} values on the last axis of {{name}} ({{', '.join(table)}}), got {{tuple(array.shape)}}."
        )
    return array


def _packed(out, leading, own):
    """Results on the last axes."""
    if not out:
        return {empty}
    return {stacked}.reshape((*leading, *own))
'''
JAX = ArrayLibrary(
    _language("jnp", "jnp", "jax"),
    "import jax.numpy as jnp",
    _VECTOR.format(
        number="jnp.asarray(value, dtype=float)",
        empty="jnp.zeros((*leading, *own))",
        stacked="jnp.stack([jnp.broadcast_to(value, leading) for value in out], -1)",
    ),
    "jnp.broadcast_shapes",
    (
        "In double precision: call jax.config.update('jax_enable_x64', True) before anything else of JAX.",
        "The functions are pure: jax.jit({f}), jax.vmap({f}, …), jax.jacfwd({f}, argnums=…).",
    ),
)
TORCH = ArrayLibrary(
    _language("torch", "torch", all_wrapped=True),
    "import torch",
    _VECTOR.format(
        number="torch.as_tensor(value, dtype=torch.float64)",
        empty="torch.zeros((*leading, *own), dtype=torch.float64)",
        stacked="torch.stack([torch.broadcast_to(_number(value), leading) for value in out], -1)",
    ),
    "torch.broadcast_shapes",
    (
        "In double precision, whatever the tensors given are; differentiable by torch.autograd.",
        "torch.func.vmap({f}, …) and torch.func.jacrev({f}, argnums=…) work too.",
    ),
)


_SCALAR = "_number({0})"
_OWN = ("jnp", "torch", "NAN", "INFINITY", "leading", "out", "DEFAULTS")


def emit_arrays(arrays: ArrayLibrary, program: Program, *, version: str = "") -> str:
    """The text of a module for an array library."""
    module = python_module(program, arrays.language, _OWN)
    file = module.file
    call = [
        f"Call: {file.first.name}({file.arguments}), vectors on the last axis, further axes before it; "
        "the tables say what they hold.",
        *(f"      {line.format(f=file.first.name)}" for line in arrays.call),
    ]
    vectors = sorted(module.tables, key=lambda port: not port.hoisted)
    hoist, *routines = file.functions
    parts = [
        *(f"# {line}".rstrip() for line in head(file, version, call)),
        "",
        arrays.imports,
        "",
        'NAN, INFINITY = float("nan"), float("inf")',
        *(python_table(module, port, c_number) for port in vectors),
        "",
        "",
        arrays.vector,
        *_hoist(module, hoist),
    ]
    for f in routines:
        routine = program.routine(f.function.name)
        shapes = ", ".join(leading(module, port) for port in program.ports)
        parts += [
            "",
            "",
            f"def {f.name}({signature(module)}):",
            described(routine),
            f"    h = {f.hoisting}",
            *(module.converted(port, _SCALAR) for port in program.ports),
            f"    leading = {arrays.shapes}({shapes})",
            *f.lines,
            *f.listed("    "),
            f"    return _packed(out, leading, {routine.shape!r})",
        ]
    return "\n".join([*parts, ""])


def _hoist(module: PythonModule, f: Emitted) -> list[str]:
    return [
        "",
        f"def {f.name}({f.given}):",
        '    """What depends on parameters alone, a list: the routines call it themselves."""',
        *(module.converted(port, _SCALAR) for port in f.function.ports),
        *f.lines,
        *f.listed("    "),
        "    return out",
    ]
