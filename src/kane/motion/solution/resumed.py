# SPDX-License-Identifier: BSD-3-Clause
"""Motions that continue from the end of another: what they inherit, and the check that their equations are of the same bodies.

Equations fit if coordinates and speeds have the same names, and kinetic energy and rates of coordinates have the same values along
the previous motion. Loads and constraints may differ: a disk slides first, and then rolls.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kane import expect
from kane.dynamics.readings.quantities import evaluate_along
from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.expr.node import Expr
from kane.expr.symbols import Input, Symbol, input_of
from kane.motion.inputs.expressions import Formula, HeldInput, SampleAndHold, by_symbol, formula, gains_of, value
from kane.motion.inputs.functions import Recorded, constant
from kane.motion.solution.phases import Phase
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array, distinct
from kane.numeric.sampling import named_values
from kane.numeric.scale import SIX_DIGITS

_COMPARED = 25
"""Largest number of samples at which two systems are compared."""
OPTIONS = {"method": "auto", "rtol": 1e-9, "atol": 1e-9, "max_step": None, "breakpoints": (), "settings": None}
"""Options that a continued motion inherits unless they are given, and their defaults for other motions."""


@dataclass(frozen=True, slots=True, eq=False)
class Begin:
    """Values at the start: `q`, and `u` or `rates`; further `states`; the `work` done so far (J).

    `fresh`: events at whose thresholds the motion begins, by name, with the sides to which their quantities move; quantities within
    the share `rounded` of their terms, or within `beyond`, may have either sign. `goes_on`: the start is the end of another motion;
    `whole`: one of the same equations and values, so that it satisfies the constraints. `rtol`: the relative tolerance of that motion;
    `since`: time from the previous action to the start (s), 0 if there was none; `steps`: number of steps taken before.
    """

    q: Any
    u: Any
    rates: Any
    states: Any = None
    work: float = 0.0
    fresh: Mapping[str, float] = field(default_factory=dict)
    goes_on: bool = False
    whole: bool = False
    rtol: float = 0.0
    since: float = 0.0
    rounded: float = 0.0
    beyond: Mapping[str, float] = field(default_factory=dict)
    steps: int = 0


def merged_options(given: Mapping[str, Any], start: Solution | None) -> dict[str, Any]:
    """The options given, completed by those of the motion `start`, or by the defaults."""
    before: dict[str, Any] = {}
    if start is not None:
        before = {"rtol": start.rtol, "atol": start.atol, **(start._options or {})}
    return {name: before.get(name, usual) if given[name] is None else given[name] for name, usual in OPTIONS.items()}


def begin_of(start: Any, given: Mapping[str, Any], span: Any) -> tuple[Begin, Any]:
    """The initial values of a motion, and its span, of which the end alone may be given if the motion continues `start`."""
    if start is None:
        if given["q"] is None:
            raise SimulationError(
                "Expected start values, q= and u=, got none. Give coordinates and speeds at the beginning of the span, or the "
                "motion to continue: start=sol."
            )
        if (given["u"] is None) == (given["rates"] is None):
            which = "neither. At rest it is u=0" if given["u"] is None else "both"
            raise SimulationError(f"Expected either u= or rates= at the start, got {which}.")
        return Begin(given["q"], given["u"], given["rates"], given["states"]), span
    cure = "Give a kn.State, or what kn.simulate or kn.load_solution returned."
    expect.instance(
        start, Solution, "a state to start from, or a motion to continue or to join", cure, error=SimulationError
    )
    extra = [f"{name}=" for name in ("q", "u", "rates", "states") if given[name] is not None]
    if extra:
        raise SimulationError(
            f"Expected start= or start values, got both, {' and '.join(extra)} beside start=. To continue from a changed state, "
            "give q=sol.q[-1] and u=sol.u[-1] with your changes, and no start=."
        )
    if isinstance(span, int | float | np.number) and not isinstance(span, bool):
        span = (float(start.t[-1]), span)
    last = None if start.event is None else start.event.name
    fresh = {e.name: 0.0 for e, t in start.events if t >= start.t[-1] or e.name == last}
    unmoved = given["parameters"] is None and given["inputs"] is None
    return Begin(
        start.q[-1], start.u[-1], None, start.a[-1], float(start.work[-1]), fresh, True, unmoved, start.rtol
    ), span


def inherited_parameters(eom: Equations, start: Solution | None, given: Any, inputs: Any) -> Any:
    """The parameters given, of the equations and of `inputs`, completed by those of the last phase of `start`."""
    if start is None:
        return by_symbol(eom, given, inputs)
    names = {p.name: p for p in eom.parameters}
    last = last_phase(start)
    kept: dict[Expr, Any] = {names.get(str(s), s): v for s, v in gains_of(last.inputs.values()).items()}
    own = by_symbol(eom, given, inputs, kept)
    kept |= {names[str(p)]: v for p, v in last.parameters.items() if str(p) in names}
    return {**kept, **(own if isinstance(own, Mapping) else named_values("parameters", eom.parameters, own))}


def inherited_inputs(eom: Equations, last: Phase | None, given: Any, parameters: Mapping[Expr, Any]) -> Any:
    """The inputs given, completed by those of the `last` phase with new `parameters`; sampled controllers keep their memory."""
    if last is None:
        return given
    before = {str(s): f for s, f in last.inputs.items()}
    given = given if isinstance(given, Mapping) else named_values("inputs", eom.inputs, given)
    new = {str(s) for key in given for s in (key if isinstance(key, tuple) else (key,))}
    held: dict[int, SampleAndHold] = {}
    found: dict[Any, Any] = {}
    for s in eom.inputs:
        chain = [before.get(str(x)) for x in eom.inputs if input_of(x) is s]
        if isinstance(s, Input) and s.name not in new and all(f is not None for f in chain):
            state = eom.state if len(chain) == 1 else ()
            again = tuple(_again(s.name, f, parameters, state, held) for f in chain)
            found[s] = again if len(again) > 1 and callable(again[0]) else again[0]
    return {**found, **given}


def _again(
    name: str, drive: Any, parameters: Mapping[Expr, Any], state: tuple[Symbol, ...], held: dict[int, SampleAndHold]
) -> Any:
    number = constant(drive)
    if number is not None:
        return number
    if isinstance(drive, Recorded):
        raise SimulationError(
            f"Expected the input {name} again, inputs={{{name}: …}}, as the motion to continue was saved or pickled, got none: only "
            "the values of its function at the samples were saved."
        )
    if isinstance(drive, Formula):
        own = {s: float(parameters.get(s, v)) for s, v in gains_of([drive]).items()}
        return formula(name, drive.expr, {**drive.values, **parameters}, drive.state or state, own)
    if isinstance(drive, HeldInput):
        return HeldInput(held.setdefault(id(drive.group), drive.group.copy()), drive.place)
    return drive


def last_phase(start: Solution) -> Phase:
    """The phase in which a motion ends."""
    last: Phase = start.phases[int(start.phase[-1])]
    return last


def check_fits(eom: Equations, start: Solution, drives: Mapping[Expr, Any], parameters: Mapping[Expr, Any]) -> None:
    """A SimulationError unless the equations are of the bodies and speeds whose motion is to be continued."""
    other = start.equations
    if eom.derived is other.derived:
        return
    for kind in ("coordinates", "speeds", "states"):
        own, came = ([s.name for s in getattr(e, kind)] for e in (eom, other))
        if own != came:
            raise SimulationError(
                f"Expected start= of a motion with the {kind} {', '.join(own)}, got one with {', '.join(came)}. It belongs to "
                "another system: continue with its own equations, or give q= and u=."
            )
    at = distinct(np.linspace(0, len(start) - 1, min(len(start), _COMPARED)).astype(int))
    there = np.array(start[[*other.rates, other.kinetic_energy]])[:, at]
    here = np.array([_here(eom, start, k, drives, parameters) for k in at.tolist()]).T
    off = np.abs(here - there) > SIX_DIGITS * np.nanmax(np.abs(there), axis=1, initial=0.0, keepdims=True)
    if off.any():
        i, k = (int(x) for x in np.argwhere(off)[0])
        what = [*(f"{q.name}'" for q in eom.coordinates), "the kinetic energy"][i]
        raise SimulationError(
            f"Expected start= of a motion of the same bodies, got one along which {what} is {there[i, k]:.9g} at t = "
            f"{start.t[at[k]]:.6g}; by these equations it is {here[i, k]:.9g}. It belongs to another system: continue with its own "
            "equations, or give q= and u=."
        )


def _here(eom: Equations, start: Solution, k: int, drives: Mapping[Expr, Any], parameters: Mapping[Expr, Any]) -> Array:
    """(q̇, K) by these equations at sample k of the previous motion, with the parameters and inputs of that motion."""
    phase, t, x = start.phases[start.phase[k]], float(start.t[k]), start.states[k]
    constants = {str(s): v for s, v in parameters.items()} | {str(s): v for s, v in phase.parameters.items()}
    inputs = {str(s): value(f, t, x) for s, f in phase.inputs.items()}
    q, u, a = np.split(x, np.cumsum([len(eom.coordinates), len(eom.speeds)]))
    known = {s: inputs[str(s)] if str(s) in inputs else value(f, t, x) for s, f in drives.items()}
    found = evaluate_along(
        eom.solved,
        [*eom.rates, eom.kinetic_energy],
        list(q),
        list(u),
        {p: constants[p.name] for p in eom.parameters},
        known,
        t,
        list(a),
        held=False,
    )
    return np.array([float(v) for v in found])
