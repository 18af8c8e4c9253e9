# SPDX-License-Identifier: BSD-3-Clause
"""The work of each load along a motion: ∫ (Σ F·v + Σ T·ω) dt, which is −ΔV where a potential energy is declared.

Between samples the power is a cubic spline, so that what loads do within a sample's distance is as fine as the samples are.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from kane.dynamics.readings.energy import depends_on_time
from kane.expr.node import Expr
from kane.model.loads import Load
from kane.numeric.arrays import Array

_LEAST = 4
"""Samples that a cubic spline needs."""


def work_of(
    load: Load, power: Expr, t: Array, values: Callable[[Sequence[Expr]], list[Array]], runs: Sequence[Any]
) -> Array:
    """The work since the start (n), from the values of expressions along a motion; `runs` are the samples of its phases."""
    held = load.potential is not None and not depends_on_time(load.potential)
    (own,) = values([load.potential if held and load.potential is not None else power])
    found = np.empty(len(t))
    done = 0.0
    for at in runs:
        found[at] = done + (own[at[0]] - own[at] if held else _integral(t[at], own[at]))
        done = found[at[-1]]
    return found


def _integral(t: Array, power: Array) -> Array:
    from scipy.interpolate import CubicSpline  # takes its time to import

    if len(t) < _LEAST:
        return np.append(0.0, np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(t)))
    whole = CubicSpline(t, power).antiderivative()
    return np.asarray(whole(t) - whole(t[0]))
