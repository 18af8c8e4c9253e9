# SPDX-License-Identifier: BSD-3-Clause
"""`assemble`: a state that satisfies the constraints, from coordinates and speeds that are given, guessed, or left out.

Speeds follow from A u + b = 0. No division is made in constraints A_q q̇ + b_q = 0 and speeds u = Y q̇ + z: where A may have false
poles, or is not finite, the speeds are those of the rates that the constraints allow, with A_q N = 0, A_q q̇₀ + b_q = 0 and

    B u = B (Y q̇₀ + z),    B (Y N) = 0

Configurations on the specified closure branches are found by the Gauss–Newton method from many starts, and sorted by distance from the
guesses, or from zero without guesses: angles in rad, lengths relative to the size of the mechanism. Full turns are removed from angles
so that they are nearest to their guess, and Euler parameters have the sign that is nearest.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Unpack, overload

import numpy as np

from kane import expect
from kane.analysis.flow import turning
from kane.analysis.many.assembled import One, assembled, level_of
from kane.analysis.many.poses import Poses, poses
from kane.analysis.state_checks import GivenEntries, entries, misses
from kane.dynamics.constraints.manifold import LevelSet, turned_closures
from kane.dynamics.readings.quantities import parameter_values
from kane.equations.equations import Equations, check_equations
from kane.equations.state import State, StateValues, by_keyword, state_of
from kane.errors import ArgumentError, SimulationError, ValueMissingError
from kane.expr.evaluation import evaluate
from kane.expr.matrix import dot
from kane.expr.node import Expr
from kane.expr.symbols import rate, time
from kane.expr.visit import substituted
from kane.model.declarations import constraint_rate
from kane.numeric.arrays import Array, ranks
from kane.numeric.newton import Closed
from kane.numeric.rank import balance, least_squares, singular
from kane.numeric.sampling import ASSEMBLY_SEED, finite_number, named_values
from kane.numeric.scale import CLOSED, DERIVE_RANK, GIVEN, ONE_POSITION, ROUNDED, ROUNDED_ROOT, STATE_RANK
from kane.progress import working

TRIES = (60, 400, 1600)
"""Numbers of starts of successive attempts, each made only if those before reached no configuration on a specified branch."""
_SLIDES, _NEAREST, _SHARES = 40, 6, 0.25 ** np.arange(7)
_TOLD = 6


class AssemblyResult(NamedTuple):
    """The configurations found, nearest first, that with the smallest residual, `nearest`, and the `turned` closures in words."""

    closed: tuple[Closed, ...]
    nearest: Closed
    turned: str
    starts: int


def search(level: LevelSet, start: GivenEntries) -> "ClosureSearch":
    """A search for the values that a start leaves free."""
    return ClosureSearch(level.of(start.values, start.free), start)


@dataclass(frozen=True, eq=False)
class ClosureSearch:
    """The configuration constraints of a system at given values of everything except coordinates, with a start."""

    level: LevelSet
    start: GivenEntries

    @property
    def _free(self) -> list[int]:
        return list(self.level.free)

    def turned(self, x: Array) -> str:
        """The closures that are on a wrong branch at q, in words."""
        return turned_closures(self.level.manifold.branches, self.level.turned(x))

    def words(self, found: AssemblyResult) -> list[str]:
        """For each configuration, which of the branches found it is on, and where the next one is, in words."""
        open_, count = len(self._kernel(found.closed[0].x)), len(found.closed)
        if open_:
            return [f"the nearest; {open_} of the guesses could be fixed"] * count
        if count == 1:
            return [f"the only branch from {found.starts} starts"]
        following = [*found.closed[1:], found.closed[0]]
        return [
            f"{f'branch {k} of {count}' if k > 1 else f'the nearest of {count} branches'}; {'next' if k < count else 'nearest'}: "
            f"{self._apart(other.x, at.x)}"
            for k, (at, other) in enumerate(zip(found.closed, following, strict=True), 1)
        ]

    def cure(self) -> str:
        """Advice for given coordinates on a wrong branch: coordinates that are on the specified one."""
        every = tuple(range(len(self.start.values)))
        found = search(self.level, GivenEntries(self.start.values, every, ())).found()
        if not found.closed:
            return "No coordinates were found on the intended branch: correct the frames and axes of the closure."
        return (
            f"The intended branch contains {self._apart(found.closed[0].x, self.start.values)}, with the other coordinates as "
            "given: kn.assemble finds it from kn.guess(…) of all of them."
        )

    def _apart(self, x: Array, other: Array) -> str:
        """The first few coordinates of x that differ from `other`, in words."""
        apart = np.abs(x - other) > ONE_POSITION * self.level.wide
        coordinates = self.level.manifold.system.coordinates
        pairs = [(q, v) for q, v, differs in zip(coordinates, x, apart, strict=True) if differs]
        return ", ".join(f"{q} = {v:.4g}" for q, v in pairs[:_TOLD]) + (", …" if len(pairs) > _TOLD else "")

    def found(self, thorough: bool = False) -> AssemblyResult:
        """The result of the attempts; `thorough` omits the first, smallest one."""
        rng = np.random.default_rng(ASSEMBLY_SEED)
        nearest, turned, starts = None, "", 0
        for count in TRIES[1 if thorough else 0 :]:
            starts += count
            closed, best, away = self._tried(self._starts(rng, count))
            if closed:
                return AssemblyResult(closed, best, "", starts)
            nearest = best if nearest is None or best.size < nearest.size else nearest
            turned = turned or away
        assert nearest is not None
        return AssemblyResult((), nearest, turned, starts)

    def _starts(self, rng: "np.random.Generator", count: int) -> Array:
        """Starts (k × free): the given one, some around it, and others within a turn, or within the size of the mechanism."""
        first, size, near = self.start.values[self._free], self.level.usual, count // 3
        x = rng.uniform(-np.pi, np.pi, (count, len(first))) * np.where(size.turns, 1.0, size.x / 2)
        x[:near] = rng.normal(size=(near, len(first))) * size.x * np.linspace(0.0, 1.0, near)[:, None]
        return np.asarray(x + first)

    def _tried(self, x: Array) -> tuple[tuple[Closed, ...], Closed, str]:
        """Different configurations on the specified branches; the one nearest to satisfying the constraints; the turned closures."""
        reached = self.level.reached(x, self.level.usual)
        nearest = self.level.closest(reached.q[reached.best])
        closed = reached.found.left <= CLOSED
        if not closed.any():
            return (), nearest, ""
        q, away = self._homed(reached.q[closed]), np.asarray(reached.turned[closed].any(axis=1))
        order = np.argsort(self.distances(q), kind="stable")
        q, away = q[order], away[order]
        if away.all():
            return (), nearest, self.turned(q[0])
        q = q[~away]
        q = q[self._distinct(q)] if not len(self._kernel(q[0])) else np.array([*map(self._slid, q[:_NEAREST])])
        return self._ordered([self.level.closest(x) for x in q[self._distinct(q)]]), nearest, ""

    def _ordered(self, ends: Sequence[Closed]) -> tuple[Closed, ...]:
        """Different configurations, nearest first; of two at equal distances, that with the larger first coordinate comes first."""
        x = np.array([c.x for c in ends])
        columns = (-x / self.level.wide)[:, self._free].T
        order = np.lexsort([*(ranks(c, ONE_POSITION) for c in columns[::-1]), ranks(self.distances(x), ROUNDED_ROOT)])
        return tuple(ends[order[k]] for k in self._distinct(x[order]))

    def distances(self, x: Array) -> Array:
        """Distances of q (k × n) from the guesses (k); coordinates left out decide between equal distances."""
        away = np.zeros(x.shape)
        away[:, self._free] = (x - self.start.values)[:, self._free] / self.level.metric
        guessed = np.linalg.norm(away[:, list(self.start.guessed)], axis=1)
        weight = ONE_POSITION if self.start.guessed else 1.0
        return np.asarray(guessed + weight * np.linalg.norm(away[:, list(self.start.missing)], axis=1))

    def _distinct(self, x: Array) -> list[int]:
        """Indices of different q (k × n), the first of each."""
        kept: list[int] = []
        free, size = self._free, self.level.metric
        for k, one in enumerate(x):
            if all(np.abs((one - x[i])[free] / size).max() > ONE_POSITION for i in kept):
                kept.append(k)
        return kept

    def _homed(self, x: Array) -> Array:
        """Each q (k × n) with angles within half a turn of the start and Euler parameters of its sign, if it closes there too.

        An angle half a turn away is taken as positive, whatever its rounding, and Euler parameters with a positive first component.
        """
        free = np.array(self._free)[self.level.usual.turns]
        home, first = x.copy(), self.start.values
        home[:, free] += 2 * np.pi * np.floor((first - x)[:, free] / (2 * np.pi) + 0.5 + ONE_POSITION)
        place = {q: i for i, q in enumerate(self.level.manifold.system.coordinates)}
        for e in self.level.manifold.system.euler_parameters:
            at = [place[q] for q in e.coordinates]
            if set(at) <= set(self.start.free):
                side, own = home[:, at] @ first[at], home[:, at]
                begin = own[np.arange(len(own)), (np.abs(own) > ONE_POSITION).argmax(axis=1)]
                side = np.where(np.abs(side) <= ONE_POSITION, begin, side)
                home[:, at] *= np.where(side < 0, -1.0, 1.0)[:, None]
        left = self.level.shares(self.level.numbers(home)[0]).max(axis=1, initial=0)
        kept = (left <= 10 * CLOSED) & (self.level.turned(home) == self.level.turned(x)).all(axis=1)
        return np.where(kept[:, None], home, x)

    def singular_at(self, x: Array) -> str:
        """The constraints that are not finite at q (n), and where, in words; "" if all are finite."""
        f, g = self.level.one(x)
        lost = ~(np.isfinite(f) & np.isfinite(g).all(axis=1))
        names = [n for n, bad in zip(self.level.manifold.names, lost, strict=True) if bad]
        at = [(q, v) for q, v in zip(self.level.manifold.system.coordinates, x, strict=True) if v]
        where = ", ".join(f"{q} = {v:.6g}" for q, v in at[:_TOLD]) or "zero of all coordinates"
        return f"infinity or NaN of {', '.join(map(repr, names))} at {where}" if names else ""

    def block(self, x: Array) -> Array:
        """∂f/∂q (m × free) at q (n), divided by the sizes of f and of q."""
        return np.asarray(self.level.one(x)[1][:, self._free] * self.level.metric / self.level.usual.f[:, None])

    def _kernel(self, x: Array) -> Array:
        """A basis, as rows, of the directions of free coordinates that the constraints allow at q (n)."""
        return singular(self.block(x)).kernel(STATE_RANK)

    def _slid(self, x: Array) -> Array:
        """The configuration nearest to the guesses, reached from q (n) along the constraints.

        The first step would end there if the constraints were linear, the others allow for their curvature, by secants.
        """
        free, size = self._free, self.level.metric
        pull = np.isin(free, self.start.guessed)
        length, last = 1.0, None
        for _ in range(_SLIDES):
            kernel = self._kernel(x)
            change = kernel.T @ (kernel @ (pull * (self.start.values - x)[free] / size))
            if np.abs(change).max(initial=0) <= ROUNDED_ROOT:
                break
            if last is not None:
                moved = (x - last[0])[free] / size
                bend = float(moved @ (last[1] - change))
                length = min(max(float(moved @ moved) / bend, _SHARES[-1]), 10.0) if bend > 0 else 1.0
            last = x, change
            for share in length * _SHARES:
                trial = x.copy()
                trial[free] += share * change * size
                trial = self.level.closest(trial).x
                nearer = self.distances(trial[None])[0] < self.distances(x[None])[0]
                if nearer and np.isfinite(self.block(trial)).all():
                    break
            else:
                break
            x = trial
        return x


class VelocityConstraints(NamedTuple):
    """Constraints `rows` x + `rest` = 0 on x, speeds or rates, with their `names`; the speeds are u = `to_speeds` x + `added`."""

    names: tuple[str, ...]
    rows: Array
    rest: Array
    to_speeds: Array
    added: Array


def velocity_constraints_at(eom: Equations, at: Mapping[Expr, Any], by_rates: bool) -> VelocityConstraints:
    """The velocity constraints at a configuration, in the speeds or, with `by_rates`, in the rates of the coordinates.

    Raises SimulationError, naming constraints or speeds, if these are not finite even in rates.
    """
    constraints, n = eom.derived.constraints, len(eom.speeds)
    m = len(constraints.b)
    a = np.asarray(evaluate(constraints.a, at), dtype=float).reshape(m, n)
    b = np.array(evaluate(list(constraints.b), at), dtype=float) if m else np.zeros(0)
    names = tuple(c.name for c in constraints.constraints)
    if _plain(eom, a, b):
        if not by_rates:
            return VelocityConstraints(names, a, b, np.eye(n), np.zeros(n))
        y = np.asarray(evaluate(eom.Y, at), dtype=float)[:n]
        z = np.array(evaluate(list(eom.z), at), dtype=float)[:n]
        return VelocityConstraints(names, a @ y, a @ z + b, y, z)
    y, z, c, rest = _in_basic_rates(eom, at)
    names = tuple(k.name for k in eom.system.constraints)
    if by_rates:
        spread = _basic(eom, at)
        return VelocityConstraints(names, c @ spread, rest, y @ spread, z)
    return _possible(names, y, z, c, rest)


def _plain(eom: Equations, a: Array, b: Array) -> bool:
    """Whether A u + b = 0 can be used directly: it is finite and the speeds have no false pole."""
    return eom.solved.twin is None and bool(np.isfinite(a).all() and np.isfinite(b).all())


def _in_basic_rates(eom: Equations, at: Mapping[Expr, Any]) -> tuple[Array, Array, Array, Array]:
    """Y, z, A_q, b_q in the basic rates: those of coordinates, and the quasi-rates of Euler parameters."""
    speeds, system = eom.derived.kinematical, eom.system
    rows = [dot(list(row.values()), list(row)) + z for row, z in zip(speeds.rows, speeds.z, strict=True)]
    held = [substituted(constraint_rate(c), speeds.euler_rates) for c in system.constraints]
    count = len(speeds.rates)
    unit = dict(zip(speeds.rates, np.eye(count, count + 1), strict=True))
    with np.errstate(all="ignore"):
        wide = [np.broadcast_to(x, count + 1) for x in evaluate([*rows, *held], {**at, **unit})]
    numbers = np.array(wide, dtype=float)
    labels = [*(f"the speed {u}" for u in eom.speeds), *(repr(c.name) for c in system.constraints)]
    lost = [x for x, row in zip(labels, numbers, strict=True) if not np.isfinite(row).all()]
    if lost:
        place = [f"{q} = {float(at[q]):.6g}" for q in eom.coordinates if at[q]]
        where = ", ".join(place[:_TOLD]) or "zero of all coordinates"
        raise SimulationError(
            f"Expected constraints and speeds that are finite at this configuration, got infinity or NaN of {', '.join(lost)} "
            f"at {where}. The coordinates are singular there: choose a nearby configuration, or other coordinates (another "
            "sequence of angles)."
        )
    rest = numbers[:, -1]
    linear, n = numbers[:, :-1] - rest[:, None], len(eom.speeds)
    return linear[:n], rest[:n], linear[n:], rest[n:]


def _basic(eom: Equations, at: Mapping[Expr, Any]) -> Array:
    """The matrix of the basic rates in the rates of coordinates, with ω = 2 E(e)ᵀ ė for Euler parameters."""
    rates = {r: k for k, r in enumerate(eom.derived.kinematical.rates)}
    place = {q: k for k, q in enumerate(eom.coordinates)}
    spread = np.zeros((len(rates), len(place)))
    for q, k in place.items():
        if rate(q) in rates:
            spread[rates[rate(q)], k] = 1.0
    for s in eom.system.euler_parameters:
        e = np.array([float(at[q]) for q in s.coordinates])
        spread[np.ix_([rates[w] for w in s.quasi], [place[q] for q in s.coordinates])] = 4 * turning(e).T
    return spread


def _possible(names: tuple[str, ...], y: Array, z: Array, c: Array, rest: Array) -> VelocityConstraints:
    """The constraints B u = B (Y q̇₀ + z) on speeds, from Y, z and the constraints C q̇ + `rest` = 0."""
    scaled = balance(c)
    wanted = -rest / scaled.rows[:, 0]
    first = least_squares(scaled.matrix, wanted)
    bad = misses(names, scaled.matrix @ first - wanted, limit=GIVEN * np.abs(wanted).max(initial=0))
    expected = "constraints that rates can satisfy simultaneously at this configuration"
    cure = "It is a singular configuration: choose a nearby one."
    expect.none(bad, expected, "least residuals {}", cure, error=SimulationError)
    open_ = singular(scaled.matrix).kernel(DERIVE_RANK) / scaled.columns
    moved = balance(y @ open_.T)
    b = singular(moved.matrix).cokernel(DERIVE_RANK) / moved.rows[:, 0]
    together = f"{', '.join(names)}{' together' if len(names) > 1 else ''}"
    return VelocityConstraints(
        (together,) * len(b), b, -b @ (y @ (first / scaled.columns[0]) + z), np.eye(len(y)), np.zeros(len(y))
    )


_IN_A_MODE = "A contact that sticks has no slip: choose a mode in which it slips, or simulate the system itself, which chooses modes."
_LEAVE_OUT = "Leave some out, or mark them with kn.guess(…), to have them solved for."
_BESIDE = "The coordinates, or lengths, are singular there: give other values, or other coordinates (another sequence of angles)."


@dataclass(frozen=True, slots=True, eq=False)
class Assembled(State):
    """A state that satisfies the constraints, from `kn.assemble`: a `kn.State`, for `kn.simulate(eom, span, start=…)`.

    `residual` is the largest residual of the constraints. `branch` describes, as text, which of the branches found the state is on
    and where the next one lies; "" if there was nothing to search.
    """

    residual: float = field(kw_only=True)
    branch: str = field(default="", kw_only=True)

    @property
    def state(self) -> State:
        """The State alone."""
        return self.replace()

    def __repr__(self) -> str:
        values = ", ".join(f"{s} = {v:.6g}" for s, v in (*self.q.items(), *self.u.items()))
        return f"Assembled({values}; residual {self.residual:.1e}{self.branch and '; '}{self.branch})"


@overload
def assemble(
    eom: Equations,
    state: State | Any | None = None,
    *,
    rates: Mapping[Any, Any] | None = None,
    all_branches: Literal[False] = False,
    **values: Unpack[StateValues],
) -> Assembled | Any: ...


@overload
def assemble(
    eom: Equations,
    state: State | Any | None = None,
    *,
    rates: Mapping[Any, Any] | None = None,
    all_branches: Literal[True],
    **values: Unpack[StateValues],
) -> tuple[Assembled, ...]: ...


@by_keyword
def assemble(
    eom: Equations,
    state: State | Any | None = None,
    *,
    rates: Mapping[Any, Any] | None = None,
    all_branches: bool = False,
    **values: Unpack[StateValues],
) -> Assembled | tuple[Assembled, ...] | Any:
    """Find a state that satisfies all constraints: the configuration nearest to the guesses, of those reached from many starts.

    Given values are kept, guesses `kn.guess(value)` are changed, and values left out are solved for: coordinates by the
    Gauss–Newton method, speeds by linear least squares. The nearest configuration has the smallest changes of guessed coordinates,
    or without guesses the smallest coordinates, angles in rad and lengths relative to the size of the mechanism. Of two mirror
    images at the same distance, that with the larger first coordinate is taken. Spurious solutions, with a joint of a closed loop
    turned over, are excluded.

    Parameters
    ----------
    eom : Equations
    state : a `kn.State` instead of the values that follow
    q : coordinates, by symbol or name
    u : speeds, by symbol or name; if no speeds are given, they are the smallest that the constraints allow, zero if possible
    rates : rates q̇, by coordinate, instead of `u`
    inputs : values at time `t` of the inputs, and of their derivatives, that constraints contain
    all_branches : return all states found, nearest first, as a tuple; angles that differ by full turns count as equal

    If values are arrays (n, one entry for each of n states, as for `kn.simulate_many`; t as well), the result is an xarray Dataset
    with the dimension instance: coordinates, speeds, `residual`, `status` and `cause`. The first state is found as above, and its
    branch is followed through the arrays, with intermediate steps if needed. Where the branch ends, at a dead point or out of
    reach, the state is NaN and `cause` gives the reason; later states are reached from the last valid one. Angles are continuous
    along the arrays.

    Returns
    -------
    Assembled, tuple of Assembled, or xarray.Dataset

    Raises
    ------
    ValueMissingError
        if the constraints do not determine the values left out
    SimulationError
        if no state satisfies the constraints with the given values; the message names the violated constraint and its residual, or
        the closed loop with a joint turned over
    """
    check_equations(eom)
    many = poses(eom, state, values, rates)
    if many is not None:
        with working("Assembling"):
            return _of_many(many, all_branches)
    given = state_of(state, **values)
    with working("Assembling"):
        made = _assembled(eom, given, rates, all_branches)[0]
    return tuple(made) if all_branches else made[0]


def _assembled(
    eom: Equations, given: State, rates: Mapping[Any, Any] | None, every: bool, level: LevelSet | None = None
) -> tuple[list[Assembled], LevelSet | None]:
    """The nearest state, or, if `every`, all states found; and the constraints, from `level` if it is given."""
    constants = _constants(eom, given)
    if given.u is not None and rates is not None:
        raise SimulationError("Expected either u= or rates= to assemble with, got both.")
    wanted = _wanted_speeds(eom, given.u, rates)
    start = entries("coordinates", eom.coordinates, given.q)
    sought = search(level or eom.derived.conditions.at(constants), start) if eom.derived.conditions.f else None
    found = _configurations(eom, start, sought, every)
    made = []
    for configuration, branch in found if every else found[:1]:
        at = dict(zip(eom.coordinates, configuration.x.tolist(), strict=True))
        speeds, left = _motion(eom, wanted, constants | dict(at.items()), rates is not None)
        by_speed = dict(zip(eom.speeds, speeds.tolist(), strict=True))
        rest = {kind: getattr(given, kind) for kind in ("states", "parameters", "inputs", "t")}
        made.append(Assembled(at, by_speed, **rest, residual=max(configuration.size, left), branch=branch))
    return made, sought.level if sought else None


def _constants(eom: Equations, given: State) -> dict[Expr, Any]:
    """Parameters, inputs and the time by symbol."""
    constants: dict[Expr, Any] = {
        **parameter_values(eom.system, given.parameters),
        time: finite_number("time", "the state", given.t),
    }
    return constants | named_values("inputs", eom.inputs, given.inputs)


def _of_many(many: Poses, all_branches: bool) -> Any:
    """The states as a Dataset, on the branch of the first."""
    eom, by_rates = many.eom, "rates" in many.instances.columns
    cure = "Find all branches for one state at a time."
    expect.that(not all_branches, "all_branches= for one state", came="arrays", cure=cure, error=ArgumentError)
    rates = many.instances.at if by_rates else None

    def alone(k: int) -> One:
        own, held = rates(k)["rates"] if rates else None, eom.derived.conditions.f
        (found,), level = _assembled(eom, many.state(k), own, False, level_of(many, k) if held else None)
        return One(np.array([*found.q.values()]), np.array([*found.u.values()]), found.residual, level)

    def motion(k: int, q: Array) -> tuple[Array, float]:
        given = many.state(k)
        wanted = _wanted_speeds(eom, given.u, rates(k)["rates"] if rates else None)
        at = _constants(eom, given) | dict(zip(eom.coordinates, q.tolist(), strict=True))
        return _motion(eom, wanted, at, by_rates)

    return assembled(many, alone, motion, not by_rates and eom.solved.twin is None)


def _configurations(
    eom: Equations, start: GivenEntries, sought: ClosureSearch | None, every: bool
) -> list[tuple[Closed, str]]:
    """Configurations with their branches in words: the nearest, or, if `every`, all that are found."""
    names = [q.name for q in eom.coordinates]
    if sought is None:
        missing = (names[i] for i in start.missing)
        expect.none(missing, "a start value for all coordinates", "none for {}", error=ValueMissingError)
        return [(Closed(start.values, np.zeros(0), 0), "")]
    if not start.free:
        return [(_given(sought), "")]
    found = sought.found(every)
    if not found.closed:
        raise SimulationError(_not_closed(sought, found))
    # values left out must be determined by the constraints, the given values and the guesses
    asked = start.free if every else start.missing
    unknown, count = _undetermined(sought.block(found.closed[0].x), start, names, asked)
    if unknown:
        cure = "" if every else ", or a guess for each: kn.guess(value)"
        raise ValueMissingError(
            f"Expected values that determine the configuration, got {count} too few: {', '.join(unknown)} can still vary. "
            f"Give {count} of them{cure}."
        )
    return list(zip(found.closed, sought.words(found), strict=True))


def _given(given: ClosureSearch) -> Closed:
    """The coordinates, all given, after the removal of rounding errors; raises SimulationError if they violate the constraints."""
    names, values = given.level.manifold.names, given.start.values
    if given.singular_at(values):
        raise SimulationError(
            f"Expected coordinates at which the constraints are finite, got {given.singular_at(values)}. {_BESIDE}"
        )
    whole = given.level.of(values, range(len(values)))
    residual = whole.one(values)[0]
    bad, expected = misses(names, residual, whole.shares(residual)), "start values that satisfy the constraints"
    expect.none(bad, expected, "coordinates that miss {}", _LEAVE_OUT, error=SimulationError)
    closed = whole.closest(values)
    turned = given.turned(closed.x)
    if turned:
        raise SimulationError(
            f"Expected coordinates on the intended branch of the closures, got {turned}, where the equations of the closures "
            f"hold, too. {given.cure()}"
        )
    return closed


def _not_closed(sought: ClosureSearch, found: AssemblyResult) -> str:
    """A message: no configuration was found, or none on the specified branch."""
    start, names = sought.start, [q.name for q in sought.level.manifold.system.coordinates]
    if found.turned:
        return (
            f"Expected a configuration on the intended branch of the closures, got only others from {found.starts} starts, "
            f"the nearest {found.turned}. The parts cannot reach the intended orientation with the values given: free more "
            "coordinates, or correct the frames and axes of the closure."
        )
    first, best = np.abs(sought.level.one(start.values)[0]).max(), found.nearest
    undefined = sought.singular_at(best.x)
    if undefined:
        return (
            f"Expected a configuration at which the constraints are finite, got {undefined} in the nearest. {_BESIDE}"
        )
    worst = int(np.argmax(np.abs(best.residual)))
    return (
        f"Expected a configuration that satisfies the constraints, got none from {found.starts} starts: the residual "
        f"decreased {f'from {first:.3g} ' if np.isfinite(first) else ''}to {best.size:.3g} and is largest in "
        f"{sought.level.manifold.names[worst]!r}{'' if np.isfinite(first) else ', which is not finite at the guesses'}. The "
        "parts may not reach each other with the values given and these lengths: free more coordinates than "
        f"{', '.join(names[i] for i in start.free)}, or correct the lengths."
    )


def _undetermined(
    block: Array, start: GivenEntries, names: Sequence[str], among: Sequence[int]
) -> tuple[list[str], int]:
    """Free values `among` some indices that may still change with `block` zero, and the number of missing values."""
    directions = singular(block).kernel(STATE_RANK)
    open_ = np.abs(directions).max(axis=0, initial=0) > ROUNDED_ROOT
    return [names[i] for i, x in zip(start.free, open_, strict=True) if x and i in among], len(directions)


def _wanted_speeds(eom: Equations, u: Any, rates: Any) -> GivenEntries:
    if rates is not None:
        return entries("rates, by coordinate,", eom.coordinates, rates)
    if u is None:
        n = len(eom.speeds)
        return GivenEntries(np.zeros(n), tuple(range(n)), ())
    return entries("speeds", eom.speeds, u)


def _motion(eom: Equations, start: GivenEntries, at: Mapping[Expr, Any], by_rates: bool) -> tuple[Array, float]:
    """u with A u + b = 0, or from rates by u = Y q̇ + z, and the largest residual."""
    held = velocity_constraints_at(eom, at, by_rates)
    rows, rest = held.rows, held.rest
    names = [s.name for s in (eom.coordinates if by_rates else eom.speeds)]
    # scale columns, so that m/s and rad/s are comparable
    pace = np.abs(rows).max(axis=0, initial=0)
    pace = np.where(pace > ROUNDED * pace.max(initial=0), pace, 1.0)
    rows, x = rows / pace, start.values * pace
    size = np.abs(rows).max(axis=1, initial=0)
    # a row within rounding of zero is not scaled up
    scale = np.maximum(size, max(ROUNDED_ROOT * size.max(initial=0), np.finfo(float).tiny))
    free = list(start.free)
    if free:
        block = rows[:, free] / scale[:, None]
        unknown, count = _undetermined(block, start, names, start.missing)
        if unknown:
            raise ValueMissingError(
                f"Expected a start value for all {'rates' if by_rates else 'speeds'} that the constraints do not determine, "
                f"got too few: {', '.join(unknown)} are undetermined. Give {count} of them."
            )
        if len(rows):
            x[free] += least_squares(block, -(rows @ x + rest) / scale)
    left = np.abs((rows @ x + rest) / scale)
    limit = GIVEN * max(np.abs(x).max(initial=0), np.abs(rest / scale).max(initial=0))
    bad, what = misses(held.names, rows @ x + rest, left, limit), "rates" if by_rates else "speeds"
    expected = f"start {what} that satisfy the constraints A u + b = 0"
    cure = f"{_IN_A_MODE} {_LEAVE_OUT}" if eom.system.modes else _LEAVE_OUT
    expect.none(bad, expected, "values that miss {}", cure, error=SimulationError)
    return held.to_speeds @ (x / pace) + held.added, float(left.max(initial=0))
