# SPDX-License-Identifier: BSD-3-Clause
"""Measurements of a motion: times, and columns of values with gaps."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane import expect
from kane.dynamics.readings.quantities import asked
from kane.equations.equations import Equations
from kane.errors import SimulationError, UnitError, ValueMissingError, cut
from kane.expr.node import Expr
from kane.motion.solution.tables import named as output_names
from kane.numeric.arrays import Array, Mask

TIMES = ("t", "time")


@dataclass(frozen=True, slots=True, eq=False)
class Measurements:
    """`values` (n × columns) at times t (n), NaN for missing ones; `exprs` are the expressions of the model for the columns."""

    t: Array
    names: tuple[str, ...]
    exprs: tuple[Expr, ...]
    values: Array

    @property
    def there(self) -> Mask:
        """The mask of values that are not missing."""
        return np.isfinite(self.values)

    def between(self, first: int, last: int) -> "Measurements":
        """Rows first … last − 1."""
        return Measurements(self.t[first:last], self.names, self.exprs, self.values[first:last])


def measured(eom: Equations, data: Any, outputs: Mapping[str, Any] | None) -> Measurements:
    """The measurements in a DataFrame, a Dataset or a dict of arrays, with times as the column, index or coordinate "t" or "time".

    Raises
    ------
    SimulationError
        if times do not increase, columns differ in length, or there are no values
    UnitError
        if the unit of a column differs from that of the model
    ValueMissingError
        if there are no times, or a column is neither an output nor a symbol of the equations
    """
    columns, units = _columns(data)
    times = next((name for name in TIMES if name in columns), None)
    if times is None:
        raise ValueMissingError(
            f"Expected times of the data as a column or index 't', got {', '.join(columns) or 'nothing'}. Name one: "
            "data.rename(columns={…: 't'})."
        )
    t = _numbers("t", columns.pop(times))
    own = {name: asked(eom.derived, what) for name, what in output_names(outputs).items()}
    named = {*(s.name for s in (*eom.state, *eom.parameters, *eom.inputs)), *own}
    strange = [name for name in columns if name not in named]
    known = f"outputs= or names of the equations ({', '.join(sorted(named))})"
    expect.none(strange, f"columns of data that are {known}", "{}", error=ValueMissingError)
    exprs = {name: (own[name] if name in own else asked(eom.derived, name)) for name in columns}
    for name, found in exprs.items():
        expect.that(
            found.shape == (), f"an expression for the column {name!r}", "a vector or list", error=SimulationError
        )
        _check_unit(eom, name, found.roots[0], units.get(name))
    values = np.column_stack(
        [_numbers(name, column, len(t)) for name, column in columns.items()] or [np.zeros((len(t), 0))]
    )
    _check_times(t)
    if not np.isfinite(values).any():
        raise SimulationError("Expected data with at least one column of measured values besides t, got none.")
    return Measurements(t, tuple(columns), tuple(found.roots[0] for found in exprs.values()), values)


def _columns(data: Any) -> tuple[dict[str, Any], dict[str, str]]:
    """Columns and units by name."""
    if isinstance(data, Mapping) and not hasattr(data, "data_vars"):
        return {str(key): value for key, value in data.items()}, {}
    if hasattr(data, "data_vars"):  # xarray
        found = {str(name): data[name].values for name in (*data.coords, *data.data_vars) if data[name].ndim == 1}
        units = {str(name): str(data[name].attrs["units"]) for name in data.data_vars if "units" in data[name].attrs}
        return found, units
    if hasattr(data, "columns"):  # pandas
        found = {str(name): data[name].to_numpy() for name in data.columns}
        if not set(TIMES) & set(found) and data.index.name in TIMES:
            found[str(data.index.name)] = data.index.to_numpy()
        units = dict(getattr(data, "attrs", {}).get("units", {}))
        return found, {str(k): str(v) for k, v in units.items()}
    raise SimulationError(
        f"Expected data as a DataFrame, a Dataset or a dict of arrays, got {type(data).__name__}: {cut(repr(data))}."
    )


def _numbers(name: str, given: Any, count: int | None = None) -> Array:
    result = expect.floats(given, f"numbers in the column {name!r}", error=SimulationError)
    if result.ndim != 1 or (count is not None and len(result) != count):
        raise SimulationError(
            f"Expected the column {name!r} as a list of {'numbers' if count is None else f'{count} numbers, as many as times'}, got "
            f"an array of the shape {result.shape}."
        )
    if np.isinf(result).any():
        raise SimulationError(f"Expected finite numbers in the column {name!r}, or NaN for gaps, got an infinite one.")
    return result


def _check_times(t: Array) -> None:
    if not (np.isfinite(t).all() and len(t) > 1 and (np.diff(t) > 0).all()):
        where = next((i for i in range(len(t) - 1) if not t[i + 1] > t[i]), 0)
        told = f"{t[where]:g}, then {t[where + 1]:g} in row {where + 1}" if len(t) > 1 else f"{len(t)} of them"
        raise SimulationError(
            f"Expected times of data that increase, two at least, got {told}. Sort the rows, and drop doubles."
        )


def _check_unit(eom: Equations, name: str, expr: Expr, unit: str | None) -> None:
    if unit is None:
        return
    own = eom.unit(expr)
    if own and unit and own != unit:
        raise UnitError(
            f"Expected the column {name!r} in {own}, the unit of the model, got {unit}. Convert the data, or name the expression that "
            f"was measured: outputs={{{name!r}: …}}."
        )


_WIDTH = 7
"""Number of points in a local fit."""


def starts_of(measured_: Measurements, at: Sequence[int]) -> tuple[dict[Expr, Array], dict[Expr, Array]]:
    """Values and rates of the measured expressions at given rows, by local quadratic fits."""
    values, rates = dict[Expr, Array](), dict[Expr, Array]()
    for k, expr in enumerate(measured_.exprs):
        there = np.flatnonzero(measured_.there[:, k])
        if len(there) < 3:
            continue
        found = []
        for row in at:
            near = there[np.argsort(np.abs(there - row), kind="stable")[:_WIDTH]]
            dt = measured_.t[near] - measured_.t[row]
            found.append(np.polynomial.polynomial.polyfit(dt, measured_.values[near, k], 2)[:2])
        values[expr], rates[expr] = np.array(found).T
    return values, rates
