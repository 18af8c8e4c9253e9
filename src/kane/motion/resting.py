# SPDX-License-Identifier: BSD-3-Clause
"""Events whose quantity is zero along a step but for rounding: what passes there means nothing."""

import warnings
from collections.abc import Sequence

import numpy as np

from kane.errors import KaneWarning, cut
from kane.expr.evaluate import evaluate, free_symbols
from kane.expr.size import size
from kane.expr.symbols import Rate, Reaction
from kane.model.declarations import Event
from kane.motion.met import Met
from kane.motion.routines import Routines
from kane.numeric.arrays import Array

_ROUNDING = 16 * np.finfo(float).eps
"""Share of a quantity's terms that rounding may leave of it."""
_LONG = 1e-9
"""Share of the span from which on a step is long enough to tell."""


def that_move(met: Sequence[Met], now: Routines, times: Array, values: Array, state: Array, span: float) -> list[Met]:
    """The events met but for those whose quantity (places × events) rests at its threshold all along the step, which are warned of."""
    if not met or times[-1] - times[0] < _LONG * span:
        return list(met)
    events, still = now.eom.events, []
    for event in dict.fromkeys(e for e, _ in met):
        over = np.abs(values[:, events.index(event)] - event.threshold).max()
        if over <= _ROUNDING * _terms(event, now, float(times[-1]), state):
            still.append(event)
            warnings.warn(
                f"Expected a quantity of the event {event.name!r} that crosses {event.threshold:g}, got one that stays there but for "
                f"rounding about t = {times[0]:.6g}: {cut(event.quantity)}. Such events are left out. Watch what changes.",
                KaneWarning,
                stacklevel=2,
            )
    return [pair for pair in met if pair[0] not in still]


def _terms(event: Event, now: Routines, t: float, state: Array) -> float:
    """The size of what a quantity is made of; none is known of reactions and accelerations."""
    if any(isinstance(s, Reaction | Rate) for s in free_symbols([event.quantity])):
        return 0.0
    return float(evaluate(size(event.quantity, {}), now.values(t, state))) + abs(event.threshold)
