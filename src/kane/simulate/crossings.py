# SPDX-License-Identifier: BSD-3-Clause
"""Where events happen within a step: sign changes located on the solver's own interpolant."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from kane.model.events import Event

Array = npt.NDArray[np.float64]

_TIME_TOLERANCE = 1e-12


def crossings(
    events: Sequence[Event],
    watch: Callable[[float, Array], Array],
    dense: Callable[[float], Array],
    span: tuple[float, float],
    values: tuple[Array, Array],
) -> list[tuple[Event, float]]:
    """The events that a step from `span[0]` to `span[1]` meets, in order of time.

    `watch` gives the events' quantities at a time and state, `values` those at both ends of the step.
    """
    from scipy.optimize import brentq

    t_old, t_new = span
    found: list[tuple[Event, float]] = []
    for k, event in enumerate(events):
        a, b = values[0][k] - event.threshold, values[1][k] - event.threshold
        falls, rises = a > 0 >= b and event.direction <= 0, a < 0 <= b and event.direction >= 0
        if not (falls or rises):
            continue

        def gap(t: float, k: int = k, threshold: float = event.threshold) -> float:
            return float(watch(t, dense(t))[k] - threshold)

        at_end = b == 0 or gap(t_old) * gap(t_new) > 0
        t = t_new if at_end else float(brentq(gap, t_old, t_new, xtol=_TIME_TOLERANCE))
        found.append((event, t))
    return sorted(found, key=lambda pair: pair[1])
