# SPDX-License-Identifier: BSD-3-Clause
"""Variational equations Ψ′ = J Ψ + ∂f/∂p by Gauss collocation with eight stages, order 16 (Hairer & Wanner 1996, sec. IV.5).

The stage states are sampled from the motion and made exact to rounding by Newton iterations on the collocation equations. J is
evaluated at all stages of all steps at once. Steps are halved until Ψ has converged; its error falls with the sixteenth power.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kane.motion.derivatives.parameter_slopes import Slopes
from kane.motion.inputs.expressions import Formula
from kane.motion.inputs.functions import following
from kane.motion.right_hand_side import Routines, by_inputs, entries, exact, gains, is_long
from kane.motion.solution.phases import Indices
from kane.motion.steppers.collocation import gauss
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED, ROUNDED_CHAIN

_NODES = gauss(8)
_C, _B = np.array(_NODES.c), np.array(_NODES.b)
_A = np.array(_NODES.a).T
_ROUNDS = 8
"""Largest number of Newton iterations."""
_ENTRIES = 1 << 23
"""Largest number of entries of the collocation matrices that are stored at once."""


class CollocationSteps(NamedTuple):
    """Successive steps: start times t, lengths h (steps), and the number of steps up to each edge but the first."""

    t: Array
    h: Array
    ends: Indices

    @property
    def times(self) -> Array:
        """The times of all stages (steps × 8)."""
        return np.asarray(self.t[:, None] + self.h[:, None] * _C)

    def divided(self, parts: Indices) -> "CollocationSteps":
        """Each step divided into the given number of equal ones."""
        h, place = np.repeat(self.h / parts, parts), np.concatenate([np.arange(m) for m in parts])
        return CollocationSteps(np.repeat(self.t, parts) + place * h, h, np.cumsum(parts)[self.ends - 1])


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """A smooth part of a motion, with one set of equations, over times `edges` (e); x is its first state, None after another stretch.

    `by` gives ∂f/∂p (m × n × k) at times and states, `feedback` the contribution to ∂f/∂x of inputs that depend on the state. `rows`
    are the requested samples of the motion, `places` the indices of their edges.
    """

    now: Routines
    by: Slopes
    feedback: Slopes
    x: Array | None
    edges: Array
    phase: int
    rows: tuple[int, ...] = ()
    places: tuple[int, ...] = ()

    @property
    def t0(self) -> float:
        """The start time."""
        return float(self.edges[0])

    @property
    def t1(self) -> float:
        """The end time."""
        return float(self.edges[-1])

    def parts(self, steps: int) -> Indices:
        """The number of equal steps in each interval between edges, for about `steps` steps in the whole stretch."""
        share: Array = np.diff(self.edges) / max(self.t1 - self.t0, 1e-300)
        return np.maximum(np.ceil(steps * share - ROUNDED_CHAIN).astype(np.int64), 1)

    def steps(self, parts: Indices) -> CollocationSteps:
        """The steps, as many in each interval between edges as `parts` tells."""
        return CollocationSteps(self.edges[:-1], np.diff(self.edges), np.arange(1, len(self.edges))).divided(parts)


def jacobians(stretch: Stretch, t: Array, x: Array) -> Array:
    """J (k × n × n) at times (k) and states (k × n)."""
    now, n = stretch.now, stretch.now.width
    if is_long(now):
        j = exact(now)
        return np.array([j(s, np.append(row, 0.0))[:n, :n] for s, row in zip(t.tolist(), x, strict=True)])
    r = now.inputs(t, x)
    held = now.routine(entries)(t, x, now.p, r)[:, :n, :n]
    if any(following([f]) and not isinstance(f, Formula) for f in now.drives):
        found = held + by_inputs(now, t, x, r)[:, :n] @ gains(now, t, x, r)
        return np.where(np.isfinite(found), found, 0.0)
    return held if stretch.feedback is None else held + stretch.feedback(t, x)


def transition(stretch: Stretch, x: Array, parts: Indices, guess: Array, scale: Array) -> tuple[Array, Array]:
    """The matrices Φ in δx = Φ δ(x₀, p) at the edges after the first (e − 1 × n × n + k), and the final state.

    `x` is the initial state, `guess` (steps × 8 × n) are approximate states at the stages.
    """
    n, own_steps = len(x), stretch.steps(parts)
    times, h, ends, k = own_steps.times, own_steps.h, set(own_steps.ends.tolist()), 0
    chunk = max(1, _ENTRIES // (len(_C) * n) ** 2)
    phi, found = None, list[Array]()
    for start in range(0, len(h), chunk):
        some = slice(start, start + chunk)
        own, gained, x = _chunk(stretch, (times[some], h[some]), x, guess[some], scale)
        k = gained.shape[2]
        phi = np.eye(n, n + k) if phi is None else phi
        for m in range(len(own)):
            phi = own[m] @ phi
            phi[:, n:] += gained[m]
            if start + m + 1 in ends:
                found.append(phi)
    return np.array(found), x


def _solved(whole: Array, right: Array) -> Array:
    """The solutions of stages; NaN where steps are so long that one has none, which shorter steps mend."""
    try:
        return np.asarray(np.linalg.solve(whole, right))
    except np.linalg.LinAlgError:
        return np.full_like(right, np.nan)


def _chunk(
    stretch: Stretch, at: tuple[Array, Array], start: Array, guess: Array, scale: Array
) -> tuple[Array, Array, Array]:
    """∂x/∂x₀ and ∂x/∂p over each step, and the state at the end of the last one; `at` are stage times and step lengths.

    States are solved for in units of their sizes, `scale`: pivots do not depend on the units of the model.
    """
    now, n, x, (times, h) = stretch.now, len(start), guess / scale, at
    steps, s = times.shape
    flat, own_units, end = times.reshape(-1), scale / scale[:, None], start / scale
    for _ in range(_ROUNDS):
        there = x.reshape(-1, n) * scale
        f = now.rate(flat, there)[:, :-1].reshape(steps, s, n) / scale
        j = jacobians(stretch, flat, there).reshape(steps, s, n, n) * own_units
        whole = np.eye(s * n) - np.einsum("m,ij,mjab->miajb", h, _A, j).reshape(steps, s * n, s * n)
        unit = np.tile(np.eye(n), (s, 1))
        right = np.concatenate(
            [
                np.broadcast_to(unit, (steps, s * n, n)),
                (np.einsum("m,ij,mjb->mib", h, _A, f) - x).reshape(steps, s * n, 1),
            ],
            axis=2,
        )
        solved = _solved(whole, right).reshape(steps, s, n, n + 1)
        change, end = np.empty_like(x), start / scale
        for m in range(steps):
            change[m] = solved[m, :, :, :n] @ end + solved[m, :, :, n]
            end = end + h[m] * _B @ (f[m] + np.einsum("jab,jb->ja", j[m], change[m]))
        x = x + change
        if not np.abs(change).max(initial=0) > ROUNDED * s * n:
            break
    own = (np.eye(n) + np.einsum("m,j,mjab,mjbc->mac", h, _B, j, solved[:, :, :, :n])) / own_units
    if stretch.by is None:
        return own, np.zeros((steps, n, 0)), end * scale
    forced = stretch.by(flat, x.reshape(-1, n) * scale).reshape(steps, s, n, -1) / scale[:, None]
    right = np.einsum("m,ij,mjak->miak", h, _A, forced).reshape(steps, s * n, -1)
    of_p = _solved(whole, right).reshape(steps, s, n, -1)
    gained = np.einsum("m,j,mjak->mak", h, _B, forced + np.einsum("mjab,mjbk->mjak", j, of_p))
    return own, gained * scale[:, None], end * scale
