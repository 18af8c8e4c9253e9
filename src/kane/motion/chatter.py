# SPDX-License-Identifier: BSD-3-Clause
"""Motions that do not get on: a load that jumps to and fro at a switch holds them there, by ever smaller steps.

Dry friction written −F sign(v) does so at rest: no acceleration of either side keeps v = 0, and none of the other leaves it.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Iterable, Sequence

import numpy as np

from kane.errors import cut
from kane.expr.build import neg
from kane.expr.evaluation import evaluate
from kane.expr.node import Expr
from kane.motion.compiled_equations import Routines
from kane.motion.switches import Switch, switches
from kane.numeric.arrays import Array
from kane.numeric.scale import CHANGES_SIDE

RECENT = 200
"""Steps that are looked back on."""
HELD = 1e-5
"""Share of the span that so many steps must lead on, at least, where a switch turns to and fro."""
_TURNS = 2
_MANY, _LEAST = 10_000, 1e-4
"""After so many steps that led on by less than that share of the span a motion is given up."""


class Pace:
    """How a motion gets on: the last states and when they were reached, by steps and by the clock."""

    def __init__(self, span: tuple[float, float], max_seconds: float, bounded: bool) -> None:
        self.length, self.bounded, self.max_seconds = span[1] - span[0], bounded, max_seconds
        self.begun = time.monotonic()
        self.states: deque[tuple[float, Array]] = deque(maxlen=RECENT + 1)
        self.before: list[tuple[float, Array]] = []
        self.noted = 0
        self.mark, self.marked = span[0], 0

    def note(self, t: float, y: Array) -> None:
        """A state that was gone on from."""
        self.states.append((t, y))
        if self.noted % RECENT == 0 and len(self.before) < RECENT:
            self.before.append((t, y))
        self.noted += 1

    def halts(self, now: Routines, steps: int) -> str:
        """Why the motion is not gone on with, in words; "" where it is."""
        late = self.late(self.states[-1][0])
        if late:
            return late
        if steps % RECENT or len(self.states) <= RECENT:
            return ""
        t = self.states[-1][0]
        if t - self.states[0][0] < HELD * self.length:
            told = chattering(now, self)
            if told:
                return f"the motion does not get on beyond t = {t:.6g}, {RECENT} steps led on by {t - self.states[0][0]:.1e} s: {told}"
        return self.crawls(t, steps)

    def late(self, t: float) -> str:
        """That the time by the clock is over, in words; "" where it is not."""
        if self.max_seconds < math.inf and time.monotonic() - self.begun > self.max_seconds:
            return f"max_seconds={self.max_seconds:g} have passed; at t = {t:.6g}"
        return ""

    def crawls(self, t: float, steps: int) -> str:
        """That many steps led on by next to nothing, in words; "" where they did not, or their number was asked for."""
        if self.bounded or steps - self.marked < _MANY:
            return ""
        gained, self.mark, self.marked = t - self.mark, t, steps
        if gained >= _LEAST * self.length:
            return ""
        return (
            f"the motion does not get on: {_MANY} steps led from t = {t - gained:.6g} to {t:.6g}, {gained / self.length:.1e} of the "
            'span. Choose method="Radau" where the equations are stiff, end before, or give max_steps= to go on all the same'
        )


def chattering(now: Routines, pace: Pace) -> str:
    """Which load turns to and fro at a switch by the last states, or stands at it, and what to do; "" where none does."""
    found = switches(now.eom, now.laws)
    if not found or not pace.states:
        return ""

    def numbers(states: Iterable[tuple[float, Array]]) -> Array:
        return np.array([evaluate([s.quantity for s in found], now.values(t, y)) for t, y in states], dtype=float)

    table = numbers(pace.states)
    turns = (np.diff(np.sign(table), axis=0) != 0).sum(axis=0)
    size = np.abs(np.vstack([numbers(pace.before), table]))
    near = size[-1] <= CHANGES_SIDE * np.maximum(size.max(axis=0), np.finfo(float).tiny)
    for s, count, at in zip(found, turns, near, strict=True):
        if count >= _TURNS or at:
            return _told(s)
    return ""


def standing(now: Routines, quantities: Sequence[Expr]) -> str:
    """What is said of a load that stands at a switch of one of some quantities."""
    found = [s for s in switches(now.eom, now.laws) if s.jumps]
    return _told(next((s for s in found for c in quantities if c is s.quantity or c is neg(s.quantity)), found[0]))


def _told(s: Switch) -> str:
    return (
        f"{cut(s.text, 80)} in the {s.load} turns to and fro, as {cut(s.quantity)} comes to zero again and again. Declare "
        f"friction, kn.friction(…) or kn.dry_friction(…), or {s.smooth} in its place and choose "
        'method="Radau"'
    )
