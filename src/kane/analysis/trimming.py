# SPDX-License-Identifier: BSD-3-Clause
"""`trim` and `equilibrium`: steady motions and equilibria, by Newton's method with exact derivatives in X = (q, u, a, inputs, p).

f = 0,  eᵀe = 1,  A u + b = 0,  u̇_I = 0,  q̇ = 0 of the coordinates that matter,  ȧ = 0 of the further states that do
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NamedTuple, Unpack

import numpy as np

from kane import expect
from kane.analysis.differentiable import warn_of_jumps
from kane.analysis.flow import Flow, Preference, dependence, flow_at, magnitudes, scaled, share
from kane.analysis.linearization import choice_of
from kane.analysis.local import (
    Slopes,
    Values,
    all_switches,
    coded,
    quick_solver,
    regular_rows,
    slopes_at,
    solver,
    unknowns,
    values,
    values_at,
)
from kane.analysis.many.following import Square, Unknowns
from kane.analysis.many.poses import Poses, poses
from kane.analysis.many.trimmed import Followed, Routes, trimmed
from kane.analysis.operating_point import closed, state_from, warn_of_contacts
from kane.analysis.perturbations import Perturbations, perturbations
from kane.analysis.state_checks import StateArrays, entries, open_shares
from kane.dynamics.constraints.manifold import branches, turned_closures
from kane.dynamics.constraints.partition import choose
from kane.dynamics.readings.unsolved import partials, unsolved
from kane.equations.compiled import Numeric, ports
from kane.equations.equations import Equations, check_equations
from kane.equations.state import GROUPS, State, StateValues, by_keyword, state_of
from kane.errors import SimulationError, ValueMissingError
from kane.expr.build import sub
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Symbol, time
from kane.numeric.arrays import Array, Mask
from kane.numeric.newton import Closed, close, closest, starts
from kane.numeric.rank import level, singular
from kane.numeric.sampling import SEED, draw, named_values
from kane.numeric.scale import ROUNDED_CHAIN, SOLVED, STATE_RANK, TAKES_PART, UNRELATED
from kane.program.from_expressions import Bundle
from kane.program.native.machine import Settings
from kane.progress import working

_NEAR = (3, 8)
"""Seeds of the states near the start at which it is asked what depends on what."""
_SURELY = 1e-3
"""Share of the tolerance below which it does not matter at which state sizes are those."""
_ROUNDS = 3
"""Times that sizes of what moves and of what must vanish follow from each other."""


class Applying(NamedTuple):
    """The perturbations, speeds and further states of which rates must vanish."""

    constant: tuple[int, ...]
    steady: tuple[int, ...]
    further: tuple[int, ...]


class Sizes(NamedTuple):
    """The sizes of the terms of F; of F and X where both move as far as they do together, `rows` and `columns`."""

    terms: Array
    rows: Array
    columns: Array


@dataclass(frozen=True, slots=True, eq=False)
class Conditions:
    """F and ∂F/∂X; `symbols` names X; rates must vanish of the perturbations `constant`, the speeds `steady`, the states `further`.

    Dependent speeds that follow from what matters are among `steady`: at a dead centre the acceleration of the independent ones alone
    may vanish though nothing is at rest. `quick` are those near states at which the equations were found regular.
    """

    numeric: Numeric[Equations]
    t: float
    symbols: tuple[Symbol, ...]
    constant: tuple[int, ...]
    steady: tuple[int, ...]
    further: tuple[int, ...] = ()
    constraints_only: bool = False
    quick: bool = False

    @property
    def eom(self) -> Equations:
        """The equations."""
        return self.numeric.equations

    @property
    def perturbed(self) -> Perturbations:
        """The perturbations of the coordinates."""
        return self.numeric.value(perturbations)

    @property
    def applying(self) -> Applying:
        """What must not change."""
        return Applying(self.constant, self.steady, self.further)

    @property
    def labels(self) -> tuple[tuple[str, str], ...]:
        """A name and a unit for each condition."""
        eom, perturbed = self.eom, self.perturbed
        held = [c.name for c in eom.system.holonomic], [c.name for c in eom.constraints.constraints]
        labels = [(n, "") for n in held[0]] + [("unit length of Euler parameters", "")] * len(perturbed.sets)
        labels += [(n, "") for n in held[1]]
        if self.constraints_only:
            return tuple(labels)
        labels += [(f"{perturbed.names[i]}'", _unit(perturbed.symbols[i])) for i in self.constant]
        moved = [*(eom.speeds[i] for i in self.steady), *(eom.states[i] for i in self.further)]
        return (*labels, *((f"{s.name}'", _unit(s)) for s in moved))

    def state(self, x: Array) -> StateArrays:
        """The state at X."""
        eom = self.eom
        at = np.cumsum([len(eom.state), len(eom.inputs)])
        own, r, p = np.split(x, at)
        return StateArrays(self.t, own, p, r)

    def __call__(self, x: Array) -> tuple[Array, Array]:
        """F and ∂F/∂X."""
        values, z, slopes, solve = self._numbers(x)
        places, held = self._places(x, values, slopes)
        f, j = list(places), list(held)
        if not self.constraints_only:
            plain, n = list(self.perturbed.coordinates), len(self.eom.speeds)
            rates = np.append(values.rates[plain], values.spins)
            moved = np.vstack([slopes.rates[plain], slopes.spins])
            free = list(self.steady)
            further = list(self.further)
            f += [rates[list(self.constant)], z[:n][free], values.states[further]]
            j += [moved[list(self.constant)], -solve(slopes.residual)[:n][free], slopes.states[further]]
        return np.concatenate(f), np.vstack(j)

    def sizes(self, x: Array) -> Sizes:
        """How large the terms of F are at X, and what steps from there are measured by."""
        values, z, slopes, solve = self._numbers(x)
        nq, n = len(self.eom.coordinates), len(self.eom.speeds)
        size = magnitudes(self.eom, values, slopes, z, x[nq : nq + n])
        plain = list(self.perturbed.coordinates)
        held = [values.configuration_terms, np.ones(len(self.perturbed.sets)), size.motion]
        terms = np.concatenate([*held, size.rates[plain], size.spins, size.accelerations, values.state_terms])
        pushed = np.maximum(np.abs(size.inverse @ slopes.residual[:n]), np.abs(solve(slopes.residual)[:n]))
        moved = self._places(x, values, slopes)[1]
        j = np.abs(np.vstack([*moved, slopes.rates[plain], slopes.spins, pushed, slopes.states]))
        start, states = sum(map(len, held)), len(values.states)
        changed = [*(i - n for i in self.steady), *self.further]
        rest = [] if self.constraints_only else [*self.constant, *(len(terms) - states - start + i for i in changed)]
        taken = [*range(start), *(start + i for i in rest)]
        least = np.zeros(len(x))
        least[nq : nq + n] = size.alone
        rows, columns = _steps(terms, j, least)
        return Sizes(np.where(terms > 0, terms, rows)[taken], rows[taken], columns)

    def _numbers(self, x: Array) -> tuple[Values, Array, Slopes, Callable[[Array], Array]]:
        """What stands in the equations at X, z (zero for constraints alone), the derivatives, and what solves for z."""
        eom, state, run = self.eom, self.state(x), coded(self.numeric)
        values = values_at(run, state)
        solve = np.zeros_like if self.constraints_only else (quick_solver if self.quick else solver)(eom, values, state)
        z = solve(values.right)
        slopes = slopes_at(run, state, z)
        if eom.parameters:
            pairs = zip(slopes, slopes_at(run, state, z, *eom.parameters), strict=True)
            slopes = Slopes(*map(np.hstack, pairs))
        return values, z, slopes, solve

    def _places(self, x: Array, values: Values, slopes: Slopes) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        """f, eᵀe − 1, A u + b and their derivatives."""
        sets = self.perturbed.sets
        norms, norm_slopes = np.zeros(len(sets)), np.zeros((len(sets), len(x)))
        for k, places in enumerate(sets):
            e = x[list(places)]
            norms[k], norm_slopes[k, list(places)] = e @ e - 1.0, 2 * e
        f = values.configuration, norms, values.motion
        return f, (slopes.configuration, norm_slopes, slopes.motion)


def _steps(terms: Array, j: Array, least: Array) -> tuple[Array, Array]:
    """Sizes of f with `terms` (m) and slopes of the size `j` (m × n), and of x, no smaller than the `least`; 1 where nothing tells.

    An x has the size that changes some terms by theirs. Such changes make terms in other f, which are small where the motion is
    straight or at rest, and let others move further.
    """
    rows, columns = terms, np.zeros(len(least))
    for _ in range(_ROUNDS):
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = np.where((j > 0) & (rows[:, None] > 0), rows[:, None] / j, np.inf).min(axis=0, initial=np.inf)
        columns = np.maximum(np.where(np.isfinite(reach), reach, 0.0), least)
        columns = np.where(columns > 0, columns, 1.0)
        rows = np.maximum(rows, (j * columns).max(axis=1, initial=0))
    return np.where(rows > 0, rows, 1.0), columns


def _unit(s: Symbol | None) -> str:
    return f"{s.unit}/s" if s is not None and s.unit else ""


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """F over the sizes of its `rows` and ∂F/∂Y, of Y = X at `places` over the sizes of its `columns`: the same in any units.

    The other X stay as at the `start`.
    """

    conditions: Conditions
    rows: Array
    columns: Array
    start: Array
    places: Sequence[int]

    def spread(self, y: Array) -> Array:
        """X of Y."""
        x = self.start.copy()
        x[list(self.places)] = y * self.columns
        return x

    def __call__(self, y: Array) -> tuple[Array, Array]:
        """F and ∂F/∂Y."""
        f, j = self.conditions(self.spread(y))
        return f / self.rows, j[:, list(self.places)] * self.columns / self.rows[:, None]

    def last(self, y: Array) -> str:
        """The last of Y, by name."""
        return f"{self.conditions.symbols[self.places[-1]].name} = {y[-1] * self.columns[-1]:.6g}"


def conditions(
    numeric: Numeric[Equations], t: float, start: Array, choice: Preference, moving: Sequence[str]
) -> Conditions:
    """The conditions that apply: coordinates on which no speed depends near the start may move, and so may `moving`."""
    eom = numeric.equations
    symbols: tuple[Symbol, ...] = (*eom.state, *eom.inputs, *eom.parameters)
    bare = Conditions(numeric, t, symbols, (), (), constraints_only=True)
    placed, width = len(eom.coordinates) + len(eom.speeds), len(eom.state)
    constant: set[int] = set()
    further: set[int] = set()
    steady = set(range(len(eom.speeds)))
    _, rows, columns = bare.sizes(start)
    measured = Measured(bare, rows, columns, start, range(len(start)))
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
    """The same with those dependent speeds, exchanged one by one, with which the fewest coordinates matter to the independent ones.

    Along a frame that spins the speeds of a contact change in a steady motion, and where one of them is independent the spin matters.
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
            other = flow_at(flow.numeric, flow.state, choice)
            fewer = int(_matter(other)[: other.counts[0]].sum())
            if fewer < least:
                flow, least, again = other, fewer, True
                break
    return flow


def _matter(flow: Flow) -> Mask:
    """Which of the independent coordinates, speeds and further states matter to the speeds."""
    return dependence(scaled(flow.a, flow), *flow.counts)


_TRIES = 12


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Conditions, a start X, and which entries of X may move; `missing` are those that were left out.

    `measured` are the conditions over their sizes at the start.
    """

    conditions: Conditions
    start: Array
    free: tuple[int, ...]
    missing: tuple[int, ...]
    measured: Measured

    @property
    def mattering(self) -> tuple[int, ...]:
        """Entries of X on which something depends."""
        conditions = self.conditions
        perturbed, eom = conditions.perturbed, conditions.eom
        nq, n = len(eom.coordinates), len(eom.speeds)
        plain = len(perturbed.coordinates)
        own = [perturbed.coordinates[i] for i in conditions.constant if i < plain]
        steady = (*conditions.steady, *(n + i for i in conditions.further))
        return (*own, *(nq + i for i in steady), *range(len(eom.state), len(self.start)))


def problem(numeric: Numeric[Equations], given: State, moving: Sequence[Any], independent: Sequence[Any]) -> Problem:
    """What is to be solved, from what a state gives, guesses and leaves out."""
    eom, perturbed = numeric.equations, numeric.value(perturbations)
    defaults = {p: p.default for p in eom.parameters if p.default is not None}
    complete = replace(given, parameters=defaults | named_values("parameters", eom.parameters, given.parameters))
    parts = [entries(what, getattr(eom, what), getattr(complete, kind), "value") for kind, what in GROUPS.items()]
    for what, part in zip(GROUPS.values(), parts, strict=True):
        if what in ("inputs", "parameters"):
            missing = [getattr(eom, what)[i].name for i in part.missing[:1]]
            came = "none for {}: give a number to keep, or kn.guess(value) to have it solved for"
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
    names = [m.name if isinstance(m, Symbol) else m for m in moving]
    unknown = [n for n in names if n not in perturbed.names and n not in {s.name for s in (*eom.speeds, *eom.states)}]
    expect.none(unknown, "moving= to name coordinates, speeds or states", error=ValueMissingError)
    held = conditions(numeric, float(given.t), x, choice_of(numeric, independent), names)
    measured = Measured(held, *held.sizes(x)[1:], x, range(len(x)))
    return Problem(held, x, tuple(free), tuple(missing), measured)


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
    """A steady motion or an equilibrium: u̇ = 0 of the independent speeds, q̇ = 0 of the coordinates that matter, all constraints.

    Values that are given are kept, guesses (`kn.guess(value)`) may move, coordinates and speeds left out are solved for, from zero,
    further states from their defaults; these rest too, ȧ = 0, where the speeds depend on them.
    Coordinates on which no speed depends may move steadily: a heading, a wheel's angle, a place on the road.

    Parameters
    ----------
    eom : Equations
    state : `kn.State` of values and guesses, in place of those that follow
    q, u, states, parameters, inputs : values and guesses by symbol or name; parameters left out take their defaults
    moving : more coordinates, speeds and states that may change
    independent : speeds to be independent, where those of the equations are not constant in a steady motion
    tolerance : what may remain of rates, accelerations and constraints, as a share of the terms that cancel in them
    settings : how to compile

    Of arrays in the places of numbers the result is a Dataset over instance, of coordinates, speeds, states and what is guessed. The
    steady motion of the first is followed along the arrays; where that ends the cause is told, and the next ones are reached from the
    last before it. Conditions are those that apply at the first.

    Raises
    ------
    SimulationError
        if no such motion is found; says which acceleration remains, and how much of it
    ValueMissingError
        if the conditions do not determine what is left out
    """
    check_equations(eom)
    many = poses(eom, state, values)
    if many is not None:
        with working("Trimming"):
            return _of_many(many, eom.numeric(settings), (moving, independent, tolerance))
    with working("Trimming"):
        numeric = eom.numeric(settings)
        task = problem(numeric, state_of(state, **values), moving, independent)
        x = solve_problem(task, tolerance)
        expected, came = "values that determine the steady motion", "too few: {} can still take other values"
        cure = "Give some of them, or a guess for each: kn.guess(value)."
        expect.none(undetermined(task, x, task.missing), expected, came, cure, error=ValueMissingError)
        arrays = closed(numeric, task.conditions.state(x))
        warn_of_jumps(numeric, arrays, tolerance)
        found = state_from(eom, arrays)
        warn_of_contacts(eom, [found])
        return found


def _of_many(many: Poses, numeric: Numeric[Equations], options: tuple[Sequence[Any], Sequence[Any], float]) -> Any:
    """Those of many states as a Dataset, on the branch of the first."""
    moving, independent, tolerance = options

    def alone(k: int) -> State:
        found: State = trim(
            numeric.equations, many.state(k), moving=moving, independent=independent, tolerance=tolerance,
            settings=numeric.settings,
        )  # fmt: skip
        return found

    def followed(k: int, first: Array) -> Followed | None:
        if isinstance(many.given("t")[time], np.ndarray) or numeric.value(all_switches):
            return None
        return _followed(problem(numeric, many.state(k), moving, independent), first, tolerance)

    return trimmed(many, Routes(alone, followed))


def _followed(task: Problem, first: Array, tolerance: float) -> Followed | None:
    """What is followed from the steady motion X; None where the conditions do not determine what is free."""
    conditions, free = replace(task.conditions, quick=True), list(task.free)
    numeric, eom, measured = conditions.numeric, conditions.eom, task.measured
    _, j = conditions(first)
    rows = sorted(choose(j[:, free] * measured.columns[free] / measured.rows[:, None]).rows) if free else []
    if len(rows) < len(free):
        return None
    _, z, slopes, _ = conditions._numbers(first)
    keep, terms = regular_rows(eom), conditions.sizes(task.start).terms
    routine = numeric.routine(steadiness, conditions.applying, tuple(rows), tuple(free), keep).flat
    # X is (x, r, p), what routines take (x, p, r, z)
    x, r, p = (len(s) for s in (eom.state, eom.inputs, eom.parameters))
    places = [*range(x), *range(x + p, x + p + r), *range(x, x + p)]
    pushed = np.abs(slopes.residual[list(keep)] * measured.columns).max(axis=1, initial=0)
    unknowns = Unknowns(
        [*(places[i] for i in free), *(x + p + r + k for k in keep)],
        np.concatenate([measured.columns[free], np.ones(len(keep))]),
        np.concatenate([measured.rows[rows], np.where(pushed > 0, pushed, 1.0)]),
        len(free),
    )

    def left(xs: Array) -> Array:
        # far below the tolerance by the sizes at the first, which cost less than those there
        shares = _quick_shares(conditions, xs, terms)
        for k in np.flatnonzero(~(shares <= _SURELY * tolerance)).tolist():
            shares[k] = _shares(conditions, xs[k]).max(initial=0)
        return shares

    return Followed(task.start, free, conditions.symbols, places, routine, unknowns, z[list(keep)], left, tolerance)


def steadiness(
    eom: Equations, applying: Applying, rows: Sequence[int], free: Sequence[int], keep: Sequence[int]
) -> Bundle[Square]:
    """Some of F, and K z = k of the rows that are kept, with the derivatives in what is free of X, and in z."""
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
    return Bundle("steadiness", (*ports(eom.derived), unknowns(eom)), Square, groups)


def _quick_shares(conditions: Conditions, xs: Array, terms: Array) -> Array:
    """What is left of F at each X (k × …), by sizes of its terms that are known; infinity where K is singular at one of them."""
    eom, run = conditions.eom, coded(conditions.numeric)
    x, r, p = np.split(xs, np.cumsum([len(eom.state), len(eom.inputs)]), axis=1)
    own, keep, n = run(values)(conditions.t, x, p, r), list(regular_rows(eom)), len(eom.speeds)
    z = np.zeros(own.right.shape)
    try:
        z[:, keep] = np.linalg.solve(own.matrix[:, keep][:, :, keep], own.right[:, keep, None])[:, :, 0]
    except np.linalg.LinAlgError:
        return np.full(len(xs), np.inf)
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
    """A state of rest: as `trim` with all speeds zero, whatever speeds a `state` that is given has."""
    check_equations(eom)
    given = state_of(state, q=q, states=states, inputs=inputs, parameters=parameters, t=t)
    return trim(eom, replace(given, u=dict.fromkeys(eom.speeds, 0.0)), tolerance=tolerance, settings=settings)


def solve_problem(task: Problem, tolerance: float) -> Array:
    """X by Gauss–Newton from the start; where something was left out and that fails, from other starts for it.

    A SimulationError says what remains where there is none.
    """
    measured, turned = task.measured, _astray(task.conditions)
    spreads = [0.2 * k for k in range(1, _TRIES)] if task.missing else []
    tries = starts(task.start / measured.columns, task.missing, SEED, spreads)

    def astray(y: Array) -> Array:
        x = y * measured.columns
        return np.append(turned(x), _shares(task.conditions, x).max(initial=0) > tolerance)

    best = closest(measured, tries, task.free, np.inf, limit=1e-14, astray=astray)
    x = _plain(task, best) * measured.columns
    left = _shares(task.conditions, x)
    if not left.max(initial=0) <= tolerance:
        raise SimulationError(_failed(task, task.conditions(x)[0], left, best.steps))
    away = turned_closures(branches(task.conditions.eom.system), turned(x))
    expected = "a steady motion on the branch that the closures mean"
    cure = "Guess coordinates on that branch: kn.assemble finds them."
    expect.that(not away, expected, came=away, cure=cure, error=SimulationError)
    return x


def _shares(conditions: Conditions, x: Array) -> Array:
    """What is left of each condition, over the size of its terms."""
    f, held = conditions(x)[0], len(conditions.eom.system.holonomic)
    sizes = conditions.sizes(x).terms
    shares = share(f, sizes)
    shares[:held] = open_shares(conditions.eom, f[:held], sizes[:held], conditions.state(x).given(conditions.eom))
    return shares


def _plain(task: Problem, best: Closed) -> Array:
    """Y with what is zero but for rounding made zero: where nothing else has a size, no number is small."""
    free = np.array(task.free, dtype=int)
    tiny = free[np.abs(best.x[free]) <= ROUNDED_CHAIN]
    if not best.x[tiny].any():
        return best.x
    y = best.x.copy()
    y[tiny] = 0.0
    left = np.abs(task.measured(y)[0]).max(initial=0)
    return y if left <= max(best.size, ROUNDED_CHAIN) else best.x


def _astray(conditions: Conditions) -> Callable[[Array], Array]:
    """By what angles closures are turned at X."""
    eom = conditions.eom
    constraints, nq, width = eom.derived.conditions, len(eom.coordinates), len(eom.state)
    rest = [*eom.inputs, *eom.parameters, time]

    def angles(x: Array) -> Array:
        values: dict[Expr, Any] = dict(zip(rest, [*x[width:].tolist(), conditions.t], strict=True))
        return constraints.at(values).turned(x[:nq])

    return angles


def _failed(task: Problem, residual: Array, shares: Array, steps: int) -> str:
    labels = task.conditions.labels
    order = np.argsort(-shares, kind="stable")
    worst = [(*labels[i], residual[i]) for i in order[:4] if shares[i] > 1e-3 * shares.max()]
    remains = [f"{name} = {x:.6g}{' ' + unit if unit else ''}" for name, unit, x in worst]
    solved = [task.conditions.symbols[i].name for i in task.free]
    return (
        f"Expected a steady motion with the values given, got none: after {steps} steps there remains {', '.join(remains)}. Solved "
        f"for were {', '.join(solved) or 'no values'}; guess nearer, or mark more values with kn.guess(…)."
    )


def null_space(task: Problem, x: Array) -> Array:
    """Directions of the free entries in which the conditions stay satisfied, one a row (k × free)."""
    _, j = task.measured(x / task.measured.columns)
    return singular(level(j[:, list(task.free)])).kernel(STATE_RANK)


def undetermined(task: Problem, x: Array, among: Sequence[int]) -> list[str]:
    """Entries of X among those given that matter and are not determined."""
    if not task.free:
        return []
    directions = np.abs(null_space(task, x)).max(axis=0, initial=0)
    matter = set(task.mattering) & set(among)
    open_ = [i for i, d in zip(task.free, directions, strict=True) if d > TAKES_PART and i in matter]
    return [task.conditions.symbols[i].name for i in open_]
