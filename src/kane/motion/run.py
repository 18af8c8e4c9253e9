# SPDX-License-Identifier: BSD-3-Clause
"""`simulate`: integrate the compiled equations of motion, in machine code or by SciPy's solvers."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from kane.analysis.assemble import assemble
from kane.analysis.state import check_equations, start_state
from kane.dynamics.readings.undirected import undirected
from kane.dynamics.readings.values import parameter_values
from kane.equations.equations import Equations
from kane.errors import KaneWarning, SimulationError
from kane.expr.node import Expr
from kane.motion.beams import warn_of_beams
from kane.motion.breakpoints import in_loads
from kane.motion.checking import check_drifts, checking_functions
from kane.motion.drives import Function, Signal, input_functions
from kane.motion.feedback import HeldInput, controllers
from kane.motion.formulas import Formula, own_parameters
from kane.motion.jumps import warn_of_jumps
from kane.motion.methods import AUTO, check_method, chosen
from kane.motion.native import NativeCourse
from kane.motion.resumed import Begin, begin_of, check_fits, inherited_inputs, inherited_parameters, told
from kane.motion.singular_rates import check_regular
from kane.motion.smooth import check_prescribed
from kane.motion.solution import Solution
from kane.motion.start import (
    check_breakpoints,
    check_events,
    check_first_step,
    check_longest,
    check_masses,
    check_rates,
    check_span,
    check_steps,
    check_tolerance,
    massless,
    sample_times,
)
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.stepping import Course, End, Method
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array
from kane.program.native.machine import Settings
from kane.progress import far, working

_MOST_STEPS = 1_000_000
_SAME_TIME = 1e-12
"""Share of the span's ends by which the time of a start may differ from its beginning."""


def simulate(
    eom: Equations,
    span: tuple[float, float] | float,
    *,
    q: Mapping[Any, float] | Sequence[float] | Array | None = None,
    u: Mapping[Any, float] | Sequence[float] | Array | None = None,
    rates: Mapping[Any, float] | Sequence[float] | Array | None = None,
    start: Solution | None = None,
    parameters: Mapping[Any, float] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    t: float | None = None,
    method: str | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    samples: int | Sequence[float] = 501,
    max_steps: int | None = None,
    max_step: float | None = None,
    first_step: float | None = None,
    breakpoints: Sequence[float] | None = None,
    max_seconds: float | None = None,
    settings: Settings | None = None,
    check: Sequence[Any] = (),
    states: Mapping[Any, float] | Sequence[float] | Array | None = None,
) -> Solution:
    """The motion from `span[0]` to `span[1]` (s).

    The power of the loads without a potential is integrated with the state, so that `sol.energy_check` holds the integration to
    the energy; a motion that does not keep it warns. Terminal events of the system end the motion; where the right-hand side becomes
    infinite or NaN, or a constraint cannot be kept, it stops, and the solution holds what there is.

    Parameters
    ----------
    eom : Equations
    span : (float, float), or the end alone where the motion goes on from `start`
    q, u : start values by symbol or name, or in the order of `eom.coordinates` and `eom.speeds`
    rates : the rates of the coordinates at the start, by coordinate, in place of `u`
    start : a motion to go on from, in place of start values: from its end and with its work, parameters, inputs, tolerances and,
        unless it comes from a file, its other options, so far as none are given here. Its equations may have other loads and
        constraints, if bodies and speeds are the same. `sol + more` is the whole
    parameters : values by symbol or name; those left out take their defaults
    inputs : for each input a number, an expression of time, parameters, coordinates and speeds, a signal, a table of time, a function
        f(t) or f(t, x) with x = (q, u, a), or a sampled controller (`kn.sampled`); for several at once, {(f1, f2): …}
    t : the time of the start values, if they come with one (`**point.arguments`): the span must begin there
    method : "auto" unless told, one that runs in machine code ("gauss16", "dop853", "vern9", "tsit5", for stiff equations "radau9",
        and at steps of the length max_step "rk4" and the symplectic "midpoint"), or one of SciPy's "RK23", "RK45", "DOP853", "Radau",
        "BDF", "LSODA". "auto" takes machine code where constraints do not bend and no tables jump; `sol.method` says which ran
    rtol, atol : relative tolerance, and absolute one, in the units of coordinates and speeds; 1e-9 unless told
    samples : how many evenly spaced times to return, or the times; the start and the end always come too
    max_steps : after how many steps to stop; unless told, after a million, or 10,000 that led on by less than 1e-4 of the span
    max_seconds : after what time by the clock to stop
    max_step : the longest step (s): what an input does within an eighth of a step may be leapt over
    first_step : the length of the first step (s); unless told, one over which an Euler step and the change of rates are small
    breakpoints : times at which loads or inputs jump or switch: steps end there, and begin anew
    settings : how to compile
    states : start values of further states, by symbol or name, or in the order of `eom.states`; those left out take their defaults
    check : integrals, such as `eom.integrals`, and expressions that must stay constant: a motion along which one does not warns

    Raises
    ------
    ValueMissingError
        if a start value, parameter or input is missing or unknown
    SimulationError
        if the start is not admissible, or the integration fails
    """
    check_equations(eom)
    checking_functions(eom.derived, check)
    begin, span = begin_of(
        start, {"q": q, "u": u, "rates": rates, "states": states, "parameters": parameters, "inputs": inputs}, span
    )
    t0, t1 = span = check_span(span)
    _check_time(t if start is None else float(start.t[-1]), t0, t1)
    options = told(
        {
            "method": method,
            "rtol": rtol,
            "atol": atol,
            "max_step": max_step,
            "breakpoints": breakpoints,
            "settings": settings,
        },
        start,
    )
    bounds = {"max_steps": max_steps, "max_seconds": max_seconds, "first_step": first_step}
    values = inherited_parameters(eom, start, parameters)
    constants = parameter_values(eom.system, values)
    check_masses(eom, constants)
    law = inherited_inputs(eom, start, inputs, own_parameters(values) | constants)
    drives = input_functions(eom, law, span, own_parameters(values) | constants)
    if start is not None:
        check_fits(eom, start, drives, constants)
        begin = replace(begin, whole=begin.whole and eom.derived is start.equations.derived)
    check_prescribed(eom, constants, span)
    with working("Simulating"):
        solution = _run(eom, span, begin, (constants, drives), options, bounds, sample_times(samples, span))
    given = {"parameters": values, "inputs": law, "first_step": first_step} | {
        name: options[name] for name in ("breakpoints", "settings", "max_step")
    }
    solution = _repeatable(solution, start, given)
    _check_kept(solution, check)
    return replace(solution, _options=options)


def _check_time(t: float | None, t0: float, t1: float) -> None:
    """Start values of a time `t` begin a span there."""
    if t is not None and abs(t0 - t) > _SAME_TIME * max(abs(t0), abs(t1)):
        raise SimulationError(
            f"Expected a span that begins at the time of the start values, t = {t:.9g}, got one from {t0:.9g}. Begin it there, or "
            "take start values that hold at its beginning."
        )


def _run(
    eom: Equations,
    span: tuple[float, float],
    begin: Begin,
    given: tuple[Mapping[Expr, float], Mapping[Expr, Function]],
    options: Mapping[str, Any],
    bounds: Mapping[str, Any],
    times: Array,
) -> Solution:
    """A motion with values of its parameters and its inputs."""
    solver, (constants, drives) = _solver(options, bounds), given
    stepper = Stepper(
        eom, np.array([constants[p] for p in eom.parameters]), tuple(drives.values()), options["settings"]
    )
    start = _begun(stepper, begin, constants, span[0])
    for event, value in zip(eom.events, stepper.now.watch(span[0], start), strict=True):
        if not np.isfinite(value):
            warnings.warn(f"The event {event.name!r} is not finite at the start.", KaneWarning, stacklevel=3)
    solver = replace(solver, breakpoints=_breakpoints(solver.breakpoints, eom, drives, constants, span))
    name = chosen(solver.name, stepper, stepper.now.drives, solver.rtol, solver.max_step)
    solver = replace(solver, name=name, free=solver.name == AUTO)
    kind = NativeCourse if name in INTEGRATORS else Course
    course = kind(stepper, solver, span, start, times, _fresh(eom, begin))
    return _solution(course, _to_its_end(course), constants, drives)


def _solver(options: Mapping[str, Any], bounds: Mapping[str, Any]) -> Method:
    most = bounds["max_steps"]
    return Method(
        check_method(options["method"]),
        check_tolerance("rtol", options["rtol"]),
        check_tolerance("atol", options["atol"]),
        _MOST_STEPS if most is None else check_steps(most),
        check_longest("max_step", "length", "step", options["max_step"]),
        check_breakpoints(options["breakpoints"]),
        check_longest("max_seconds", "time", "time by the clock", bounds["max_seconds"]),
        first=check_first_step(bounds["first_step"], options["max_step"], options["method"]),
        bounded=most is not None,
    )


def _fresh(eom: Equations, begin: Begin) -> dict[int, float]:
    """At which of the events' thresholds a motion begins: it has passed them, and is to meet them when it comes back."""
    own, names = {e.name for e in eom.system.events}, {e.name for e in begin.fresh}
    return {k: 0.0 for k, e in enumerate(eom.events) if e.name in names & own}


def _repeatable(solution: Solution, start: Solution | None, given: dict[str, Any]) -> Solution:
    return replace(solution, _again=partial(_again, solution, start, given))


def _again(
    solution: Solution, start: Solution | None, given: dict[str, Any], *, halved: bool = False, **more: Any
) -> Solution:
    """The same motion once more, at other tolerances or half the steps."""
    if halved and given["max_step"] is not None:
        given = given | {"max_step": given["max_step"] / 2}
    # where others have led on, "auto" finds them again
    method = AUTO if ", " in solution.method else solution.method
    begin: dict[str, Any] = (
        {"q": solution.q[0], "u": solution.u[0], "states": solution.a[0]} if start is None else {"start": start}
    )
    with warnings.catch_warnings():  # of what is wrong with the motion it has warned
        warnings.simplefilter("ignore", KaneWarning)
        span = float(solution.t[0]), float(solution.t[-1])
        return simulate(
            solution.equations, span, samples=np.unique(solution.t).tolist(), method=method, **begin, **given, **more
        )


def _begun(stepper: Stepper, begin: Begin, constants: Mapping[Expr, float], t0: float) -> Array:
    """The start, whole and admissible; sampled controllers have been asked there."""
    drives = dict(zip(stepper.first.inputs, stepper.now.drives, strict=True))
    given = {"parameters": dict(constants), "inputs": {s: _at_start(f, t0) for s, f in drives.items()}}
    first = (
        start_state(stepper.first, begin.q, begin.u, begin.states)
        if begin.whole
        else _start(stepper.first, begin, given, t0)
    )
    for held in controllers(stepper.now.drives):
        held.due(t0, first)
    return _admissible(stepper, t0, np.append(first, begin.work))


def _at_start(drive: Any, t: float) -> float:
    """An input where the state is sought: what follows from the state moves nothing, and is left out."""
    return 0.0 if getattr(drive, "of_state", False) or isinstance(drive, HeldInput) else float(drive(t))


def _breakpoints(
    given: tuple[float, ...],
    eom: Equations,
    drives: Mapping[Expr, Function],
    constants: Mapping[Expr, float],
    span: tuple[float, float],
) -> tuple[float, ...]:
    """Those given, and those that loads and inputs are known to have."""
    warn_of_jumps(drives.values(), span, given)
    own = [f.breakpoints(span) for f in drives.values() if isinstance(f, Formula | Signal)]
    own += [tuple(held.instants(span[1])) for held in controllers(tuple(drives.values()))]
    return tuple(sorted({*given, *in_loads(eom, constants, span)}.union(*own)))


def _to_its_end(course: Course | NativeCourse) -> End:
    while (end := course.advance()) is None:
        far(course.far)
    return end


def _check_kept(solution: Solution, functions: Sequence[Any]) -> None:
    """Warn of an energy, or another function, that changes along the motion though it should not."""
    if solution.status != "stopped" and not solution.keeps_energy:
        warnings.warn(_wrong_energy(solution), KaneWarning, stacklevel=3)
    if functions:
        check_drifts(solution.checking_functions(functions), solution.rtol)
    warn_of_beams(solution)


def _wrong_energy(solution: Solution) -> str:
    check = solution.energy_check
    return (
        f"Expected E − ∫P dt constant along the motion, got a change of {check.drift:.3g} J, {check.relative:.1g} of what there is at "
        f"t = {check.at:.4g} s: the motion is not to be trusted from about there on. Tighten rtol= and atol= from {solution.rtol:g} "
        f"and {solution.atol:g}, choose another method=, or look for what switches or becomes singular on the way."
    )


def _start(eom: Equations, begin: Begin, at: dict[str, Any], t0: float) -> Array:
    """(q, u, a), what is left out solved for where there are constraints; u = Y q̇ + z of rates."""
    q, u = begin.q, begin.u
    if eom.constraints.constraints or begin.rates is not None:
        try:
            assembled = assemble(eom, q=q, u=u, rates=begin.rates, **at, t=t0)
        except SimulationError as error:
            if not begin.goes_on:
                raise
            raise SimulationError(
                f"Expected start= whose end satisfies the constraints with the values given now, got one that does not. {error} Leave "
                "those values as they were, or begin anew from an assembled state: kn.assemble(eom, q={…}), then q= and u=."
            ) from error
        q, u = assembled.q, assembled.u
    return start_state(eom, q, u, begin.states)


def _admissible(stepper: Stepper, t0: float, y: Array) -> Array:
    """The start moved onto the constraints; the model holds there, and the rates are finite."""
    check_regular(stepper.eom, stepper.now.values(t0, y), t0)
    start, numbers = stepper.keep(t0, y)
    stepper.settle(t0, start, numbers)
    check_events(stepper.first, stepper.now.watch(t0, start), t0, lambda: stepper.now.values(t0, start))
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
    return start


def _solution(
    course: Course | NativeCourse, end: End, constants: Mapping[Expr, float], drives: Mapping[Expr, Function]
) -> Solution:
    stepper, method = course.stepper, course.method
    states = np.array([y for y, _ in course.rows])
    return Solution(
        stepper.first,
        np.array(course.t),
        states[:, :-1],
        states[:, -1],
        constants,
        drives,
        end.status,
        end.message,
        end.event,
        tuple(sorted([*course.events, *stepper.changes], key=lambda pair: pair[1])),
        course.steps,
        course.evaluations,
        tuple(stepper.segments),
        tuple(eom for _, eom in course.rows) if stepper.segments else (),
        rtol=method.rtol,
        atol=method.atol,
        method=course.name,
    )
