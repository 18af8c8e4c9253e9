# SPDX-License-Identifier: BSD-3-Clause
"""Actions of events: resets of state, parameters and inputs, all computed from the values before, that satisfy the constraints."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from kane.analysis.assembly import assemble
from kane.analysis.state_checks import start_state
from kane.dynamics.readings.quantities import evaluate_along, time_derivative
from kane.equations.equations import Equations
from kane.equations.state import guess
from kane.errors import KaneError, SimulationError, cut
from kane.expr.node import Expr
from kane.expr.symbols import Input, Symbol, input_of
from kane.model.declarations import Event, target
from kane.motion.hybrid.automaton import acting, leapt_over
from kane.motion.inputs.expressions import value
from kane.motion.inputs.functions import Function, input_functions
from kane.motion.inputs.smooth import rounding_of
from kane.motion.solution.phases import Phase
from kane.motion.solution.resumed import inherited_inputs
from kane.motion.start import check_masses
from kane.numeric.arrays import Array
from kane.numeric.sampling import finite_number
from kane.numeric.scale import EPS, EQUAL, NEAR_TIME, SAME_TIME


@dataclass(frozen=True, slots=True, eq=False)
class Instant:
    """A motion at time `t`: equations of the system, `first`, and of the mode, `now`; `x` = (q, u, a); parameters, inputs: `phase`."""

    first: Equations
    now: Equations
    t: float
    x: Array
    phase: Phase

    def values(self, exprs: Sequence[Any]) -> list[Any]:
        """Values of expressions at this instant."""
        q, u, a = (list(part) for part in self.parts)
        inputs = {s: value(f, self.t, self.x) for s, f in self.phase.inputs.items()}
        result: list[Any] = evaluate_along(
            self.now.solved, list(exprs), q, u, self.phase.parameters, inputs, self.t, a, held=False
        )
        return result

    @property
    def parts(self) -> list[Array]:
        """q, u and a."""
        return np.split(self.x, np.cumsum([len(self.first.coordinates), len(self.first.speeds)]))

    def rate(self, e: Expr) -> float | None:
        """The time derivative of an expression along the motion; None if it has none."""
        try:
            return float(self.values([time_derivative(self.first.derived, e)])[0])
        except KaneError:
            return None


def acted(before: Instant, events: Sequence[Event], end: float) -> Instant:
    """The instant after the actions of events; new inputs are defined up to the time `end`.

    Raises
    ------
    SimulationError
        if two events set one symbol to different values, a value is not finite, or the constraints cannot be satisfied
    """
    eom, names = before.first, " and ".join(repr(e.name) for e in events)
    new = _wanted(before, events)
    constants = {p: float(new.get(p, v)) for p, v in before.phase.parameters.items()}
    check_masses(eom, constants)
    phase = Phase(constants, _inputs(before, new, constants, end), tuple(events))
    moved: dict[Expr, float] = {s: new[s] for s in eom.state if s in new}
    x = before.x
    if moved or constants != before.phase.parameters:
        x = _state(Instant(eom, before.now, before.t, x, phase), moved, names)
    return Instant(eom, before.now, before.t, x, phase)


def _wanted(before: Instant, events: Sequence[Event]) -> dict[Expr, Any]:
    """The new values by symbol; SimulationError if two events set different ones."""
    result: dict[Expr, Any] = {}
    by: dict[Expr, Event] = {}
    for event in events:
        for symbol, what in _consequences(before, event).items():
            if symbol in result and not (result[symbol] is what or _equal(result[symbol], what)):
                raise SimulationError(
                    f"Expected one value for {symbol} at t = {before.t:.9g}, got {cut(result[symbol])} from the event "
                    f"{by[symbol].name!r} and {cut(what)} from {event.name!r} at the same time. Combine them into one event, "
                    "or let one of them set another symbol."
                )
            result[symbol], by[symbol] = what, event
    return result


def _equal(a: Any, b: Any) -> bool:
    return isinstance(a, float) and isinstance(b, float) and a == b


def _consequences(before: Instant, event: Event) -> dict[Expr, Any]:
    system = before.first.system
    given = event.then if isinstance(event.then, Mapping) else _asked(before, event)
    wanted: dict[Expr, Any] = {target(system, event, key): what for key, what in given.items()}
    exprs = {s: what for s, what in wanted.items() if isinstance(what, Expr) and not isinstance(s, Input)}
    numbers = before.values(list(exprs.values())) if exprs else []
    wanted |= dict(zip(exprs, map(float, numbers), strict=True))
    who = f"value from the event {event.name!r}"
    return {s: what if isinstance(s, Input) else finite_number(who, str(s), what) for s, what in wanted.items()}


def _asked(before: Instant, event: Event) -> Mapping[Any, Any]:
    """The new values that a user's function returns; SimulationError if it fails or returns anything but a mapping."""
    eom = before.first
    q, u, a = before.parts
    told: dict[str, Any] = {
        "t": before.t,
        "q": dict(zip(eom.coordinates, q.tolist(), strict=True)),
        "u": dict(zip(eom.speeds, u.tolist(), strict=True)),
        "parameters": dict(before.phase.parameters),
    }
    if len(a):
        told["states"] = dict(zip(eom.states, a.tolist(), strict=True))
    try:
        answer = event.then(**told)
    except KaneError:
        raise
    except Exception as error:
        raise SimulationError(
            f"Expected values from the function of the event {event.name!r}, got {type(error).__name__} from it at "
            f"t = {before.t:.6g}: {error}. It is called with the keywords {', '.join(told)}."
        ) from error
    if not isinstance(answer, Mapping):
        raise SimulationError(
            f"Expected a dict {{symbol: value}} from the function of the event {event.name!r}, got {cut(repr(answer))} at "
            f"t = {before.t:.6g}. Return what changes, {{}} where nothing does."
        )
    return answer


def _inputs(
    before: Instant, new: Mapping[Expr, Any], constants: Mapping[Expr, float], end: float
) -> Mapping[Expr, Function]:
    """The inputs after the event; SimulationError if a prescribed motion jumps by more than rounding errors of value and time."""
    given = {s: what for s, what in new.items() if isinstance(s, Input)}
    if not given and constants == before.phase.parameters:
        return before.phase.inputs
    eom, t = before.first, before.t
    laws = inherited_inputs(eom, before.phase, given, constants)
    made = input_functions(eom, laws, (t, max(end, float(np.nextafter(t, np.inf)))), constants)
    for s, rate in pairwise(eom.inputs):
        if input_of(s) is not input_of(rate):
            continue
        laws = before.phase.inputs, made
        (old, now), rates = ([value(f[x], t, before.x) for f in laws] for x in (s, rate))
        near = EQUAL * max(abs(now), abs(old)) + NEAR_TIME * (end - t) * max(map(abs, rates))
        if abs(now - old) > near + sum(rounding_of(f[s])(t) for f in laws):
            raise SimulationError(
                f"Expected the prescribed motion {s} without a jump at t = {t:.9g}, where an event changes it, got {old:.6g} before "
                f"and {now:.6g} after: it would need an infinite force. Let the new law begin where the old one ends."
            )
    return made


def _state(after: Instant, moved: Mapping[Expr, float], names: str) -> Array:
    """(q, u, a) with the new values; constraints determine the dependent coordinates and speeds."""
    eom = after.first
    parts = [
        dict(zip(own, part.tolist(), strict=True))
        for own, part in zip((eom.coordinates, eom.speeds, eom.states), after.parts, strict=True)
    ]
    q, u, a = ({s: moved.get(s, v) for s, v in part.items()} for part in parts)
    if not eom.constraints.constraints:
        return start_state(eom, q, u, a)
    free_q = set(following(eom, moved)) if any(s in moved for s in q) else set[Symbol]()
    free_u = set(eom.dependent_speeds if sum(s in moved for s in u) < len(eom.independent_speeds) else u) - set(moved)
    inputs = {s: value(f, after.t, after.x) for s, f in after.phase.inputs.items()}
    try:
        found = assemble(
            eom,
            q={s: guess(v) if s in free_q else v for s, v in q.items()},
            u={s: guess(v) if s in free_u else v for s, v in u.items()},
            parameters=dict(after.phase.parameters),
            inputs=inputs,
            t=after.t,
        )
    except SimulationError as error:
        dependent = [s.name for s in eom.dependent_speeds if s in moved]
        own = ", ".join(s.name for s in eom.independent_speeds)
        cure = (
            f" {', '.join(dependent)} follow from {own}: set only these."
            if dependent
            else " Set only values that the constraints leave free."
        )
        raise SimulationError(
            f"Expected actions after which the constraints hold, got a state that violates them from the event {names} at t = "
            f"{after.t:.9g}. {error}{cure}"
        ) from error
    return start_state(eom, found.q, found.u, a)


def following(eom: Equations, moved: Mapping[Expr, Any] | set[Symbol]) -> list[Symbol]:
    """The coordinates that constraints determine when others are set: the dependent ones, or all others if enough are set."""
    free = len(eom.coordinates) - len(eom.system.holonomic)
    enough = sum(q in moved for q in eom.coordinates) >= free or not eom.system.dependent_coordinates
    return [q for q in (eom.coordinates if enough else eom.system.dependent_coordinates) if q not in moved]


def after_actions(
    before: Instant, at_once: Sequence[Event], end: float
) -> tuple[Instant, list[Event], list[Event], dict[str, float] | None]:
    """The instant after the actions; events whose thresholds the resets cross; events that acted; the result of `sides`."""
    own = {e.name: e for e in before.first.system.events}
    done = [own[e.name] for e in at_once if e.name in own]
    now, by, met, after = acting(done), list[Event](), list[Event](), before
    met_here = list(done)
    while now:
        prior, after = after, acted(after, now, end)
        by += now
        others = [e for e in own.values() if e not in done]
        quantities = [e.quantity for e in others]
        leapt = (
            leapt_over(others, np.array(prior.values(quantities)), np.array(after.values(quantities))) if others else []
        )
        met += leapt
        done += leapt
        now = acting(leapt)
    after = replace(after, phase=replace(after.phase, by=tuple(by)))
    leaving = sides(before, after, met_here)
    return after, met, by, None if leaving is None else dict.fromkeys([e.name for e in met], 0.0) | leaving


def beyond(before: Instant, after: Instant, events: Sequence[Event], length: float) -> dict[str, float]:
    """The distances of quantities from their thresholds after actions, by event name, if errors of event location explain them.

    An event is located to a fraction of the step, which is at most the phase of this `length`. Larger distances are omitted.
    """
    quantities, levels = [e.quantity for e in events], [e.threshold for e in events]
    old, new = (np.abs(np.array(x.values(quantities)) - levels).tolist() for x in (before, after))
    apart = SAME_TIME * length + 8 * EPS * abs(before.t)
    return {
        e.name: b
        for e, a, b in zip(events, old, new, strict=True)
        if b <= 2 * a and a <= abs(before.rate(e.quantity) or 0.0) * apart
    }


def sides(before: Instant, after: Instant, events: Sequence[Event]) -> dict[str, float] | None:
    """The side to which quantities leave their thresholds: back (±1) if an action reversed their rate, 0 if they pass through.

    Quantities without a rate before are omitted: the start of the next phase decides. None if a quantity already moves away from its
    threshold before the action: then its crossings are too close to be resolved.
    """
    result: dict[str, float] = {}
    for event in events:
        old, new = before.rate(event.quantity), after.rate(event.quantity)
        if old == 0 and event.direction:
            continue
        result[event.name] = 0.0
        if not old or new is None:
            continue
        came = float(-event.direction) if event.direction else -np.sign(old)
        if old * came > 0:
            return None
        if new * came > -EQUAL * abs(old):
            result[event.name] = came
    return result
