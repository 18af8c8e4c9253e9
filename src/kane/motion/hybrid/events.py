# SPDX-License-Identifier: BSD-3-Clause
"""Events that a step meets: quantities looked at on the solver's interpolant, and located by the search that kernels have.

A pivot of W need not change its sign where
it vanishes (x² of u = x² x'): where it is smallest, it is compared with the largest that it has been. Where a quantity is at its
threshold but for rounding, passages mean nothing: at a start the first derivative along the motion that is not zero says to which
side it leaves.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from functools import cache
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
from kane.motion.hybrid.event_routines import glance
from kane.motion.inputs.expressions import Formula, HeldInput
from kane.motion.inputs.functions import constant
from kane.motion.right_hand_side import Given, Routines
from kane.motion.steppers.crossings import KINDS, LEAVES, MET, inspection_kernel, room
from kane.motion.steppers.watched import LOOSE
from kane.numeric.arrays import Array
from kane.numeric.polynomials import SMALL
from kane.numeric.scale import LATER, NEAR_TIME, ROUNDED_TERMS, SAME_TIME, SOON, UNRELATED
from kane.program.from_expressions import Task, build_program
from kane.program.native.entry import CompiledKernel, Hook, aligned, doubles
from kane.program.native.machine import Settings
from kane.program.passes.optimize import rounding
from kane.program.program import Port

PARTS = 8
"""In so many parts a step is looked at."""
_ENDLESS = 1e300

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
    SINGULAR = "left to SciPy's solver, which passes singular states"
    TURNED = "not taken: another branch of a closure lies there"
    MISSED = "not taken: a constraint does not hold there"
    BENT = "not taken: constraints hold other positions or velocities there"


class Inspection(NamedTuple):
    """The verdict on a step; `t` is how long it is then, 0 where that is not said, `message` what was found."""

    verdict: Verdict
    t: float = 0.0
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
    """A step as events see it: its `times` (9), and the events' quantities there (9 × events)."""

    times: Array
    values: Array


def met_along(
    now: Routines, dense: Dense, step: StepSeen, largest: Array, fresh: Fresh, rtol: float, since: float, end: float
) -> tuple[list[Met], End | None]:
    """The events that a step meets, up to one that ends the motion; `largest` are the sizes that their quantities have had.

    The motion is to lead to `end`, and since the time `since` no action was taken.
    """
    events, (times, values) = now.eom.events, step
    routine, count = now.routine(glance, *now.turning).flat, len(events)

    def look(t: float) -> Array:
        state = dense(t)
        x = state[: now.width]
        found = routine(t, x, now.parameters(routine), now.inputs(t, state) if now.drives else None)
        return np.concatenate([now.watch(t, state)[:count], found[count + len(now.turning) :][:count]])

    found = crossings(events, look, times, values, thresholds(events, largest), fresh, steps_since(times, since, end))
    found += vanishing(events, now.watch, dense, times, values, largest, rtol)
    noted, at_once = up_to_a_break(found, float(times[-1] - times[0]))
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
    look: Callable[[float], Array],
    times: Array,
    values: Array,
    least: Array,
    fresh: Fresh,
    steps: float = math.inf,
) -> list[Met]:
    """The events that a step meets, in order of time, but for those that rest at their thresholds, which are warned of.

    `look` gives the events' quantities at a time, and the sizes of their terms; `values` (9 × events) are those at `times` (9), whose
    first and last are the ends of the step; `least` are their thresholds. Those of `fresh`, by name, are at their thresholds at the
    beginning; of so many `steps` the state holds rounding.
    """
    count, start, h = len(events), float(times[0]), float(times[-1] - times[0])
    kinds = np.zeros((count, KINDS))
    kinds[:, 1] = [e.direction for e in events]
    given: Given = {
        "events": count,
        "values": np.append(values.T, np.zeros(8)),
        "least": np.array([*least, 0.0]),
        "told": np.array([min(steps, _ENDLESS), 0.0]),
        "rests": np.zeros(count + 1),
        "kinds": kinds.reshape(-1),
        "leaves": np.array([*(leaves_row(fresh.get(e.name)) for e in events), np.zeros(LEAVES)]).reshape(-1),
        "met": np.zeros(2 * MET),
        "zoom": aligned(room(count)),
    }

    def glance_at(share: float, x: int, out: int) -> None:
        doubles(out, 2 * count)[:] = look(start + share * h)

    hook = Hook(glance_at)
    found = inspection()(given | {"glance": hook})
    if hook.raised is not None:
        raise hook.raised
    if found < 0:
        back = [
            e.name for e, v, at in zip(events, values.T, least, strict=False) if _returns(fresh.get(e.name), v - at)
        ]
        if back:
            raise SimulationError(
                f"Expected a quantity that leaves its threshold, got that of {back[0]!r}, which goes back through it at once: where "
                "slip begins, friction turns faster than it grows, and forces before it do not tell its direction. Give the contact "
                "static= a little above its mu=: then slip begins with an acceleration of its own."
            )
        raise SimulationError(
            f"Expected at most {MET} events in a step, got more in the one of {h:.3g} s from t = {start:.6g}. Give max_step= of a "
            "tenth of that, or leave out the events that come so often."
        )
    for event, rests in zip(events, given["rests"].tolist(), strict=False):
        if rests:
            warn(
                f"Expected a quantity of the event {event.name!r} that crosses {event.threshold:g}, got one that stays there but for "
                f"rounding about t = {start:.6g}: {cut(event.quantity)}. Such events are left out. Watch what changes."
            )
    # where kinematics end the state just before is meant: there the energy may be infinite
    early = [SAME_TIME * isinstance(e, KinematicsEnd) for e in events]
    met = [(int(k), share) for share, k in given["met"][: 2 * found].reshape(-1, 2).tolist()]
    return [(events[k], start + max(share - early[k], 0.0) * h) for k, share in met]


def _returns(leaves: Leaves | None, beyond: Array) -> bool:
    """Whether a quantity that is to leave its threshold to a side is never on it along a step."""
    return leaves is not None and leaves.side != 0.0 and bool((leaves.side * beyond[1:] < 0.0).all())


def steps_since(times: Array, since: float, end: float) -> float:
    """Of how many steps like this one a motion to `end` is from a time on; without end for the shortest ones."""
    h = float(times[-1] - times[0])
    return math.inf if h < NEAR_TIME * (end - since) else (float(times[0]) - since) / h + 2.0


@cache
def inspection() -> CompiledKernel:
    """The search for events in a step, compiled."""
    return CompiledKernel(inspection_kernel(), Settings())


def leaves_row(leaves: Leaves | None) -> tuple[float, ...]:
    """A row of `leaves` of kernels."""
    return (0.0,) * LEAVES if leaves is None else (1.0, *leaves, SOON ** (1 / leaves.order))


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


_ORDERS = 4
"""So many derivatives are asked to which side a quantity leaves its threshold."""


def at_start(
    now: Routines, t: float, state: Array, known: Mapping[str, float], rtol: float = 0.0, rounded: float = 0.0
) -> tuple[list[Met], Fresh]:
    """The system's events that are met at the start of a motion, and how those at their thresholds leave them.

    A quantity that leaves in the direction of its event meets it. Leaving is no crossing of an event in both directions. Those in
    `known`, by name, were met before; their sides are given, but for 0, and they leave within the share `rounded` of their terms, as a
    contact does that opens: an action sets values of its own. A state that a motion led to is known to `rtol`: a quantity
    that constraints held at its threshold till then has rates that are as small, and leaves by those that are not.
    """
    share = max(ROUNDED_TERMS, rtol)
    met: list[Met] = []
    fresh: dict[str, Leaves] = {}
    own = {e.name for e in now.eom.system.events}
    for event, value in zip(now.eom.events, now.watch(t, state), strict=True):
        if event.name not in own:  # what every model watches may not be passed
            continue
        if event.name in known:
            side = known[event.name]
            order = 1 if side else departure(event, now, t, state, share)[1]
            band = _rounding(event, now, t, state, rounded) if rounded else 0.0
            fresh[event.name] = Leaves(side, order, band)
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
    e = event.quantity
    try:
        for order in range(1, _ORDERS + 1):
            e = time_derivative(now.eom.solved.derived, _known(e, now, t, state))
            e = without_unknowns(now.eom.solved, [e])[0]
            value, error = _with_terms(e, now, t, state)
            if not abs(value) <= share * error / 2:
                return (float(np.sign(value)), order) if math.isfinite(value) else (0.0, 1)
    except (KaneError, KeyError):  # what has no derivative, or one in rates that are not known
        pass
    return 0.0, 1


def _known(e: Expr, now: Routines, t: float, state: Array) -> Expr:
    """An expression in time, the state and parameters alone, with what is solved for and inputs in their places."""
    laws: dict[Expr, Expr] = {}
    for s, f in zip(now.eom.inputs, now.drives, strict=True):
        if isinstance(f, Formula):
            laws[s] = f.expr
        elif constant(f) is not None or isinstance(f, HeldInput):
            laws[s] = as_expr(now.values(t, state)[s])
    return substituted(without_unknowns(now.eom.solved, [e])[0], laws)


def _with_terms(e: Expr, now: Routines, t: float, state: Array) -> tuple[float, float]:
    """A value and the magnitude of what it is summed of."""
    values, symbols = now.values(t, state), list(free_symbols([e]))
    code = build_program("quantity", [Port("x", tuple(symbols))], [Task("rate", [e], (1,), ["rate"])])
    ((value, error),) = rounding(code, [float(values[s]) for s in symbols])
    return value, error


def quantity_along(event: Event, now: Routines, t: float, state: Array) -> tuple[float, float]:
    """The quantity of an event, reactions solved for, and the magnitude of its terms."""
    return _with_terms(_known(event.quantity, now, t, state), now, t, state)


def _rounding(event: Event, now: Routines, t: float, state: Array, share: float = ROUNDED_TERMS) -> float:
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
