# SPDX-License-Identifier: BSD-3-Clause
"""Instances: the initial values, parameters and inputs of many motions or states, each one number for all or one per instance.

Columns are given by dicts, arrays whose first axis counts instances, pandas DataFrames, xarray Datasets, or designs of experiments.
Numbers and arrays of length one apply to all instances; other arrays have the same length, the number of instances.

Results at instances are xarray variables with names, units and dimensions; xarray, as pandas, is an optional package.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane import expect
from kane.equations.equations import Equations
from kane.errors import SimulationError, ValueMissingError
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Input, Parameter, Symbol, declared, time
from kane.numeric.arrays import Array
from kane.numeric.sampling import finite_number, named_values, spelled_out, unknown

STARTS = ("q", "u", "states")


@dataclass(frozen=True, slots=True, eq=False)
class Instances:
    """`count` instances: by kind the common values, as given, and by symbol the columns (count) of values that differ.

    `common` is None for a kind without values, or with columns alone.
    """

    count: int
    common: Mapping[str, Any]
    columns: Mapping[str, Mapping[Any, Array]]

    def at(self, k: int) -> dict[str, Any]:
        """The arguments of `kn.simulate` for instance k."""
        result: dict[str, Any] = {}
        for kind, columns in self.columns.items():
            own = {s: float(column[k]) for s, column in columns.items()}
            common = self.common[kind]
            result[kind] = common if not own else {**(common or {}), **own}
        return result

    def part(self, rows: range) -> "Instances":
        """The instances in `rows`."""
        columns = {
            kind: {s: column[rows.start : rows.stop] for s, column in own.items()} for kind, own in self.columns.items()
        }
        return Instances(len(rows), self.common, columns)

    def by_parameters(self, eom: Equations) -> "Instances":
        """The same with parameters in place of the inputs that are columns, so that code for one instance runs all."""
        moved = self.columns["inputs"]
        gains = {s: Parameter.declare(s.name, None, eom.unit(s), s.description, s) for s in moved}
        columns = {**self.columns["parameters"], **{gains[s]: c for s, c in moved.items()}}
        common = {**self.common, "inputs": {**(self.common["inputs"] or {}), **gains} or None}
        return Instances(self.count, common, {**self.columns, "inputs": {}, "parameters": columns})

    @property
    def vary_laws(self) -> bool:
        """Whether inputs differ by parameters in them."""
        laws = [v for v in (self.common["inputs"] or {}).values() if isinstance(v, Expr)]
        return not set(self.columns["parameters"]).isdisjoint(free_symbols(laws))

    @property
    def varied(self) -> Iterator[tuple[str, Any, Array]]:
        """Kind, symbol and column of each value that differs."""
        for kind, columns in self.columns.items():
            for s, column in columns.items():
                yield kind, s, column


def has_columns(given: Mapping[str, Any]) -> bool:
    """Whether values of some kind are given per instance: as a table, as an array with a row for each, or as columns."""
    return any(map(_is_many, given.values()))


def _is_many(given: Any) -> bool:
    if hasattr(given, "data_vars") or hasattr(given, "iloc"):
        return True
    if isinstance(given, Mapping):
        values = [v for v in given.values() if not isinstance(v, Expr) and not callable(v)]
        return any(isinstance(v, list | tuple) or np.ndim(v) > 0 for v in values)
    if isinstance(given, list | tuple):
        return any(isinstance(v, list | tuple | np.ndarray) and np.ndim(v) > 0 for v in given)
    return isinstance(given, np.ndarray) and given.ndim > 1


def instances(eom: Equations, given: Mapping[str, Any], design: Mapping[Any, Any] | None = None) -> Instances:
    """The instances from the values of each kind and from a design, a table with columns of any kind by name.

    Raises
    ------
    ValueMissingError
        if a name is unknown, or comes twice
    SimulationError
        if arrays have different lengths or none at all, or a number is not finite
    """
    symbols = _symbols(eom, given)
    values = {kind: _by_symbol(kind, symbols[kind], own) for kind, own in given.items()}
    _add_design(values, {kind: symbols[kind] for kind in given}, design or {})
    columns = {kind: _columns(kind, own) for kind, own in values.items()}
    lengths = {(s, kind): len(c) for kind, own in columns.items() for s, c in own.items()}
    many = _common_length(lengths)
    common: dict[str, Any] = {}
    for kind, own in values.items():
        rest = {s: v for s, v in own.items() if s not in columns[kind]}
        rest |= {s: float(c[0]) for s, c in columns[kind].items() if len(c) == 1}
        if kind == "parameters":
            rest = {s: finite_number("value", s.name, v) for s, v in rest.items()}
        common[kind] = rest or None
        columns[kind] = {s: c for s, c in columns[kind].items() if len(c) > 1}
    return Instances(many, common, columns)


def _symbols(eom: Equations, given: Mapping[str, Any]) -> dict[str, tuple[Symbol, ...]]:
    """The symbols of each kind; parameters that occur in inputs alone are among the parameters."""
    return {
        "q": tuple(eom.coordinates),
        "u": tuple(eom.speeds),
        "states": tuple(eom.states),
        "parameters": (*eom.system.parameters, *own_parameters(eom, given["inputs"])),
        "inputs": tuple(s for s in eom.inputs if isinstance(s, Input) or "t" in given),
        "t": (time,),
        "rates": tuple(eom.coordinates),
    }


def own_parameters(eom: Equations, inputs: Any) -> tuple[Parameter, ...]:
    """The parameters that occur only in inputs, which may be expressions, and several of them in a list, tuple or array.

    Raises ValueMissingError if one has the name of another, or of a parameter of the model.
    """
    given = inputs.values() if isinstance(inputs, Mapping) else inputs if isinstance(inputs, list | tuple) else ()
    rows = [v.flat if isinstance(v, np.ndarray) else v if isinstance(v, list | tuple) else (v,) for v in given]
    symbols, known = free_symbols([e for row in rows for e in row if isinstance(e, Expr)]), set(eom.system.parameters)
    own = tuple(s for s in symbols if isinstance(s, Parameter) and s not in known)
    names = {s.name: s for s in (*own, *eom.system.parameters)} if own else {}
    twice = (f"{declared(s)} beside {declared(names[s.name])}" for s in own if names[s.name] is not s)
    cure = "Take one symbol in both places, or another name."
    expect.none(twice, "parameters of inputs with names of their own", cure=cure, error=ValueMissingError)
    return own


def _by_symbol(kind: str, symbols: Sequence[Symbol], given: Any) -> dict[Any, Any]:
    """The values of a kind by symbol; a tuple of inputs with one common function stays one key."""
    table = spelled_out(_WORDS[kind], symbols, table_of(given))
    if not isinstance(table, Mapping):
        table = _in_order(kind, symbols, table)
    together = {key: value for key, value in table.items() if isinstance(key, tuple)}
    rest = {key: value for key, value in table.items() if key not in together}
    own = {s for s in symbols if isinstance(s, Parameter)}
    foreign = {
        s: v for s, v in rest.items() if isinstance(s, Parameter) and s not in own
    }  # shared by variants of a model
    named = {s: v for s, v in rest.items() if s not in foreign}
    return {**named_values(_WORDS[kind], symbols, named), **together}


_PLAIN = ("states", "parameters", "inputs", "t")
_WORDS = {"q": "coordinates", "u": "speeds", "rates": "rates, by coordinate,"} | {kind: kind for kind in _PLAIN}


def table_of(given: Any) -> Any:
    """A DataFrame or Dataset as a dict of its columns; other values unchanged."""
    if hasattr(given, "iloc") and hasattr(given, "columns"):
        return {name: given[name] for name in given.columns}
    if hasattr(given, "data_vars"):
        return {name: given[name] for name in given.data_vars}
    return {} if given is None else given


def _in_order(kind: str, symbols: Sequence[Symbol], given: Any) -> dict[Any, Any]:
    """Values in the order of the symbols, along the last axis."""
    names = ", ".join(s.name for s in symbols)
    expected = f"{kind} as a dict {{name: value}} or an array (instances × {len(symbols)}) of {names}"
    cure = "Give a dict, in which numbers and arrays may stand side by side."
    table = expect.floats(given, expected, cure, error=SimulationError)
    if table.ndim not in (1, 2) or table.shape[-1] != len(symbols):
        raise SimulationError(
            f"Expected {kind} as an array (instances × {len(symbols)}) of {names}, or ({len(symbols)}) for all instances, got the "
            f"shape {table.shape}. Transpose it, or give a dict {{name: values}}."
        )
    return dict(zip(symbols, table.T if table.ndim == 2 else table, strict=True))


def _add_design(
    values: dict[str, dict[Any, Any]], symbols: Mapping[str, Sequence[Symbol]], table: Mapping[Any, Any]
) -> None:
    """Adds the columns of a design to the values of their kinds."""
    every = [s for own in symbols.values() for s in own]
    for key, value in table.items():
        kind, s = _symbol_for(symbols, every, key)
        if s in values[kind]:
            raise ValueMissingError(
                f"Expected one value for {s.name}, got two, by {kind}= and by design=. Leave one out."
            )
        values[kind][s] = value


def _symbol_for(symbols: Mapping[str, Sequence[Symbol]], every: Sequence[Symbol], key: Any) -> tuple[str, Symbol]:
    """The kind and the symbol of a key of a design."""
    for kind, own in symbols.items():
        for s in own:
            if s is key or (isinstance(key, str) and s.name == key):
                return kind, s
    raise ValueMissingError(
        f"Expected coordinates, speeds, states, parameters and inputs of the system in a design, got {unknown(key, every)}"
    )


def _columns(kind: str, values: Mapping[Any, Any]) -> dict[Any, Array]:
    """The columns among the values. As an input, a tuple is a function with its derivatives; as a key, inputs with a law each."""
    listed = (np.ndarray, list, range) if kind == "inputs" else (np.ndarray, list, range, tuple)
    result: dict[Any, Array] = {}
    for s, value in values.items():
        if not isinstance(s, tuple) and (isinstance(value, listed) or hasattr(value, "to_numpy")):
            result[s] = _column(kind, s, value.to_numpy() if hasattr(value, "to_numpy") else value)
    return result


def _column(kind: str, s: Any, value: Any) -> Array:
    """A column of finite numbers."""
    column = expect.floats(value, f"numbers for {s} in {kind}", "Give one for each instance.", error=SimulationError)
    if column.ndim > 1:
        raise SimulationError(
            f"Expected one axis, the instances, for {s} in {kind}, got the shape {column.shape}. Flatten it, or let a design combine "
            f'values, design={{…}}, sampler="product".'
        )
    column = column.reshape(-1)
    wrong = np.flatnonzero(~np.isfinite(column))
    if wrong.size:
        raise SimulationError(
            f"Expected finite numbers for {s} in {kind}, got {column[wrong[0]]} for instance {wrong[0]}, {wrong.size} of "
            f"{len(column)} in all. Leave these instances out."
        )
    return column


def _common_length(lengths: Mapping[tuple[Any, str], int]) -> int:
    """The number of instances."""
    none = [f"{s} ({kind})" for (s, kind), n in lengths.items() if n == 0]
    came, cure = "an array without numbers for {}", "Give some, or a number."
    expect.none(none, "at least one instance", came, cure, error=SimulationError)
    several = {key: n for key, n in lengths.items() if n != 1}
    if len(set(several.values())) > 1:
        told = ", ".join(f"{n} for {s} ({kind})" for (s, kind), n in several.items())
        raise SimulationError(
            f"Expected arrays of one length, a number for each instance, got {told}. Give as many of each, one number for all, or "
            'let a design combine them, design={…}, sampler="product".'
        )
    return next(iter(several.values()), 1)


AXES = ("x", "y", "z")


def labelled(
    xarray: Any, name: str, values: Array, first: Sequence[str], unit: str, description: str, dims: Sequence[str] = ()
) -> Any:
    """An xarray Variable of values; its dimensions are `first`, then `dims`, by default "axis" of vectors or numbered names."""
    n = len(first)
    usual = ["axis"] if values.shape[n:] == (3,) else [f"{name}_{k}" for k in range(1, values.ndim - n + 1)]
    rest = dims or usual
    told = {"units": unit, "long_name": description or name}
    return xarray.Variable([*first, *rest], values, {k: v for k, v in told.items() if v})


def package(name: str, extra: str = "table") -> Any:
    """Imports an optional package, which an extra of the library installs.

    Raises
    ------
    ImportError
        if it is not there
    """
    told = f"Expected the package {name}, got none. Install it, pip install 'kane[{extra}]'; "
    return expect.package(name, ImportError(told + "sol.t, sol.q, sol.u and sol[…] need none."))
