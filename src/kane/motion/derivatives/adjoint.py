# SPDX-License-Identifier: BSD-3-Clause
"""`Adjoint`: derivatives of a few numbers made of a motion, by however many parameters and start values, by one sweep backwards.

Weights λ = ∂J/∂x go back over the stretches of a motion, and over its events by the transposed saltation matrices. Of ∫ L dt an event
that is met at another time changes L⁻ − L⁺ times that, too.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from kane.motion.derivatives.pulling import Integrand, Pulling, Weights
from kane.motion.derivatives.transition import Stretch
from kane.motion.derivatives.variation import Again, Differential
from kane.motion.right_hand_side import Routines
from kane.motion.solution.phases import Indices
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.numeric.polynomials import gauss

_AGREES = 5e-8
"""Change of weights by halved steps at which they are known: they are off by 2⁻⁹ of it."""
_HALVINGS = 5
"""So often are steps halved; what goes on changing then is stiff, and is left to collocation."""
_FALLS = 8.0
"""So much smaller the change is at least after one more halving, if it is worth another."""
_POINTS = 8
"""Points of the quadrature of an integrand in a step of collocation."""


class Seeds(NamedTuple):
    """What m numbers J are made of: ∂J/∂x at samples, by row of the motion (m × n each), and an integrand."""

    rows: dict[int, Array]
    integrand: Integrand | None


class _Grid(NamedTuple):
    """Steps of a stretch: beginnings, lengths, states there, and behind which of them its edges are."""

    t: Array
    h: Array
    x: Array
    ends: list[int]

    @property
    def coarse(self) -> "_Grid":
        """The same with two steps as one."""
        return _Grid(self.t[::2], 2 * self.h[::2], self.x[::2], [e // 2 for e in self.ends])


class Adjoint:
    """The way back along a motion, which `again` gives at other samples."""

    def __init__(self, walk: Differential, motion: Solution, again: Again) -> None:
        self.walk, self.motion, self.again = walk, motion, again
        self._pulling: dict[Routines, Pulling] = {}

    def __call__(self, seeds: Seeds, count: int) -> Weights:
        """Weights of the start and of parameters, of `count` numbers.

        Raises
        ------
        SimulationError
            if the motion has no derivative, as for the way forwards
        """
        walk, motion = self.walk, self.motion
        walk.begin(motion)
        self._pulling = {}
        n, k = motion.states.shape[1], len(walk.by)
        stretches = walk.stretches(motion, sorted(seeds.rows))
        grids = self._grids(stretches, [2 * s.parts(max(1, m)) for s, m in self._counts(stretches)])
        weights = Weights(np.zeros((count, n)), np.zeros((count, k)), np.zeros((count, k)))
        left = dict(seeds.rows)
        for number in reversed(range(int(motion.phase[-1]) + 1)):
            for s, grid in reversed(list(zip(stretches, grids, strict=True))):
                if s.phase == number:
                    edges = {place: left.pop(row) for row, place in zip(s.rows, s.places, strict=True) if row in left}
                    weights = self._stretch(s, grid, weights, edges, seeds.integrand)
            for row in [row for row in left if int(motion.phase[row]) == number]:
                weights = weights._replace(x=weights.x + left.pop(row))
            if number:
                weights = self._across(number, weights, seeds.integrand)
        return weights

    def _counts(self, stretches: Sequence[Stretch]) -> Iterator[tuple[Stretch, int]]:
        """Half of the steps that each stretch takes at first: as many in all as the motion took."""
        for s in stretches:
            yield s, int(np.ceil(self.motion.steps * (s.t1 - s.t0) / max(self.walk.length, 1e-300)))

    def _grids(self, stretches: Sequence[Stretch], parts: Sequence[Indices]) -> list[_Grid | None]:
        """Steps of stretches, by one more motion for all; None where times do not tell them apart."""
        steps = [s.steps(m) for s, m in zip(stretches, parts, strict=True)]
        clear = [bool(np.all(np.diff(t) > 0) and t[-1] < s.t1) for s, (t, _) in zip(stretches, steps, strict=True)]
        wanted = np.unique(np.concatenate([t for (t, _), ok in zip(steps, clear, strict=True) if ok] or [np.zeros(0)]))
        motion = self.again(wanted) if len(wanted) else None
        found = list[_Grid | None]()
        for s, m, (t, h), ok in zip(stretches, parts, steps, clear, strict=True):
            if motion is None or not ok:
                found.append(None)
                continue
            rows = np.flatnonzero(motion.phase == s.phase)
            x = motion.states[rows[np.minimum(np.searchsorted(motion.t[rows], t), len(rows) - 1)]].copy()
            if s.x is not None:
                x[0] = s.x
            found.append(_Grid(t, h, x, np.cumsum(m).tolist()))
        return found

    # ------------------------------------------------------------------------------------------ one stretch

    def _stretch(
        self, s: Stretch, grid: _Grid | None, end: Weights, edges: dict[int, Array], integrand: Integrand | None
    ) -> Weights:
        """Weights at its beginning, with steps halved until they are known; by collocation where there is no end of it."""
        if grid is not None and Pulling.serves(s.now):
            if s.now not in self._pulling:
                self._pulling[s.now] = Pulling(s.now, self.walk.by)
            pulling = self._pulling[s.now]
            before, last = _pulled(pulling, grid.coarse, end, edges, integrand), np.inf
            for _ in range(_HALVINGS):
                found = _pulled(pulling, grid, end, edges, integrand)
                off = self._off(before, found, end)
                if off <= _AGREES:
                    return found
                (finer,) = self._grids([s], [2 * np.diff([0, *grid.ends])])
                if finer is None or not off < last / _FALLS:
                    break
                before, grid, last = found, finer, off
        return self._collocated(s, grid, end, edges, integrand)

    def _off(self, before: Weights, found: Weights, end: Weights) -> float:
        """The largest change, in sizes of what it is a part of; infinite where numbers are not finite."""
        sizes = np.abs(found.x * self.walk.scale).max(axis=1, initial=0)
        sizes = np.maximum(np.maximum(sizes, np.abs(end.x * self.walk.scale).max(axis=1, initial=0)), 1e-300)
        by_x = np.abs((found.x - before.x) * self.walk.scale) / sizes[:, None]
        by_p = np.abs(found.p - before.p) / np.maximum(found.sizes, 1e-300)
        whole = np.concatenate([by_x.reshape(-1), by_p.reshape(-1)])
        return float(whole.max(initial=0)) if np.isfinite(whole).all() else np.inf

    def _collocated(
        self, s: Stretch, grid: _Grid | None, end: Weights, edges: dict[int, Array], integrand: Integrand | None
    ) -> Weights:
        """The same by Φ of the way forwards, at the places that are asked for and those of the quadrature."""
        n, x = self.motion.states.shape[1], s.x if grid is None else grid.x[0]
        if x is None:
            x = self.again(np.array([s.t0])).states[-1]
        own = {float(s.edges[place]): seed for place, seed in edges.items()}
        times, share = np.zeros(0), np.zeros(0)
        if integrand is not None:
            panels = np.linspace(s.t0, s.t1, 1 + max(1, len(grid.t) if grid is not None else 1))
            times, share = gauss(_POINTS, panels.tolist())
        inner = times[(times > s.t0) & (times < s.t1)]
        cut = Stretch(s.now, s.by, s.feedback, x, np.unique(np.concatenate([s.edges, inner])), s.phase)
        (flow,) = self.walk.transitions(self.motion, [cut], self.again)
        at = dict(zip(cut.edges.tolist(), [np.eye(*flow.shape[1:]), *flow], strict=True))
        moved = end.x @ flow[-1] + sum((seed @ at[t] for t, seed in own.items()), np.zeros((len(end.x), flow.shape[2])))
        if integrand is not None and len(inner) == len(times):
            along = self.again(times)
            rows = np.flatnonzero(along.phase == s.phase)
            states = along.states[rows[np.searchsorted(along.t[rows], times)]]
            _, by_x, by_p = integrand.slopes(s.now, self.walk.by, times, states)
            flows = np.array([at[t] for t in times.tolist()])
            row = np.einsum("t,tn,tnk->k", share, by_x, flows)
            row[n:] += share @ by_p
            moved = moved + np.outer(integrand.factors, row)
        return Weights(moved[:, :n], end.p + moved[:, n:], end.sizes + np.abs(moved[:, n:]))

    # ------------------------------------------------------------------------------------------ one event

    def _across(self, number: int, after: Weights, integrand: Integrand | None) -> Weights:
        """Weights before the event with which a phase begins."""
        motion, walk = self.motion, self.walk
        n, k = motion.states.shape[1], len(walk.by)
        row = int(np.flatnonzero(motion.phase == number - 1)[-1])
        saltation, dt = walk.across(motion, row, np.eye(n, n + k), number, None)
        moved = after.x @ saltation
        if integrand is not None:
            sides = (walk.side(motion, r) for r in (row, row + 1))
            before, behind = (float(integrand.slopes(s.now, (), np.array([s.t]), s.x[None])[0][0]) for s in sides)
            moved = moved + np.outer(integrand.factors, (before - behind) * dt)
        return Weights(moved[:, :n], after.p + moved[:, n:], after.sizes + np.abs(moved[:, n:]))


def _pulled(
    pulling: Pulling, grid: _Grid, weights: Weights, edges: dict[int, Array], integrand: Integrand | None
) -> Weights:
    """Weights at the beginning of the steps; those of edges are added where they are met. Rows that have none yet wait."""
    for place in reversed(range(1, len(grid.ends) + 1)):
        if place in edges:
            weights = weights._replace(x=weights.x + edges[place])
        some = slice(grid.ends[place - 2] if place > 1 else 0, grid.ends[place - 1])
        active = np.flatnonzero(weights.x.any(axis=1) | (integrand is not None))
        if not len(active):
            continue
        own = integrand if integrand is None else Integrand(integrand.expr, integrand.factors[active], integrand.inputs)
        found = pulling((grid.t[some], grid.h[some], grid.x[some]), Weights(*(part[active] for part in weights)), own)
        whole = Weights(*(part.copy() for part in weights))
        for part, new in zip(whole, found, strict=True):
            part[active] = new
        weights = whole
    return weights._replace(x=weights.x + edges[0]) if 0 in edges else weights
