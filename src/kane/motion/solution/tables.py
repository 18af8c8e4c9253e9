# SPDX-License-Identifier: BSD-3-Clause
"""Motions as tables of pandas and xarray, with units."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from kane.equations.equations import Equations
from kane.equations.instances import AXES, labelled, package
from kane.errors import ArgumentError, cut
from kane.expr.node import Expr
from kane.numeric.arrays import Array


def columns(motion: Any, outputs: Mapping[str, Any] | None) -> dict[str, tuple[Array, str, str]]:
    """Values (n × …), unit and description by name: coordinates, speeds, further states, inputs, then the outputs."""
    eom: Equations = motion.equations
    own = (*eom.state, *eom.inputs)
    result = {s.name: (np.asarray(motion[s]), eom.unit(s), s.description) for s in own}
    for name, what in named(outputs).items():
        if name in result or name == "t":
            raise ArgumentError(
                f"Expected a new name for an output, got {name!r}, which the motion already has. Choose another."
            )
        result[name] = (np.asarray(motion[what]), eom.unit(what) if isinstance(what, Expr) else "", "")
    return result


def named(outputs: Any) -> Mapping[str, Any]:
    """Outputs by name; an empty mapping if there are none.

    Raises
    ------
    ArgumentError
        if they are not a dict with names as keys
    """
    if outputs is None:
        return {}
    if isinstance(outputs, Mapping) and all(isinstance(name, str) for name in outputs):
        return outputs
    raise ArgumentError(
        f"Expected outputs as a dict of names and expressions, got {cut(repr(outputs))}. Name each: {{'height': q1*kn.sin(q2)}}."
    )


def facts(motion: Any) -> dict[str, Any]:
    """Attributes of a motion as a whole: texts and numbers."""
    own = {
        name: getattr(motion, name) for name in ("status", "message", "method", "rtol", "atol", "steps", "evaluations")
    }
    return own | {f"parameter {p.name}": float(v) for p, v in motion.parameters.items()}


def dataframe(motion: Any, outputs: Mapping[str, Any] | None) -> Any:
    """See Solution.to_dataframe."""
    pandas = package("pandas")
    table: dict[str, Array] = {}
    units: dict[str, str] = {}
    for name, (values, unit, _) in columns(motion, outputs).items():
        parts = values.reshape(len(values), -1)
        ends = [""] if values.ndim == 1 else _labels(values.shape[1:])
        for k, end in enumerate(ends):
            table[name + end], units[name + end] = parts[:, k], unit
    frame = pandas.DataFrame(table, index=pandas.Index(motion.t, name="t"))
    frame.attrs = {"units": {"t": "s"} | units, **facts(motion)}
    return frame


def _labels(shape: tuple[int, ...]) -> list[str]:
    """Suffixes of the names of components: .x, .y, .z for vectors, .1.1 for other shapes."""
    if shape == (3,):
        return [f".{a}" for a in AXES]
    return ["".join(f".{i + 1}" for i in place) for place in np.ndindex(*shape)]


def dataset(motion: Any, outputs: Mapping[str, Any] | None) -> Any:
    """See Solution.to_xarray."""
    xarray = package("xarray")
    variables = {}
    for name, (values, unit, description) in columns(motion, outputs).items():
        variables[name] = labelled(xarray, name, values, ["t"], unit, description)
    for text, values in motion.regimes.items():
        told = {"long_name": f"regime of {text}: the sign of its switching quantity; for friction, 1 while it slides"}
        variables[f"regime {text}"] = xarray.Variable("t", values, told)
    coordinates: dict[str, Any] = {"t": xarray.Variable("t", motion.t, {"units": "s", "long_name": "time"})}
    if any("axis" in v.dims for v in variables.values()):
        coordinates["axis"] = list(AXES)
    return xarray.Dataset(variables, coordinates, facts(motion))
