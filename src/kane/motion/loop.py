# SPDX-License-Identifier: BSD-3-Clause
"""Motions of several phases: integrate up to an event with an action, apply the action, and continue with the new values."""

import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from operator import itemgetter
from typing import Any

import numpy as np

from kane.analysis.assembly import assemble
from kane.analysis.state_checks import check_kinetic_energy, start_state
from kane.dynamics.readings.regularity import undirected
from kane.equations.equations import Equations
from kane.errors import KaneError, SimulationError, warn
from kane.expr.node import Expr
from kane.model.declarations import Event
from kane.motion.course import Course, Method, Solver
from kane.motion.hybrid.actions import Instant, after_actions, beyond
from kane.motion.hybrid.automaton import (
    End,
    acting,
    at_start,
    check_forces,
    ended_by,
    phase_after,
    up_to_a_break,
    without_rounding,
)
from kane.motion.inputs.breakpoints import bumps_of
from kane.motion.inputs.expressions import Formula, HeldInput, controllers
from kane.motion.inputs.functions import Asked, Function, Signal, warn_of_jumps
from kane.motion.methods import AUTO, check_method, chosen
from kane.motion.native import KernelSolver, Stiffness
from kane.motion.right_hand_side import Given, timed
from kane.motion.solution.phases import Phase, joined
from kane.motion.solution.resumed import Begin
from kane.motion.solution.solution import Solution
from kane.motion.solvers.stepping import SolverInPython
from kane.motion.start import (
    check_breakpoints,
    check_events,
    check_first_step,
    check_longest,
    check_mass_matrix,
    check_rates,
    check_regular,
    check_steps,
    check_tolerance,
    massless,
)
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array
from kane.numeric.scale import SAME_TIME
from kane.progress import MESSAGE, Interrupted, far, in_time, is_noted

MOST_STEPS = 1_000_000
_ASKED = 1025
"""Number of times in a span at which a user's function is evaluated in search of pulses."""
STEPS_ASKED = 256
"""Least number of steps over the span if such a function is an input and no breakpoints are given."""
_TIMES = 3
"""Number of successive phases, none longer than rounding of the time, after which a motion is stopped."""


def run(
    eom: Equations,
    span: tuple[float, float],
    begin: Begin,
    given: tuple[Mapping[Expr, float], Mapping[Expr, Function]],
    options: Mapping[str, Any],
    bounds: Mapping[str, Any],
    times: Array,
) -> Solution:
    """The motion from `begin` over `span`, `given` the parameters' values and the inputs; errors after its first phase stop it."""
    method, phase, t = solver(options, bounds).after(begin.steps), Phase(*given), span[0]
    pieces: list[Solution] = []
    short, begun = 0, bounds.get("begun", time.monotonic())
    while True:
        rest = method.after(sum(p.steps for p in pieces))
        try:
            piece, end, now = _phase(
                eom, (t, span[1]), begin, phase, rest, (times, options["settings"], begun), not pieces
            )
        except KaneError as error:
            if not pieces:
                raise
            return _stopped(pieces, f"the motion cannot continue after {_names(phase.by)} at t = {t:.9g}: {error}")
        except Interrupted:  # before the first step of the phase
            if not pieces:
                raise
            return _stopped(pieces, f"{MESSAGE}{t:.6g}")
        pieces.append(piece)
        if not acting(end.at_once):
            return whole(pieces)
        phase, t = piece.phases[-1], float(piece.t[np.searchsorted(piece.phase, piece.phase[-1])])
        before = Instant(eom, now, float(piece.t[-1]), piece.states[-1], phase)
        short = short + 1 if before.t - t <= SAME_TIME * max(abs(before.t), span[1] - span[0]) else 0
        try:
            after, met, by, leaving = after_actions(before, end.at_once, span[1])
        except KaneError as error:
            return _stopped(pieces, f"{_names(acting(end.at_once))} cannot act at t = {before.t:.9g}: {error}")
        # events that act again at the same instant do not leave their thresholds
        again = short > 0 and before.t <= t and {e.name for e in end.at_once} <= {e.name for e in phase.by}
        if leaving is None or short >= _TIMES or again:
            return _stopped(pieces, _without_end(by, before.t, pieces))
        since, t, phase = before.t - t, before.t, after.phase
        q, u, a = after.parts
        past = beyond(before, after, end.at_once, since)
        begin = Begin(q, u, None, a, float(piece.work[-1]), leaving, True, True, since=since, beyond=past)
        final = end.event or next((e for e in met if e.terminal), None)
        pieces[-1] = replace(piece, events=(*piece.events, *((e, t) for e in met)))
        if final is not None or t >= span[1]:
            pieces.append(_last(pieces[-1], after, final, span[1]))
            return whole(pieces)


def whole(pieces: Sequence[Solution]) -> Solution:
    """The phases joined to one solution."""
    made: Solution = joined(pieces) if len(pieces) > 1 else pieces[0]
    return made


def _names(events: Sequence[Event]) -> str:
    return " and ".join(f"the event {e.name!r}" for e in events)


def _without_end(by: Sequence[Event], t: float, pieces: Sequence[Solution]) -> str:
    """The message on events that act infinitely often in finite time (Zeno)."""
    names = {e.name for e in by}
    count = sum(e.name in names for p in pieces for e, _ in p.events)
    return (
        f"{_names(by)} acts without end at t = {t:.9g}, {count} times so far, as for a ball that bounces lower and lower until it "
        "is at rest. End the motion before that by a terminal event on a quantity that becomes small, such as kn.Event('rests', "
        "energy, threshold=…, direction=-1), and continue from there with a model at rest; or replace the event by a force"
    )


def _stopped(pieces: Sequence[Solution], message: str) -> Solution:
    return replace(whole(pieces), status="stopped", message=message, event=None)


def _last(piece: Solution, after: Instant, final: Event | None, end: float) -> Solution:
    """The instant after the last actions as a phase with one sample."""
    told = f"reached t = {end:g}" if final is None else piece.message
    if final is not None and not told:
        told = f"{final.name} at t = {after.t:.6g}: {final.message or 'terminal event'}"
    return replace(
        piece,
        t=piece.t[-1:],
        states=after.x[None, :],
        work=piece.work[-1:],
        samples=piece.samples[-1:],
        phases=(after.phase,),
        phase=piece.phase[-1:] * 0,
        status="finished" if final is None else "event",
        message=told,
        event=final,
        events=(),
        steps=0,
        evaluations=0,
        segments=(),
    )


def _phase(
    eom: Equations,
    span: tuple[float, float],
    begin: Begin,
    phase: Phase,
    solver: Method,
    more: tuple[Array, Any, float],
    first: bool,
) -> tuple[Solution, End, Equations]:
    """Integrates a phase: its solution, End, and final equations. `more`: sample times, settings, the clock's reading at the start."""
    times, settings, begun = more
    constants, drives = phase.parameters, phase.inputs
    stepper = Stepper(eom, np.array([constants[p] for p in eom.parameters]), tuple(drives.values()), settings)
    if eom.system.modes and eom.embedding is not None:  # at the start of a mode an entry of A may be nearly zero
        stepper.reach = np.abs(eom.derived.compared.a).max(axis=0)
    start = admitted_start(stepper, begin, constants, span[0])
    if not first:
        solver = replace(solver, first=None)
    else:
        warn_of_jumps(drives.values(), span, solver.breakpoints)
        for event, value in zip(stepper.eom.events, stepper.now.watch(span[0], start), strict=True):
            if not np.isfinite(value):
                warn(f"The event {event.name!r} is not finite at the start.")
    name = chosen(solver.name, stepper, stepper.now.drives, solver.rtol, solver.max_step)
    solver = replace(
        bounded(solver, drives.values(), span),
        breakpoints=breakpoints_of(eom, phase, span, solver.breakpoints),
        name=name,
        free=solver.name == AUTO,
    )
    check_forces(stepper.now, span[0], start, begin.fresh)
    met, fresh = at_start(stepper.now, span[0], start, begin.fresh, begin.rtol, begin.rounded, begin.beyond)
    course = Course(stepper, solver, span, start, times, solver_by, fresh, begin.since)
    course.pace.begun = begun
    course.events += met
    end = ended_by(up_to_a_break(met, 0.0)[1], met) or _to_its_end(course)
    return _solution(course, end, phase), end, course.rows[-1][1]


def bounded(method: Method, drives: Iterable[Any], span: tuple[float, float]) -> Method:
    """The method with a longest step, unless given: a user's function might jump where no stage is evaluated."""
    asked = not method.breakpoints and any(isinstance(f, Asked) for f in drives)
    return (
        replace(method, max_step=(span[1] - span[0]) / STEPS_ASKED) if asked and method.max_step == math.inf else method
    )


def continued(
    stepper: Stepper,
    method: Method,
    run: tuple[tuple[float, float], Array, Array],
    phase: Phase,
    came: tuple[Given, Stiffness],
    begun: float,
) -> Solution:
    """The whole motion of one phase whose kernel returned at its limit with `came`; `run` is (span, start, sample times)."""
    course = Course(stepper, method, *run, solver_by)
    course.pace.begun = begun
    kernel = course.solver
    assert isinstance(kernel, KernelSolver)
    end = course.follow(kernel.take_over(*came)) or _to_its_end(course)
    return _solution(course, end, phase)


def solver_by(course: Course, name: str, t: float, y: Array) -> Solver:
    """The solver of a course by a method, from y at t: a kernel, or a solver called from Python."""
    return KernelSolver(course, t, y) if name in INTEGRATORS else SolverInPython(course, name, t, y)


def solver(options: Mapping[str, Any], bounds: Mapping[str, Any]) -> Method:
    """The method and limits given by options, checked.

    Raises
    ------
    SimulationError
        if an option is not admissible
    """
    most = bounds["max_steps"]
    return Method(
        check_method(options["method"]),
        check_tolerance("rtol", options["rtol"]),
        check_tolerance("atol", options["atol"]),
        MOST_STEPS if most is None else check_steps(most),
        check_longest("max_step", "length", "step", options["max_step"]),
        check_breakpoints(options["breakpoints"]),
        check_longest("max_seconds", "time", "time by the clock", bounds["max_seconds"]),
        first=check_first_step(bounds["first_step"], options["max_step"], options["method"]),
        bounded=most is not None,
    )


def admitted_start(stepper: Stepper, begin: Begin, constants: Mapping[Expr, float], t0: float) -> Array:
    """The initial y, assembled, projected and checked; sampled controllers are evaluated there."""
    drives = dict(zip(stepper.first.inputs, stepper.now.drives, strict=True))
    given = {"parameters": dict(constants), "inputs": {s: _at_start(f, t0) for s, f in drives.items()}}
    first = (
        start_state(stepper.first, begin.q, begin.u, begin.states)
        if begin.whole
        else _start(stepper.first, begin, given, t0)
    )
    for held in controllers(stepper.now.drives):
        held.due(t0, first)
    return _admissible(stepper, t0, np.append(first, begin.work), bool(begin.rounded))


def _at_start(drive: Any, t: float) -> float:
    """The value of an input during assembly; 0 if it depends on the state or is sampled, since it then prescribes no motion."""
    return 0.0 if getattr(drive, "of_state", False) or isinstance(drive, HeldInput) else float(drive(t))


def breakpoints_of(
    eom: Equations, phase: Phase, span: tuple[float, float], given: Sequence[float] = ()
) -> tuple[float, ...]:
    """The given breakpoints, and those of the rates and inputs of a phase that are known, within the span; in order."""
    drives, constants = phase.inputs, phase.parameters
    own = [f.breakpoints(span) for f in drives.values() if isinstance(f, Formula | Signal)]
    own += [tuple(_asked_bumps(f, span)) for f in drives.values() if isinstance(f, Asked)]
    own += [tuple(held.instants(span[1])) for held in controllers(tuple(drives.values()))]
    return tuple(sorted({*given, *eom.numeric().value(timed).breakpoints(constants, span)}.union(*own)))


def _asked_bumps(function: Asked, span: tuple[float, float]) -> set[float]:
    """The times of pulses of a user's function within the span."""
    found = bumps_of(lambda times: np.array([function(t) for t in times.tolist()]), span, _ASKED)
    return {t for t in found if span[0] < t < span[1]}


def _to_its_end(course: Course) -> End:
    with in_time(lambda: course.pace.late(course.t[-1])):
        try:
            while not is_noted():
                end = course.advance()
                if end is not None:
                    return end
                far(course.far)
        except Interrupted:
            pass
        return course.interrupted()


def _start(eom: Equations, begin: Begin, at: dict[str, Any], t0: float) -> Array:
    """(q, u, a) at the start; with constraints, missing values are solved for (assembly); u = Y q̇ + z if rates are given."""
    q, u = begin.q, begin.u
    if eom.constraints.constraints or begin.rates is not None:
        try:
            assembled = assemble(eom, q=q, u=u, rates=begin.rates, **at, t=t0)
        except SimulationError as error:
            if not begin.goes_on:
                raise
            raise SimulationError(
                "Expected start= whose end satisfies the constraints with the values given now, got one that does not. "
                f"{error} Keep those values, or start from an assembled state: kn.assemble(eom, q={{…}}), then q= and u=."
            ) from error
        q, u = assembled.q, assembled.u
    return start_state(eom, q, u, begin.states)


def _admissible(stepper: Stepper, t0: float, y: Array, decided: bool = False) -> Array:
    """The start, projected onto the constraints; raises a SimulationError if the model is not valid or rates are not finite there.

    If it is `decided` that a contact is closed, its force may be negative by rounding.
    """
    stepper.regularize(t0, y)
    check_regular(stepper.eom, stepper.now.values(t0, y), t0)
    start, numbers = stepper.keep(t0, y)
    if numbers is not None:
        check_kinetic_energy(stepper.eom.speeds, numbers.m, f"at t = {t0:g}")
    stepper.settle(t0, start, numbers)
    values = stepper.now.watch(t0, start)
    if decided:
        values = without_rounding(stepper.now, t0, start, values)
    check_events(stepper.eom, values, t0, lambda: stepper.now.values(t0, start))
    names = stepper.now.rates.labels[:-1]
    constants: dict[Expr, float] = dict(zip(stepper.first.parameters, stepper.now.p.tolist(), strict=True))
    rates = stepper.rate(t0, start)
    if stepper.kinks is not None:
        stepper.kinks.check_start(t0, start[:-1], (stepper.now.p, stepper.now.inputs(t0, start)), rates[:-1])
    check_rates(
        names,
        rates,
        t0,
        lambda: stepper.now.explain(t0, start) + massless(stepper.first, constants),
        lambda: undirected(stepper.now.eom.solved, stepper.now.values(t0, start)),
    )
    check_mass_matrix(stepper.eom, stepper.now.values(t0, start), t0)
    return start


def _solution(course: Course, end: End, phase: Phase) -> Solution:
    stepper, method = course.stepper, course.method
    states = np.array([y for y, _ in course.rows])
    jumps = course.jumps
    begins = np.zeros(len(course.t), dtype=np.int64)
    begins[[row for row, *_ in jumps]] = 1
    phases = [phase]
    for row, by, before in jumps:
        phases.append(phase_after(course.stepper.now, phases[-1], course.t[row], before, by))
    return Solution(
        stepper.first,
        np.array(course.t),
        states[:, :-1],
        states[:, -1],
        phase.parameters,
        phase.inputs,
        end.status,
        end.message,
        end.event,
        tuple(sorted([*course.events, *stepper.changes], key=itemgetter(1))),
        *course.counts,
        tuple(stepper.segments),
        tuple(eom for _, eom in course.rows) if stepper.segments else (),
        rtol=method.rtol,
        atol=method.atol,
        method=course.name,
        phases=tuple(phases),
        phase=np.cumsum(begins),
    )
