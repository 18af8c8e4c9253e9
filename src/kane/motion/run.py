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
from kane.motion.singular_rates import check_regular
from kane.motion.smooth import check_prescribed
from kane.motion.solution import Solution
from kane.motion.start import (
    check_breakpoints,
    check_events,
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
    span: tuple[float, float],
    *,
    q: Mapping[Any, float] | Sequence[float] | Array,
    u: Mapping[Any, float] | Sequence[float] | Array | None = None,
    rates: Mapping[Any, float] | Sequence[float] | Array | None = None,
    parameters: Mapping[Any, float] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    t: float | None = None,
    method: str = "auto",
    rtol: float = 1e-9,
    atol: float = 1e-9,
    samples: int | Sequence[float] = 501,
    max_steps: int | None = None,
    max_step: float | None = None,
    breakpoints: Sequence[float] = (),
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
    span : (float, float)
    q, u : start values by symbol or name, or in the order of `eom.coordinates` and `eom.speeds`
    rates : the rates of the coordinates at the start, by coordinate, in place of `u`
    parameters : values by symbol or name; those left out take their defaults
    inputs : for each input a number, an expression of time, parameters, coordinates and speeds, a signal, a table of time, a function
        f(t) or f(t, x) with x = (q, u, a), or a sampled controller (`kn.sampled`); for several at once, {(f1, f2): …}
    t : the time of the start values, if they come with one (`**point.arguments`): the span must begin there
    method : "auto", one that runs in machine code ("gauss16", "dop853", "tsit5", for stiff equations "radau9", and at steps of
        the length max_step "rk4" and the symplectic "midpoint"), or one of SciPy's "RK23", "RK45", "DOP853", "Radau", "BDF",
        "LSODA". "auto" takes machine code where constraints do not bend and no tables jump; `sol.method` says which ran
    rtol, atol : relative tolerance, and absolute one, in the units of coordinates and speeds
    samples : how many evenly spaced times to return, or the times; the start and the end always come too
    max_steps : after how many steps to stop; unless told, after a million, or 10,000 that led on by less than 1e-4 of the span
    max_seconds : after what time by the clock to stop
    max_step : the longest step (s): what an input does within an eighth of a step may be leapt over
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
    t0, _ = span = check_span(span)
    _check_begun_at(t, span)
    solver = Method(
        check_method(method),
        check_tolerance("rtol", rtol),
        check_tolerance("atol", atol),
        _MOST_STEPS if max_steps is None else check_steps(max_steps),
        check_longest("max_step", "length", "step", max_step),
        check_breakpoints(breakpoints),
        check_longest("max_seconds", "time", "time by the clock", max_seconds),
        bounded=max_steps is not None,
    )
    constants = parameter_values(eom.system, parameters)
    check_masses(eom, constants)
    drives = input_functions(eom, inputs, span, own_parameters(parameters) | constants)
    check_prescribed(eom, constants, span)
    if (u is None) == (rates is None):
        raise SimulationError(f"Expected either u= or rates= at the start, got {'neither' if u is None else 'both'}.")
    with working("Simulating"):
        stepper = Stepper(eom, np.array([constants[p] for p in eom.parameters]), tuple(drives.values()), settings)
        start = _begun(stepper, q, u, rates, parameters, t0, states)
        for event, value in zip(eom.events, stepper.now.watch(t0, start), strict=True):
            if not np.isfinite(value):
                warnings.warn(f"The event {event.name!r} is not finite at the start.", KaneWarning, stacklevel=2)
        solver = replace(solver, breakpoints=_breakpoints(solver.breakpoints, eom, drives, constants, span))
        solver = replace(solver, name=chosen(method, stepper, stepper.now.drives, solver.max_step), free=method == AUTO)
        kind = NativeCourse if solver.name in INTEGRATORS else Course
        course = kind(stepper, solver, span, start, sample_times(samples, span))
        end = _to_its_end(course)
    given = {"parameters": parameters, "inputs": inputs, "breakpoints": breakpoints, "settings": settings}
    solution = _repeatable(_solution(course, end, constants, drives), max_step, given)
    _check_kept(solution, check)
    return solution


def _check_begun_at(t: float | None, span: tuple[float, float]) -> None:
    if t is not None and abs(t - span[0]) > _SAME_TIME * max(map(abs, span)):
        raise SimulationError(
            f"Expected a span that begins at the time of the start values, t = {t:.9g}, got t = {span[0]:.9g}. Begin it there, or "
            "take start values that hold at its beginning."
        )


def _repeatable(solution: Solution, max_step: float | None, given: dict[str, Any]) -> Solution:
    return replace(solution, _again=partial(_again, solution, max_step, given))


def _again(
    solution: Solution, max_step: float | None, given: dict[str, Any], *, halved: bool = False, **more: Any
) -> Solution:
    """The same motion once more, at other tolerances or half the steps."""
    if halved and max_step is not None:
        max_step /= 2
    # where others have led on, "auto" finds them again
    method = AUTO if ", " in solution.method else solution.method
    start = {"q": solution.q[0], "u": solution.u[0], "states": solution.a[0], "method": method, "max_step": max_step}
    with warnings.catch_warnings():  # of what is wrong with the motion it has warned
        warnings.simplefilter("ignore", KaneWarning)
        span = float(solution.t[0]), float(solution.t[-1])
        return simulate(solution.equations, span, samples=solution.t.tolist(), **start, **given, **more)


def _begun(stepper: Stepper, q: Any, u: Any, rates: Any, parameters: Any, t0: float, states: Any) -> Array:
    """The start, whole and admissible; sampled controllers have been asked there."""
    drives = dict(zip(stepper.first.inputs, stepper.now.drives, strict=True))
    begin = {"parameters": parameters, "inputs": {s: _at_start(f, t0) for s, f in drives.items()}}
    first = _start(stepper.first, q, u, rates, begin, t0, states)
    for held in controllers(stepper.now.drives):
        held.due(t0, first)
    return _admissible(stepper, t0, np.append(first, 0.0))


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


def _start(eom: Equations, q: Any, u: Any, rates: Any, at: dict[str, Any], t0: float, states: Any) -> Array:
    """(q, u, a), what is left out solved for where there are constraints; u = Y q̇ + z of rates."""
    if eom.constraints.constraints or rates is not None:
        assembled = assemble(eom, q=q, u=u, rates=rates, **at, t=t0)
        q, u = assembled.q, assembled.u
    return start_state(eom, q, u, states)


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
