# SPDX-License-Identifier: BSD-3-Clause
"""The states nearest to their own guesses, found for many at once by Newton's method; states in doubt are left to `assemble`.

Newton's method starts at the guesses of each state, around them, and on all branches of the first state. A state is in doubt if fewer
branches are found than the first state has, if which is nearest depends on the sizes of lengths, or if the constraints are nearly
singular.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from kane.analysis.assembly import ClosureSearch, search
from kane.analysis.many.assembled import closing, level_of, speeds_at, start_of, states_of
from kane.analysis.many.poses import Poses
from kane.analysis.state_checks import StateArrays, entries
from kane.dynamics.constraints.manifold import LevelSet
from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.numeric.arrays import Array, Indices, Mask
from kane.numeric.newton import close_many
from kane.numeric.rank import balance
from kane.numeric.sampling import ASSEMBLY_SEED
from kane.numeric.scale import CLOSED, GIVEN, NEAR_SINGULAR, ONE_POSITION

_AROUND = 5
"""Number of starts around the guesses of each state."""
_NEARER = 0.9
"""Largest ratio of the distances of the nearest and the next branch at which the nearest is accepted."""
_FAR = 1.0
"""Largest distance from the guesses (rad, or sizes of lengths) that is accepted: beyond it a nearer branch may have been missed."""


class StatesOnConstraints(NamedTuple):
    """q (k × n), u and A (k × m × s) at states on the constraints, and the states in `doubt`."""

    q: Array
    u: Array
    a: Array
    doubt: Mask


class NearestStates:
    """The search for many states, with branches and sizes of coordinates and constraints from the first state.

    Raises
    ------
    KaneError
        if the first state cannot be assembled
    """

    def __init__(self, poses: Poses) -> None:
        self.eom = poses.eom
        start = entries("coordinates", self.eom.coordinates, poses.state(0).q)
        self.free, self.guessed, self.missing = [*start.free], [*start.guessed], [*start.missing]
        speeds = entries("speeds", self.eom.speeds, poses.state(0).u)
        self.sought = [*speeds.free] if speeds.missing else []
        self.level: LevelSet | None = None
        self.branches, self.apart = np.zeros((0, len(start.values))), True
        if self.eom.derived.conditions.f:
            sought = search(level_of(poses, 0), start)
            self.level = sought.level if start.free else sought.level.of(start.values, range(len(start.values)))
            self.branches = self._found(sought)
            self.apart = all(_determined(sought.block(x)[None]).all() for x in self.branches)

    def _found(self, sought: ClosureSearch) -> Array:
        if not self.free:
            return self.branches
        closed = sought.found().closed
        if not closed:
            raise SimulationError("Expected a state whose branches are those of others, got one that does not close.")
        return np.array([one.x for one in closed])

    def at(self, poses: Poses) -> StatesOnConstraints:
        """The states at other values."""
        eom, count = self.eom, poses.count
        base, free = start_of(poses)
        q, doubt = base, np.zeros(count, dtype=bool)
        unit = {e for s in eom.system.euler_parameters for e in s.coordinates}
        unlike = free != self.free or not self.apart
        if eom.solved.twin is not None or unlike or any(eom.coordinates[i] in unit for i in free):
            doubt[:] = True
        elif self.level is None:
            doubt[:] = bool(free)
        else:
            guesses = base.copy()
            given = poses.given("q")
            for i, s in enumerate(eom.coordinates):
                guesses[:, i] = getattr(given.get(s, 0.0), "value", given.get(s, 0.0))
            q, doubt = self._closed(poses, guesses)
        u, a = np.zeros((count, len(eom.speeds))), np.zeros((count, len(eom.b), len(eom.speeds)))
        sure = np.flatnonzero(~doubt)
        if len(sure):
            u[sure], _, unsure, a[sure] = speeds_at(poses, q, sure)
            level = balance(a[sure][:, :, self.sought], order=(0, 1), rounding=0.0).matrix
            doubt[sure[unsure | ~_determined(level)]] = True
        return StatesOnConstraints(q, u, a, doubt)

    def _closed(self, poses: Poses, guesses: Array) -> tuple[Array, Mask]:
        """The configurations nearest to the guesses (k × n), and which are in doubt."""
        level, count = self.level, poses.count
        assert level is not None
        free, size = [*level.free], level.usual
        starts = guesses[:, None] if not self.free else self._starts(guesses)
        tries = starts.shape[1]
        rows = np.repeat(np.arange(count), tries)
        values = _values_at(self.eom, poses)
        begun = starts.reshape(count * tries, -1)

        def of_free(x: Array, members: Indices) -> tuple[Array, Array]:
            q = begun[members]
            q[:, free] = x
            f, g = values(q, rows[members])
            return f, g[:, :, free]

        if not self.free:  # all coordinates are given: residuals are rounding errors of these
            missed = np.abs(of_free(begun, rows)[0] / size.f).max(axis=1, initial=0)
        found = close_many(of_free, begun[:, free], size, _none)
        q = begun.copy()
        q[:, free] = found.x
        left, q = self._home(q, guesses[rows], found.left, lambda q: values(q, rows)[0])
        t, p, r = (x[rows] for x in poses.numbers())
        turned = level.manifold.at(StateArrays(t, q, p, r).given(self.eom)).turned(q).any(axis=1)
        valid = ((left <= CLOSED) & ~turned).reshape(count, tries)
        if not self.free:
            return q, ~valid[:, 0] | ~(missed <= GIVEN)
        away = ((q - guesses[rows])[:, free] / level.metric).reshape(count, tries, -1)
        guessed, missing = (np.isin(free, own) for own in (self.guessed, self.missing))
        weight = ONE_POSITION if self.guessed else 1.0
        distance = np.linalg.norm(away[:, :, guessed], axis=2) + weight * np.linalg.norm(away[:, :, missing], axis=2)
        distance[~valid] = np.inf
        best = np.argmin(distance, axis=1)
        every = np.arange(count)
        others = valid & (np.abs(away - away[every, best][:, None]).max(axis=2) > ONE_POSITION)
        following = np.where(others, distance, np.inf).min(axis=1)
        nearest = q.reshape(count, tries, -1)[every, best]
        block = values(nearest, every)[1][:, :, free] * size.x / size.f[:, None]
        surely = np.isfinite(distance[every, best]) & (distance[every, best] < _NEARER * following)
        surely &= (_different(away, valid) >= len(self.branches)) & self._nearest_anyhow(away, best, others)
        surely &= np.abs(away[every, best]).max(axis=1) <= _FAR
        return nearest, ~(surely & _determined(block))

    def _nearest_anyhow(self, away: Array, best: Indices, others: Mask) -> Mask:
        """Whether the best configuration (k × tries × free, differences from guesses) is nearest both in angles and in each length."""
        assert self.level is not None
        turns = self.level.usual.turns
        counted = np.isin([*self.level.free], self.guessed or self.missing)
        angle = np.linalg.norm(away[:, :, counted & turns], axis=2, keepdims=True)
        parts = np.concatenate([angle, np.abs(away[:, :, counted & ~turns])], axis=2)
        own = parts[np.arange(len(best)), best][:, None]
        return np.asarray(((own <= np.maximum(_NEARER * parts, ONE_POSITION)).all(axis=2) | ~others).all(axis=1))

    def _starts(self, guesses: Array) -> Array:
        """The guesses of each state, starts around them, and the branches of the first state (k × tries × n)."""
        assert self.level is not None
        free, size = [*self.level.free], self.level.usual.x
        near = np.random.default_rng(ASSEMBLY_SEED).normal(size=(_AROUND, len(free))) * size
        around = np.repeat(guesses[:, None], 1 + _AROUND, axis=1)
        around[:, 1:, free] += near * np.linspace(0.1, 1.0, _AROUND)[:, None]
        branches = np.repeat(guesses[:, None], len(self.branches), axis=1)
        branches[:, :, free] = self.branches[:, free]
        return np.concatenate([around, branches], axis=1)

    def _home(self, x: Array, guesses: Array, left: Array, f: Callable[[Array], Array]) -> tuple[Array, Array]:
        """Each q (k × n) with angles within half a turn of the guesses, if the constraints hold there too, and the residuals."""
        assert self.level is not None
        if not self.free:
            return left, x
        turning = np.array(self.level.free)[self.level.usual.turns]
        home = x.copy()
        home[:, turning] += 2 * np.pi * np.round((guesses - x)[:, turning] / (2 * np.pi))
        there = self.level.shares(f(home)).max(axis=1, initial=0)
        kept = there <= 10 * CLOSED
        return np.where(kept, np.minimum(left, there), left), np.where(kept[:, None], home, x)


def _different(x: Array, valid: Mask) -> Indices:
    """Number of different valid configurations in each row of x (k × tries × n)."""
    count = np.zeros(len(x), dtype=np.int64)
    for i in range(x.shape[1]):
        same = valid[:, :i] & (np.abs(x[:, :i] - x[:, i : i + 1]).max(axis=2) <= ONE_POSITION)
        count += valid[:, i] & ~same.any(axis=1)
    return count


def _none(x: Array, rows: Indices) -> Mask:
    """Accept no state early: that some starts converge does not allow others to be abandoned."""
    return np.zeros(len(x), dtype=bool)


def _values_at(eom: Equations, poses: Poses) -> Callable[[Array, Indices], tuple[Array, Array]]:
    """f (k × m) and ∂f/∂q (k × m × n) as a function of q (k × n) and indices of states."""
    (t, p, r), routine = poses.numbers(), eom.numeric().routine(closing)

    def values(q: Array, rows: Indices) -> tuple[Array, Array]:
        now = routine(t[rows], states_of(eom, q), p[rows], r[rows])
        return now.f, now.gradient

    return values


def _determined(block: Array) -> Mask:
    """Which ∂f/∂q (k × m × free), in the sizes of f and q, have full column rank beyond doubt."""
    if not block.shape[2]:
        return np.ones(len(block), dtype=bool)
    if block.shape[1] < block.shape[2] or not np.isfinite(block).all():
        return np.zeros(len(block), dtype=bool)
    values = np.linalg.svd(block, compute_uv=False)
    return np.asarray(values[:, -1] > NEAR_SINGULAR * values[:, 0])
