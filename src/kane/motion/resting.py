# SPDX-License-Identifier: BSD-3-Clause
"""Events whose quantity is at its threshold but for rounding: along a step, where passages mean nothing, and at the start of a motion.

At a start the first derivative along the motion that is not zero says to which side the quantity leaves.
"""

import math
import warnings
from collections.abc import Mapping, Sequence

import numpy as np

from kane.dynamics.readings.values import time_derivative, without_unknowns
from kane.errors import KaneError, KaneWarning, cut
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import Expr, as_expr
from kane.expr.size import size
from kane.expr.symbols import Rate, Reaction
from kane.expr.visit import substituted
from kane.model.declarations import Event
from kane.motion.compiled_equations import Routines
from kane.motion.drives import constant
from kane.motion.feedback import HeldInput
from kane.motion.formulas import Formula
from kane.motion.met import Fresh, Leaves, Met
from kane.numeric.arrays import Array
from kane.numeric.scale import EPS, NEAR_TIME
from kane.program.build import Task, build_program
from kane.program.passes.rounding import rounding
from kane.program.program import Port

_ROUNDING = 16 * EPS
"""Share of a quantity's terms that rounding may leave of it."""
_STEPS = 64
"""So many steps at most add up their rounding: more are as likely to take it away."""
_ORDERS = 4
"""So many derivatives are asked to which side a quantity leaves its threshold."""


def that_move(met: Sequence[Met], now: Routines, times: Array, values: Array, states: Array, span: float) -> list[Met]:
    """The events met but for those whose quantity (places × events) rests at its threshold all along the step, which are warned of.

    Rounding is that of its largest terms along the step, by the `states` at all places but the first, and of the steps before, each of
    which rounds the state: an error stays where the terms pass zero together.
    """
    if not met or times[-1] - times[0] < NEAR_TIME * span:
        return list(met)
    events, still = now.eom.events, []
    steps = min(1 + span / float(times[-1] - times[0]), _STEPS)
    for event in dict.fromkeys(e for e, _ in met):
        over = np.abs(values[:, events.index(event)] - event.threshold).max()
        if over <= steps * max(
            _rounding(event, now, float(t), state) for t, state in zip(times[1:], states, strict=True)
        ):
            still.append(event)
            warnings.warn(
                f"Expected a quantity of the event {event.name!r} that crosses {event.threshold:g}, got one that stays there but for "
                f"rounding about t = {times[0]:.6g}: {cut(event.quantity)}. Such events are left out. Watch what changes.",
                KaneWarning,
                stacklevel=2,
            )
    return [pair for pair in met if pair[0] not in still]


def at_start(now: Routines, t: float, state: Array, known: Mapping[str, float]) -> tuple[list[Met], Fresh]:
    """The system's events that are met at the start of a motion, and how those at their thresholds leave them.

    A quantity that leaves in the direction of its event meets it. Leaving is no crossing of an event in both directions. Those in
    `known`, by name, were met before; their sides are given, but for 0.
    """
    met: list[Met] = []
    fresh: dict[str, Leaves] = {}
    own = {e.name for e in now.eom.system.events}
    for event, value in zip(now.eom.events, now.watch(t, state), strict=True):
        if event.name not in own:  # what every model watches may not be passed
            continue
        if event.name in known:
            side = known[event.name]
            fresh[event.name] = Leaves(side, 1 if side else departure(event, now, t, state)[1])
        elif abs(value - event.threshold) <= (band := _rounding(event, now, t, state)):
            side, order = departure(event, now, t, state)
            fresh[event.name] = Leaves(side, order, band)
            if side and side == event.direction:
                met.append((event, t))
            elif side == 0 if event.direction else event.breaks:
                warnings.warn(_undecided(event, t, side), KaneWarning, stacklevel=5)
    return met, fresh


def _undecided(event: Event, t: float, side: float) -> str:
    why, cure = (
        ("leaving it is no crossing of an event in both directions", "Give direction=1 or -1, or begin")
        if side
        else (f"the first {_ORDERS} derivatives do not say to which side it leaves", "Begin")
    )
    return (
        f"Expected a start beside the threshold {event.threshold:g} of the event {event.name!r}, got one on it at t = {t:.6g}. "
        f"Whether the event is met there is not known: {why}. {cure} beside it."
    )


def departure(event: Event, now: Routines, t: float, state: Array) -> tuple[float, int]:
    """The sign and order of the first derivative of an event's quantity along the motion that is not zero; 0 if it is not known."""
    solved, values, e = now.eom.solved, now.values(t, state), event.quantity
    laws: dict[Expr, Expr] = {}
    for s, f in zip(now.eom.inputs, now.drives, strict=True):
        if isinstance(f, Formula):
            laws[s] = f.expr
        elif constant(f) is not None or isinstance(f, HeldInput):
            laws[s] = as_expr(values[s])
    try:
        for order in range(1, _ORDERS + 1):
            plain = substituted(without_unknowns(solved, [e])[0], laws)
            (e,) = without_unknowns(solved, [time_derivative(solved.derived, plain)])
            symbols = list(free_symbols([e]))
            code = build_program("quantity", [Port("x", tuple(symbols))], [Task("rate", [e], (1,), ["rate"])])
            ((value, error),) = rounding(code, [float(values[s]) for s in symbols])
            if not abs(value) <= _ROUNDING * error / 2:
                return (float(np.sign(value)), order) if math.isfinite(value) else (0.0, 1)
    except (KaneError, KeyError):  # what has no derivative, or one in rates that are not known
        pass
    return 0.0, 1


def _rounding(event: Event, now: Routines, t: float, state: Array) -> float:
    """What rounding may leave of the terms of a quantity; nothing is known of those of reactions and accelerations."""
    if any(isinstance(s, Reaction | Rate) for s in free_symbols([event.quantity])):
        return 0.0
    terms = float(evaluate(size(event.quantity, {}), now.values(t, state)))
    return _ROUNDING * (terms + abs(event.threshold))
