# SPDX-License-Identifier: BSD-3-Clause
"""`simulate`: integrate the compiled equations of motion, in machine code or by solvers of SciPy or SUNDIALS; warnings on results."""

import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from kane.dynamics.readings.quantities import parameter_values
from kane.equations.compiled import Kept
from kane.equations.equations import Equations, check_equations
from kane.equations.state import State, state_of
from kane.errors import KaneWarning, SimulationError, warn
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Input, Parameter, input_of
from kane.model.beams.beam import Beam, doubts
from kane.motion.course import Method
from kane.motion.inputs.expressions import Formula, by_symbol, given_parameters
from kane.motion.inputs.functions import asked, input_functions
from kane.motion.integrators import AdaptiveStep, FixedStep
from kane.motion.loop import MOST_STEPS, STEPS_ASKED, breakpoints_of, run, solver
from kane.motion.methods import AUTO, chosen
from kane.motion.runner import Plan, Runner, check_values, is_plain
from kane.motion.solution.accuracy import variational_errors
from kane.motion.solution.checks import check_drifts, checking_functions
from kane.motion.solution.resumed import (
    OPTIONS,
    begin_of,
    check_fits,
    inherited_inputs,
    inherited_parameters,
    last_phase,
    merged_options,
)
from kane.motion.solution.solution import Solution
from kane.motion.start import check_span, sample_times
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array, distinct
from kane.numeric.scale import SAME_TIME
from kane.program.native.machine import Settings
from kane.progress import check_whole, noted, working

if TYPE_CHECKING:
    from kane.motion.contact_batch import ContactBatch, ContactCalls  # slow to import


def simulate(
    eom: Equations,
    span: tuple[float, float] | float,
    *,
    q: Mapping[Any, float] | Sequence[float] | Array | None = None,
    u: Mapping[Any, float] | Sequence[float] | Array | None = None,
    rates: Mapping[Any, float] | Sequence[float] | Array | None = None,
    start: Solution | State | None = None,
    parameters: Mapping[Any, float] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    t: float | None = None,
    method: str | AdaptiveStep | FixedStep | None = None,
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
    """Integrate the equations of motion from `span[0]` to `span[1]` (s).

    The power of loads without potential is integrated with the state, so that `sol.energy_check` can compare it with the change of
    energy; a warning is given if they disagree. Terminal events of the system end the motion. If the right-hand side becomes
    infinite or NaN, or a constraint cannot be satisfied, the motion stops there, and the solution contains the part before.

    Parameters
    ----------
    eom : Equations
    span : (start, end), s; or the end alone if the motion continues `start`
    q, u : initial values by symbol or name, or in the order of `eom.coordinates` and `eom.speeds`; 0 sets all to zero
    rates : initial rates q̇, by coordinate, instead of `u`
    start : a `kn.State` instead of q, u, states, parameters, inputs and t; or a Solution to continue from its end, with its work,
        parameters, inputs, tolerances and (unless it was read from a file) other options, except for those given here. The
        equations may have other loads and constraints, with the same bodies and speeds. `sol + more` joins both
    parameters : values by symbol or name, also of parameters that only inputs contain; those left out take their defaults
    inputs : for each input a number, an expression in time, parameters, coordinates and speeds, a `kn.signal`, a table over time, a
        function f(t) or f(t, x) with x = (q, u, a), or a sampled controller (`kn.sampled`); for several at once, {(f1, f2): …}
    t : time of the initial values (s); if given, the span must start there
    method : "auto" by default. In machine code: "gauss16", "dop853", "tsitpap8", "vern9", "tsit5", for stiff equations "radau9",
        with a fixed step max_step "rk4" and the symplectic "midpoint". From SciPy: "RK23", "RK45", "DOP853", "Radau", "BDF",
        "LSODA". From SUNDIALS, for stiff equations: "cvode" (`pip install 'kane[stiff]'`). "auto" takes machine code unless
        constraints have corners or tables jump; `sol.method` is the method used. Or an integrator with its options,
        `kn.Gauss16(rtol=1e-10)`, instead of the keywords: see `kn.integrators`
    rtol, atol : relative and absolute tolerance, the latter in the units of coordinates and speeds; 1e-9 by default
    samples : number of evenly spaced times to return, or the times; start and end are always included
    max_steps : number of steps to stop after; by default a million, or 10,000 that together advance by less than 1e-4 of the span
    max_seconds : elapsed real time (s) to stop after
    max_step : largest step (s); changes of inputs within an eighth of a step may be missed. By default 1/256 of the span if inputs
        are Python functions and no `breakpoints` are given
    first_step : length of the first step (s); by default estimated from the rates and their change
    breakpoints : times (s) at which loads or inputs jump or switch; steps end there, and the integrator restarts
    settings : a `kn.Settings` for the compiled code
    states : initial values of further states, by symbol or name, or in the order of `eom.states`; those left out take their
        defaults
    check : integrals, such as `eom.integrals`, and expressions that should be constant; a warning is given if one of them is not

    Returns
    -------
    Solution

    Raises
    ------
    ValueMissingError
        if an initial value, parameter or input is missing, or a name is unknown
    SimulationError
        if the initial state is not admissible, or the integration fails
    """
    check_equations(eom)
    checking_functions(eom.derived, check)
    plan = Plan(span, method, rtol, atol, samples, max_steps, max_step, first_step, breakpoints, max_seconds).spelled()
    if start is None and rates is None and t is None:
        result = repeated(
            _stored_runners(eom, plan, inputs, settings), eom, plan, (q, u, states, parameters), inputs, settings, check
        )
        if result is not None:
            return result
    if isinstance(start, State):
        at = state_of(start, q=q, u=u, states=states, parameters=parameters, inputs=inputs, t=t)
        q, u, parameters, inputs, t, states = at.in_order
        start, t = None, t or None
    begin, span = begin_of(
        start, {"q": q, "u": u, "rates": rates, "states": states, "parameters": parameters, "inputs": inputs}, span
    )
    span = check_span(span)
    for told in (t, None if start is None else float(start.t[-1])):
        _check_time(told, *span)
    options, bounds = _options(plan, settings, start)
    values = inherited_parameters(eom, start, parameters, inputs)
    constants = parameter_values(eom.system, values)
    check_values(eom, np.array([constants[p] for p in eom.parameters]), span)
    known = given_parameters(values) | constants
    law = inherited_inputs(eom, None if start is None else last_phase(start), inputs, known)
    drives = input_functions(eom, law, span, known)
    if start is not None:
        check_fits(eom, start, drives, constants)
        begin = replace(begin, whole=begin.whole and eom.derived is start.equations.derived)
    with working("Simulating"), noted():
        solution = _runs(eom)(eom, span, begin, (constants, drives), options, bounds, sample_times(samples, span))
    again = repeating(start, _given(parameters, inputs, plan.first_step, options))
    check_conserved(solution := replace(solution, _again=again, _options=options), check)
    return solution


def _runs(eom: Equations) -> Callable[..., Solution]:
    """The function that integrates motions of the equations; that for contacts is slow to import."""
    if not eom.system.contacts:
        return run
    from kane.motion.contact_motion import run_over_time

    return run_over_time(eom)


class Runners:
    """The runners of one plan, as many as were in use at the same time; the `first` calls are made without one."""

    def __init__(self, first: int = 0) -> None:
        self._free, self._left, self.is_plain = list["Runner | ContactCalls"](), first, True

    def ready(self) -> bool:
        """Whether a runner is to be used for this call, which is counted."""
        self._left -= 1
        return self.is_plain and self._left < 0

    def take(self, made: Callable[[], "Runner | ContactCalls | None"]) -> "Runner | ContactCalls | None":
        """A free runner, or a new one by `made()`; None if the motions of the plan need the general loop."""
        try:
            return self._free.pop()
        except IndexError:
            runner = made()
            self.is_plain = runner is not None
            return runner

    def give_back(self, runner: "Runner | ContactCalls") -> None:
        """Marks a runner as free."""
        self._free.append(runner)


def _stored_runners(eom: Equations, plan: Plan, inputs: Any, settings: Settings | None) -> Runners | None:
    """The runners stored with the equations for a plan with these inputs, used from the second motion on; None if inputs vary."""
    if not are_fixed(eom, inputs):
        return None
    try:
        if isinstance(plan.samples, np.integer):
            plan = plan._replace(samples=int(plan.samples))
        elif type(plan.samples) is not int:
            times = np.asarray(plan.samples, dtype=float)
            plan = plan._replace(samples=(times.shape, times.tobytes()))
        kept, key = eom.numeric(settings).value(_plans), (plan, tuple((inputs or {}).items()))
        runners = kept.get(key)
        if runners is None:
            kept.put(key, runners := Runners(first=1))
        return runners
    except (TypeError, ValueError):  # arguments without a key: the caller handles or rejects them
        return None


def _plans(eom: Equations) -> Kept[Runners]:
    return Kept()


def are_fixed(eom: Equations, inputs: Any, given: Collection[Any] = ()) -> bool:
    """Whether each input is a number, or an expression whose parameters may change without further checks.

    Parameters that the model does not contain have a default, or are `given`. A motion prescribed by an expression with corners is
    checked for jumps at given values.
    """
    if inputs is not None and not isinstance(inputs, dict):
        return False
    laws = [v for v in (inputs or {}).values() if isinstance(v, Expr)]
    if not all(isinstance(v, Expr | int | float) for v in (inputs or {}).values()):
        return False
    varied = [s for s in free_symbols(laws) if isinstance(s, Parameter)]
    own, moving = {*eom.parameters, *given}, {str(input_of(s)) for s in eom.inputs if not isinstance(s, Input)}
    bent = any(
        str(key) in moving and not Formula(v, {}).smooth for key, v in (inputs or {}).items() if isinstance(v, Expr)
    )
    return not varied or (not bent and all(s in own or s.default is not None for s in varied))


def repeated(
    runners: Runners | None,
    eom: Equations,
    plan: Plan,
    at: tuple[Any, Any, Any, Any],
    inputs: Any,
    settings: Settings | None,
    check: Sequence[Any],
) -> Solution | None:
    """The motion from `at` = (q, u, states, parameters) by a stored runner; None if it needs the general loop."""
    if runners is None or at[0] is None or at[1] is None or not runners.ready():
        return None
    runner = runners.take(lambda: single_runner(eom, plan, inputs, settings))
    if runner is None:
        return None
    try:
        solution, kept = by_runner(runner, eom, plan, at, inputs)
    finally:
        runners.give_back(runner)
    if solution is None:
        return None
    if not kept or check:
        check_conserved(solution, check)
    return solution


def by_runner(
    runner: "Runner | ContactCalls", eom: Equations, plan: Plan, at: tuple[Any, Any, Any, Any], inputs: Any
) -> tuple[Solution | None, bool]:
    """The motion by a runner in exclusive use, and whether its energy balance certainly holds; None if it needs the general loop."""
    q, u, states, parameters = at
    parameters = by_symbol(eom, parameters, inputs) if inputs else parameters
    if parameters is None:
        runner.usual = runner.usual or parameter_values(eom.system, None)
    constants = dict(runner.usual) if parameters is None else parameter_values(eom.system, parameters)
    runner.take(eom, given_parameters(parameters) | constants)
    again = repeating(None, _given(parameters, inputs, plan.first_step, runner.options))
    x = runner.begin(eom, (q, u, states), constants)
    return (None, False) if x is None else runner.run(eom, x, constants, again)


def _options(plan: Plan, settings: Settings | None, start: Solution | None) -> tuple[dict[str, Any], dict[str, Any]]:
    """The options of a plan, with those left out taken from `start` or the defaults, and its limits."""
    given = {name: copy(getattr(plan, name)) for name in OPTIONS if name != "settings"}
    bounds = {name: getattr(plan, name) for name in ("max_steps", "max_seconds", "first_step")}
    return merged_options(given | {"settings": settings}, start), bounds


def runner_of(
    eom: Equations, plan: Plan, inputs: Any, settings: Settings | None, parameters: Mapping[Any, float] | None = None
) -> Runner | None:
    """A runner for the motions of a plan; None if they need Python between two steps.

    `parameters`, if given, are inserted in the inputs, and the runner is for motions with these values only.
    """
    span, constants = check_span(plan.span), None if parameters is None else parameter_values(eom.system, parameters)
    method, drives, options = _method_and_inputs(eom, plan, inputs, settings, parameters)
    p = np.array(
        [(1.0 if s.default is None else s.default) if constants is None else constants[s] for s in eom.parameters]
    )
    stepper = Stepper(eom, p, tuple(drives.values()), settings)
    name = chosen(method.name, stepper, stepper.now.drives, method.rtol, method.max_step)
    method = replace(method, name=name, free=method.name == AUTO)
    if not is_plain(stepper, method):
        return None
    return Runner(stepper, method, span, sample_times(plan.samples, span), drives, options)


def single_runner(eom: Equations, plan: Plan, inputs: Any, settings: Settings | None) -> "Runner | ContactCalls | None":
    """A runner for single motions of a plan, one call of machine code each; None if they need Python between two steps."""
    own = runner_of(eom, plan, inputs, settings)
    contacts = contacts_of(eom, plan, inputs, settings) if own is None else None
    return own if contacts is None else contacts.single()


def contacts_of(
    eom: Equations, plan: Plan, inputs: Any, settings: Settings | None, parameters: Mapping[Any, float] | None = None
) -> "ContactBatch | None":
    """A runner for motions of a plan with contacts; None without contacts, or if the motions need other code."""
    if not eom.system.contacts:
        return None
    from kane.motion.contact_batch import ContactBatch, leads_contacts

    method, drives, options = _method_and_inputs(eom, plan, inputs, settings, parameters)
    span = check_span(plan.span)
    if not leads_contacts(eom, drives, method):
        return None
    return ContactBatch(eom, method, span, drives, sample_times(plan.samples, span), options)


def _method_and_inputs(
    eom: Equations, plan: Plan, inputs: Any, settings: Settings | None, parameters: Mapping[Any, float] | None
) -> tuple[Method, Mapping[Expr, Any], dict[str, Any]]:
    """The method, inputs and options of the motions of a plan; inputs may contain `parameters` if these are given."""
    options, bounds = _options(plan, settings, None)
    parameters = by_symbol(eom, parameters, inputs)
    usual: dict[Expr, Any] = {p: 1.0 if p.default is None else p.default for p in eom.parameters}
    known = usual if parameters is None else given_parameters(parameters) | parameter_values(eom.system, parameters)
    return solver(options, bounds), input_functions(eom, inputs, check_span(plan.span), known), options


def _check_time(t: float | None, t0: float, t1: float) -> None:
    """A SimulationError unless the span begins at the time `t` of the start values."""
    if t is not None and abs(t0 - t) > SAME_TIME * max(abs(t0), abs(t1)):
        raise SimulationError(
            f"Expected a span that begins at the time of the start values, t = {t:.9g}, got one from {t0:.9g}. Begin the span "
            "there, or give start values at its beginning."
        )


_MORE = 4
"""Limit of the steps of a repeated motion, as a multiple of those of the first."""


def repeating(start: Solution | None, given: dict[str, Any]) -> Callable[..., Any]:
    """A function of a motion that repeats it, from its beginning or from the end of `start`."""
    return partial(_again, start, given)


def _given(parameters: Any, inputs: Any, first: Any, options: Mapping[str, Any]) -> dict[str, Any]:
    """Copies of the arguments for a repetition, since the caller may change the originals."""
    own = {name: options[name] for name in ("breakpoints", "settings", "max_step")}
    parameters, inputs = (dict(x) if isinstance(x, Mapping) else copy(x) for x in (parameters, inputs))
    return own | {"parameters": parameters, "inputs": inputs, "first_step": first}


def _again(
    start: Solution | None,
    given: dict[str, Any],
    solution: Solution,
    samples: Array | None = None,
    variational: bool = False,
    **more: Any,
) -> Solution | Array:
    """Repeats a motion with other samples, or with smaller tolerances or steps; or its errors by the variational equations."""
    if variational:
        own = solution.phases[0], (float(solution.t[0]), float(solution.t[-1]))
        known = breakpoints_of(solution.equations, *own, given["breakpoints"] or ())
        return variational_errors(solution, known, given["settings"])
    if samples is None:
        given = _finer(solution, given)
    else:
        more |= {"rtol": solution.rtol, "atol": solution.atol}
    more["max_steps"] = max(MOST_STEPS, _MORE * solution.steps)
    # if several methods were used, "auto" chooses them again
    method = AUTO if ", " in solution.method else solution.method
    begin: dict[str, Any] = (
        {"q": solution.q[0], "u": solution.u[0], "states": solution.a[0]} if start is None else {"start": start}
    )
    times = distinct(solution.t if samples is None else samples).tolist()
    with warnings.catch_warnings():  # the motion itself has given these warnings
        warnings.simplefilter("ignore", KaneWarning)
        span = float(solution.t[0]), float(solution.t[-1])
        result: Solution = check_whole(
            simulate(solution.equations, span, samples=times, method=method, **begin, **given, **more)
        )
        return result


def _finer(solution: Solution, given: dict[str, Any]) -> dict[str, Any]:
    """The arguments with half the largest step, as this may limit the steps."""
    longest = given["max_step"]
    if longest is None and asked(tuple(solution.inputs.values())):
        longest = (solution.t[-1] - solution.t[0]) / STEPS_ASKED
    if longest is not None:
        longest = float(longest) / 2
        first = given["first_step"]
        given = given | {"max_step": longest, "first_step": first if first is None else min(first, longest)}
    return given


def check_conserved(solution: Solution, functions: Sequence[Any]) -> None:
    """Warn if the energy minus work, or another function that should be constant, changes along the motion."""
    if solution.status != "stopped" and not solution.keeps_energy:
        warn(_wrong_energy(solution))
    if functions:
        check_drifts(solution.checking_functions(functions), solution.rtol)
    warn_of_beams(solution)


def _wrong_energy(solution: Solution) -> str:
    check = solution.energy_check
    told = (
        f"Expected E − ∫P dt constant along the motion, got a change of {check.drift:.3g} J, {check.relative:.1g} of the "
        f"energy present at t = {check.at:.4g} s: "
    )
    if check.drift <= solution.steps * solution.atol:  # the motion may be reliable
        return (
            f"{told}the motion or ∫P dt, whose errors may be atol = {solution.atol:g} J a step, is unreliable from about there on. "
            "Give an atol= that is small beside the energies."
        )
    return (
        f"{told}the motion is unreliable from about there on. Tighten rtol= and atol= from "
        f"{solution.rtol:g} and {solution.atol:g}, choose another method=, or look for loads that switch and equations that "
        "become singular during the motion."
    )


_STEEPEST = 0.4
"""Largest slope for which beams are valid. The strain energy is quadratic in v'' in both forms: under a tip force with this slope a
cantilever deflects 7 % more than the elastica; the error grows as the square of the slope."""


def warn_of_beams(solution: Solution) -> None:
    """Warn of beams that rotate faster, or deflect further, than their declared model allows."""
    for beam in solution.equations.system.bodies:
        if isinstance(beam, Beam):
            for said, category in doubts(beam, _spin(solution, beam), solution.parameters):
                warn(said, category)
            slope = _slope(solution, beam)
            if beam.deformation.stiffening and slope > _STEEPEST:
                warn(
                    f"Expected deflections of {beam.name} with slopes below {_STEEPEST:g}, as its strain energy assumes, got "
                    f"{slope:.3g}: the motion is inaccurate from about there on. Divide the beam into several."
                )


def _spin(solution: Solution, beam: Beam) -> float:
    """The largest angular speed of the beam's frame across its axis (rad/s)."""
    root = beam.frame.root()
    if root is beam.frame:
        return 0.0
    w = beam.frame.angular_velocity(root)
    along = w.dot(beam.deformation.axis)
    whole, axial = (np.asarray(x) for x in solution[[w.dot(w), along]])
    across = whole - axial**2
    return float(np.sqrt(np.max(across, initial=0.0, where=np.isfinite(across))))


def _slope(solution: Solution, beam: Beam) -> float:
    """The largest slope dv/dx of the deflections."""
    length, steepest = float(evaluate(beam.length, solution.parameters)), 0.0
    for f in beam.deformation.bending:
        slopes = f.shapes.evaluate(np.linspace(0, 1, 17), 1) @ np.array(solution[list(f.coordinates)]) / length
        steepest = max(steepest, float(np.max(np.abs(slopes), initial=0.0, where=np.isfinite(slopes))))
    return steepest
