# SPDX-License-Identifier: BSD-3-Clause
"""A motion on its way over a span, whatever steps it: its method, its samples, the events that it meets, and how it ends."""

import math
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kane.dynamics.poles import KinematicsEnd
from kane.equations.equations import Equations
from kane.errors import cut
from kane.expr.build import neg
from kane.expr.evaluation import evaluate
from kane.expr.node import Expr
from kane.model.contact_modes import friction_name
from kane.model.declarations import Event
from kane.motion.hybrid.events import End, Fresh, StepSeen, met_along, still_there, thresholds
from kane.motion.right_hand_side import Routines, Switch, switches
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array
from kane.numeric.scale import CHANGES_SIDE
from kane.progress import MESSAGE


@dataclass(frozen=True, slots=True)
class Method:
    """A solver of SciPy's or SUNDIALS' by name, its tolerances, how many steps, how long, where they end, and the `first` one.

    `bounded` says that the number of steps was asked for: then a motion is not given up for getting on slowly. `free` says that the
    method was not: then it may be left. `whole` is how many steps the motion has of which this is a part, 0 where it is all of it.
    """

    name: str
    rtol: float
    atol: float
    max_steps: int
    max_step: float = np.inf
    breakpoints: tuple[float, ...] = ()
    max_seconds: float = np.inf
    bounded: bool = True
    free: bool = False
    first: float | None = None
    whole: int = 0

    def after(self, steps: int) -> "Method":
        """It after so many steps of the motion."""
        return replace(self, max_steps=max(self.max_steps - steps, 0), whole=self.whole or self.max_steps)

    def spent(self, t: float) -> str:
        """What is said where no step is left at t."""
        return f"{self.whole or self.max_steps} steps were not enough; at t = {t:.6g}"


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
    ends = {friction_name(c) for c in now.eom.system.contacts}  # before |v| is zero, by an event that is near it
    found = [s for s in switches(now.eom, now.laws) if s.jumps or s.load not in ends]
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


class Course:
    """A motion on its way over `span`: `advance()` until it gives an End.

    `t` and `rows` are the samples, each with the equations that hold there; `events` those that were met, `jumps` the
    samples with which phases begin, by which events, and from which state. `fresh` are those at whose thresholds it begins.
    """

    def __init__(
        self, stepper: Stepper, method: Method, span: tuple[float, float], start: Array, times: Array, fresh: Fresh
    ) -> None:
        self.stepper, self.method, self.span, self.times, self.fresh = stepper, method, span, times, fresh
        self.t = [span[0]]
        reach = stepper.reach
        # the start is on the constraints: what is left of them is rounding, and nothing of it counts
        self.rows: list[tuple[Array, Equations]] = [(start.copy(), stepper.sample(span[0], start)[1])]
        stepper.reach = reach
        self.events: list[tuple[Event, float]] = []
        self.jumps: list[tuple[int, tuple[Event, ...], Array]] = []
        self.pace = Pace(span, method.max_seconds, method.bounded)

    @property
    def name(self) -> str:
        """The method."""
        return self.method.name

    def since(self, interval: float) -> None:
        """How long it is since an action was taken: the next one may be as near. Solvers choose their first steps without it."""

    @property
    def acted(self) -> float:
        """When an action was last taken, or the motion began."""
        return self.span[0]

    def sample(self, t: float, y: Array) -> None:
        """A sample, moved onto the constraints."""
        self.t.append(t)
        self.rows.append(self.stepper.sample(t, y))

    def sample_up_to(self, end: float, dense: Callable[[float], Array], ends: bool) -> None:
        """The samples before `end`, by the states along a step, and the one there if the motion ends there."""
        before = self.times[(self.times > self.t[-1]) & (self.times < end)]
        for t in [*before, *([end] if ends and end > self.t[-1] else [])]:
            self.sample(float(t), dense(float(t)))

    def stopped(self, message: str, t: float, y: Array) -> End:
        """What there is up to a state is the motion."""
        if t > self.t[-1] and np.all(np.isfinite(y)):
            self.sample(t, y)
        return End("stopped", message)

    def broken(self, t: float, y: Array) -> End:
        """The end of a motion that Ctrl-C ends."""
        self.stopped("", t, y)
        return End("stopped", f"{MESSAGE}{self.t[-1]:.6g}")

    def meets(
        self, now: Routines, dense: Callable[[float], Array], step: StepSeen, largest: Array
    ) -> tuple[list[tuple[Event, float]], End | None, float]:
        """The events of a step, the end that they make, and when; without one, the beginning of the step."""
        noted, end = met_along(now, dense, step, largest, self.fresh, self.method.rtol, self.acted, self.span[1])
        return noted, end, float(step.times[0]) if end is None else next(t for event, t in noted if event.breaks)

    def passes(self, end: End | None, t: float, dense: Callable[[float], Array]) -> bool:
        """Whether the kinematics that end a motion at t are regular there with other dependent speeds."""
        return (
            end is not None and isinstance(end.event, KinematicsEnd) and self.stepper.regular(t, dense(t)) is not None
        )

    def leave(self, after: Array, largest: Array) -> None:
        """The events at whose thresholds the motion still is after a step, by their quantities there."""
        events = self.stepper.eom.events
        self.fresh = still_there(self.fresh, events, after - thresholds(events, largest))
