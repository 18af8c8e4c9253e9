# SPDX-License-Identifier: BSD-3-Clause
"""Loads and inputs that switch, in machine code: the equations of the side on which a motion is, up to the place where a switch turns.

With every switch replaced by what it is on its side, rates are smooth across the place, so that a step sees it as an event on its own
polynomial. The step is taken again up to there, and another side begins. Where a motion comes back at once from both sides, as dry
friction −F sign(v) does at rest, no acceleration of either side keeps v = 0, and none of the other leaves it: it does not get on.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from kane.dynamics.readings.quantities import without_unknowns
from kane.equations.equations import Equations
from kane.errors import cut
from kane.expr.build import neg
from kane.expr.evaluation import evaluate
from kane.expr.node import Expr
from kane.expr.piecewise import Piecewise, leaps, on
from kane.expr.piecewise import switches as switches_of
from kane.motion.hybrid.events import Inspection, Verdict
from kane.motion.inputs.expressions import Formula, law_ports
from kane.motion.inputs.functions import law_and
from kane.motion.right_hand_side import Routines, rates, watched
from kane.motion.steps import Stepper
from kane.motion.switches import Switch, has_jumps, switches
from kane.numeric.arrays import Array
from kane.numeric.scale import CHANGES_SIDE, EQUAL, LAST_DIGIT, LATER, NEAR_TIME, ROUNDED, SOON
from kane.numeric.sign_changes import SHARES, passages, zero_of
from kane.program.from_expressions import Bundle, Shaped

RECENT = 200
"""Steps that are looked back on."""
HELD = 1e-5
"""Share of the span that so many steps must lead on, at least, where a switch turns to and fro."""
_TURNS = 2
MANY_STEPS, _LEAST = 10_000, 1e-4
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
        if self.bounded or steps - self.marked < MANY_STEPS:
            return ""
        gained, self.mark, self.marked = t - self.mark, t, steps
        if gained >= _LEAST * self.length:
            return ""
        return (
            f"the motion does not get on: {MANY_STEPS} steps led from t = {t - gained:.6g} to {t:.6g}, {gained / self.length:.1e} of "
            'the span. Choose method="Radau" where the equations are stiff, end before, or give max_steps= to go on all the same'
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


def quantities(eom: Equations, laws: Sequence[Expr] = ()) -> tuple[Expr, ...]:
    """The quantities of all switches that the rates hold, then of those of the laws of inputs, but for tables that only bend."""
    found = [s for roots in (rates(eom).task.roots, laws) for s in switches_of(roots)]
    return tuple(dict.fromkeys(s.quantity for s in found if not all(map(_bending, s.nodes))))


def _bending(node: Expr) -> bool:
    return isinstance(node.op, Piecewise) and not leaps(node.op)


def unfit(eom: Equations, laws: Sequence[Expr] = ()) -> bool:
    """Whether they jump and there are switches with more than two sides, tables of steps, or with none: what chooses pivots."""
    if not has_jumps(eom, laws):
        return False
    loads = eom.solved.regular.declared_loads
    scalars = [x for load in loads for _, v in (*load.forces, *load.torques) for x in v.scalars()]
    own = switches_of([*without_unknowns(eom.solved, scalars), *laws])
    tables = any(isinstance(node.op, Piecewise) and leaps(node.op) for s in own for node in s.nodes)
    return tables or not set(quantities(eom, laws)) <= {s.quantity for s in own}


def rates_on(eom: Equations, *sides: int) -> Bundle[tuple[Array, ...]]:
    """(q̇, u̇, P) with the switches on these sides."""
    plain, fixed = rates(eom), on(quantities(eom), sides)
    groups = {name: Shaped(g.shape, tuple(map(fixed, g.roots))) for name, g in plain.groups.items()}
    return Bundle(plain.name, plain.ports, plain.record, groups, plain.labels)


def watched_on(eom: Equations, more: tuple[Expr, ...], *sides: int) -> Bundle[tuple[Array, ...]]:
    """The events' quantities, then those of the switches of rates, and `more` of the laws of inputs, on their sides."""
    own = quantities(eom)
    names = [*(e.name for e in eom.events), *map(str, range(len(own) + len(more)))]
    roots = [*without_unknowns(eom.solved, [e.quantity for e in eom.events]), *own]
    fixed = [*map(on(own, sides), roots), *more]
    return Bundle("watched", law_ports(eom, more), watched(eom).record, {"events": fixed}, names)


def drives_on(drives: tuple[Any, ...], fixed: Callable[[Expr], Expr]) -> tuple[Any, ...]:
    """Inputs with the switches of their laws on sides."""
    return tuple(replace(f, expr=fixed(f.expr)) if isinstance(f, Formula) and f.of_state else f for f in drives)


class Modes:
    """The side of each switch; `fresh` are those whose quantities are zero now, `tried` those that came back from a side before."""

    def __init__(self, stepper: Stepper, t: float, y: Array) -> None:
        self.eom = stepper.eom
        self.events = len(self.eom.events)
        self.quantities = quantities(self.eom, stepper.now.laws)
        self.sides = (1,) * len(self.quantities)
        values = np.zeros(0)
        for _ in self.sides:  # a quantity may hold other switches
            values, before = self._values(stepper, t, y), self.sides
            self.sides = tuple(-1 if v < 0 else 1 for v in values)
            if self.sides == before:
                break
        self.fresh = frozenset(np.flatnonzero(values == 0).tolist())
        self.tried: frozenset[int] = frozenset()

    def routines(self, stepper: Stepper) -> Routines:
        """The equations on these sides, and what is watched."""
        now, own = self._watched(stepper), self.sides[: len(quantities(self.eom))]
        return replace(now, rates=self.eom.numeric(now.settings).routine(rates_on, *own).flat) if own else now

    def _watched(self, stepper: Stepper) -> Routines:
        now, eom, fixed = stepper.now, self.eom, on(self.quantities, self.sides)
        drives, own = drives_on(now.drives, fixed), len(quantities(eom))
        law = law_and(drives, eom.inputs, list(map(fixed, self.quantities[own:])))
        more = law.values[len(eom.inputs) :]
        events = eom.numeric(now.settings).routine(watched_on, more, *self.sides[:own]).flat
        return replace(now, events=events, drives=drives, switches=None, numbers=law.numbers)

    def _values(self, stepper: Stepper, t: float, y: Array) -> Array:
        """The quantities on these sides."""
        return self._watched(stepper).watch(t, y)[self.events :]

    def turn(self, stepper: Stepper, t: float, y: Array, which: tuple[int, ...], tried: bool = False) -> None:
        """The other side of some switches, whose quantities are zero, and of those whose quantities jump across zero with them."""
        turned = set(which)
        for _ in self.sides:
            before = self._values(stepper, t, y)
            self.sides = tuple(-s if k in turned else s for k, s in enumerate(self.sides))
            after = self._values(stepper, t, y)
            leapt = np.abs(after - before) > EQUAL * np.maximum(np.abs(after), np.abs(before))
            turned = {int(k) for k in np.flatnonzero(leapt & (after * self.sides < 0))}.difference(which)
            if not turned:
                break
        self.fresh = frozenset(which)
        self.tried = self.fresh if tried else frozenset()

    def gone_on(self) -> None:
        """A step was taken: every quantity is away from zero."""
        self.fresh = self.tried = frozenset()

    def look(self, now: Routines, state: Callable[[float], Array], start: float, h: float, values: Array) -> Inspection:
        """What switches do in the step of length h from `start`; `values` are theirs at the places."""
        met: list[tuple[float, int]] = []
        largest = np.abs(values).max(axis=0, initial=0)
        for k, side in enumerate(self.sides):

            def ahead(t: float, k: int = k, side: int = side) -> float:
                return side * float(now.watch(t, state(t))[self.events + k])

            def each(times: Array, ahead: Callable[[float], float] = ahead) -> Array:
                return np.array([ahead(float(t)) for t in times])

            times, own = start + h * np.array(SHARES), side * values[:, k]
            if k in self.fresh:
                begin = start + LATER * h
                if not largest[k] > 0 or abs(ahead(begin)) <= ROUNDED * largest[k]:
                    return Inspection(Verdict.SINGULAR, which=(k,))
                if ahead(begin) < 0:
                    if ahead(start + SOON * h) > 0:
                        return Inspection(Verdict.SHORTER, LATER * h, (k,))
                    return Inspection(Verdict.OTHER_SIDE, which=(k,))
                times = begin + (start + h - begin) * np.array(SHARES)
                own = np.append(each(times[:-1]), own[-1])
            for a, b, first, last in passages(each, times, own):
                if first > 0:
                    met.append((zero_of(ahead, a, b, first, last, LAST_DIGIT * max(abs(a), abs(b))), k))
                    break
        if not met:
            return Inspection(Verdict.TAKEN)
        t = min(met)[0]
        which = tuple(k for at, k in met if at - t <= NEAR_TIME * h)
        return Inspection(Verdict.UP_TO, start + h if t >= start + (1 - NEAR_TIME) * h else t, which)
