# SPDX-License-Identifier: BSD-3-Clause
"""Many states, given by arrays or by a Dataset of arrays, and results at each state as an xarray Dataset.

A state without a result does not affect others: its numbers are NaN, its `status` is "failed", and `cause` gives the reason.
"""

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from kane import expect
from kane.dynamics.readings.quantities import parameter_values
from kane.equations.equations import Equations
from kane.equations.instances import STARTS, Instances, has_columns, instances, labelled, package
from kane.equations.state import GROUPS, Guess, State, StateValues, columns_of, state_of
from kane.errors import ArgumentError, KaneError, SimulationError, SingularError, ValueMissingError
from kane.expr.symbols import Symbol, rate, time
from kane.numeric.arrays import Array
from kane.numeric.sampling import finite_number

T = TypeVar("T")
BY_NAME = ("parameters", "inputs", "t")
_OWN = ("instance", "status", "cause", "residual")


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Many states: the values given for each, and the causes of invalid ones by index."""

    eom: Equations
    instances: Instances
    failed: Mapping[int, str]

    @property
    def count(self) -> int:
        """The number of states."""
        return self.instances.count

    @property
    def open(self) -> Iterator[int]:
        """Indices of the valid states."""
        return (k for k in range(self.count) if k not in self.failed)

    def given(self, kind: str) -> Mapping[Any, Any]:
        """Given values of a kind by symbol: numbers, guesses, columns (k)."""
        return {**(self.instances.common[kind] or {}), **self.instances.columns[kind]}

    def state(self, k: int) -> State:
        """State k, without the kinds of values that a State does not have."""
        own = {kind: x for kind, x in self.instances.at(k).items() if kind in GROUPS}
        return State(**own, t=float(np.broadcast_to(self.given("t")[time], self.count)[k]))

    def of_state(self) -> State:
        """All states as one `State` with arrays."""
        own = {kind: dict(self.given(kind)) or None for kind in GROUPS}
        return State(**own, t=self.given("t")[time])

    def numbers(self) -> tuple[Array, Array, Array]:
        """t (k), parameters (k × np) and inputs (k × nr); inputs that are not given are zero."""
        eom, columns = self.eom, self.instances.columns["parameters"]
        plain = {**self.given("parameters"), **{s: float(column[0]) for s, column in columns.items()}}
        constants: dict[Any, Any] = {**parameter_values(eom.system, plain), **columns}
        inputs = self.given("inputs")
        return (
            self._table([self.given("t")[time]])[:, 0],
            self._table([constants[s] for s in eom.parameters]),
            self._table([inputs.get(s, 0.0) for s in eom.inputs]),
        )

    def _table(self, columns: Sequence[Any]) -> Array:
        table = np.empty((self.count, len(columns)))
        for i, column in enumerate(columns):
            table[:, i] = column
        return table

    def first(
        self,
        ask: Callable[[int], T],
        causes: dict[int, str],
        wrong: tuple[type[Exception], ...] = (SimulationError, SingularError),
    ) -> tuple[int, T] | None:
        """The first state for which `ask` succeeds, with its result; causes are recorded for those before it."""
        for k in self.open:
            try:
                return k, ask(k)
            except wrong as error:
                causes[k] = str(error)
        return None

    def rest(
        self,
        ask: Callable[[int], T],
        causes: dict[int, str],
        done: Container[int],
        wrong: tuple[type[Exception], ...] = (),
    ) -> Iterator[tuple[int, T]]:
        """The results of `ask` for all other states, with causes for those that fail; errors in `wrong` are raised."""
        for k in [k for k in self.open if k not in done and k not in causes]:
            try:
                yield k, ask(k)
            except KaneError as error:
                if isinstance(error, wrong):
                    raise
                causes[k] = str(error)

    def each(self, ask: Callable[[int], T]) -> tuple[dict[int, T], dict[int, str]]:
        """The results of `ask` for each state, and the causes of failures; missing values and wrong arguments are raised."""
        causes = dict(self.failed)
        return dict(self.rest(ask, causes, (), (ValueMissingError, ArgumentError))), causes

    def dataset(self, values: Mapping[str, Any], causes: Mapping[int, str], names: Mapping[str, Any]) -> Any:
        """A Dataset of variables over instance; `names` are the labels of their other dimensions.

        Its coordinates are the given values: arrays over instance, or numbers if common to all.
        """
        xarray = package("xarray")
        texts = np.full(self.count, "", dtype=object)
        texts[list(causes)] = list(causes.values())
        status = np.where(texts == "", "found", "failed").astype(object)
        own = dict(values)
        own["status"] = xarray.Variable("instance", status, {"long_name": "found, or failed"})
        own["cause"] = xarray.Variable("instance", texts, {"long_name": "the reason for which there is none"})
        shown: dict[str, Any] = {"instance": np.arange(self.count), **names}
        for kind in (*STARTS, *BY_NAME):
            for s, value in self.given(kind).items():
                if s.name not in own | shown and isinstance(value, float | int | np.ndarray):
                    first = ["instance"] if np.ndim(value) else []
                    shown[s.name] = self.variable(xarray, s, np.asarray(value, dtype=float), first)
        return xarray.Dataset(own, shown)

    def variables(self, symbols: Sequence[Symbol], values: Array) -> dict[str, Any]:
        """Variables for values (symbols × k), by name."""
        taken = (repr(s.name) for s in symbols if s.name in _OWN)
        expected = f"coordinates and speeds with names other than {', '.join(_OWN)}, which the Dataset uses itself"
        expect.none(taken, expected, cure="Rename them.", error=SimulationError)
        xarray = package("xarray")
        return {s.name: self.variable(xarray, s, x) for s, x in zip(symbols, values, strict=True)}

    def variable(self, xarray: Any, s: Symbol, values: Array, first: Sequence[str] = ("instance",)) -> Any:
        """A variable for the values of a symbol, with unit and description."""
        units = self.eom.numeric().value(_units)
        unit = units[s] if s in units else self.eom.unit(s)
        return labelled(xarray, s.name, values, first, unit, "time" if s is time else s.description)


def _units(eom: Equations) -> Mapping[Symbol, str]:
    """Units of all symbols that usually have values, determined once for a system."""
    symbols = (*eom.state, *eom.inputs, *eom.parameters, *eom.reactions, *map(rate, eom.speeds))
    return {**{s: eom.unit(s) for s in symbols}, time: "s"}


def poses(
    eom: Equations, state: State | Any | None, values: StateValues, rates: Mapping[Any, Any] | None = None
) -> Poses | None:
    """The states, if arrays or a Dataset are given, else None.

    Raises
    ------
    ImportError
        without xarray
    SimulationError
        if arrays have different lengths or none at all, or a number is not finite
    ValueMissingError
        if a name is unknown, or has two values
    """
    if hasattr(state, "data_vars"):
        return _of_dataset(eom, state, values)
    at = state_of(state, **values)
    kinds: dict[str, Any] = {kind: getattr(at, kind) for kind in GROUPS} | {"t": {time: at.t}}
    if rates is not None:
        kinds["rates"] = rates
    if not has_columns(kinds):
        return None
    package("xarray")
    return Poses(eom, in_numbers(instances(eom, kinds)), {})


def in_numbers(given: Instances) -> Instances:
    """Instances with common numbers as floats; guesses remain."""
    common = {
        kind: own and {s: x if isinstance(x, Guess) else finite_number("value", s.name, x) for s, x in own.items()}
        for kind, own in given.common.items()
    }
    return replace(given, common=common)


def _of_dataset(eom: Equations, table: Any, values: StateValues) -> Poses:
    """The states of a Dataset, completed by values given by keyword."""
    kinds = columns_of(eom, table)
    count = table.sizes.get("instance", 0)
    if not count or not all(np.shape(x) in ((), (count,)) for own in kinds.values() for x in own.values()):
        raise SimulationError(
            f"Expected a Dataset of states over instance alone, as kn.assemble and kn.trim give it, got the dimensions "
            f"{dict(table.sizes)}. Give columns by name, q={{…}}, u={{…}}."
        )
    lost = np.zeros(count, dtype=bool)
    for x in (x for own in kinds.values() for x in own.values()):
        lost |= ~np.isfinite(x)
    if lost.all():
        raise SimulationError("Expected states in the Dataset, got none that is finite. See its `cause`.")
    texts = table["cause"].to_numpy() if "cause" in table.variables else np.full(count, "")
    failed = {
        k: str(texts[k]) or "Expected finite numbers of the state, got NaN." for k in np.flatnonzero(lost).tolist()
    }
    first = int(np.argmin(lost))
    for own in kinds.values():
        own.update({s: np.where(lost, x[first], x) for s, x in own.items() if np.ndim(x)})
    kinds["t"] = kinds["t"] or {time: 0.0}
    more: dict[str, Any] = dict.fromkeys(kinds)
    more |= {kind: {time: x} if kind == "t" else x for kind, x in values.items() if x is not None}
    return _joined(eom, instances(eom, kinds), in_numbers(instances(eom, more)), count, failed)


def _joined(eom: Equations, one: Instances, other: Instances, count: int, failed: Mapping[int, str]) -> Poses:
    """The values of both, where no symbol has two."""
    if other.count not in (1, count):
        raise SimulationError(f"Expected {count} values of each array beside the Dataset, got {other.count}.")
    common, columns = dict[str, Any](), dict[str, Mapping[Any, Array]]()
    for kind in one.columns:
        pairs = [{**(x.common[kind] or {}), **x.columns[kind]} for x in (one, other)]
        twice = [s.name for s in pairs[0] if s in pairs[1] and s is not time]
        if twice:
            raise ValueMissingError(
                f"Expected one value for {twice[0]}, got two, by the Dataset and by keyword. Drop one: states.drop_vars({twice[0]!r})."
            )
        whole = pairs[0] | pairs[1]
        columns[kind] = {s: x for s, x in whole.items() if isinstance(x, np.ndarray)}
        common[kind] = {s: x for s, x in whole.items() if s not in columns[kind]} or None
    return Poses(eom, Instances(count, common, columns), failed)
