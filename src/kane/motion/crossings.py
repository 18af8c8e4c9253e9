# SPDX-License-Identifier: BSD-3-Clause
"""Where events happen within a step: sign changes located on the solver's own interpolant."""

from collections.abc import Callable, Sequence

from kane.model.events import Event
from kane.numeric.arrays import Array

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
    t_old, t_new = span
    met: list[tuple[Event, float]] = []
    for k, event in enumerate(events):
        a, b = values[0][k] - event.threshold, values[1][k] - event.threshold
        falls, rises = a > 0 >= b and event.direction <= 0, a < 0 <= b and event.direction >= 0
        if not (falls or rises):
            continue

        def gap(t: float, k: int = k, threshold: float = event.threshold) -> float:
            return float(watch(t, dense(t))[k] - threshold)

        met.append((event, _located(gap, t_old, t_new, a, b)))
    return sorted(met, key=lambda pair: pair[1])


def _located(gap: Callable[[float], float], t_old: float, t_new: float, a: float, b: float) -> float:
    """Where `gap` passes zero, a and b being its values at the states kept; an end that projection moved across is the place."""
    from scipy.optimize import brentq

    first, last = gap(t_old), gap(t_new)
    if first * a <= 0:
        return t_old
    if b == 0 or last * a > 0:
        return t_new
    return float(brentq(gap, t_old, t_new, xtol=_TIME_TOLERANCE))
