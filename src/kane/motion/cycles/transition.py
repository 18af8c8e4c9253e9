# SPDX-License-Identifier: BSD-3-Clause
"""Ψ′ = J Ψ + ∂f/∂p over a stretch of a motion, by Gauss's collocation with eight stages, order 16 (Hairer & Wanner 1996, sec. IV.5).

The states at the stages come from the motion, and Newton's steps on the equations of collocation make them exact to rounding. J is
evaluated at all stages of all steps together. Steps are halved until Ψ changes no more: what is left falls with the sixteenth power.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kane.motion.inputs.functions import following
from kane.motion.right_hand_side import Routines, entries, exact, is_long
from kane.motion.steppers.collocation import gauss
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED

_NODES = gauss(8)
_C, _B = np.array(_NODES.c), np.array(_NODES.b)
_A = np.array(_NODES.a).T
_ROUNDS = 8
"""Newton's steps at most."""


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """From `t0` and the state x on to `t1` with one set of equations; `by` gives ∂f/∂p (m × n × k) at times and states."""

    now: Routines
    by: Callable[[Array, Array], Array] | None
    x: Array
    t0: float
    t1: float
    phase: int

    def times(self, steps: int) -> Array:
        """The times of all stages (steps × 8)."""
        h = (self.t1 - self.t0) / steps
        return np.asarray(self.t0 + h * (np.arange(steps)[:, None] + _C))


def rates(now: Routines, t: Array, x: Array) -> Array:
    """f (k × n) at times (k) and states (k × n)."""
    r = now.inputs_all(t, x) if now.drives else None
    return now.rates(t, x, now.p, r)[:, :-1]


def jacobians(now: Routines, t: Array, x: Array) -> Array:
    """J (k × n × n) at times (k) and states (k × n)."""
    n = now.width
    if is_long(now) or following(now.drives):
        j = exact(now)
        return np.array([j(s, np.append(row, 0.0))[:n, :n] for s, row in zip(t.tolist(), x, strict=True)])
    return now.routine(entries)(t, x, now.p, now.inputs_all(t, x))[:, :n, :n]


def transition(stretch: Stretch, steps: int, guess: Array, scale: Array) -> Array:
    """δx = Φ δ(x₀, p) of the end (n × n + k), from states near those at the stages (steps × 8 × n)."""
    now, n = stretch.now, len(stretch.x)
    s, h = len(_C), (stretch.t1 - stretch.t0) / steps
    times, x = stretch.times(steps), guess.copy()
    flat = times.reshape(-1)
    for _ in range(_ROUNDS):
        f = rates(now, flat, x.reshape(-1, n)).reshape(steps, s, n)
        j = jacobians(now, flat, x.reshape(-1, n)).reshape(steps, s, n, n)
        whole = np.eye(s * n) - h * np.einsum("ij,mjab->miajb", _A, j).reshape(steps, s * n, s * n)
        start = np.zeros((s, n, n)) + np.eye(n)
        right = np.concatenate(
            [
                np.broadcast_to(start.reshape(s * n, n), (steps, s * n, n)),
                (h * np.einsum("ij,mjb->mib", _A, f) - x).reshape(steps, s * n, 1),
            ],
            axis=2,
        )
        solved = np.linalg.solve(whole, right).reshape(steps, s, n, n + 1)
        change, at = np.empty_like(x), stretch.x
        for m in range(steps):
            change[m] = solved[m, :, :, :n] @ at + solved[m, :, :, n]
            at = at + h * _B @ (f[m] + np.einsum("jab,jb->ja", j[m], change[m]))
        x = x + change
        if not np.abs(change / scale).max(initial=0) > ROUNDED * s * n:
            break
    return _product(stretch, solved[:, :, :, :n], whole, j, (flat, x), h)


def _product(stretch: Stretch, solved: Array, whole: Array, j: Array, at: tuple[Array, Array], h: float) -> Array:
    """The steps' own transitions, one after the other."""
    steps, s, n, _ = solved.shape
    own = np.eye(n) + h * np.einsum("j,mjab,mjbc->mac", _B, j, solved)
    if stretch.by is None:
        found = np.eye(n)
        for m in range(steps):
            found = own[m] @ found
        return found
    flat, x = at
    forced = stretch.by(flat, x.reshape(-1, n)).reshape(steps, s, n, -1)
    k = forced.shape[3]
    right = h * np.einsum("ij,mjak->miak", _A, forced).reshape(steps, s * n, k)
    of_p = np.linalg.solve(whole, right).reshape(steps, s, n, k)
    gained = h * np.einsum("j,mjak->mak", _B, forced + np.einsum("mjab,mjbk->mjak", j, of_p))
    found = np.eye(n, n + k)
    for m in range(steps):
        found = own[m] @ found
        found[:, n:] += gained[m]
    return found
