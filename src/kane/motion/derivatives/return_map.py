# SPDX-License-Identifier: BSD-3-Clause
"""The flow map of a motion up to a section (the Poincaré map) or over a period, x ↦ P(x), and its derivative."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from kane import expect
from kane.analysis.assembly import assemble
from kane.analysis.flow import magnitudes
from kane.analysis.local import coded, slopes_at, values_at
from kane.analysis.state_checks import StateArrays, start_state
from kane.dynamics.readings.quantities import parameter_values
from kane.equations.equations import Equations, derive
from kane.equations.state import GROUPS, State
from kane.errors import SimulationError, cut
from kane.expr.differentiation import diff, weighted
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ONE, Expr
from kane.expr.symbols import Parameter, Time
from kane.model.contacts import laws_of
from kane.model.declarations import Event, expressions
from kane.motion.contact_motion import run_over_time
from kane.motion.derivatives.variation import Again, Differential, Variation
from kane.motion.inputs.expressions import Formula, by_symbol, given_parameters
from kane.motion.inputs.functions import Function, constant, input_functions
from kane.motion.right_hand_side import rates
from kane.motion.runner import check_values
from kane.motion.solution.resumed import OPTIONS, Begin
from kane.motion.solution.solution import Solution
from kane.motion.start import check_tolerance, sample_times
from kane.numeric.arrays import Array
from kane.numeric.scale import SIX_DIGITS
from kane.program.native.machine import Settings


def with_section(eom: Equations, section: Event) -> Equations:
    """The equations with the section as an event that ends the motion."""
    own = [e for e in eom.system.events if e.name != section.name]
    return derive(eom.system.replace(events=[*own, section]), near=eom.derived.near, route=eom.solved.asked)


def named(eom: Equations, section: Any) -> Event:
    """The section: an event, or the event of the system with that name."""
    if isinstance(section, Event):
        return section
    for e in eom.system.events:
        if e.name == section:
            return e
    names = ", ".join(repr(e.name) for e in eom.system.events) or "none"
    raise SimulationError(
        f"Expected section= as an event, or the name of one of the system ({names}), got {cut(repr(section))}. Make one: "
        "kn.Event('passes', q, direction=1)."
    )


@dataclass(frozen=True, slots=True, eq=False)
class ReturnMap:
    """P of equations: up to the `section`, or over a `period`, a number or an expression of parameters.

    `within` is the longest time to the section (s), `t0` the start time of motions, `further` are options of `kn.simulate`. `closing`:
    motions begin on a section without action, and leave it also where rounding, or a step of Newton's, has put their start beside it.
    """

    eom: Equations
    section: Event | None
    period: Expr | float | None
    inputs: Mapping[Any, Any] | None
    t0: float
    within: float
    tolerances: tuple[float, float]
    settings: Settings | None = None
    further: Mapping[str, Any] = field(default_factory=dict)
    closing: bool = False

    @staticmethod
    def of(eom: Equations, section: Any, period: Any, **given: Any) -> "ReturnMap":
        """The map of a section (event or name) or of a period; SimulationError names inadmissible numbers."""
        within = given["within"]
        right = expect.is_number(within) and within > 0
        expect.that(right, "within as a number above zero", within, error=SimulationError)
        for name, value in zip(("rtol", "atol"), given["tolerances"], strict=True):
            check_tolerance(name, value)
        if section is None:
            return ReturnMap(eom, None, period, **given)
        found = replace(named(eom, section), terminal=True)
        if not any(e.name == found.name and e.terminal and e.quantity is found.quantity for e in eom.system.events):
            eom = eom.numeric(given.get("settings")).value(with_section, found)
        else:
            found = next(e for e in eom.system.events if e.name == found.name)
        return ReturnMap(eom, found, None, **given)

    def length(self, constants: Mapping[Expr, float]) -> float:
        """The period, or the longest time to the section (s)."""
        if self.section is not None:
            return self.within
        if isinstance(self.period, Expr):
            return float(evaluate(self.period, dict(constants)))
        return float(self.period or 0.0)

    def state(self, x: Array, **more: Any) -> State:
        """(q, u, a) as an initial State."""
        values = dict(zip(self.eom.state, x.tolist(), strict=True))
        groups = {kind: {s: values[s] for s in getattr(self.eom, GROUPS[kind])} for kind in ("q", "u", "states")}
        return State(**groups, t=self.t0, **more)

    def known(self, parameters: Mapping[Any, float] | None) -> dict[Expr, Any]:
        """Values of all parameters; those that occur only in inputs are included if specified."""
        parameters = by_symbol(self.eom, parameters, self.inputs)
        own = parameter_values(self.eom.system, parameters)
        return {**own, **{s: v for s, v in given_parameters(parameters).items() if s not in own}}

    def span(self, known: Mapping[Expr, float]) -> tuple[float, float]:
        """The longest time span of a motion with given values of all parameters."""
        return self.t0, self.t0 + self.length(known)

    def drives(self, parameters: Mapping[Any, float] | None) -> dict[Expr, Function]:
        """The inputs of a motion as functions, with given parameter values."""
        known = self.known(parameters)
        return input_functions(self.eom, self.inputs, self.span(known), known)

    def __call__(self, x: Array, parameters: Mapping[Any, float] | None, samples: Any = ()) -> Solution:
        """The motion that starts at x.

        Raises
        ------
        SimulationError
            if the section is not reached, or the motion ends before
        """
        motion = self.motion(x, parameters, samples)
        self._check_end(motion, self.span(self.known(parameters)))
        return motion

    def motion(self, x: Array, parameters: Mapping[Any, float] | None, samples: Any = ()) -> Solution:
        """The same without the check of its end; `parameters` may include those that occur only in inputs."""
        eom, constants, known = self.eom, parameter_values(self.eom.system, parameters), self.known(parameters)
        span = self.span(known)
        check_values(eom, np.array([constants[p] for p in eom.parameters]), span)
        drives = input_functions(eom, self.inputs, span, known)
        bounds = {name: self.further.get(name) for name in ("max_steps", "max_seconds", "first_step")}
        q, u, a = np.split(x, np.cumsum([len(eom.coordinates), len(eom.speeds)]))
        fresh, beside = self._fresh(x, known)
        first = Begin(q, u, None, a, fresh=fresh, beyond=beside)
        result: Solution = run_over_time(eom)(
            eom, span, first, (constants, drives), self.options, bounds, sample_times(samples, span)
        )
        return result

    @property
    def options(self) -> dict[str, Any]:
        """Options of the motions."""
        own = dict(zip(("rtol", "atol"), self.tolerances, strict=True), settings=self.settings)
        return OPTIONS | {name: value for name, value in self.further.items() if name in OPTIONS} | own

    def admitted(self, given: State) -> Array:
        """(q, u, a) assembled from values and guesses, on the constraint manifold."""
        eom, q, u = self.eom, given.q, given.u
        if eom.constraints.constraints:
            at = self.inputs_at_start(given.parameters)
            found = assemble(eom, q=q, u=u, parameters=given.parameters, inputs=at, t=self.t0)
            q, u = found.q, found.u
        return start_state(eom, q, u, given.states)

    def inputs_at_start(self, parameters: Mapping[Any, float] | None) -> dict[Any, float]:
        """Values of the inputs at t0; inputs that depend on the state are set to zero, which does not affect the assembly."""
        drives = self.drives(parameters)
        return {s: 0.0 if getattr(f, "of_state", False) else float(f(self.t0)) for s, f in drives.items()}

    def off(self, x: Array, constants: Mapping[Expr, float]) -> tuple[float, float]:
        """The event function h of the section at x, relative to its threshold, and the size of its terms, Σ |∂h/∂x| sizes of x."""
        assert self.section is not None
        values: dict[Expr, Any] = dict(zip(self.eom.state, x.tolist(), strict=True)) | dict(constants)
        quantity = self.section.quantity
        if any(s not in values for s in free_symbols([quantity])):
            return 0.0, 1.0
        h = float(evaluate(quantity, values)) - self.section.threshold
        slopes = evaluate(weighted([quantity], [ONE], self.eom.state), values)
        return h, float(np.abs(slopes) @ self.sizes(x, constants)) if h else 1.0

    def sizes(self, x: Array, constants: Mapping[Expr, float]) -> Array:
        """Changes of q and u at the energy of the largest one, each at least as large as itself; a further state is its own size."""
        eom, inputs = self.eom, self.inputs_at_start(constants)
        p, r = (
            [float(known[s]) for s in symbols] for known, symbols in ((constants, eom.parameters), (inputs, eom.inputs))
        )
        state, run = StateArrays(self.t0, x, np.array(p), np.array(r)), coded(eom.numeric(self.settings))
        values = values_at(run, state)
        zero = np.zeros_like(values.right)
        alike = magnitudes(eom, values, slopes_at(run, state, zero), zero, state).alike
        own, further = np.split(np.abs(x), [len(alike)])
        share = np.divide(own, alike, out=np.zeros_like(own), where=alike > 0)
        return np.append(np.maximum(own, alike * share.max(initial=0)), further)

    def _fresh(self, x: Array, constants: Mapping[Expr, float]) -> tuple[dict[str, float], dict[str, float]]:
        """By the section's name, if x lies on it, the side to which the motion leaves it, and how far beside it x may be."""
        if self.section is None:
            return {}, {}
        h, terms = self.off(x, constants)
        if not abs(h) <= SIX_DIGITS * terms:
            return {}, {}
        name, begins = self.section.name, self.closing and self.section.then is None
        return {name: float(self.section.direction)}, {name: abs(h)} if begins else {}

    def _check_end(self, motion: Solution, span: tuple[float, float]) -> None:
        end, last = float(motion.t[-1]), motion.phases[int(motion.phase[-1])].parameters
        changed = (s.name for s in self.eom.parameters if last[s] != motion.parameters[s])
        cure = "Let an event reset them, or make them further states by kn.state."
        expect.none(changed, "initial values of parameters at the end", "others of {}", cure, error=SimulationError)
        if self.section is None:
            if motion.status == "finished":
                return
            raise SimulationError(
                f"Expected a motion over the whole period, to t = {span[1]:.6g}, got one that ended at t = {end:.6g}: "
                f"{motion.message}."
            )
        if motion.event is not None and motion.event.name == self.section.name:
            return
        came = (
            f"none within {self.within:g} s"
            if motion.status == "finished"
            else f"one that ended at t = {end:.6g}: {motion.message}"
        )
        raise SimulationError(
            f"Expected a motion that reaches the section {self.section.name!r}, got {came}. Start closer to the cycle, give "
            "the event the direction in which the cycle crosses it, or allow more time by within=…."
        )

    def differential(
        self, motion: Solution, by: tuple[Parameter, ...] = (), parameters: Mapping[Any, float] | None = None
    ) -> Variation:
        """The derivative of the end of a motion; `parameters` default to `motion.parameters`, which lack those of inputs alone."""
        walk, slopes, parameters = self.walk(by), None, parameters or motion.parameters
        if self.section is None and isinstance(self.period, Expr):
            slopes = np.array([float(evaluate(diff(self.period, p), dict(parameters))) for p in by])
        return walk(motion, self.again(motion, parameters), self.section, slopes)

    def walk(self, by: tuple[Parameter, ...]) -> Differential:
        """The differentiation of its motions."""
        return Differential(by, self.settings, self.options | {"contacts": self.eom, "drives": self.drives})

    def again(self, motion: Solution, parameters: Mapping[Any, float]) -> Again:
        """A function that recomputes the motion at other sample times."""
        return lambda samples: self.motion(motion.states[0], parameters, samples)

    def timed(self, parameters: Mapping[Any, float]) -> bool:
        """Whether the equations depend on time explicitly, or an input is a function that may."""
        contacts = self.eom.system.contacts
        exprs = [*rates(self.eom).task.roots, *expressions(self.eom.events), *laws_of(contacts)]
        exprs += [row.expr for row in (*self.eom.system.constraints, *(r for c in contacts for r in c.rows))]
        drives = self.drives(parameters).values()
        exprs += [f.expr for f in drives if isinstance(f, Formula)]
        told = any(constant(f) is None for f in drives if not isinstance(f, Formula))
        return told or any(isinstance(s, Time) for s in free_symbols(exprs))
