# SPDX-License-Identifier: BSD-3-Clause
"""A motion on its way over a span, whatever steps it: its method, its samples, the events that it meets, and how it ends."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from kane.dynamics.poles import KinematicsEnd
from kane.equations.equations import Equations
from kane.model.declarations import Event
from kane.motion.hybrid.events import End, Fresh, StepSeen, met_along, still_there, thresholds
from kane.motion.hybrid.modes import Pace
from kane.motion.interrupts import MESSAGE
from kane.motion.right_hand_side import Routines
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array


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


class Course:
    """A motion on its way over `span`: `advance()` until it gives an End.

    `t` and `rows` are the samples, each with the equations that hold there; `events` those that were met, `jumps` the
    samples with which phases begin, and by which events. `fresh` are those at whose thresholds it begins.
    """

    def __init__(
        self, stepper: Stepper, method: Method, span: tuple[float, float], start: Array, times: Array, fresh: Fresh
    ) -> None:
        self.stepper, self.method, self.span, self.times, self.fresh = stepper, method, span, times, fresh
        self.t = [span[0]]
        self.rows: list[tuple[Array, Equations]] = [stepper.sample(span[0], start)]
        self.events: list[tuple[Event, float]] = []
        self.jumps: list[tuple[int, tuple[Event, ...]]] = []
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
