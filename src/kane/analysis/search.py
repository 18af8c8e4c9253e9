# SPDX-License-Identifier: BSD-3-Clause
"""Configurations that satisfy the constraints, on the branches that closures mean: all that many starts find, nearest first.

Distances are measured from the guesses, or from zero where there are none; what turns in rad, lengths by how far they reach.
Angles that are the same a turn further are taken nearest to their guess, Euler parameters with the sign that is nearest.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from kane.analysis.state import Entries
from kane.dynamics.constraints.branches import branches, told, turned_function
from kane.dynamics.constraints.closure import Closure, many_function, rounding_function, unit_places
from kane.expr.node import Expr
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.numeric.many import Indices, Sizes, close_many, sizes
from kane.numeric.newton import Closed, close
from kane.numeric.rank import singular
from kane.numeric.scale import CLOSED, LAST_DIGIT, ONE_POSITION, ROUNDED_ROOT, STATE_RANK

TRIES = (60, 400, 1600)
"""Starts that are made together: more where those before led to no branch that is meant."""
_SEED = 20048
_SLIDES, _NEAREST = 40, 6
_TOLD = 6


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """The configurations found, nearest first; where there is none, what came `nearest`, and what was `turned`."""

    closed: tuple[Closed, ...]
    nearest: Closed
    turned: str
    starts: int


@dataclass(frozen=True, eq=False)
class Search:
    """The configuration constraints of a system at `values` of all but its coordinates, and where to start."""

    system: System
    conditions: Closure
    values: Mapping[Expr, Any]
    start: Entries

    @cached_property
    def many(self) -> Callable[[Array], tuple[Array, Array]]:
        """f (k × m) and ∂f/∂q (k × m × n) at q (k × n)."""
        return many_function(self.system, self.conditions, self.values)

    @cached_property
    def _turned(self) -> Any:
        return turned_function(self.system, self.values)

    def one(self, x: Array) -> tuple[Array, Array]:
        """f (m) and ∂f/∂q (m × n) at q (n)."""
        f, g = self.many(x[None])
        return f[0], g[0]

    def told(self, x: Array) -> str:
        """Which closures are turned at q, in words."""
        return told(branches(self.system), self._turned(x))

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
        found = Search(self.system, self.conditions, self.values, Entries(self.start.values, every, ())).found()
        if not found.closed:
            return "None was found on that branch: correct the frames and axes of the closure."
        return (
            f"On it lies {self._apart(found.closed[0].x, self.start.values)}, with the others as they are: kn.assemble finds it "
            "from kn.guess(…) of all of them."
        )

    def _apart(self, x: Array, other: Array) -> str:
        """Where coordinates are that differ from others, the first few."""
        apart = np.abs(x - other) > ONE_POSITION * self._wide
        pairs = [(q, v) for q, v, differs in zip(self.system.coordinates, x, apart, strict=True) if differs]
        return ", ".join(f"{q} = {v:.4g}" for q, v in pairs[:_TOLD]) + (", …" if len(pairs) > _TOLD else "")

    def found(self, thorough: bool = False) -> Found:
        """What the tries lead to, the `thorough` ones at once."""
        rng = np.random.default_rng(_SEED)
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

    @cached_property
    def _size(self) -> Sizes:
        """Sizes of the free coordinates and of f."""
        rng, n = np.random.default_rng(_SEED), len(self.start.free)
        x = np.vstack([np.zeros(n), rng.uniform(-np.pi, np.pi, (11, n))])
        unit = unit_places(self.system, self.start.free)
        rounding = rounding_function(self.system, self.conditions, self.values)
        return sizes(self._free, x, unit, lambda x, members: rounding(self._whole(x), members))

    def shares(self, residual: Array) -> Array:
        """What is left of f (m), over the usual size of its terms."""
        return np.asarray(np.abs(residual) / self._size.f)

    def closed(self, x: Array) -> Closed:
        """Steps from q (n) on, of what is free, in sizes of its own."""
        return close(self.one, x, self.start.free, LAST_DIGIT, sizes=(self._size.f, self._wide))

    @cached_property
    def _wide(self) -> Array:
        """Sizes of all coordinates, 1 of those that are held."""
        wide = np.ones(len(self.start.values))
        wide[list(self.start.free)] = self._size.x
        return wide

    def _free(self, x: Array, members: Indices) -> tuple[Array, Array]:
        f, g = self.many(self._whole(x))
        return f, g[:, :, list(self.start.free)]

    def _whole(self, x: Array) -> Array:
        whole = np.tile(self.start.values, (len(x), 1))
        whole[:, list(self.start.free)] = x
        return whole

    def _starts(self, rng: np.random.Generator, count: int) -> Array:
        """The start itself, some around it, and others anywhere within a turn, or within reach (k × free)."""
        first, size = self.start.values[list(self.start.free)], self._size
        x = rng.uniform(-np.pi, np.pi, (count, len(first))) * np.where(size.turns, 1.0, size.x / 2)
        x[: count // 3] = (
            rng.normal(size=(count // 3, len(first))) * size.x * np.linspace(0.0, 1.0, count // 3)[:, None]
        )
        return np.asarray(x + first)

    def _tried(self, x: Array) -> tuple[tuple[Closed, ...], Closed, str]:
        """Different configurations on the branches that are meant; what came nearest to closing; what was turned."""
        found = close_many(self._free, x, self._size, lambda x, _: ~self._turned(self._whole(x)).any(axis=1))
        best = int(np.argmin(np.where(np.isfinite(found.left), found.left, np.inf)))
        nearest = self.closed(self._whole(found.x[best : best + 1])[0])
        whole = self._homed(self._whole(found.x[found.left <= CLOSED]))
        if not len(whole):
            return (), nearest, ""
        whole = whole[np.argsort(self.distances(whole), kind="stable")]
        away = self._turned(whole).any(axis=1)
        if away.all():
            return (), nearest, self.told(whole[0])
        whole = whole[~away]
        whole = (
            self._distinct(whole) if not len(self._kernel(whole[0])) else np.array([*map(self._slid, whole[:_NEAREST])])
        )
        closed = [self.closed(x) for x in self._distinct(whole)]
        return tuple(sorted(closed, key=lambda c: float(self.distances(c.x[None])[0]))), nearest, ""

    def distances(self, x: Array) -> Array:
        """How far each q (k × n) is from the guesses (k); what was left out counts where these are alike."""
        away = np.zeros(x.shape)
        away[:, list(self.start.free)] = (x - self.start.values)[:, list(self.start.free)] / self._size.x
        guessed = np.linalg.norm(away[:, list(self.start.guessed)], axis=1)
        return np.asarray(
            guessed
            + (ONE_POSITION if self.start.guessed else 1.0) * np.linalg.norm(away[:, list(self.start.missing)], axis=1)
        )

    def _distinct(self, x: Array) -> Array:
        """Each of several q (k × n) once."""
        kept: list[Array] = []
        free, size = list(self.start.free), self._size.x
        for one in x:
            if all(np.abs((one - other)[free] / size).max() > ONE_POSITION for other in kept):
                kept.append(one)
        return np.array(kept)

    def _homed(self, x: Array) -> Array:
        """Each q (k × n) with angles within half a turn of the start, Euler parameters on its side, where it is closed there too."""
        free = np.array(self.start.free)[self._size.turns]
        home, first = x.copy(), self.start.values
        home[:, free] += 2 * np.pi * np.round((first - x)[:, free] / (2 * np.pi))
        place = {q: i for i, q in enumerate(self.system.coordinates)}
        for e in self.system.euler_parameters:
            at = [place[q] for q in e.coordinates]
            if set(at) <= set(self.start.free):
                side = home[:, at] @ first[at]
                side = np.where(side == 0, home[:, at[0]], side)
                home[:, at] *= np.where(side < 0, -1.0, 1.0)[:, None]
        left = np.abs(self.many(home)[0] / self._size.f).max(axis=1, initial=0)
        kept = (left <= 10 * CLOSED) & (self._turned(home) == self._turned(x)).all(axis=1)
        return np.where(kept[:, None], home, x)

    def singular_at(self, x: Array) -> str:
        """Which constraints are not finite at q (n), in words, those of most say first; "" where all are."""
        f, g = self.one(x)
        lost = ~(np.isfinite(f) & np.isfinite(g).all(axis=1))
        names = [n for n, bad in zip(self.conditions.names, lost, strict=True) if bad]
        at = [(q, v) for q, v in zip(self.system.coordinates, x, strict=True) if v]
        where = ", ".join(f"{q} = {v:.6g}" for q, v in at[:_TOLD]) or "zero of all coordinates"
        return f"infinity or NaN of {', '.join(map(repr, names))} at {where}" if names else ""

    def block(self, x: Array) -> Array:
        """∂f/∂q at q (n) over what is free, in sizes of its own."""
        return np.asarray(self.one(x)[1][:, list(self.start.free)] * self._size.x / self._size.f[:, None])

    def _kernel(self, x: Array) -> Array:
        """Directions, over what is free, in which the constraints leave q (n) open, one a row."""
        return singular(self.block(x)).kernel(STATE_RANK)

    def _slid(self, x: Array) -> Array:
        """From q (n) along the constraints to the place nearest to the guesses."""
        free, size = list(self.start.free), self._size.x
        pull = np.isin(free, self.start.guessed)
        for _ in range(_SLIDES):
            kernel = self._kernel(x)
            change = kernel.T @ (kernel @ (pull * (self.start.values - x)[free] / size))
            if np.abs(change).max(initial=0) <= ROUNDED_ROOT:
                break
            for share in (1.0, 0.5, 0.25, 0.1):
                trial = x.copy()
                trial[free] += share * change * size
                trial = self.closed(trial).x
                nearer = self.distances(trial[None])[0] < self.distances(x[None])[0]
                if nearer and np.isfinite(self.block(trial)).all():
                    break
            else:
                break
            x = trial
        return x
