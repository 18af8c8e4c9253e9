# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of many motions as further states of the equations (forward sensitivity analysis), which ensembles run as any others.

ψ_b = ∂x/∂b obeys ψ̇ = ∂f/∂x ψ + ∂f/∂b + ∂f/∂r (∂r/∂x ψ + ∂r/∂b), in symbolic form. An event with the reset x⁺ = g(x⁻, t, b) also
sets ψ by the saltation matrix: δτ = −(∇h·ψ + ∂h/∂b)/ḣ, and

    ψ⁺ = ∂g/∂x (ψ + f⁻ δτ) + ∂g/∂t δτ + ∂g/∂b − f(x⁺) δτ

Where they cannot be further states of the equations, mainly with contacts, motions are differentiated one by one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from kane import expect
from kane.dynamics.readings.quantities import asked
from kane.dynamics.slopes import forward
from kane.equations.equations import Equations, derive
from kane.equations.instances import Instances, package
from kane.equations.state import State
from kane.errors import KaneError, SimulationError, warn
from kane.expr.differentiation import tangent
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.expr.symbols import Parameter, StateVariable, Symbol, time
from kane.expr.visit import substituted
from kane.model.declarations import Event, target
from kane.motion.derivatives.jumps import check_set
from kane.motion.derivatives.moved_breakpoints import moves_breakpoints
from kane.motion.derivatives.parametric_motion import ParametricMotion
from kane.motion.derivatives.pulling import Laws
from kane.motion.inputs.expressions import given_parameters
from kane.motion.inputs.functions import input_functions
from kane.motion.many.results import CARRIED, RecordedQuantity
from kane.motion.right_hand_side import rates_jump
from kane.motion.runner import Plan
from kane.numeric.arrays import Array
from kane.program.native.machine import Settings
from kane.progress import far

_ROW = "row"
"""The dimension, of size one, of the rows of a matrix of derivatives of a scalar expression."""


@dataclass(frozen=True, slots=True, eq=False)
class Varied:
    """The equations `eom`, with `carried` = ∂x/∂b (x × b) as further states, of the motions of `plain`."""

    plain: Equations
    eom: Equations
    by: tuple[Symbol, ...]
    carried: tuple[tuple[StateVariable, ...], ...]
    laws: Laws

    def derivative(self, one: RecordedQuantity) -> RecordedQuantity:
        """The derivative of a recorded quantity."""
        wanted = asked(self.plain.derived, one.what)
        expect.that(
            wanted.shape in ((), (3,)), f"an expression or vector as {one.name}", one.what, error=SimulationError
        )
        roots = self.laws.read(self.plain, wanted.roots)
        every = enumerate(self.by)
        seeds = [_seeds(self.plain, b, [row[k] for row in self.carried], self.laws) for k, b in every]
        rows = [[tangent(e, own, at_rest=True) for own in seeds] for e in roots]
        dims = ("axis" if wanted.shape else _ROW, "by")
        return RecordedQuantity(f"{one.name}_by", Matrix(rows), "", f"derivative of {one.name}", one.reduce, dims)


def check_reduced(kept: Sequence[RecordedQuantity]) -> None:
    """Raises SimulationError for reductions that do not commute with differentiation."""
    for one in kept:
        if one.reduce not in CARRIED:
            raise SimulationError(
                f"Expected reduce= of {one.name!r} as 'last', 'mean' or none where by= is given, got another one, whose "
                "derivative does not follow from derivatives of the values along t. Leave reduce= out to keep these values."
            )


def _seeds(eom: Equations, b: Symbol, psi: Sequence[Expr], laws: Laws) -> dict[Expr, Expr]:
    own: dict[Expr, Expr] = dict(zip(eom.state, psi, strict=True))
    if isinstance(b, Parameter):
        own[b] = ONE
    return own | {r: tangent(law, own, at_rest=True) for r, law in laws.whole.items()}


def varied(eom: Equations, by: tuple[Symbol, ...], laws: Laws) -> Varied:
    """The equations with the derivatives of their motions with respect to parameters and initial values.

    Raises
    ------
    SimulationError
        if rates jump without an event
    """
    _check(eom, laws)
    carried = tuple(tuple(StateVariable.declare(f"d_{x}_d_{b}", 0.0, "", "") for b in by) for x in eom.state)
    rates: dict[Any, Expr] = {}
    events = list(eom.system.events)
    for k, b in enumerate(by):
        psi = [row[k] for row in carried]
        seeds = _seeds(eom, b, psi, laws)
        symbols = [s for s in seeds if isinstance(s, Symbol)]
        change = forward(eom.solved, symbols, [seeds[s] for s in symbols])
        rates |= dict(zip(psi, change, strict=True))
        events = [_acting(eom, old, new, b, psi, laws) for old, new in zip(eom.system.events, events, strict=True)]
    system = eom.system.replace(states={**dict(eom.system.states), **rates}, events=events)
    whole = derive(system, near=eom.derived.near, route=eom.solved.asked)
    return Varied(eom, whole, by, carried, laws)


def obstacle(eom: Equations, by: Sequence[Symbol], inputs: Mapping[Any, Any] | None) -> str:
    """The reasons for which the derivatives cannot be further states, as text; "" if they can."""
    acting = [e for e in eom.system.events if e.then is not None]
    rates: dict[Any, Any] = dict(eom.system.states)
    still = [all(isinstance(s, Parameter) or rates.get(s) is ZERO for s in free_symbols([e.quantity])) for e in acting]
    laws = [e for e in dict(inputs or {}).values() if isinstance(e, Expr)]
    met = {
        "contacts": bool(eom.system.contacts),
        "actions in Python": not all(isinstance(e.then, Mapping) for e in acting),
        "actions under constraints": bool(acting and eom.constraints.constraints),
        "events whose quantity only other events change": any(still),
        "parameters that change the times at which inputs or loads switch": moves_breakpoints(eom, laws, by),
    }
    return " and ".join(text for text, holds in met.items() if holds)


def _check(eom: Equations, laws: Laws) -> None:
    state = set(eom.state)
    of_state = [law for law in laws.whole.values() if not state.isdisjoint(free_symbols([law]))]
    if rates_jump(eom, of_state):
        raise SimulationError(
            "Expected equations whose rates are smooth between events for the derivatives of motions, got loads, inputs or "
            "rates of states that jump with the state. Declare dry friction by kn.contact or kn.joints.stiction, and other "
            "switches by events that set a further state."
        )


def _acting(eom: Equations, event: Event, made: Event, b: Symbol, psi: Sequence[Expr], laws: Laws) -> Event:
    """The event with a reset of ψ_b as well."""
    if event.then is None:
        return made
    made_of = laws.read(eom, [as_expr(what) for what in event.then.values()])
    targets = (target(eom.system, event, key) for key in event.then)
    own: dict[Expr, Expr] = dict(zip(targets, made_of, strict=True))
    check_set(
        {s: what for s, what in own.items() if isinstance(s, Symbol)}, event, [b] if isinstance(b, Parameter) else []
    )
    seeds = _seeds(eom, b, psi, laws)
    f = laws.read(eom, eom.solved.right_hand_side)
    onward: dict[Expr, Expr] = {**dict[Expr, Expr](zip(eom.state, f, strict=True)), time: ONE}
    (h,) = laws.read(eom, [event.quantity])
    later = -tangent(h, seeds, at_rest=True) / tangent(h, onward, at_rest=True)
    moved: dict[Expr, Expr] = {s: e + onward[s] * later for s, e in zip(eom.state, psi, strict=True)}
    change: dict[Expr, Expr] = {**{s: e for s, e in seeds.items() if s not in moved}, **moved, time: later}
    then: dict[Any, Any] = dict(made.then)
    for s, p, rate in zip(eom.state, psi, f, strict=True):
        e = tangent(own[s], change, at_rest=True) if s in own else moved[s]
        then[p] = e - substituted(rate, own) * later
    return replace(made, then=then)


def begun(one: Varied, many: Instances, span: tuple[float, float], settings: Settings | None) -> Instances:
    """The instances with the initial values of ∂x/∂b."""
    eom, place = one.plain, {s: i for i, s in enumerate(one.plain.state)}
    common, columns = dict(many.common), {kind: dict(own) for kind, own in many.columns.items()}
    told = dict(common["states"] or {})
    if not eom.system.euler_parameters and not eom.constraints.constraints:
        told |= {
            s: float(place.get(b, -1) == i)
            for i, row in enumerate(one.carried)
            for s, b in zip(row, one.by, strict=True)
        }
    else:
        every = np.array([_at_start(one, many.at(k), span, settings) for k in range(many.count)])
        for i, row in enumerate(one.carried):
            for k, s in enumerate(row):
                column = every[:, i, k]
                if many.count > 1 and (column != column[0]).any():
                    columns["states"][s] = column.copy()
                else:
                    told[s] = float(column[0])
    return Instances(many.count, {**common, "states": told or None}, columns)


def _at_start(one: Varied, given: Mapping[str, Any], span: tuple[float, float], settings: Settings | None) -> Array:
    """∂x/∂b of an initial state; zeros if its assembly fails, which is reported when the instance is run."""
    course = ParametricMotion.of(one.plain, span, one.by, State(**given), (1e-9, 1e-9), settings)
    try:
        start = course.start
    except KaneError:
        return np.zeros((len(one.plain.state), len(one.by)))
    return course.start_slopes(start)


def varied_for(
    eom: Equations, many: Instances, by: tuple[Symbol, ...], span: tuple[float, float], settings: Settings | None
) -> Varied:
    """The equations of an ensemble with the derivatives of its motions."""
    first = many.at(0)
    usual = {**{p: p.default for p in eom.parameters}, **(first["parameters"] or {})}
    laws = Laws(input_functions(eom, first["inputs"], span, given_parameters(usual)))
    return eom.numeric(settings).value(varied, by, laws)


def tidied(found: Any, one: Varied) -> Any:
    """The Dataset without the further states `carried`, and with the names of b."""
    hidden = [f"{s}(0)" for row in one.carried for s in row]
    plain = found.drop_vars([name for name in hidden if name in found.coords])
    plain = plain.isel({"state": slice(0, len(one.plain.state)), **{dim: 0 for dim in (_ROW,) if dim in found.dims}})
    return plain.assign_coords(by=("by", [s.name for s in one.by]))


USUAL = 1e-11
"""Default tolerances of motions that are differentiated one by one."""

_FURTHER = ("method", "max_step", "breakpoints", "max_steps", "first_step", "max_seconds")
"""Options of the motions that are passed on."""


def one_by_one(
    found: Any,
    eom: Equations,
    plan: Plan,
    many: Instances,
    kept: Sequence[RecordedQuantity],
    by: tuple[Symbol, ...],
    settings: Settings | None,
) -> Any:
    """The Dataset with the derivatives of the recorded quantities; NaN, with a warning, for motions that are not differentiable.

    Raises
    ------
    SimulationError
        if no motion is differentiable
    """
    t, values, causes = found["t"].values, dict[str, Array](), dict[int, str]()
    for k in range(many.count):
        far(partial("derivatives of motion {} of {}".format, k, many.count))
        try:
            rows = _of_one(eom, plan, State(**many.at(k)), kept, by, settings, t)
        except KaneError as error:
            causes[k] = str(error)
            continue
        for one, row in zip(kept, rows, strict=True):
            values.setdefault(one.name, np.full((many.count, *row.shape), np.nan))[k] = row
    if causes:
        first = f"{len(causes)} of {many.count}, of instance {min(causes)}: {causes[min(causes)]}"
        if len(causes) == many.count:
            raise SimulationError(f"Expected motions that have derivatives, got none of {first}")
        warn(f"Expected motions that have derivatives, got none of {first}")
    own = {}
    for one in kept:
        table = values[one.name]
        first_dims = ["instance"] if one.reduce else ["instance", "t"]
        dims = [*first_dims, *["axis"][: table.ndim - len(first_dims) - 1], "by"]
        own[f"{one.name}_by"] = package("xarray").Variable(dims, table, {"long_name": f"derivative of {one.name}"})
    return found.assign(own).assign_coords(by=("by", [s.name for s in by]))


def _of_one(
    eom: Equations, plan: Plan, given: State, kept: Sequence[RecordedQuantity], by: tuple[Symbol, ...], settings: Settings | None,
    t: Array,
) -> list[Array]:  # fmt: skip
    """The derivatives of the recorded quantities of one motion, at times t or reduced over them."""
    rtol, atol = (USUAL if one is None else one for one in (plan.rtol, plan.atol))
    further = {name: value for name, value in plan._asdict().items() if name in _FURTHER and value is not None}
    course = ParametricMotion.of(eom, plan.span, by, given, (rtol, atol), settings, further)
    along = course.sensitivities(course.motion(t))
    rows = np.maximum(np.searchsorted(along.t, t, side="right") - 1, 0)
    result = []
    for one in kept:
        part = along[one.what][rows]
        part[along.t[rows] != t] = np.nan
        result.append(part if one.reduce is None else np.asarray(one.reduce(part)))
    return result
