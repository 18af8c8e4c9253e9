# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of many motions computed one by one, where they cannot be further states of the equations: mainly with contacts."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from kane.equations.equations import Equations
from kane.equations.instances import Instances, package
from kane.equations.state import State
from kane.errors import KaneError, SimulationError, warn
from kane.expr.symbols import Symbol
from kane.motion.derivatives.parametric_motion import ParametricMotion
from kane.motion.many.results import RecordedQuantity
from kane.motion.runner import Plan
from kane.numeric.arrays import Array
from kane.program.native.machine import Settings
from kane.progress import far

USUAL = 1e-11
"""Default tolerances of motions that are differentiated one by one."""

_FURTHER = ("method", "max_step", "breakpoints", "max_steps", "first_step", "max_seconds")
"""Options of the motions that are passed on."""


def one_by_one(
    found: Any,
    eom: Equations,
    plan: Plan,
    many: Instances,
    kept: Sequence[RecordedQuantity],
    by: tuple[Symbol, ...],
    settings: Settings | None,
) -> Any:
    """The Dataset with the derivatives of the recorded quantities; NaN, with a warning, for motions that are not differentiable.

    Raises
    ------
    SimulationError
        if no motion is differentiable
    """
    t, values, causes = found["t"].values, dict[str, Array](), dict[int, str]()
    for k in range(many.count):
        far(partial("derivatives of motion {} of {}".format, k, many.count))
        try:
            rows = _of_one(eom, plan, State(**many.at(k)), kept, by, settings, t)
        except KaneError as error:
            causes[k] = str(error)
            continue
        for one, row in zip(kept, rows, strict=True):
            values.setdefault(one.name, np.full((many.count, *row.shape), np.nan))[k] = row
    if causes:
        first = f"{len(causes)} of {many.count}, of instance {min(causes)}: {causes[min(causes)]}"
        if len(causes) == many.count:
            raise SimulationError(f"Expected motions that have derivatives, got none of {first}")
        warn(f"Expected motions that have derivatives, got none of {first}")
    own = {}
    for one in kept:
        table = values[one.name]
        first_dims = ["instance"] if one.reduce else ["instance", "t"]
        dims = [*first_dims, *["axis"][: table.ndim - len(first_dims) - 1], "by"]
        own[f"{one.name}_by"] = package("xarray").Variable(dims, table, {"long_name": f"derivative of {one.name}"})
    return found.assign(own).assign_coords(by=("by", [s.name for s in by]))


def _of_one(
    eom: Equations, plan: Plan, given: State, kept: Sequence[RecordedQuantity], by: tuple[Symbol, ...], settings: Settings | None,
    t: Array,
) -> list[Array]:  # fmt: skip
    """The derivatives of the recorded quantities of one motion, at times t or reduced over them."""
    rtol, atol = (USUAL if one is None else one for one in (plan.rtol, plan.atol))
    further = {name: value for name, value in plan._asdict().items() if name in _FURTHER and value is not None}
    course = ParametricMotion.of(eom, plan.span, by, given, (rtol, atol), settings, further)
    along = course.sensitivities(course.motion(t))
    rows = np.maximum(np.searchsorted(along.t, t, side="right") - 1, 0)
    result = []
    for one in kept:
        part = along[one.what][rows]
        part[along.t[rows] != t] = np.nan
        result.append(part if one.reduce is None else np.asarray(one.reduce(part)))
    return result
