# SPDX-License-Identifier: BSD-3-Clause
"""`trim` and `equilibrium`: steady motions and equilibria, by Newton's method with exact derivatives in X = (q, u, a, inputs, p).

f = 0,  eᵀe = 1,  A u + b = 0,  u̇_I = 0,  q̇ = 0 for coordinates and ȧ = 0 for further states that affect the speeds
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, Unpack

import numpy as np

from kane import expect
from kane.analysis.flow import Flow, Preference, dependence, flow_at, scaled
from kane.analysis.linearization import choice_of
from kane.analysis.local import all_switches
from kane.analysis.many.poses import Poses, poses
from kane.analysis.many.trimmed import SteadyEquations, trimmed
from kane.analysis.many.trimmed import followed as followed_from
from kane.analysis.one_sided import warn_of_jumps
from kane.analysis.operating_point import closed, left_out, state_from, warn_of_contacts
from kane.analysis.perturbations import perturbations
from kane.analysis.state_checks import entries
from kane.analysis.steady_conditions import Conditions, ScaledConditions, SteadyProblem, shares
from kane.dynamics.constraints.manifold import branches, turned_closures
from kane.equations.compiled import Numeric
from kane.equations.equations import Equations, check_equations
from kane.equations.state import GROUPS, State, StateValues, by_keyword, state_of
from kane.errors import ArgumentError, SimulationError, ValueMissingError
from kane.expr.symbols import Symbol, time
from kane.numeric.arrays import Array, Mask
from kane.numeric.newton import Closed, close, closest, starts
from kane.numeric.rank import level, singular
from kane.numeric.sampling import SEED, draw, finite_number, named_values, names_in
from kane.numeric.scale import ROUNDED_CHAIN, SOLVED, STATE_RANK, TAKES_PART, UNRELATED
from kane.program.native.machine import Settings
from kane.progress import working

_NEAR = (3, 8)
"""Seeds of random states near the start at which dependences are determined."""


def conditions(
    numeric: Numeric[Equations], t: float, start: Array, choice: Preference, moving: Sequence[str]
) -> Conditions:
    """The conditions that apply: coordinates on which no speed depends near the start may vary, and so may those in `moving`."""
    eom = numeric.equations
    symbols: tuple[Symbol, ...] = (*eom.state, *eom.inputs, *eom.parameters)
    bare = Conditions(numeric, t, symbols, (), (), constraints_only=True)
    placed, width = len(eom.coordinates) + len(eom.speeds), len(eom.state)
    constant: set[int] = set()
    further: set[int] = set()
    steady = set(range(len(eom.speeds)))
    _, rows, columns = bare.sizes(start)
    measured = ScaledConditions(bare, rows, columns, start, range(len(start)))
    for seed in _NEAR:
        y = start / columns
        y[:width] += [draw(seed, s, -0.1, 0.1) for s in symbols[:width]]
        if eom.constraints.constraints or bare.perturbed.sets:
            y = close(measured, y, range(placed)).x
        flow = flow_at(numeric, bare.state(y * columns), choice)
        if not choice.u:
            flow = freest(flow)
            choice = flow.choice
        tangent, every = flow.tangents, _matter(flow)
        matters = every[: flow.counts[0]]
        further |= set(np.flatnonzero(every[flow.counts[1] :]).tolist())
        constant |= {i for i, m in zip(tangent.free_q, matters, strict=True) if m}
        by_cyclic = np.abs(tangent.e[:, ~matters]).max(axis=1, initial=0)
        steady -= set(np.flatnonzero(by_cyclic > UNRELATED * np.abs(tangent.e).max(initial=0)).tolist())
    return Conditions(
        numeric,
        t,
        symbols,
        tuple(sorted(i for i in constant if bare.perturbed.names[i] not in moving)),
        tuple(sorted(i for i in steady if eom.speeds[i].name not in moving)),
        tuple(sorted(i for i in further if eom.states[i].name not in moving)),
    )


def freest(flow: Flow) -> Flow:
    """The flow with the dependent speeds, found by single exchanges, for which the fewest coordinates affect the independent speeds.

    The speeds of a contact along a rotating frame vary in a steady motion; if one of them were independent, the rotation would have to
    vanish.
    """
    count = len(flow.numeric.equations.speeds)
    least = int(_matter(flow)[: flow.counts[0]].sum())
    again = True
    while again and least:
        again = False
        free = flow.tangents.free_u
        dependent = [i for i in range(count) if i not in free]
        for i, d in product(free, dependent):
            choice = Preference(flow.choice.q, (i, *(k for k in dependent if k != d)))
            other = flow_at(flow.numeric, flow.state, choice, known=flow)
            fewer = int(_matter(other)[: other.counts[0]].sum())
            if fewer < least:
                flow, least, again = other, fewer, True
                break
    return flow


def _matter(flow: Flow) -> Mask:
    """Which of the independent coordinates, speeds and further states affect the speeds."""
    return dependence(scaled(flow.a, flow), *flow.counts)


_TRIES = 12


def problem(
    numeric: Numeric[Equations], given: State, moving: Sequence[Any], independent: Sequence[Any]
) -> SteadyProblem:
    """The steady problem for the values, guesses and missing values of a state."""
    eom, perturbed = numeric.equations, numeric.value(perturbations)
    defaults = {p: p.default for p in eom.parameters if p.default is not None}
    complete = replace(given, parameters=defaults | named_values("parameters", eom.parameters, given.parameters))
    parts = [entries(what, getattr(eom, what), getattr(complete, kind), "value") for kind, what in GROUPS.items()]
    for what, part in zip(GROUPS.values(), parts, strict=True):
        if what in ("inputs", "parameters"):
            missing = [getattr(eom, what)[i].name for i in part.missing]
            came = "none for {}: give a number to keep it, or kn.guess(value) to solve for it"
            expect.none(missing, f"a value for every one of the {what}", came, error=ValueMissingError)
    x = np.concatenate([part.values for part in parts])
    first = np.cumsum([0, *(len(part.values) for part in parts)]).tolist()
    for i in parts[2].missing:
        x[first[2] + i] = eom.states[i].default or 0.0
    free = [k + i for k, part in zip(first, parts, strict=False) for i in part.free]
    missing = [k + i for k, part in zip(first, parts, strict=False) for i in part.missing]
    for places in perturbed.sets:
        e = x[list(places)]
        if not e.any():
            x[places[0]] = 1.0
    names = names_in("moving= as a list", moving)
    unknown = [n for n in names if n not in perturbed.names and n not in {s.name for s in (*eom.speeds, *eom.states)}]
    expect.none(unknown, "moving= to name coordinates, speeds or states", error=ValueMissingError)
    held = conditions(numeric, finite_number("time", "the state", given.t), x, choice_of(numeric, independent), names)
    measured = ScaledConditions(held, *held.sizes(x)[1:], x, range(len(x)))
    return SteadyProblem(held, x, tuple(free), tuple(missing), measured)


@by_keyword
def trim(
    eom: Equations,
    state: State | Any | None = None,
    *,
    moving: Sequence[Any] = (),
    independent: Sequence[Any] = (),
    tolerance: float = SOLVED,
    settings: Settings | None = None,
    **values: Unpack[StateValues],
) -> State | Any:
    """Find a steady motion or an equilibrium: u̇_I = 0, and q̇ = 0 of the coordinates that matter, with all constraints satisfied.

    Given values are kept, and guesses `kn.guess(value)` are changed. Coordinates and speeds left out are solved for, starting from
    zero, and further states, starting from their defaults; ȧ = 0 for states on which the speeds depend. Coordinates on which the
    dynamics do not depend may vary: a heading, the angle of a wheel, a position on the road.

    Parameters
    ----------
    eom : Equations
    state : a `kn.State` of values and guesses instead of those that follow
    q, u, states, parameters, inputs : values and guesses by symbol or name; parameters left out take their defaults
    moving : further coordinates, speeds and states that may vary
    independent : speeds to be independent, if those of `eom` are not constant in a steady motion
    tolerance : admissible residual of rates, accelerations and constraints, relative to the terms that cancel in them
    settings : a `kn.Settings` for the compiled code

    If values are arrays, the result is an xarray Dataset with the dimension instance: coordinates, speeds, states and guessed
    values. The steady motion of the first instance is followed through the arrays; where it ends, `cause` gives the reason, and
    later ones are reached from the last valid one. The coordinates that may vary are those of the first instance.

    Raises
    ------
    SimulationError
        if no steady motion is found; the message names the accelerations that remain, with their sizes
    ValueMissingError
        if the conditions do not determine the values left out
    """
    check_equations(eom)
    expect.floats(tolerance, "a tolerance, a number", error=ArgumentError)
    many = poses(eom, state, values)
    if many is not None:
        with working("Trimming"):
            return _of_many(many, eom.numeric(settings), (moving, independent, tolerance))
    with working("Trimming"):
        numeric = eom.numeric(settings)
        return _found(problem(numeric, state_of(state, **values), moving, independent), tolerance)


def _found(task: SteadyProblem, tolerance: float) -> State:
    """The steady motion that solves a problem; raises ValueMissingError if values left out are not determined."""
    numeric, x = task.conditions.numeric, solve_problem(task, tolerance)
    expected, came = "values that determine the steady motion", "too few: {} can still have other values"
    cure = "Give some of them, or a guess for each: kn.guess(value)."
    expect.none(undetermined(task, x, task.missing), expected, came, cure, error=ValueMissingError)
    arrays = closed(numeric, task.conditions.state(x))
    warn_of_jumps(numeric, arrays, tolerance)
    result = state_from(numeric.equations, arrays)
    warn_of_contacts(numeric.equations, [result])
    return result


def _of_many(many: Poses, numeric: Numeric[Equations], options: tuple[Sequence[Any], Sequence[Any], float]) -> Any:
    """The steady motions of many states as a Dataset, on the branch of the first."""
    moving, independent, tolerance = options
    last: dict[int, SteadyProblem] = {}

    def alone(k: int) -> State:
        last.clear()
        last[k] = problem(numeric, many.state(k), moving, independent)
        return _found(last[k], tolerance)

    def followed(k: int, first: Array) -> SteadyEquations | None:
        if isinstance(many.given("t")[time], np.ndarray) or numeric.value(all_switches):
            return None
        return followed_from(last[k], first, tolerance)

    return trimmed(many, alone, followed)


def equilibrium(
    eom: Equations,
    state: State | None = None,
    *,
    q: Mapping[Any, Any] | Sequence[Any] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    t: float | None = None,
    tolerance: float = SOLVED,
    settings: Settings | None = None,
    states: Mapping[Any, Any] | Sequence[Any] | None = None,
) -> State:
    """Find an equilibrium: `trim` with all speeds zero; speeds in `state` are ignored. Arguments as for `trim`."""
    check_equations(eom)
    given = state_of(state, q=q, states=states, inputs=inputs, parameters=parameters, t=t)
    return trim(eom, replace(given, u=dict.fromkeys(eom.speeds, 0.0)), tolerance=tolerance, settings=settings)


def solve_problem(task: SteadyProblem, tolerance: float) -> Array:
    """X by the Gauss–Newton method from the start; if values were left out and this fails, also from other starts.

    Raises SimulationError, with the residuals, if none converges.
    """
    measured, turned = task.measured, _astray(task.conditions)
    spreads = [0.2 * k for k in range(1, _TRIES)] if task.missing else []
    tries = starts(task.start / measured.columns, task.missing, SEED, spreads)

    def astray(y: Array) -> Array:
        x = y * measured.columns
        return np.append(turned(x), shares(task.conditions, x).max(initial=0) > tolerance)

    best = closest(measured, tries, task.free, np.inf, limit=1e-14, astray=astray)
    x = _plain(task, best) * measured.columns
    left = shares(task.conditions, x)
    if not left.max(initial=0) <= tolerance:
        raise SimulationError(_failed(task, task.conditions(x)[0], left, best.steps))
    away = turned_closures(branches(task.conditions.eom.system), turned(x))
    expected = "a steady motion on the intended branch of the closures"
    cure = "Guess coordinates on this branch, which kn.assemble finds."
    expect.that(not away, expected, came=away, cure=cure, error=SimulationError)
    return x


def _plain(task: SteadyProblem, best: Closed) -> Array:
    """Y with rounding residues of zero set to zero; without other terms no number could be judged small."""
    free = np.array(task.free, dtype=int)
    tiny = free[np.abs(best.x[free]) <= ROUNDED_CHAIN]
    if not best.x[tiny].any():
        return best.x
    y = best.x.copy()
    y[tiny] = 0.0
    left = np.abs(task.measured(y)[0]).max(initial=0)
    return y if left <= max(best.size, ROUNDED_CHAIN) else best.x


def _astray(conditions: Conditions) -> Callable[[Array], Array]:
    """A function of X: the angles by which closures are away from their specified branches."""
    eom = conditions.eom

    def angles(x: Array) -> Array:
        values = conditions.state(x).given(eom)
        return eom.derived.conditions.at(values).turned(x[: len(eom.coordinates)])

    return angles


def _failed(task: SteadyProblem, residual: Array, shares: Array, steps: int) -> str:
    labels = task.conditions.labels
    order = np.argsort(-shares, kind="stable")
    worst = [(*labels[i], residual[i]) for i in order[:4] if shares[i] > 1e-3 * shares.max()]
    remains = [f"{name} = {x:.6g}{' ' + unit if unit else ''}" for name, unit, x in worst]
    solved = [task.conditions.symbols[i].name for i in task.free]
    return (
        f"Expected a steady motion with the values given, got none: after {steps} steps the residuals are "
        f"{', '.join(remains)}. The unknowns were {', '.join(solved) or 'no values'}. Give better guesses, or mark more "
        f"values with kn.guess(…).{left_out(task.conditions.eom)}"
    )


def null_space(task: SteadyProblem, x: Array) -> Array:
    """A basis (k × free), as rows, of the changes of free entries that leave the conditions satisfied."""
    _, j = task.measured(x / task.measured.columns)
    return singular(level(j[:, list(task.free)])).kernel(STATE_RANK)


def undetermined(task: SteadyProblem, x: Array, among: Sequence[int]) -> list[str]:
    """Names of entries of X `among` some indices that affect the conditions and are not determined by them."""
    if not task.free:
        return []
    directions = np.abs(null_space(task, x)).max(axis=0, initial=0)
    matter = set(task.mattering) & set(among)
    open_ = [i for i, d in zip(task.free, directions, strict=True) if d > TAKES_PART and i in matter]
    return [task.conditions.symbols[i].name for i in open_]
