# SPDX-License-Identifier: BSD-3-Clause
"""Events that a step meets: quantities looked at on the solver's interpolant, `PARTS` times a step, and located between.

What passes its threshold and comes back between two of them is found by bounds (`bounds`). A pivot of W need not change its sign where
it vanishes (x² of u = x² x'): where it is smallest, it is compared with the largest that it has been. Where a quantity is at its
threshold but for rounding, passages mean nothing: at a start the first derivative along the motion that is not zero says to which
side it leaves.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from typing import NamedTuple

import numpy as np

from kane.dynamics.poles import SLIPS, KinematicsEnd, SlipEnd
from kane.dynamics.readings.quantities import time_derivative, without_unknowns
from kane.equations.equations import Equations
from kane.errors import KaneError, SimulationError, cut, warn
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ZERO, Expr, as_expr, postorder
from kane.expr.ops import DIV, POW
from kane.expr.regular import size
from kane.expr.symbols import Rate, Reaction
from kane.expr.visit import substituted
from kane.model.declarations import Event
from kane.motion.inputs.expressions import Formula
from kane.motion.inputs.feedback import HeldInput
from kane.motion.inputs.functions import constant
from kane.motion.right_hand_side import Routines
from kane.motion.steppers.watched import LOOSE
from kane.numeric.arrays import Array
from kane.numeric.scale import EPS, LATER, NEAR_TIME, SAME_TIME, SOON, UNRELATED
from kane.numeric.sign_changes import MOST, SHARES, SMALL, Bracket, passages, zero_of
from kane.program.from_expressions import Task, build_program
from kane.program.passes.optimize import rounding
from kane.program.program import Port

PARTS = 8
"""In so many parts a step is looked at."""
_BESIDE, _GROWN = (8 * SAME_TIME, 1e-5), 10.0
"""Shares of a step beside a change of sign, and how many times larger a quantity is at the nearer one where that is a pole."""
_TINY = np.finfo(float).tiny
"""What a quantity is that leaves its threshold until it has changed enough to show to which side."""

Watch = Callable[[float, Array], Array]
Dense = Callable[[float], Array]
Met = tuple[Event, float]


class Leaves(NamedTuple):
    """How a quantity leaves its threshold at the beginning of a motion, by the derivative of an `order`.

    To a `side`, 1 or −1, or 0 where it has passed; within `band` of the threshold rounding may give it any sign.
    """

    side: float
    order: int = 1
    band: float = 0.0


Fresh = Mapping[str, Leaves]
"""The events at whose thresholds a motion begins, by name."""


class Verdict(Enum):
    """What becomes of a step that has been inspected."""

    TAKEN = "taken"
    SHORTER = "taken again, shorter"
    UP_TO = "taken again, up to a switch"
    OTHER_SIDE = "taken again, on the other side of a switch"
    SINGULAR = "left to SciPy's solver, which passes singular states"
    TURNED = "not taken: another branch of a closure lies there"
    MISSED = "not taken: a constraint does not hold there"


class Inspection(NamedTuple):
    """The verdict on a step; `t` is where it ends or how long it is then, `which` the switches that turn, `message` what was found."""

    verdict: Verdict
    t: float = 0.0
    which: tuple[int, ...] = ()
    message: str = ""


class End(NamedTuple):
    """Why a motion ended: "finished", "event" or "stopped", in words, and which event ended it.

    `at_once` are all events of that instant, with those that change the motion, which goes on then.
    """

    status: str
    message: str
    event: Event | None = None
    at_once: tuple[Event, ...] = ()


def ended_by(at_once: Sequence[Event], noted: Sequence[Met], acted: bool = False) -> End | None:
    """The end that events of one instant make, whose actions may have been taken; None where there are none."""
    if not at_once:
        return None
    event = next((e for e in at_once if e.terminal), None)
    if event is None:
        return End("event", "", None, tuple(at_once))
    t = next(t for e, t in noted if e is event)
    told = f"{event.name} at t = {t:.6g}: {event.message or 'terminal event'}"
    return End("event", told, event, () if acted else tuple(at_once))


class StepSeen(NamedTuple):
    """A step as events see it: its `times`, the events' quantities there (k × events), the states at all but the first (k − 1 × n)."""

    times: Array
    values: Array
    states: Array


def met_along(
    now: Routines, dense: Dense, step: StepSeen, largest: Array, fresh: Fresh, rtol: float, span: float
) -> tuple[list[Met], End | None]:
    """The events that a step meets, up to one that ends the motion; `largest` are the sizes that their quantities have had."""
    events, (times, values, states) = now.eom.events, step
    found = crossings(events, now.watch, dense, times, values, thresholds(events, largest), fresh)
    found += vanishing(events, now.watch, dense, times, values, largest, rtol)
    moving = that_move(found, now, times, values, states, span)
    noted, at_once = up_to_a_break(moving, float(times[-1] - times[0]))
    return noted, ended_by(at_once, noted)


def still_there(fresh: Fresh, events: Sequence[Event], gaps: Array) -> Fresh:
    """Those that have not left the bands about their thresholds, by the distances of all events after a step."""
    inside = {e.name: abs(gap) for e, gap in zip(events, gaps, strict=True) if e.name in fresh}
    return {name: leaves for name, leaves in fresh.items() if inside.get(name, np.inf) < leaves.band}


def thresholds(events: Sequence[Event], largest: Array) -> Array:
    """The thresholds of events; slips whose friction names none end at a share of the `largest` that they have been."""
    slips = np.array([isinstance(e, SlipEnd) and e.by_share for e in events], dtype=bool)
    return np.where(slips, SLIPS * largest, [e.threshold for e in events])


def crossings(
    events: Sequence[Event],
    watch: Watch,
    dense: Dense,
    times: Array,
    values: Array,
    least: Array,
    fresh: Fresh,
) -> list[Met]:
    """The events that a step meets, in order of time.

    `watch` gives the events' quantities at a time and state, `values` (k × events) those at `times` (k), whose first and last are the
    ends of the step; `least` are their thresholds. Those of `fresh`, by name, are at their thresholds at the beginning.
    """
    met: list[Met] = []
    most = MOST if len(times) == len(SHARES) else 0
    for k, event in enumerate(events):

        def gap(t: float, k: int = k, threshold: float = float(least[k])) -> float:
            return float(watch(t, dense(t))[k] - threshold)

        def gaps(at: Array, gap: Callable[[float], float] = gap) -> Array:
            return np.array([gap(float(t)) for t in at])

        over = values[:, k] - least[k]
        leaves = fresh.get(event.name)
        found = _leaving(gaps, times, over, leaves, most) if leaves else passages(gaps, times, over, most)
        for start, end, a, b in found:
            if event.direction <= 0 < a or a < 0 <= event.direction:
                t = zero_of(gap, start, end, a, b, SAME_TIME * (end - start))
                if not _is_pole(gap, t, times, over):
                    met.append((event, t))
    return sorted(met, key=lambda pair: pair[1])


def up_to_a_break(met: Sequence[Met], length: float) -> tuple[list[Met], tuple[Event, ...]]:
    """The events up to the first that ends the motion or changes it, and those of that instant, if there is one.

    What lies no farther behind than is known of times in a step of that `length` is of the same instant.
    """
    ordered = sorted(met, key=lambda pair: pair[1])
    first = next((t for event, t in ordered if event.breaks), None)
    if first is None:
        return ordered, ()
    near = 2 * SAME_TIME * length + 4 * float(np.spacing(abs(first)))
    return [pair for pair in ordered if pair[1] <= first + near], tuple(
        event for event, t in ordered if abs(t - first) <= near
    )


def _leaving(gaps: Callable[[Array], Array], times: Array, values: Array, leaves: Leaves, most: int) -> list[Bracket]:
    """The passages of a quantity that leaves its threshold, where rounding gives it any sign.

    Until it shows, as tⁿ with its order n, to which side it leaves, only the last passage from that side counts.
    """
    side, order, band = leaves

    def beyond(of: Array) -> Array:
        return np.where(np.abs(of) < band, side * _TINY, of)

    def at(places: Array) -> Array:
        return beyond(gaps(places))

    shares = (times - times[0]) / (times[-1] - times[0])
    begin = times[0] + SOON ** (1 / order) * (times[-1] - times[0])
    later = begin + (times[-1] - begin) * shares
    over = np.append(at(later[:-1]), beyond(values[-1:]))
    found = passages(at, later, over, most)
    if side == 0 or side * over[0] > 0:
        return found
    early = times[0] + (begin - times[0]) * shares
    within = passages(at, early, np.concatenate([[side * _TINY], at(early[1:-1]), over[:1]]), most)
    return [*[bracket for bracket in within if bracket[2] * side > 0][-1:], *found]


def _is_pole(gap: Callable[[float], float], t: float, times: Array, over: Array) -> bool:
    """Whether a quantity changes its sign at t through infinity; `over` are its values at the `times` of the step.

    Towards a pole it grows, beyond its usual size in the step; towards a root it falls, and at a jump one side at least stays.
    """
    usual = np.median(np.abs(over[np.abs(over) > 0]))
    near, far = (share * (times[-1] - times[0]) + 4 * float(np.spacing(abs(t))) for share in _BESIDE)
    within = [s for s in (-1, 1) if times[0] <= t + s * far <= times[-1]]
    sizes = [abs(np.nan_to_num(gap(t + s * near), nan=np.inf)) for s in within]
    return min(sizes, default=0.0) > usual and all(
        size > _GROWN * abs(gap(t + s * far)) for s, size in zip(within, sizes, strict=True)
    )


def leapt(watch: Watch, dense: Dense, times: Array, values: Array) -> float | None:
    """A time at which a switch stands otherwise than at both ends of a step, which it leads across; None where there is none.

    `watch` gives the switches' quantities, `values` (k × switches) those at `times` (k). One that comes near its switch
    between two times, and turns back, is looked for where it is smallest.
    """
    found: list[float] = []
    for k in range(values.shape[1]):
        side = np.sign(values[:, k])
        if side[0] * side[-1] <= 0:
            continue
        within = np.flatnonzero(side == -side[0])
        if len(within):
            found.append(float(times[within[0]]))
            continue

        def beyond(t: float, k: int = k, sign: float = float(side[0])) -> float:
            return sign * float(watch(t, dense(t))[k])

        for start, end in _valleys(beyond, times, np.abs(values[:, k])):
            t = _smallest(beyond, start, end)
            if beyond(t) < 0:
                found.append(t)
                break
    return min(found, default=None)


def _valleys(size: Callable[[float], float], times: Array, sizes: Array) -> list[tuple[float, float]]:
    """Between which times `size` is smallest, in comparison with what is beside."""
    found: list[tuple[int, int]] = []
    if sizes[0] <= sizes[1] and size(float(times[0] + LATER * (times[1] - times[0]))) < sizes[0]:
        found.append((0, 1))
    least = np.flatnonzero((sizes[1:-1] < sizes[:-2]) & (sizes[1:-1] <= sizes[2:]))
    found += [(int(i), int(i) + 2) for i in least]
    if sizes[-1] < sizes[-2] and size(float(times[-1] - LATER * (times[-1] - times[-2]))) < sizes[-1]:
        found.append((len(times) - 2, len(times) - 1))
    return [(float(times[i]), float(times[j])) for i, j in found]


def vanishing(
    events: Sequence[Event], watch: Watch, dense: Dense, times: Array, values: Array, largest: Array, rtol: float
) -> list[Met]:
    """The pivots of W that vanish in a step where they are smallest; `largest` (events) holds the sizes that they have had."""
    met: list[Met] = []
    gone = max(UNRELATED, LOOSE * rtol)
    for k, event in enumerate(events):
        size = np.abs(values[:, k])
        if not isinstance(event, KinematicsEnd) or not size.min() < SMALL * largest[k]:
            continue
        i = int(np.argmin(size))

        def left(t: float, k: int = k) -> float:
            return abs(float(watch(t, dense(t))[k]))

        t = _smallest(left, float(times[max(i - 1, 0)]), float(times[min(i + 1, len(times) - 1)]))
        least, t = min((size[i], float(times[i])), (left(t), t))
        if least <= gone * largest[k]:
            met.append((event, t))
    return met


def _smallest(size: Callable[[float], float], start: float, end: float) -> float:
    """Where `size` is smallest between two times."""
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(size, bounds=(start, end), method="bounded", options={"xatol": 1e-7 * (end - start)})
    return float(found.x)


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
            warn(
                f"Expected a quantity of the event {event.name!r} that crosses {event.threshold:g}, got one that stays there but for "
                f"rounding about t = {times[0]:.6g}: {cut(event.quantity)}. Such events are left out. Watch what changes."
            )
    return [pair for pair in met if pair[0] not in still]


def at_start(
    now: Routines, t: float, state: Array, known: Mapping[str, float], rtol: float = 0.0
) -> tuple[list[Met], Fresh]:
    """The system's events that are met at the start of a motion, and how those at their thresholds leave them.

    A quantity that leaves in the direction of its event meets it. Leaving is no crossing of an event in both directions. Those in
    `known`, by name, were met before; their sides are given, but for 0. A state that a motion led to is known to `rtol`: a quantity
    that constraints held at its threshold till then has rates that are as small, and leaves by those that are not.
    """
    share = max(_ROUNDING, rtol)
    met: list[Met] = []
    fresh: dict[str, Leaves] = {}
    own = {e.name for e in now.eom.system.events}
    for event, value in zip(now.eom.events, now.watch(t, state), strict=True):
        if event.name not in own:  # what every model watches may not be passed
            continue
        if event.name in known:
            side = known[event.name]
            fresh[event.name] = Leaves(side, 1 if side else departure(event, now, t, state, share)[1])
        elif abs(value - event.threshold) <= (band := _rounding(event, now, t, state, share)):
            side, order = departure(event, now, t, state, share)
            fresh[event.name] = Leaves(side, order, band)
            if side and side == event.direction:
                met.append((event, t))
            elif side == 0 if event.direction else event.breaks:
                warn(_undecided(event, t, side))
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


def departure(event: Event, now: Routines, t: float, state: Array, share: float) -> tuple[float, int]:
    """The sign and order of the first derivative of an event's quantity along the motion that is not zero; 0 if it is not known.

    A derivative is zero that is no larger than a `share` of its terms.
    """
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
            if not abs(value) <= share * error / 2:
                return (float(np.sign(value)), order) if math.isfinite(value) else (0.0, 1)
    except (KaneError, KeyError):  # what has no derivative, or one in rates that are not known
        pass
    return 0.0, 1


def _rounding(event: Event, now: Routines, t: float, state: Array, share: float = _ROUNDING) -> float:
    """What rounding may leave of the terms of a quantity; nothing is known of those of reactions and accelerations."""
    if any(isinstance(s, Reaction | Rate) for s in free_symbols([event.quantity])):
        return 0.0
    terms = float(evaluate(size(event.quantity, {}), now.values(t, state)))
    return share * (terms + abs(event.threshold))


def check_witnesses(eom: Equations, constants: Mapping[Expr, float]) -> None:
    """No event whose quantity stays at its threshold for ever, as a parameter that is zero makes it."""
    for event in eom.system.events:
        symbols = free_symbols([event.quantity])
        gone: dict[Expr, Expr] = {s: ZERO for s in symbols if constants.get(s) == 0}
        if not gone or any(isinstance(s, Rate | Reaction) for s in symbols):
            continue
        left = substituted(event.quantity, gone, {}) if not _divided(event.quantity) else event.quantity
        if all(s in constants for s in free_symbols([left])) and evaluate(left, constants) == event.threshold:
            raise SimulationError(
                f"Expected a quantity of the event {event.name!r} that crosses {event.threshold:g}, got {cut(event.quantity)}, which "
                f"stays there as {' and '.join(f'{s} = 0' for s in gone)}. Give other values, or leave the event out: "
                "system.replace(events=[…])."
            )


def _divided(e: Expr) -> bool:
    """Whether a zero in an expression may be divided by."""
    return any(node.op in (DIV, POW) for node in postorder([e]))
