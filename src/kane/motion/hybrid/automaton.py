# SPDX-License-Identifier: BSD-3-Clause
"""Events and switching surfaces as arguments of a kernel: routines, tables of their kinds, and departures from thresholds.

The routines evaluate quantities, magnitudes of their terms, their rates along the motion, and the values that actions set.

A kernel executes crossings of switching surfaces, events that are noted or end the motion, and actions that set speeds, states and
parameters, and coordinates without constraints, to expressions. It returns to Python at pivots of W, and for actions that are Python
functions or set inputs or parameters on which moments of inertia, beams, switching surfaces or inputs depend.
"""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from kane.dynamics.poles import SLIPS, KinematicsEnd, SlipEnd
from kane.dynamics.readings.quantities import time_derivative, without_unknowns
from kane.equations.compiled import ports
from kane.equations.equations import Equations
from kane.errors import ExpressionError, KaneError, SimulationError, cut, warn
from kane.expr.build import add
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ZERO, Expr, as_expr, postorder
from kane.expr.ops import DIV, POW
from kane.expr.piecewise import on_sides, side_symbols
from kane.expr.regular import Sizes, size
from kane.expr.symbols import Rate, Reaction
from kane.expr.visit import substituted
from kane.model.beams.beam import Beam
from kane.model.bodies import parts_of
from kane.model.declarations import Event, target
from kane.motion.inputs.expressions import Formula, HeldInput, law_ports, parts
from kane.motion.inputs.functions import constant, law_and
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import Given, Routines, has_jumps, quantities, rates, routines, timed
from kane.motion.solution.phases import Phase
from kane.motion.start import moving
from kane.motion.steppers.crossings import KINDS, LEAVES, EventKind
from kane.motion.steppers.crossings import room as zoomed
from kane.motion.steppers.watched import rooms
from kane.numeric.arrays import Array, Mask
from kane.numeric.polynomials import DEGREE as PARTS
from kane.numeric.scale import EQUAL, ROUNDED, ROUNDED_TERMS, SAME_TIME, SOON
from kane.program.from_expressions import Bundle, Task, build_program
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.entry import aligned, aligned_copy, entry, wide_entry
from kane.program.native.machine import Settings
from kane.program.passes.optimize import rounding
from kane.program.program import Port

Met = tuple[Event, float]
"""An event and its time, s."""


class Leaves(NamedTuple):
    """How a quantity leaves its threshold at the beginning of a motion, by its first nonzero derivative, of order `order`.

    `side` is 1 or −1, or 0 if the quantity passes through; within `band` of the threshold its sign may be due to rounding.
    """

    side: float
    order: int = 1
    band: float = 0.0


Fresh = Mapping[str, Leaves]
"""The departures of quantities that are at their thresholds when a motion begins, by event name."""


def leaves_row(leaves: Leaves | None) -> tuple[float, ...]:
    """A row of the kernel's array `leaves`, of length LEAVES."""
    return (0.0,) * LEAVES if leaves is None else (1.0, *leaves, SOON ** (1 / leaves.order))


def watched(eom: Equations, *more: Expr) -> Bundle[tuple[Array, ...]]:
    """The quantities of events, and those of switching surfaces, `more`."""
    roots = [*without_unknowns(eom.solved, [e.quantity for e in eom.events]), *more]
    return _of_events(eom, "events", roots, more, [*(e.name for e in eom.events), *map(str, range(len(more)))])


def glance(eom: Equations, *more: Expr) -> Bundle[tuple[Array, ...]]:
    """The quantities of events and switching surfaces, `more`, then magnitudes of their terms and thresholds, 0 if unknown."""
    roots, memo = [*without_unknowns(eom.solved, [e.quantity for e in eom.events]), *more], Sizes()
    return _of_events(eom, "glance", [*roots, *map(_size, eom.events), *(size(c, memo) for c in more)], more)


def _size(event: Event) -> Expr:
    if any(isinstance(s, Reaction | Rate) for s in free_symbols([event.quantity])):
        return ZERO
    return add(size(event.quantity, {}, late=True), as_expr(abs(event.threshold)))


def tendency(eom: Equations) -> Bundle[tuple[Array, ...]]:
    """The time derivatives of the quantities of events that the system declares, along the motion; 0 if unknown."""
    known, own = {s for port in ports(eom.derived) for s in port.symbols}, {e.name for e in eom.system.events}

    def rate(event: Event) -> Expr:
        if event.name not in own:
            return ZERO
        try:
            (found,) = without_unknowns(eom.solved, [time_derivative(eom.solved.derived, event.quantity)])
        except ExpressionError:
            return ZERO
        return found if known.issuperset(free_symbols([found])) else ZERO

    return _of_events(eom, "tendency", list(map(rate, eom.events)))


def actions(eom: Equations) -> Bundle[tuple[Array, ...]]:
    """The values that actions in the kernel set, in the order of `values_set`."""
    return _of_events(eom, "act", [value for _, _, value in values_set(eom)])


def _of_events(
    eom: Equations, name: str, roots: list[Expr], laws: Sequence[Expr] = (), labels: Sequence[str] = ()
) -> Bundle[tuple[Array, ...]]:
    given = law_ports(eom, laws) if laws else ports(eom.derived)
    return Bundle(name, given, parts, {name: roots}, labels or list(map(str, range(len(roots)))))


def values_set(eom: Equations) -> list[tuple[int, int, Expr]]:
    """The actions in the kernel, as (index of the event, index of the variable set, value).

    Indices of parameters follow those of (q, u, a) and the work; the index −1 marks a mass, which must be positive.
    """
    if moving(eom) or (is_constrained(eom) and eom.system.contacts):
        return []
    place, known = _places(eom), {s for port in ports(eom.derived) for s in port.symbols}
    result = []
    for k, event in enumerate(eom.events):
        if not isinstance(event.then, Mapping):
            continue
        set_ = {target(eom.system, event, key): as_expr(what) for key, what in event.then.items() if _is_value(what)}
        values = without_unknowns(eom.solved, list(set_.values()))
        if len(set_) == len(event.then) and set_.keys() <= place.keys() and known.issuperset(free_symbols(values)):
            new: dict[Expr, Expr] = dict(zip(set_, values, strict=True))
            result += [(k, place[s], value) for s, value in new.items()]
            result += [
                (k, -1, substituted(mass, new))
                for mass in _masses(eom)
                if not new.keys().isdisjoint(free_symbols([mass]))
            ]
    return result


def _places(eom: Equations) -> dict[Expr, int]:
    """Indices of the variables that kernels may set: the state, except constrained coordinates, and parameters of rates and masses."""
    place: dict[Expr, int] = {s: k for k, s in enumerate(eom.state)}
    if is_constrained(eom):
        place = {s: k for s, k in place.items() if s not in set(eom.coordinates)}
    parts, clock = list(parts_of(eom.system.bodies)), timed(eom)
    if eom.system.contacts:
        return place
    judged = [x for part in parts if part.inertia for pair in part.inertia.dyads for v in pair for x in v.scalars()]
    judged += [*clock.pulses, *(turning.quantity for turning in clock.turning)]
    judged += [x for body in eom.system.bodies if isinstance(body, Beam) for _, x in body.measures()]
    fixed, n = free_symbols(judged), len(eom.state) + 1
    return place | {s: n + k for k, s in enumerate(eom.parameters) if s not in fixed}


def _masses(eom: Equations) -> list[Expr]:
    return list(dict.fromkeys(part.mass for part in parts_of(eom.system.bodies) if not part.momenta))


def _is_value(what: object) -> bool:
    return isinstance(what, Expr | int | float | np.number) and not isinstance(what, bool)


def stepped(
    eom: Equations,
    p: Array,
    drives: Sequence[Callable[[Any], Any]],
    settings: Settings | None,
    *others: Callable[[Equations], Bundle[Any]],
) -> Routines:
    """The compiled equations of a motion, with the quantities of their events; see `routines`."""
    now = routines(eom, p, drives, settings, *([watched] if eom.events else []), *others)
    return replace(now, events=now.routine(watched).flat) if eom.events else now


def on_their_sides(now: Routines) -> Routines:
    """The equations with the sides of switching surfaces as parameters, which a kernel sets; unchanged without discontinuities."""
    eom = now.eom
    if not has_jumps(eom, now.laws):
        return now
    every = quantities(eom, now.laws)
    symbols, memo = side_symbols(every), dict[Expr, Expr]()

    def fixed(e: Expr) -> Expr:
        return on_sides(e, symbols, memo)

    written = tuple(replace(f, expr=fixed(f.expr)) if isinstance(f, Formula) else f for f in now.drives)
    own = quantities(eom)
    law = law_and(written, eom.inputs, list(map(fixed, every[len(own) :])))
    turning = (*own, *law.values[len(eom.inputs) :])
    p = np.append(now.p, np.ones(len(every)))
    on_them = replace(now, p=p, quantities=every, written=written, numbers=law.numbers, turning=turning, switches=None)
    there, events, _ = on_them.compiled((rates,), (watched, *turning), (glance, *turning))
    return replace(on_them, rates=there, events=events)


def kind(eom: Equations, event: Event, acting: bool) -> EventKind:
    """How a kernel treats an event; `acting` if it executes the action."""
    if isinstance(event, KinematicsEnd) or (event.then is not None and not acting):
        return EventKind.ASKED
    return EventKind.ACTS if acting else EventKind.ENDS if event.terminal else EventKind.NOTED


def tables(eom: Equations, n: int, switches: int = 0) -> Given:
    """Kernel arguments common to all motions with n state variables: counts, kinds, thresholds and actions of events, work arrays."""
    events, count, own = eom.events, len(eom.events) + switches, {e.name for e in eom.system.events}
    values = values_set(eom)
    acting, none = {k for k, _, _ in values}, [0.0] * switches
    shared = np.array([isinstance(e, SlipEnd) and e.by_share for e in events], dtype=bool)
    kinds = np.array([[float(EventKind.TURNS), 0.0, 0.0, 0.0]] * count).reshape(-1, KINDS)
    for k, event in enumerate(events):
        kinds[k] = kind(eom, event, k in acting), event.direction, event.name in own, bool(event.terminal)
    lengths = rooms(count, len(events), len(values), n)
    return {
        "events": count,
        "own": len(events),
        "acts": len(values),
        "least": np.array([*np.where(shared, 0.0, [e.threshold for e in events]), *none]),
        "shares": np.array([*np.where(shared, SLIPS, 0.0), *none]),
        "pivots": np.array([*(float(isinstance(e, KinematicsEnd)) for e in events), *none]),
        "kinds": kinds.reshape(-1),
        "leaves": np.zeros(count * LEAVES + 1),
        "actions": np.array([*((k, place) for k, place, _ in values), (0, 0)], dtype=float).reshape(-1),
        "zoom": aligned(zoomed(count)),
        **{name: aligned(length) for name, length in lengths.items()},
    }


def automaton(now: Routines, t: float, y: Array, fresh: Fresh, wide: bool = True) -> Given:
    """Kernel arguments for events, followed by switching surfaces, from time t on."""
    assert now.events is not None
    numeric, seen, at = now.eom.numeric(now.settings), now.watch(t, y), (t, y, now.inputs(t, y))
    # vector loads of aligned arrays do not cross cache lines
    made = numeric.value(tables, len(y), len(now.quantities)).items()
    given: Given = {name: what if isinstance(what, int) else aligned_copy(what) for name, what in made}
    given |= {"seen": seen, "largest": np.nan_to_num(np.abs(seen)), "sides_at": len(now.eom.parameters)}
    begin_at(given, now.eom.events, fresh)
    given["kinds"][[k * KINDS for k in asks_for(now)]] = float(EventKind.ASKED)
    for name, routine in evaluated(now).items():
        given |= {name: entry(routine)} | now.hoisted(f"h{name[0]}", routine, *at)
    if wide:
        given["watch"] = wide_entry(now.events, PARTS)
    return given


def evaluated(now: Routines) -> dict[str, CompiledRoutine]:
    """The routines of events by argument of the kernel; the rates are placeholders for those that it does not call."""
    assert now.events is not None
    acts = now.eom.numeric(now.settings).value(values_set)
    looked, *acting = now.compiled((glance, *now.turning), *([(tendency,), (actions,)] if acts else []))
    return {"watch": now.events, "glance": looked} | dict(
        zip(("tendency", "act"), acting or [now.rates] * 2, strict=True)
    )


def asks(eom: Equations) -> bool:
    """Whether some action must be executed in Python."""
    acting = {k for k, _, _ in values_set(eom)}
    return any(e.then is not None and k not in acting for k, e in enumerate(eom.events))


def asks_for(now: Routines) -> list[int]:
    """The indices of events whose actions are executed in Python because they set parameters of inputs."""
    eom, first = now.eom, len(now.eom.state) + 1
    read = {s for f in now.drives if isinstance(f, Formula) for s in f.values}
    set_ = eom.numeric(now.settings).value(values_set) if read else []
    return [k for k, place, _ in set_ if place >= first and eom.parameters[place - first] in read]


def stands_beside(now: Routines, given: Given, t: float, y: Array) -> bool:
    """Whether no quantity is at its threshold at a start, no force outside its cone, and all are finite; writes them to `given`."""
    count, found = len(given["seen"]), now.at(now.routine(glance, *now.turning).flat, t, y)
    given["seen"][:], given["largest"][:], given["leaves"][:] = found[:count], np.abs(found[:count]), 0.0
    return bool(are_beside(now, given, found[:count], found[count:])) and bool(np.isfinite(found).all())


def are_beside(now: Routines, given: Given, values: Array, terms: Array) -> Mask:
    """Whether no quantity (… × n) is at its threshold, and no force outside its cone, at starts (…)."""
    count = values.shape[-1]
    own = given["kinds"].reshape(-1, KINDS)[:count, 2] > 0
    forces = np.array([bool(kind) for kind in now.eom.numeric().value(ends_force)] + [False] * count)[:count]
    away = np.abs(values - given["least"][:count]) > ROUNDED_TERMS * terms
    return np.asarray(((away | ~own) & ~(forces & (values < 0))).all(axis=-1))


def begin_at(given: Given, events: tuple[Event, ...], fresh: Fresh) -> None:
    """Sets the departures of events at their thresholds in the arguments of a kernel."""
    rows = given["leaves"][: len(events) * LEAVES].reshape(-1, LEAVES)
    rows[:] = 0.0
    for k, event in enumerate(events):
        if event.name in fresh:
            rows[k] = leaves_row(fresh[event.name])
            given["seen"][k] = given["least"][k]


def leaving(given: Given, events: tuple[Event, ...]) -> dict[str, Leaves]:
    """The departures of quantities from their thresholds in the present state of a kernel.

    A quantity that was noted at a switching surface, before it crosses its threshold, leaves to the far side.
    """
    rows, count = given["leaves"][: len(events) * LEAVES].reshape(-1, LEAVES), int(given["events"])
    early = given["turns"][count:] if "turns" in given else np.zeros(len(events))
    gaps = given["seen"][: len(events)] - given["least"][: len(events)]
    return {
        event.name: Leaves(float(row[1]), int(row[2]), float(row[3]))
        if row[0]
        else Leaves(-math.copysign(1.0, gap), 1, 2 * abs(gap))
        for event, row, met, gap in zip(events, rows, early, gaps.tolist(), strict=False)
        if row[0] or met > 0
    }


_ORDERS = 4
"""Highest order of the derivatives that may determine the side to which a quantity leaves its threshold."""


def at_start(
    now: Routines,
    t: float,
    state: Array,
    known: Mapping[str, float],
    rtol: float = 0.0,
    rounded: float = 0.0,
    beyond: Mapping[str, float] = MappingProxyType({}),
) -> tuple[list[Met], Fresh]:
    """The system's events that occur at the start of a motion, and the departures of quantities from their thresholds.

    An event occurs if its quantity leaves in its direction; one in both directions does not occur by leaving. Events in `known`, by
    name, have occurred before, and their sides are given, 0 if undetermined; the band is the fraction `rounded` of their terms, as for
    a contact that opens, or twice their distance beyond the threshold: after actions `beyond`, else, with `rounded`, where projection
    has moved them. A state at the end of a motion has the relative error `rtol`: derivatives of this size, as of a quantity that
    constraints kept at its threshold, count as zero.
    """
    share = max(ROUNDED_TERMS, rtol)
    met: list[Met] = []
    fresh: dict[str, Leaves] = {}
    own = {e.name for e in now.eom.system.events}
    for event, value in zip(now.eom.events, now.watch(t, state), strict=True):
        if event.name not in own:  # events that kane adds, such as pivots of W, end the motion
            continue
        if event.name in known:
            side = known[event.name]
            order = 1 if side else departure(event, now, t, state, share)[1]
            band = _rounding(event, now, t, state, rounded) if rounded else 0.0
            if side * (value - event.threshold) < 0:
                band = max(band, 2 * (abs(value - event.threshold) if rounded else beyond.get(event.name, 0.0)))
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
        ("for an event in both directions, leaving the threshold is no crossing", "Give direction=1 or -1, or start")
        if side
        else (f"the first {_ORDERS} derivatives do not show to which side the quantity goes", "Start")
    )
    return (
        f"Expected a start beside the threshold {event.threshold:g} of the event {event.name!r}, got one on it at t = "
        f"{t:.6g}. It is undetermined whether the event occurs there: {why}. {cure} off the threshold."
    )


def departure(event: Event, now: Routines, t: float, state: Array, share: float) -> tuple[float, int]:
    """The sign and order of the first nonzero derivative of an event's quantity along the motion; the sign is 0 if unknown.

    A derivative counts as zero if it is at most the fraction `share` of its terms.
    """
    e = event.quantity
    try:
        for order in range(1, _ORDERS + 1):
            e = time_derivative(now.eom.solved.derived, _known(e, now, t, state))
            e = without_unknowns(now.eom.solved, [e])[0]
            value, error = _with_terms(e, now, t, state)
            if not abs(value) <= share * error / 2:
                return (float(np.sign(value)), order) if math.isfinite(value) else (0.0, 1)
    except (KaneError, KeyError):  # no derivative, or one that contains unknown rates
        pass
    return 0.0, 1


def _known(e: Expr, now: Routines, t: float, state: Array) -> Expr:
    """An expression of time, state and parameters alone: solutions for unknowns and known laws of inputs are substituted."""
    laws: dict[Expr, Expr] = {}
    for s, f in zip(now.eom.inputs, now.drives, strict=True):
        if isinstance(f, Formula):
            laws[s] = f.expr
        elif constant(f) is not None or isinstance(f, HeldInput):
            laws[s] = as_expr(now.values(t, state)[s])
    return substituted(without_unknowns(now.eom.solved, [e])[0], laws)


def _with_terms(e: Expr, now: Routines, t: float, state: Array) -> tuple[float, float]:
    """The value of an expression and the magnitude of its terms."""
    values, symbols = now.values(t, state), list(free_symbols([e]))
    code = build_program("quantity", [Port("x", tuple(symbols))], [Task("rate", [e], (1,), ["rate"])])
    ((value, error),) = rounding(code, [float(values[s]) for s in symbols])
    return value, error


def _rounding(event: Event, now: Routines, t: float, state: Array, share: float = ROUNDED_TERMS) -> float:
    """The fraction `share` of the terms of a quantity; 0 if it contains reactions or accelerations, whose terms are unknown."""
    return share * float(evaluate(_size(event), now.values(t, state)))


def check_witnesses(eom: Equations, constants: Mapping[Expr, float]) -> None:
    """SimulationError if the quantity of an event stays at its threshold because a parameter is zero."""
    for event in eom.system.events:
        symbols = free_symbols([event.quantity])
        gone: dict[Expr, Expr] = {s: ZERO for s in symbols if constants.get(s) == 0}
        if not gone or any(isinstance(s, Rate | Reaction) for s in symbols):
            continue
        left = substituted(event.quantity, gone, {}) if not _divided(event.quantity) else event.quantity
        if all(s in constants for s in free_symbols([left])) and evaluate(left, constants) == event.threshold:
            raise SimulationError(
                f"Expected a quantity of the event {event.name!r} that crosses {event.threshold:g}, got "
                f"{cut(event.quantity)}, which remains there because {' and '.join(f'{s} = 0' for s in gone)}. Give other "
                "values, or leave the event out: system.replace(events=[…])."
            )


def _divided(e: Expr) -> bool:
    """Whether an expression contains divisions or powers, in which zero may not be substituted."""
    return any(node.op in (DIV, POW) for node in postorder([e]))


_TOLD = {
    "opens": "with a normal force ≥ 0, got N = {value:.6g}: the bodies pull each other. Choose the mode 'separated'",
    "slips": "with sufficient friction, got |F| > μ_s N, (Σ μ_s N)² − |F|² = {value:.6g}: it slips. Choose a mode with slip",
}
"""Error texts for the mode of a contact, by the event that would have ended the mode before."""


def ends_force(eom: Equations) -> tuple[str, ...]:
    """For each event, its kind if it ends a mode because contact forces leave their cone; "" otherwise."""
    if not eom.system.modes:
        return ("",) * len(eom.events)
    names = {f"{c.name} {kind}": kind for c in eom.system.contacts for kind in _TOLD}
    return tuple(names.get(e.name, "") for e in eom.events)


def check_forces(now: Routines, t: float, state: Array, known: Collection[str]) -> None:
    """Checks that contact forces lie in their cones up to rounding; events in `known` are at their thresholds.

    Raises
    ------
    SimulationError
        if a normal force is negative, or a contact sticks with |F| > μ_s N
    """
    kinds = now.eom.numeric().value(ends_force)
    if not any(kinds):
        return
    for event, kind, value in zip(now.eom.events, kinds, now.watch(t, state), strict=True):
        if kind and event.name not in known and value < 0 and _beyond(event, now, t, state):
            name = event.name.removesuffix(f" {kind}")
            raise SimulationError(
                f"Expected a contact {name!r} {_TOLD[kind].format(value=value)}, or simulate the system itself, which chooses "
                f"its modes (t = {t:.6g})."
            )


def _beyond(event: Event, now: Routines, t: float, state: Array, share: float = EQUAL) -> bool:
    """Whether a quantity is below zero by more than the fraction `share` of its terms, or NaN."""
    value, terms = _with_terms(_known(event.quantity, now, t, state), now, t, state)
    return not value >= -share * terms


def without_rounding(now: Routines, t: float, state: Array, values: Array) -> Array:
    """Quantities (events), where the least positive number replaces values that are zero, or negative within rounding errors."""
    result = values.copy()
    for k, event in enumerate(now.eom.events):
        if event.threshold == 0.0 and values[k] <= 0 and not _beyond(event, now, t, state, ROUNDED):
            result[k] = np.finfo(float).tiny
    return result


class End(NamedTuple):
    """Why a motion ended: `status` "finished", "event" or "stopped", a message, and the event that ended it, if any.

    `at_once` are all events of that instant, including those whose actions change the motion, which then continues.
    """

    status: str
    message: str
    event: Event | None = None
    at_once: tuple[Event, ...] = ()


def ended_by(at_once: Sequence[Event], noted: Sequence[Met], acted: bool = False) -> End | None:
    """The end due to events of one instant; `acted` if their actions have been executed; None if there are no events."""
    if not at_once:
        return None
    event = next((e for e in at_once if e.terminal), None)
    if event is None:
        return End("event", "", None, tuple(at_once))
    end = ended_by_last([pair for pair in noted if pair[0] is event][:1])
    return end if acted else end._replace(at_once=tuple(at_once))


def ended_by_last(noted: Sequence[Met]) -> End:
    """The end due to the last terminal event, whose action has been executed."""
    event, t = next(pair for pair in reversed(noted) if pair[0].terminal)
    return End("event", f"{event.name} at t = {t:.6g}: {event.message or 'terminal event'}", event)


def up_to_a_break(met: Sequence[Met], length: float) -> tuple[list[Met], tuple[Event, ...]]:
    """The events up to the first that ends or changes the motion, and the events of its instant.

    Times that differ by no more than the accuracy of event location in a step of that `length` are one instant.
    """
    ordered = sorted(met, key=lambda pair: pair[1])
    first = next((t for event, t in ordered if event.breaks), None)
    if first is None:
        return ordered, ()
    near = 2 * SAME_TIME * length + 4 * float(np.spacing(abs(first)))
    return [pair for pair in ordered if pair[1] <= first + near], tuple(
        event for event, t in ordered if abs(t - first) <= near
    )


def acting(events: Sequence[Event]) -> list[Event]:
    """The events with actions."""
    return [e for e in events if e.then is not None]


def leapt_over(events: Sequence[Event], before: Array, after: Array) -> list[Event]:
    """The events whose thresholds are crossed, in their directions, from quantities `before` to those `after` (events)."""
    result = []
    for event, a, b in zip(
        events, before - [e.threshold for e in events], after - [e.threshold for e in events], strict=True
    ):
        if (a > 0 >= b and event.direction <= 0) or (a < 0 <= b and event.direction >= 0):
            result.append(event)
    return result


def phase_after(now: Routines, phase: Phase, t: float, before: Array, by: tuple[Event, ...]) -> Phase:
    """The phase after actions that a kernel executed at the state `before`; the same routine returns the new parameters."""
    eom, first = now.eom, len(now.eom.state) + 1
    acting = [k for k, event in enumerate(eom.events) if event in by]
    set_ = eom.numeric(now.settings).value(values_set)
    places = [(i, place - first) for i, (k, place, _) in enumerate(set_) if k in acting and place >= first]
    if not places:
        return replace(phase, by=by)
    own = np.array([phase.parameters[s] for s in eom.parameters])
    routine, after = now.routine(actions).flat, replace(now, p=np.append(own, now.p[len(own) :]))
    values = routine(t, before[: now.width], after.parameters(routine), now.inputs(t, before))
    return replace(
        phase, parameters={**phase.parameters, **{eom.parameters[j]: float(values[i]) for i, j in places}}, by=by
    )
