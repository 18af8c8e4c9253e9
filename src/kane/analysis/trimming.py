# SPDX-License-Identifier: BSD-3-Clause
"""`trim` and `equilibrium`: steady motions and equilibria, by Newton's method with exact derivatives in X = (q, u, a, inputs, p).

f = 0,  eᵀe = 1,  A u + b = 0,  u̇_I = 0,  q̇ = 0 for coordinates and ȧ = 0 for further states that affect the speeds

Of many states the steady motion of the first is continued along the arrays. Which conditions apply is decided there; steady motions
have residuals within the tolerance. If the conditions do not determine all unknowns, or there are switches, each state is solved
alone. The followed equations have z = (u̇, λ, R) among their unknowns, so that no linear system is solved within them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple, Unpack

import numpy as np

from kane import expect
from kane.analysis.flow import Flow, Preference, dependence, flow_at, perturbations, scaled, share
from kane.analysis.linearization import choice_of
from kane.analysis.local import all_switches, regular_rows, unknowns, values
from kane.analysis.many.following import SquareEquations, Unknowns, follow
from kane.analysis.many.poses import Poses, poses
from kane.analysis.one_sided import warn_of_jumps
from kane.analysis.operating_point import closed, left_out, state_from, warn_of_contacts
from kane.analysis.stacks import MatrixEntries, solve_each
from kane.analysis.state_checks import entries
from kane.analysis.steady_conditions import Applying, Conditions, ScaledConditions, SteadyProblem, shares
from kane.dynamics.constraints.manifold import branches, turned_closures
from kane.dynamics.constraints.partition import choose
from kane.dynamics.readings.unsolved import partials, unsolved
from kane.equations.compiled import Numeric, ports
from kane.equations.equations import Equations, check_equations
from kane.equations.state import GROUPS, Guess, State, StateValues, by_keyword, state_of
from kane.errors import ArgumentError, SimulationError, SingularError, ValueMissingError
from kane.expr.build import sub
from kane.expr.evaluation import free_symbols
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO
from kane.expr.symbols import Symbol, time
from kane.numeric.arrays import Array, Mask
from kane.numeric.newton import Closed, close, closest, starts
from kane.numeric.rank import level, singular
from kane.numeric.sampling import SEED, draw, finite_number, named_values, names_in
from kane.numeric.scale import ROUNDED_CHAIN, SOLVED, STATE_RANK, TAKES_PART, UNRELATED
from kane.program.from_expressions import Bundle
from kane.program.native.compiled_routine import CompiledRoutine
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

    eom, causes = many.eom, dict(many.failed)
    first = many.first(alone, causes)
    symbols: tuple[Symbol, ...] = (*eom.state, *eom.inputs, *eom.parameters)
    x = np.full((many.count, len(symbols)), np.nan)
    if first is not None:
        start, state = first
        x[start] = [state[s] for s in symbols]
        if not isinstance(many.given("t")[time], np.ndarray) and not numeric.value(all_switches):
            task = followed(last[start], x[start], tolerance)
            if task is not None:
                _follow(many, task, (x, start), causes)
    for k, one in many.rest(alone, causes, set(np.flatnonzero(~np.isnan(x).any(axis=1)))):
        x[k] = [one[s] for s in symbols]
    x[list(causes)] = np.nan
    return _dataset(many, symbols, x, causes)


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
    """Y with rounding residues of zero, which nothing would tell from zero, set to zero; what nothing depends on as at the start."""
    free, start = np.array(task.free, dtype=int), task.start / task.measured.columns
    tiny, inert = free[np.abs(best.x[free]) <= ROUNDED_CHAIN], [i for i in task.free if i not in set(task.mattering)]
    for kept in (inert, []):
        y = best.x.copy()
        y[tiny] = 0.0
        y[kept] = start[kept]
        if np.array_equal(y, best.x) or np.abs(task.measured(y)[0]).max(initial=0) <= max(best.size, ROUNDED_CHAIN):
            return y
    return best.x


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


_TOLD = 4


class SteadyEquations(NamedTuple):
    """Conditions to follow from X at the start, with unknowns X[`free`]; `symbols` have the indices `places` in a row of data after t.

    `routine` has these unknowns and then z = (u̇, λ, R), which is `last` at the start. `left` returns the largest relative residual
    at each X (k × …), which must not exceed `tolerance`.
    """

    start: Array
    free: Sequence[int]
    symbols: Sequence[Symbol]
    places: Sequence[int]
    routine: CompiledRoutine
    unknowns: Unknowns
    last: Array
    left: Callable[[Array], Array]
    tolerance: float


def _follow(many: Poses, task: SteadyEquations, places: tuple[Array, int], causes: dict[int, str]) -> None:
    """Fill X of all states (k × …) that are reached by continuation from the one at `start`."""
    (x, start), free = places, list(task.free)
    whole = np.tile(task.start, (many.count, 1))
    for i, s in enumerate(task.symbols):
        for kind in GROUPS:
            if s in many.instances.columns[kind]:
                whole[:, i] = many.instances.columns[kind][s]
    order = [k for k in many.open if k >= start]
    data = np.zeros((len(order), 1 + sum(len(port.symbols) for port in task.routine.program.ports[1:])))
    data[:, 0] = many.given("t")[time]
    data[:, 1 + np.array(task.places)] = whole[order]
    found = follow(task.routine, data, np.concatenate([x[start, free], task.last]), task.unknowns)
    ended = np.array([row in found.ends for row in range(len(order))])
    for row, k in enumerate(order):
        end = found.ends.get(row)
        whole[k, free] = (found.x[row] if end is None else end.x)[: len(free)]
    there = np.array(order)[~ended]
    steady = dict(zip(there.tolist(), (task.left(whole[there]) <= task.tolerance).tolist(), strict=True))
    for row, k in enumerate(order):
        end = found.ends.get(row)
        if steady.get(k, False):
            x[k] = whole[k]
            continue
        at_end = ", ".join(f"{task.symbols[i].name} = {whole[k, i]:.6g}" for i in free[:_TOLD])
        way = f" on the way from instance {order[end.last]}" if end is not None else ""
        causes[k] = (
            f"Expected a steady motion on the branch of the other instances, got the end of this branch{way}, near {at_end}: there "
            "it meets another branch, or the equations are singular. Trim the states beyond it separately, from guesses."
        )


def _dataset(many: Poses, symbols: Sequence[Symbol], x: Array, causes: dict[int, str]) -> Any:
    eom = many.eom
    state = set(eom.state)
    given = {s: v for kind in ("inputs", "parameters") for s, v in many.given(kind).items()}
    shown = [i for i, s in enumerate(symbols) if s in state or isinstance(given.get(s), Guess)]
    own = many.variables([symbols[i] for i in shown], x[:, shown].T)
    return many.dataset(own, causes, {})


_SURELY = 1e-3
"""Fraction of the tolerance below which residuals need not be measured by the sizes at their own state."""


def followed(task: SteadyProblem, first: Array, tolerance: float) -> SteadyEquations | None:
    """The equations to follow from the steady motion X, or None if the conditions do not determine the unknowns."""
    conditions = replace(task.conditions, quick=True)
    free, measured_alone = _linear_last(conditions, task.free)
    numeric, eom, measured = conditions.numeric, conditions.eom, task.measured
    _, j = conditions(first)
    rows = sorted(choose(j[:, free] * measured.columns[free] / measured.rows[:, None]).rows) if free else []
    if len(rows) < len(free):
        return None
    _, z, slopes, _ = conditions.numbers(first)
    keep, terms = regular_rows(eom), conditions.sizes(first).terms
    routine = numeric.routine(steady_rows, conditions.applying, tuple(rows), tuple(free), keep).flat
    # X is ordered (x, r, p), arguments of routines (x, p, r, z)
    x, r, p = (len(s) for s in (eom.state, eom.inputs, eom.parameters))
    places = [*range(x), *range(x + p, x + p + r), *range(x, x + p)]
    pushed = np.abs(slopes.residual[list(keep)] * measured.columns).max(axis=1, initial=0)
    unknowns = Unknowns(
        [*(places[i] for i in free), *(x + p + r + k for k in keep)],
        np.concatenate([measured.columns[free], np.ones(len(keep))]),
        np.concatenate([measured.rows[rows], np.where(pushed > 0, pushed, 1.0)]),
        measured_alone,
    )

    def left(xs: Array) -> Array:
        # sizes at the first state are cheaper, and suffice far below the tolerance
        result = _quick_shares(conditions, xs, terms)
        for k in np.flatnonzero(~(result <= _SURELY * tolerance)).tolist():
            try:
                result[k] = shares(conditions, xs[k]).max(initial=0)
            except SingularError:
                result[k] = np.inf
        return result

    return SteadyEquations(
        task.start, free, conditions.symbols, places, routine, unknowns, z[list(keep)], left, tolerance
    )


def _linear_last(conditions: Conditions, free: Sequence[int]) -> tuple[list[int], int]:
    """The unknowns in X, last the inputs in which K z − k is jointly linear with z, and the number of unknowns before these.

    Those inputs follow from the others as z does: their changes do not show whether a root is on the branch.
    """
    symbols, u = conditions.symbols, unsolved(conditions.eom.derived)
    inputs = set(conditions.eom.inputs)
    asked, together, linear = [i for i in free if symbols[i] in inputs], set(u.unknowns), list[int]()
    slopes = partials([*u.places, *u.residual], [symbols[i] for i in asked])
    for k, i in enumerate(asked):
        if {*together, symbols[i]}.isdisjoint(free_symbols([row[k] for row in slopes.rows])):
            together.add(symbols[i])
            linear.append(i)
    return [*(i for i in free if i not in set(linear)), *linear], len(free) - len(linear)


def steady_rows(
    eom: Equations, applying: Applying, rows: Sequence[int], free: Sequence[int], keep: Sequence[int]
) -> Bundle[SquareEquations]:
    """The bundle of some rows of F, and K z = k in some rows, with derivatives in the unknowns of X and in z."""
    u, perturbed = unsolved(eom.derived), perturbations(eom)
    e = [[eom.coordinates[i] for i in places] for places in perturbed.sets]
    moved = [*(u.rates[i] for i in perturbed.coordinates), *u.spins]
    z = [u.unknowns[i] for i in applying.steady]
    held = [*u.configuration, *(sub(dot(x, x), ONE) for x in e), *u.motion]
    every = [*held, *(moved[i] for i in applying.constant), *z, *(u.states[i] for i in applying.further)]
    f, residual = [every[i] for i in rows], [u.residual[k] for k in keep]
    symbols = (*eom.state, *eom.inputs, *eom.parameters)
    by_x = partials([*f, *residual], [symbols[i] for i in free])
    kept = [u.unknowns[k] for k in keep]
    by_z = [[ONE if f_i is unknown else ZERO for unknown in kept] for f_i in f]
    by_z += [[u.matrix[k][i] for i in keep] for k in keep]
    gradient = [[*one, *two] for one, two in zip(by_x, by_z, strict=True)]
    size = len(f) + len(keep)
    groups = {"f": [*f, *residual], "gradient": Matrix(gradient, (size, size))}
    return Bundle("steady_rows", (*ports(eom.derived), unknowns(eom)), SquareEquations, groups)


def _quick_shares(conditions: Conditions, xs: Array, terms: Array) -> Array:
    """The largest relative residual of F at each X (k × …), for known sizes of terms; NaN where K is singular."""
    numeric, eom = conditions.numeric, conditions.eom
    x, r, p = np.split(xs, np.cumsum([len(eom.state), len(eom.inputs)]), axis=1)
    routine, keep, n = numeric.routine(values), regular_rows(eom), len(eom.speeds)
    rows = routine.flat(conditions.t, x, p, r)
    matrix, right = routine.bundle.places("matrix"), routine.bundle.places("right")
    own, z = routine.bundle.split(rows), np.zeros((len(rows), len(right)))
    a, b = MatrixEntries(rows, matrix[np.ix_(keep, keep)]), MatrixEntries(rows, right[list(keep), None])
    z[:, keep] = solve_each(a, b, numeric.settings).x[:, :, 0]
    norms = [(x[:, list(places)] ** 2).sum(axis=1)[:, None] - 1.0 for places in conditions.perturbed.sets]
    moved = np.hstack([own.rates[:, list(conditions.perturbed.coordinates)], own.spins])
    applying = conditions.applying
    steady = (
        moved[:, list(applying.constant)],
        z[:, :n][:, list(applying.steady)],
        own.states[:, list(applying.further)],
    )
    f = np.hstack([own.configuration, *norms, own.motion, *steady])
    return np.asarray(share(f, terms).max(axis=1, initial=0))
