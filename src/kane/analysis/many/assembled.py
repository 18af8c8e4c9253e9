# SPDX-License-Identifier: BSD-3-Clause
"""`assemble` at many states: the configurations by continuation along the arrays from the first one, then the speeds of all.

As many constraints as there are unknown coordinates are followed, chosen at the first state; in the end all are verified.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from kane.analysis.many.following import BranchEnd, SquareEquations, Unknowns, follow
from kane.analysis.many.poses import Poses
from kane.analysis.state_checks import StateArrays, misses
from kane.dynamics.constraints.manifold import LevelSet, turned_closures
from kane.dynamics.constraints.partition import choose
from kane.equations.compiled import ports
from kane.equations.equations import Equations
from kane.equations.instances import package
from kane.equations.state import Guess
from kane.errors import KaneError, SimulationError
from kane.expr.symbols import Coordinate, Speed
from kane.numeric.arrays import Array, Indices, Mask
from kane.numeric.scale import CLOSED, GIVEN, NEAR_SINGULAR, ROUNDED, ROUNDED_ROOT
from kane.program.from_expressions import Bundle

_TOLD = 4


class One(NamedTuple):
    """A state on the constraints: q and u in order, the largest residual, and the configuration constraints for its other values."""

    q: Array
    u: Array
    residual: float
    level: LevelSet | None = None


class ConstraintValues(NamedTuple):
    """f, ∂f/∂q, A and b at states."""

    f: Array
    gradient: Array
    a: Array
    b: Array


def closing(eom: Equations) -> Bundle[ConstraintValues]:
    """The bundle of the configuration constraints, with eᵀe − 1 of Euler parameters, and of the velocity constraints."""
    conditions, rows = eom.derived.conditions, eom.derived.constraints
    groups = {"f": list(conditions.f), "gradient": conditions.gradient, "a": rows.a, "b": list(rows.b)}
    return Bundle("closing", ports(eom.derived), ConstraintValues, groups)


def square(eom: Equations, rows: Sequence[int], columns: Sequence[int]) -> Bundle[SquareEquations]:
    """The bundle of some rows of f, and their derivatives in some of the coordinates."""
    conditions = eom.derived.conditions
    return Bundle(
        "square", ports(eom.derived), SquareEquations,
        {"f": [conditions.f[i] for i in rows], "gradient": conditions.gradient.take(rows, columns)},
    )  # fmt: skip


Motion = Callable[[int, Array], tuple[Array, float]]
"""Returns the speeds of state k at q, and the residual of the velocity constraints."""


def assembled(poses: Poses, alone: Callable[[int], One], motion: Motion, together: bool) -> Any:
    """The states as a Dataset, with guessed and missing coordinates solved for.

    `alone` assembles state k by itself. `together` allows speeds of all states to be solved for at once, from A u + b = 0.
    """
    eom = poses.eom
    q = np.full((poses.count, len(eom.coordinates)), np.nan)
    u, left = np.full((poses.count, len(eom.speeds)), np.nan), np.full(poses.count, np.nan)
    base, free = start_of(poses)
    causes = dict(poses.failed)
    if eom.derived.conditions.f and not free:
        found, causes = poses.each(alone)
        for k, one in found.items():
            q[k], u[k], left[k], _ = one
        return _dataset(poses, q, u, left, causes)
    first = poses.first(alone, causes)
    if first is not None:
        q[:], left[:] = base, 0.0
        if free:
            _follow(poses, (q, left), free, *first, causes)
        _move(poses, (q, u, left), motion, together, causes)
    for values in (q, u, left):
        values[list(causes)] = np.nan
    return _dataset(poses, q, u, left, causes)


def start_of(poses: Poses) -> tuple[Array, list[int]]:
    """Given coordinates (k × n), and the indices of those to be solved for."""
    given, coordinates = poses.given("q"), poses.eom.coordinates
    base, free = np.zeros((poses.count, len(coordinates))), list[int]()
    for i, s in enumerate(coordinates):
        value = given.get(s)
        if value is None or isinstance(value, Guess):
            free.append(i)
        else:
            base[:, i] = value
    return base, free


def _follow(
    poses: Poses, places: tuple[Array, Array], free: list[int], start: int, one: One, causes: dict[int, str]
) -> None:
    """Solve for the free coordinates in q (k × n) by continuation, and store the residuals of the constraints."""
    (q, left), eom = places, poses.eom
    numeric = eom.numeric()
    level = one.level
    if level is None:  # no constraint moves guesses
        for i in free:
            q[:, i] = getattr(poses.given("q").get(eom.coordinates[i]), "value", one.q[i])
        return
    rows = choose(level.one(one.q)[1][:, free] * level.usual.x / level.usual.f[:, None])
    if len(rows.rows) < len(free):
        raise SimulationError(
            f"Expected coordinates that the constraints determine where arrays are given, got {len(free) - len(rows.rows)} "
            "guesses too many: the configuration nearest to guesses does not define a branch. Give numbers or arrays for as "
            f"many of {', '.join(eom.coordinates[i].name for i in free)}."
        )
    chosen = tuple(sorted(rows.rows))
    routine = numeric.routine(square, chosen, tuple(free)).flat
    order = np.array([k for k in range(start, poses.count) if k not in causes])
    states = states_of(poses.eom, q[order])
    t, p, r = (x[order] for x in poses.numbers())
    usual = level.usual
    unknowns = Unknowns(free, usual.x, usual.f[list(chosen)], len(free))
    found = follow(routine, np.column_stack([t, states, p, r]), one.q[free], unknowns)
    for row, end in found.ends.items():
        causes[int(order[row])] = _ended(eom, free, int(order[end.last]), end)
    reached = np.array([k for row, k in enumerate(order) if row not in found.ends])
    q[reached[:, None], free] = found.x[[row for row in range(len(order)) if row not in found.ends]]
    f = _polish(poses, numeric.routine(closing), q, (reached, free, list(chosen)))
    left[reached] = np.abs(f).max(axis=1, initial=0)
    _check(poses, level, q, reached, f, causes)


def level_of(poses: Poses, k: int) -> LevelSet:
    """The configuration constraints of state k, by compiled code."""
    t, p, r = (x[k] for x in poses.numbers())
    eom = poses.eom
    values = StateArrays(t, np.zeros(0), p, r).given(eom)
    count, routine = len(eom.derived.conditions.f) * (1 + len(eom.coordinates)), eom.numeric().routine(closing).flat

    def compiled(q: Array, _: Any) -> Array:
        return routine(float(t), states_of(poses.eom, q), p, r)[:, :count]

    return replace(eom.derived.conditions.at(values), compiled=compiled)


def _ended(eom: Equations, free: Sequence[int], last: int, end: BranchEnd) -> str:
    at = ", ".join(f"{eom.coordinates[i].name} = {v:.6g}" for i, v in list(zip(free, end.x, strict=True))[:_TOLD])
    return (
        "Expected a configuration on the branch of the other instances, got the end of this branch on the way from instance "
        f"{last}, near {at}: a dead point, or the limit of reach of the parts, where branches meet. Assemble the "
        "configurations beyond it separately, from guesses."
    )


def states_of(eom: Equations, q: Array) -> Array:
    """(q, 0, 0) (k × …) in the order of the arguments of routines."""
    x = np.zeros((len(q), len(eom.state)))
    x[:, : q.shape[1]] = q
    return x


def _polish(poses: Poses, routine: Any, q: Array, where: tuple[Array, list[int], list[int]]) -> Array:
    """q after a further Newton step at all states where it reduces f, which leaves residuals of the size of rounding."""
    places, free, rows = where
    t, p, r = (x[places] for x in poses.numbers())
    now = routine(t, states_of(poses.eom, q[places]), p, r)
    g = now.gradient[:, rows][:, :, free]
    moved = q[places]
    moved[:, free] -= np.linalg.solve(g, now.f[:, rows, None])[:, :, 0]
    then = routine(t, states_of(poses.eom, moved), p, r)
    better = np.abs(then.f).max(axis=1, initial=0) <= np.abs(now.f).max(axis=1, initial=0)
    q[places[better]] = moved[better]
    return np.asarray(np.where(better[:, None], then.f, now.f))


def _check(poses: Poses, level: LevelSet, q: Array, reached: Array, f: Array, causes: dict[int, str]) -> None:
    """Record a cause for each configuration that violates a constraint or is on a wrong closure branch."""
    t, p, r = (x[reached] for x in poses.numbers())
    values = StateArrays(t, q, p, r).given(poses.eom)
    turned, shares = level.manifold.at(values).turned(q[reached]), level.shares(f)
    for row in np.flatnonzero(~(shares <= CLOSED).all(axis=1) | turned.any(axis=1)).tolist():
        bad = misses(level.manifold.names, f[row], shares[row], CLOSED)
        told = ", ".join(bad) or turned_closures(level.manifold.branches, turned[row])
        causes[int(reached[row])] = (
            f"Expected a configuration that satisfies the constraints, got one that violates {told}: constraints that follow "
            "from the others at the first instance do not follow from them here. Assemble it separately."
        )


def _move(
    poses: Poses, places: tuple[Array, Array, Array], motion: Motion, together: bool, causes: dict[int, str]
) -> None:
    """Solve A u + b = 0 for the speeds u (k × n) at all states with a configuration."""
    q, u, left = places
    there = np.array([k for k in range(poses.count) if k not in causes], dtype=int)
    doubtful = np.ones(len(there), dtype=bool)
    if together:
        u[there], rest, doubtful, _ = speeds_at(poses, q, there)
        left[there] = np.maximum(left[there], rest)
    for k in there[doubtful].tolist():
        try:
            u[k], open_ = motion(k, q[k])
            left[k] = max(left[k], open_)
        except KaneError as error:
            causes[k] = str(error)


def speeds_at(poses: Poses, q: Array, places: Indices) -> tuple[Array, Array, Mask, Array]:
    """u with A u + b = 0 at some states, the residuals, where u is in doubt, and A."""
    eom, (t, p, r) = poses.eom, (x[places] for x in poses.numbers())
    now = eom.numeric().routine(closing)(t, states_of(poses.eom, q[places]), p, r)
    x, free = _wanted(poses, places)
    if not now.b.shape[1] or not len(places):
        return x, np.zeros(len(places)), np.zeros(len(places), dtype=bool), now.a
    # scale columns and rows as for one state, so that units do not matter
    pace = np.abs(now.a).max(axis=1, initial=0)
    pace = np.where(pace > ROUNDED * pace.max(axis=1, keepdims=True, initial=0), pace, 1.0)
    rows = now.a / pace[:, None, :]
    size = np.abs(rows).max(axis=2, initial=0)
    scale = np.maximum(size, np.maximum(ROUNDED_ROOT * size.max(axis=1, keepdims=True), np.finfo(float).tiny))
    rows, rest, y = rows / scale[:, :, None], now.b / scale, x * pace
    doubtful = np.zeros(len(places), dtype=bool)
    if free:
        change, doubtful = _least(rows[:, :, free], -(_times(rows, y) + rest))
        y[:, free] += change
    left = np.abs(_times(rows, y) + rest).max(axis=1, initial=0)
    most = np.maximum(np.abs(y).max(axis=1, initial=0), np.abs(rest).max(axis=1, initial=0))
    return y / pace, left, doubtful | ~(left <= GIVEN * most), now.a


def _wanted(poses: Poses, places: Indices) -> tuple[Array, list[int]]:
    """Given speeds (k × n), and the indices of those that follow from the constraints."""
    given, x, free = poses.given("u"), np.zeros((len(places), len(poses.eom.speeds))), list[int]()
    for i, s in enumerate(poses.eom.speeds):
        value = given.get(s)
        if value is None or isinstance(value, Guess):
            free.append(i)
            x[:, i] = 0.0 if value is None else value.value
        else:
            x[:, i] = np.asarray(value)[places] if np.ndim(value) else value
    return x, free


def _times(a: Array, x: Array) -> Array:
    return np.asarray((a @ x[:, :, None])[:, :, 0])


def _least(a: Array, right: Array) -> tuple[Array, Mask]:
    """The least-norm x of A x = right (k × m × n) with rows independent at the first state, and where A is nearly singular."""
    chosen = sorted(choose(a[0]).rows)
    a, right = a[:, chosen], right[:, chosen]
    across: Array | None = np.swapaxes(a, 1, 2) if len(chosen) < a.shape[2] else None
    regular = a if across is None else np.asarray(a @ across)
    try:
        inverse = np.linalg.inv(regular)
        x = np.linalg.solve(regular, right[:, :, None])
    except np.linalg.LinAlgError:
        return np.zeros((len(a), a.shape[2])), np.ones(len(a), dtype=bool)
    condition = np.linalg.norm(regular, axis=(1, 2)) * np.linalg.norm(inverse, axis=(1, 2))
    x = np.asarray(x if across is None else across @ x, dtype=float)
    return np.asarray(x[:, :, 0], dtype=float), np.asarray(~(condition < 1 / NEAR_SINGULAR), dtype=bool)


def _dataset(poses: Poses, q: Array, u: Array, left: Array, causes: Mapping[int, str]) -> Any:
    xarray, eom = package("xarray"), poses.eom
    symbols: tuple[Coordinate | Speed, ...] = (*eom.coordinates, *eom.speeds)
    own = poses.variables(symbols, np.hstack([q, u]).T)
    own["residual"] = xarray.Variable("instance", left, {"long_name": "the residual of the constraints"})
    return poses.dataset(own, causes, {})
