# SPDX-License-Identifier: BSD-3-Clause
"""`Adjoint`: gradients of a few functionals of a motion with respect to any number of parameters and initial values, by the adjoint.

The adjoint λ = ∂J/∂x is integrated backwards over the smooth stretches of a motion, and mapped across events by transposed saltation
matrices. An event at time τ adds (L⁻ − L⁺) δτ to the derivative of ∫ L dt.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kane.motion.derivatives.pulling import Integrand, Pulled, Pulling, StageStates, Weights
from kane.motion.derivatives.transition import CollocationSteps, Stretch
from kane.motion.derivatives.variation import Again, Differential, Leap, states_of_phase
from kane.motion.right_hand_side import Routines
from kane.motion.solution.phases import Indices
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.numeric.polynomials import gauss

_ROUGH = 1e-9
"""Tolerance of the relative error of the adjoint: the sum of the estimates of all steps, see `pulling_kernel`."""
_FINER, _MOST = 24, 40
"""Largest number of refinements, and of steps per initial step; beyond either, the variational equations are used instead."""
_FINDS = 0.3
"""Contraction factor at which the fixed-point iteration converges; the factor is about proportional to the step length."""
_ORDER = 16
"""Order of the error of a step."""
_MOST_PARTS = 4
"""Largest number of parts into which one refinement divides a step."""
_POINTS = 8
"""Gauss points per step in the quadrature of an integrand, with the variational equations."""


class Seeds(NamedTuple):
    """The seeds of m functionals J: ∂J/∂x at samples, by row of the motion (m × n each), and an integrand."""

    rows: dict[int, Array]
    integrand: Integrand | None


_Grid = tuple[CollocationSteps, StageStates]


class Adjoint:
    """The adjoint integration along `motion`; `again` recomputes the motion at other sample times."""

    def __init__(self, walk: Differential, motion: Solution, again: Again) -> None:
        self.walk, self.motion, self.again = walk, motion, again
        self._pulling: dict[Routines, Pulling] = {}

    def __call__(self, seeds: Seeds, count: int) -> Weights:
        """The derivatives of `count` functionals with respect to the initial state and the parameters.

        Raises
        ------
        SimulationError
            if the motion is not differentiable, under the same conditions as for `Differential`
        """
        walk, motion = self.walk, self.motion
        walk.begin(motion, [] if seeds.integrand is None else seeds.integrand.checked(motion.equations))
        self._pulling = {}
        n, k = motion.states.shape[1], len(walk.by)
        stretches = walk.stretches(motion, sorted(seeds.rows))
        grids = self._grids(stretches, [self._first(s) for s in stretches])
        leaps = walk.leaps(motion, stretches, self.again)
        weights = Weights(np.zeros((count, n)), np.zeros((count, k)), np.zeros((count, k)))
        left = dict(seeds.rows)
        for number in reversed(range(int(motion.phase[-1]) + 1)):
            for i, (s, grid) in reversed(list(enumerate(zip(stretches, grids, strict=True)))):
                if s.phase == number:
                    edges = {place: left.pop(row) for row, place in zip(s.rows, s.places, strict=True) if row in left}
                    weights = self._stretch(s, grid, weights, edges, seeds.integrand)
                    weights = self._leapt(leaps[i], weights, seeds.integrand) if i in leaps else weights
            for row in [row for row in left if int(motion.phase[row]) == number]:
                weights = weights._replace(x=weights.x + left.pop(row))
            if number:
                weights = self._across(number, weights, seeds.integrand)
        return weights

    def _first(self, s: Stretch) -> CollocationSteps:
        """The initial steps of a stretch: over all stretches, about as many as the motion took."""
        count = int(np.ceil(self.motion.steps * (s.t1 - s.t0) / max(self.walk.length, 1e-300)))
        return s.steps(s.parts(max(1, count)))

    def _grids(self, stretches: Sequence[Stretch], steps: Sequence[CollocationSteps]) -> list[_Grid | None]:
        """The grids of stretches, from one motion sampled at all stage times; None if a stretch is too short to separate the times."""
        times = [own.times.reshape(-1) for own in steps]
        clear = [
            bool(np.all(np.diff(t) > 0) and s.t0 < t[0] and t[-1] < s.t1) for s, t in zip(stretches, times, strict=True)
        ]
        wanted = np.unique(np.concatenate([t for t, ok in zip(times, clear, strict=True) if ok] or [np.zeros(0)]))
        motion = self.again(wanted) if len(wanted) else None
        result = list[_Grid | None]()
        for s, own, at, ok in zip(stretches, steps, times, clear, strict=True):
            if motion is None or not ok:
                result.append(None)
                continue
            x = states_of_phase(motion, s.phase, at)
            result.append((own, StageStates(own.times, own.h, x.reshape(*own.times.shape, -1))))
        return result

    # ------------------------------------------------------------------------------------------ one stretch

    def _stretch(
        self, s: Stretch, grid: _Grid | None, end: Weights, edges: dict[int, Array], integrand: Integrand | None
    ) -> Weights:
        """The adjoint at the start of a stretch, with steps refined to tolerance; by the variational equations if refinement fails."""
        own, known = grid, Pulling.serves(s.now.drives)
        for _ in range(_FINER + 1):
            if own is None or not known:
                break
            found = self._pulled(s, own, end, edges, integrand)
            off = self._off(found)
            if off <= _ROUGH:
                last = found.weights
                return last._replace(x=last.x + edges[0]) if 0 in edges else last
            parts = _parts(found.rough, off)
            if grid is None or max(parts.sum(), len(parts) * found.pace / _FINDS) > _MOST * len(grid[0].h):
                break
            (own,) = self._grids([s], [own[0].divided(parts)])
        return self._collocated(s, grid, end, edges, integrand)

    def _pulled(
        self, s: Stretch, grid: _Grid, end: Weights, edges: dict[int, Array], integrand: Integrand | None
    ) -> Pulled:
        """The adjoint at the start of the steps, without the seed of the edge there."""
        if s.now not in self._pulling:
            self._pulling[s.now] = Pulling(s.now, self.walk.by)
        steps, stages = grid
        seeds = {int(steps.ends[place - 1]) - 1: seed for place, seed in edges.items() if place}
        return self._pulling[s.now](stages, end, seeds, integrand, self.walk.scale)

    def _off(self, found: Pulled) -> float:
        """Estimated relative error: the sum over all steps, or the largest among the parameters if that is larger."""
        by_p = found.bent / np.maximum(found.weights.sizes, 1e-300)
        off = max(float(found.rough.sum()), float(by_p.max(initial=0)))
        return off if np.isfinite(off) else np.inf

    def _collocated(
        self, s: Stretch, grid: _Grid | None, end: Weights, edges: dict[int, Array], integrand: Integrand | None
    ) -> Weights:
        """The same as `_stretch`, by transition matrices Φ of the variational equations at the edges and quadrature points."""
        n, x = self.motion.states.shape[1], s.x
        if x is None:
            (x,) = states_of_phase(self.again(np.array([s.t0])), s.phase, np.array([s.t0]))
        own = {float(s.edges[place]): seed for place, seed in edges.items()}
        times, share = np.zeros(0), np.zeros(0)
        if integrand is not None:
            panels = np.linspace(s.t0, s.t1, 2 if grid is None else 1 + len(grid[0].h))
            times, share = gauss(_POINTS, panels.tolist())
        inner = times[(times > s.t0) & (times < s.t1)]
        cut = Stretch(s.now, s.by, s.feedback, x, np.unique(np.concatenate([s.edges, inner])), s.phase)
        (flow,) = self.walk.transitions(self.motion, [cut], self.again)
        at = dict(zip(cut.edges.tolist(), [np.eye(*flow.shape[1:]), *flow], strict=True))
        moved = end.x @ flow[-1] + sum((seed @ at[t] for t, seed in own.items()), np.zeros((len(end.x), flow.shape[2])))
        integral = end.integral
        if integrand is not None and len(inner) == len(times):
            states = states_of_phase(self.again(times), s.phase, times)
            own_l, by_x, by_p = integrand.slopes(s.now, self.walk.by, times, states)
            integral += float(share @ own_l)
            flows = np.array([at[t] for t in times.tolist()])
            row = np.einsum("t,tn,tnk->k", share, by_x, flows)
            row[n:] += share @ by_p
            moved = moved + np.outer(integrand.factors, row)
        return Weights(moved[:, :n], end.p + moved[:, n:], end.sizes + np.abs(moved[:, n:]), integral)

    # ------------------------------------------------------------------------------------------ one event, or breakpoint

    def _leapt(self, leap: Leap, after: Weights, integrand: Integrand | None) -> Weights:
        """The adjoint before a breakpoint whose time depends on parameters."""
        moved = after.x @ leap.x
        if integrand is not None:
            moved = moved + np.outer(integrand.factors, integrand.jump(leap.before, leap.behind) * leap.t)
        return after._replace(p=after.p + moved, sizes=after.sizes + np.abs(moved))

    def _across(self, number: int, after: Weights, integrand: Integrand | None) -> Weights:
        """The adjoint before the event at which a phase begins."""
        motion, walk = self.motion, self.walk
        n, k = motion.states.shape[1], len(walk.by)
        row = int(np.flatnonzero(motion.phase == number - 1)[-1])
        saltation, dt = walk.across(motion, row, np.eye(n, n + k), number, None)
        moved = after.x @ saltation
        if integrand is not None:
            jump = integrand.jump(walk.side(motion, row), walk.side(motion, row + 1))
            moved = moved + np.outer(integrand.factors, jump * dt)
        own = after.p + moved[:, n:], after.sizes + np.abs(moved[:, n:])
        return Weights(moved[:, :n], *own, after.integral)


def _parts(rough: Array, off: float) -> Indices:
    """The number of parts into which each step is divided: by its error estimate, or all by two if no single step exceeds its share.

    Steps whose iteration failed or that were not reached are divided into `_MOST_PARTS`.
    """
    share = rough * len(rough) / _ROUGH
    parts = np.where(share > 1, np.ceil(np.minimum(share, 1e300) ** (1 / _ORDER)), 1.0)
    parts = np.minimum(np.where(np.isfinite(share), parts, _MOST_PARTS), _MOST_PARTS).astype(np.int64)
    return parts if (parts > 1).any() or off <= _ROUGH else np.full(len(rough), 2)
