# SPDX-License-Identifier: BSD-3-Clause
"""Configurations that satisfy the constraints, on the branches that closures mean: all that many starts find, nearest first.

Distances are measured from the guesses, or from zero where there are none; what turns in rad, lengths by how far they reach.
Angles that are the same a turn further are taken nearest to their guess, Euler parameters with the sign that is nearest.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kane.analysis.state_checks import GivenEntries
from kane.dynamics.constraints.manifold import LevelSet, turned_closures
from kane.numeric.arrays import Array
from kane.numeric.newton import Closed
from kane.numeric.rank import singular
from kane.numeric.sampling import ASSEMBLY_SEED
from kane.numeric.scale import CLOSED, ONE_POSITION, ROUNDED_ROOT, STATE_RANK

TRIES = (60, 400, 1600)
"""Starts that are made together: more where those before led to no branch that is meant."""
_SLIDES, _NEAREST = 40, 6
_TOLD = 6


class Found(NamedTuple):
    """The configurations found, nearest first; where there is none, what came `nearest`, and what was `turned`."""

    closed: tuple[Closed, ...]
    nearest: Closed
    turned: str
    starts: int


def search(level: LevelSet, start: GivenEntries) -> "ClosureSearch":
    """What a start leaves free is looked for."""
    return ClosureSearch(level.of(start.values, start.free), start)


@dataclass(frozen=True, eq=False)
class ClosureSearch:
    """The configuration constraints of a system at values of all but its coordinates, and where to start."""

    level: LevelSet
    start: GivenEntries

    @property
    def _free(self) -> list[int]:
        return list(self.level.free)

    def turned(self, x: Array) -> str:
        """Which closures are turned at q, in words."""
        return turned_closures(self.level.manifold.branches, self.level.turned(x))

    def words(self, found: Found) -> list[str]:
        """Which of the branches found each configuration is on, and where the next one lies."""
        open_, count = len(self._kernel(found.closed[0].x)), len(found.closed)
        if open_:
            return [f"the nearest; {open_} of the guesses could be given"] * count
        if count == 1:
            return [f"the only branch from {found.starts} starts"]
        following = [*found.closed[1:], found.closed[0]]
        return [
            f"{f'branch {k} of {count}' if k > 1 else f'the nearest of {count} branches'}; {'next' if k < count else 'nearest'}: "
            f"{self._apart(other.x, at.x)}"
            for k, (at, other) in enumerate(zip(found.closed, following, strict=True), 1)
        ]

    def cure(self) -> str:
        """Where the branch that is meant is, from coordinates that are given whole and are on another one."""
        every = tuple(range(len(self.start.values)))
        found = search(self.level, GivenEntries(self.start.values, every, ())).found()
        if not found.closed:
            return "None was found on that branch: correct the frames and axes of the closure."
        return (
            f"On it lies {self._apart(found.closed[0].x, self.start.values)}, with the others as they are: kn.assemble finds it "
            "from kn.guess(…) of all of them."
        )

    def _apart(self, x: Array, other: Array) -> str:
        """Where coordinates are that differ from others, the first few."""
        apart = np.abs(x - other) > ONE_POSITION * self.level.wide
        coordinates = self.level.manifold.system.coordinates
        pairs = [(q, v) for q, v, differs in zip(coordinates, x, apart, strict=True) if differs]
        return ", ".join(f"{q} = {v:.4g}" for q, v in pairs[:_TOLD]) + (", …" if len(pairs) > _TOLD else "")

    def found(self, thorough: bool = False) -> Found:
        """What the tries lead to, the `thorough` ones at once."""
        rng = np.random.default_rng(ASSEMBLY_SEED)
        nearest, turned, starts = None, "", 0
        for count in TRIES[1 if thorough else 0 :]:
            starts += count
            closed, best, away = self._tried(self._starts(rng, count))
            if closed:
                return Found(closed, best, "", starts)
            nearest = best if nearest is None or best.size < nearest.size else nearest
            turned = turned or away
        assert nearest is not None
        return Found((), nearest, turned, starts)

    def _starts(self, rng: np.random.Generator, count: int) -> Array:
        """The start itself, some around it, and others anywhere within a turn, or within reach (k × free)."""
        first, size, near = self.start.values[self._free], self.level.usual, count // 3
        x = rng.uniform(-np.pi, np.pi, (count, len(first))) * np.where(size.turns, 1.0, size.x / 2)
        x[:near] = rng.normal(size=(near, len(first))) * size.x * np.linspace(0.0, 1.0, near)[:, None]
        return np.asarray(x + first)

    def _tried(self, x: Array) -> tuple[tuple[Closed, ...], Closed, str]:
        """Different configurations on the branches that are meant; what came nearest to closing; what was turned."""
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
        q = self._distinct(q) if not len(self._kernel(q[0])) else np.array([*map(self._slid, q[:_NEAREST])])
        ends = [self.level.closest(x) for x in self._distinct(q)]
        return tuple(sorted(ends, key=lambda c: float(self.distances(c.x[None])[0]))), nearest, ""

    def distances(self, x: Array) -> Array:
        """How far each q (k × n) is from the guesses (k); what was left out counts where these are alike."""
        away = np.zeros(x.shape)
        away[:, self._free] = (x - self.start.values)[:, self._free] / self.level.usual.x
        guessed = np.linalg.norm(away[:, list(self.start.guessed)], axis=1)
        weight = ONE_POSITION if self.start.guessed else 1.0
        return np.asarray(guessed + weight * np.linalg.norm(away[:, list(self.start.missing)], axis=1))

    def _distinct(self, x: Array) -> Array:
        """Each of several q (k × n) once."""
        kept: list[Array] = []
        free, size = self._free, self.level.usual.x
        for one in x:
            if all(np.abs((one - other)[free] / size).max() > ONE_POSITION for other in kept):
                kept.append(one)
        return np.array(kept)

    def _homed(self, x: Array) -> Array:
        """Each q (k × n) with angles within half a turn of the start, Euler parameters on its side, where it is closed there too."""
        free = np.array(self._free)[self.level.usual.turns]
        home, first = x.copy(), self.start.values
        home[:, free] += 2 * np.pi * np.round((first - x)[:, free] / (2 * np.pi))
        place = {q: i for i, q in enumerate(self.level.manifold.system.coordinates)}
        for e in self.level.manifold.system.euler_parameters:
            at = [place[q] for q in e.coordinates]
            if set(at) <= set(self.start.free):
                side = home[:, at] @ first[at]
                side = np.where(side == 0, home[:, at[0]], side)
                home[:, at] *= np.where(side < 0, -1.0, 1.0)[:, None]
        left = self.level.shares(self.level.numbers(home)[0]).max(axis=1, initial=0)
        kept = (left <= 10 * CLOSED) & (self.level.turned(home) == self.level.turned(x)).all(axis=1)
        return np.where(kept[:, None], home, x)

    def singular_at(self, x: Array) -> str:
        """Which constraints are not finite at q (n), in words, those of most say first; "" where all are."""
        f, g = self.level.one(x)
        lost = ~(np.isfinite(f) & np.isfinite(g).all(axis=1))
        names = [n for n, bad in zip(self.level.manifold.names, lost, strict=True) if bad]
        at = [(q, v) for q, v in zip(self.level.manifold.system.coordinates, x, strict=True) if v]
        where = ", ".join(f"{q} = {v:.6g}" for q, v in at[:_TOLD]) or "zero of all coordinates"
        return f"infinity or NaN of {', '.join(map(repr, names))} at {where}" if names else ""

    def block(self, x: Array) -> Array:
        """∂f/∂q at q (n) over what is free, in sizes of its own."""
        size = self.level.usual
        return np.asarray(self.level.one(x)[1][:, self._free] * size.x / size.f[:, None])

    def _kernel(self, x: Array) -> Array:
        """Directions, over what is free, in which the constraints leave q (n) open, one a row."""
        return singular(self.block(x)).kernel(STATE_RANK)

    def _slid(self, x: Array) -> Array:
        """From q (n) along the constraints to the place nearest to the guesses."""
        free, size = self._free, self.level.usual.x
        pull = np.isin(free, self.start.guessed)
        for _ in range(_SLIDES):
            kernel = self._kernel(x)
            change = kernel.T @ (kernel @ (pull * (self.start.values - x)[free] / size))
            if np.abs(change).max(initial=0) <= ROUNDED_ROOT:
                break
            for share in (1.0, 0.5, 0.25, 0.1):
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
