# SPDX-License-Identifier: BSD-3-Clause
"""A motion on its way over a span, and what steps it: one loop over the steps that a solver finds.

A solver (`Solver`) is a kernel, which takes steps by itself as long as nothing is open (`native.py`), or one of SciPy's or SUNDIALS'
(`solvers/`). What is open of a step, whether constraints hold and are regular there, which events it meets, is looked at here, alike
for all; so are samples, the number of steps, the time by the clock, and which solver leads on.
"""

import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

import numpy as np

from kane.dynamics.poles import KinematicsEnd
from kane.equations.equations import Equations
from kane.model.declarations import Event
from kane.motion.broken import chattering, constraint_failure
from kane.motion.hybrid.automaton import End, Fresh, ended_by, leapt_over, up_to_a_break
from kane.motion.hybrid.events import StepSeen, events_along
from kane.motion.projection import Numbers
from kane.motion.right_hand_side import Routines
from kane.motion.steps import Stepper, regular, unheld
from kane.numeric.arrays import Array
from kane.numeric.scale import SAME_TIME
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
MANY_STEPS, _LEAST = 10_000, 1e-4
"""After so many steps that led on by less than that share of the span a motion is given up."""


class Pace:
    """How a motion gets on: the last states and when they were reached, by steps and by the clock."""

    def __init__(self, span: tuple[float, float], max_seconds: float, bounded: bool) -> None:
        self.length, self.end, self.bounded, self.max_seconds = span[1] - span[0], span[1], bounded, max_seconds
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

    def anew(self, t: float, steps: int, first: tuple[float, Array]) -> None:
        """Another solver leads on from t after so many steps; sizes at switches are compared with those at the `first` state, too."""
        self.length, self.mark, self.marked, self.noted = self.end - t, t, steps, 0
        self.states.clear()
        self.before = [first]

    def chatters(self, now: Routines, steps: int) -> str:
        """That a load turns to and fro at a switch by the states noted after so many steps, in words; "" where none does."""
        if steps % RECENT or len(self.states) <= RECENT:
            return ""
        t, since = self.states[-1][0], self.states[0][0]
        told = chattering(now, self.states, self.before) if t - since < HELD * self.length else ""
        return (
            f"the motion does not get on beyond t = {t:.6g}, {RECENT} steps led on by {t - since:.1e} s: {told}"
            if told
            else ""
        )

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


class Verdict(Enum):
    """What becomes of a step that has been inspected."""

    TAKEN = "taken"
    SHORTER = "taken again, shorter"
    SINGULAR = "left to SciPy's solver, which passes singular states"
    TURNED = "not taken: another branch of a closure lies there"
    MISSED = "not taken: a constraint does not hold there"
    BENT = "not taken: constraints hold other positions or velocities there"


class StepVerdict(NamedTuple):
    """The verdict on a step; `t` is how long it is then, 0 where that is not said, `message` what was found."""

    verdict: Verdict
    t: float = 0.0
    message: str = ""


class StepFound(NamedTuple):
    """A step from t to an `end` that a solver has found and not gone on from.

    Of it is open whether its constraints are `held`, and which events are `met`. `dense` gives the state at a time (n), or states at
    times (n × k); `first` and `last` are those at its ends.
    """

    t: float
    end: float
    dense: Callable[[Any], Array]
    first: Array
    last: Array
    held: bool = True
    met: bool = True


Came = StepFound | End | str | None
"""What a solver comes back with: a step of which something is open, the end, why there is no step, or nothing to be looked at."""


Counts = tuple[int, int]


class Solver(Protocol):
    """What steps a motion. One that goes on `by_itself` takes samples, and goes on from steps in which nothing is found.

    `ahead` is where equations were seen to be singular on the way, infinite where they were not.
    """

    by_itself: bool
    ahead: float

    @property
    def at(self) -> tuple[float, Array]:
        """Up to when the motion is stepped, and the state there."""

    @property
    def reached(self) -> tuple[float, Array]:
        """The last time and state that were gone on from."""

    @property
    def counts(self) -> Counts:
        """Steps that it has tried or taken, and evaluations of the right-hand side; those of all stages at once are one."""

    def step(self, most: int) -> Came:
        """A step, or at most so many."""

    def singular(self, step: StepFound, numbers: Numbers | None, narrow: float) -> StepVerdict:
        """Whether a step that keeps its constraints is one: constraints may be singular there, or loads switch and switch back."""

    def seen(self, step: StepFound, kept: Array) -> StepSeen:
        """What events see of a step that ends at a state on its constraints."""

    def shorten(self, step: StepFound, length: float) -> None:
        """The step is taken again, of that length; half as long where none is given, with what lies at its end in mind."""

    def avoid(self, step: StepFound, t: float) -> None:
        """The step is not gone on from, as equations are singular at t."""

    def go_on(self, step: StepFound, kept: Array, numbers: Numbers | None) -> None:
        """What was open is not: the step is gone on from, from the state on its constraints."""


class Course:
    """A motion on its way over `span`: `advance()` until it gives an End.

    `t` and `rows` are the samples, each with the equations that hold there; `events` those that were met, `jumps` the
    samples with which phases begin, by which events, and from which state. `fresh` are those at whose thresholds it begins.
    `made` gives a solver for the course by its method's name, at a time and state; an action was taken so long `since`.
    """

    def __init__(
        self,
        stepper: Stepper,
        method: Method,
        span: tuple[float, float],
        start: Array,
        times: Array,
        made: Callable[["Course", str, float, Array], Solver],
        fresh: Fresh = MappingProxyType({}),
        since: float = 0.0,
    ) -> None:
        self.since = since
        self.stepper, self.method, self.span, self.times = stepper, method, span, times
        self.fresh, self.made = fresh, made
        self.t = [span[0]]
        reach = stepper.reach
        # the start is on the constraints: what is left of them is rounding, and nothing of it counts
        self.rows: list[tuple[Array, Equations]] = [(start.copy(), stepper.sample(span[0], start)[1])]
        stepper.reach = reach
        self.events: list[tuple[Event, float]] = []
        self.jumps: list[tuple[int, tuple[Event, ...], Array]] = []
        self.pace = Pace(span, method.max_seconds, method.bounded)
        self.pace.before.append((span[0], start.copy()))  # sizes of quantities at switches
        self.names, self.counted = {method.name: None}, (0, 0)
        self.back: Callable[[float, Array], Solver] | None = None
        self.solver: Solver
        self.solver = self.first = made(self, method.name, span[0], start)

    @property
    def name(self) -> str:
        """The method, with those that have led on from a place, or past one."""
        return ", ".join(self.names)

    @property
    def steps(self) -> int:
        """Steps so far."""
        return self.counts[0]

    @property
    def counts(self) -> Counts:
        """Steps, and evaluations of the right-hand side, of all solvers so far."""
        both = (self.first,) if self.solver is self.first else (self.first, self.solver)
        steps, evaluations = zip(self.counted, *(s.counts for s in both), strict=True)
        return sum(steps), sum(evaluations)

    def far(self) -> str:
        """How far the motion is, in words."""
        return f"t = {self.solver.at[0]:.4g} of {self.span[1]:.4g} s"

    def advance(self) -> End | None:
        """A step, or as many as the solver takes by itself."""
        solver, steps, t = self.solver, self.steps, self.solver.at[0]
        most = self.method.max_steps - steps
        if most <= 0:
            return self.stopped(self.method.spent(t))
        told = self.pace.late(t) or self.pace.crawls(t, steps)
        if told:
            return self.stopped(told)
        end = self.follow(solver.step(most))
        if end is None and self.back is not None and solver is self.solver:  # which has stepped since it leads on
            self._return(self.back)
        return end

    def follow(self, came: Came) -> End | None:
        """What follows from that with which a solver came back."""
        if isinstance(came, StepFound):
            return self.judge(came)
        return self.stopped(came) if isinstance(came, str) else came

    def judge(self, step: StepFound) -> End | None:
        """What is open of a step is looked at; what is met is read off the states that are gone on from.

        So projection cannot hide it, nor make it be met twice.
        """
        solver, kept, numbers = self.solver, step.last, None
        narrow = SAME_TIME * max(abs(step.end), self.span[1] - self.span[0])
        if step.held:
            found, kept, numbers = self._inspect(step, narrow)
            if found.verdict is not Verdict.TAKEN:
                return self._otherwise(step, found)
        end, at = None, step.end
        if step.met and self.stepper.eom.events:
            noted, end, t = self._meets(step, kept)
            if end is not None and (solver.by_itself or t - step.t > narrow) and self._passes(end, t, step.dense):
                solver.avoid(step, t)
                return None
            self.events += noted
            at = step.end if end is None else t
        if end is None and not solver.by_itself and step.end >= self.span[1]:
            end = self.end_of_span()
        if end is not None or not solver.by_itself:
            self._sample_up_to(at, step.dense, end is not None)
        if end is None:
            solver.go_on(step, kept, numbers)
        else:
            self.counted = self.counted[0] + solver.by_itself, self.counted[1]  # others have counted it
        return end

    def _inspect(self, step: StepFound, narrow: float) -> tuple[StepVerdict, Array, Numbers | None]:
        """A step on the constraints; no step is made shorter than `narrow`."""
        stepper, solver, h = self.stepper, self.solver, step.end - step.t
        tolerances = self.method.rtol, self.method.atol
        bent = stepper.bent(step.dense, step.t, step.end, tolerances)
        if bent is not None:  # closed in on from before, as no state beyond belongs to the motion
            ahead = bent.t - step.t
            shorter = StepVerdict(Verdict.SHORTER, min(0.9 * ahead, h / 2))
            return shorter if ahead > narrow else StepVerdict(Verdict.BENT, message=bent.message), step.last, None
        kept, numbers = stepper.keep(step.end, step.last)
        turned, missed = stepper.turned(numbers), stepper.missed(step.end, kept, numbers, tolerances)
        if (turned or missed) and h > narrow:
            # the place is closed in on by halves, until a state lies so near to it that `settle` sees it
            return StepVerdict(Verdict.SHORTER), kept, numbers
        if turned:
            return StepVerdict(Verdict.TURNED, message=turned), kept, numbers
        if missed:
            return StepVerdict(Verdict.MISSED, message=missed), kept, numbers
        return solver.singular(step, numbers, narrow), kept, numbers

    def _otherwise(self, step: StepFound, found: StepVerdict) -> End | None:
        """What follows for a step that is not taken: it is taken otherwise, or the motion ends."""
        if found.verdict is Verdict.SHORTER:
            self.solver.shorten(step, found.t)
            return None
        if found.verdict is Verdict.SINGULAR:
            self.solver.avoid(step, math.inf)
            return None
        if found.verdict is Verdict.BENT:
            return self.stopped(found.message, (step.t, step.first))
        if found.verdict is Verdict.TURNED:
            return self.stopped(f"another branch of the closures lies beyond t = {step.t:.6g}: {found.message}")
        return self.stopped(constraint_failure(self.stepper, step.t, step.first, self.span, found.message))

    def _meets(self, step: StepFound, kept: Array) -> tuple[list[tuple[Event, float]], End | None, float]:
        """The events of a step, the end that they make, and when; without one, the beginning of the step."""
        noted, end = events_along(self.solver.seen(step, kept), step.dense, self.fresh, self.method.rtol, self.span[1])
        return noted, end, step.t if end is None else next(t for event, t in noted if event.breaks)

    def _passes(self, end: End, t: float, dense: Callable[[float], Array]) -> bool:
        """Whether the kinematics that end a motion at t are regular there with other dependent speeds."""
        return isinstance(end.event, KinematicsEnd) and self.stepper.regular(t, dense(t)) is not None

    def hand_over(self, t: float, y: Array, name: str, back: Callable[[float, Array], Solver] | None) -> None:
        """Another solver leads on; it gives `back` to the present one where constraints are regular again, if that is given."""
        self.pace.anew(t, self.steps, (self.t[0], self.rows[0][0]))
        self.solver, self.back = self.made(self, name, t, y), back
        self.names[name] = None

    def _return(self, back: Callable[[float, Array], Solver]) -> None:
        """Where constraints are regular again the solver before leads on."""
        solver, (t, y) = self.solver, self.solver.at
        if solver.ahead < math.inf or unheld(self.stepper) or not regular(self.stepper, self.stepper.keep(t, y)[1]):
            return
        steps, evaluations = solver.counts
        self.counted = self.counted[0] + steps, self.counted[1] + evaluations
        self.solver, self.back = back(t, y), None

    def sample(self, t: float, y: Array) -> None:
        """A sample, moved onto the constraints."""
        self.t.append(t)
        self.rows.append(self.stepper.sample(t, y))

    def noted(self, log: Array, jumps: Array, sample_to: Callable[[float], None]) -> None:
        """What a kernel has noted: events (t, which one), and where they ended or changed the motion.

        Rows of `jumps` are t, up to which `sample_to` samples it, how many events were noted by then, the states before and after.
        """
        met, done = [(self.stepper.eom.events[int(k)], float(t)) for t, k in log], 0
        self.events += met
        for t, count, *states in jumps.tolist():
            before, after = np.array(states).reshape(2, -1)
            sample_to(t)
            if t > self.t[-1]:
                self.sample(t, before)
            by, done = tuple(event for event, _ in met[done : int(count)] if event.then is not None), int(count)
            if by:
                self.jumps.append((len(self.t), by, before))
                self.t.append(t)
                self.rows.append((after, self.stepper.eom))

    def end_of_span(self, *seen: Array) -> End:
        """The end of the span, where rounding alone may lead across thresholds: from quantities that were looked at to those there."""
        events, t = self.stepper.eom.events, self.span[1]
        near = SAME_TIME * (t - self.span[0]) + 4 * float(np.spacing(abs(t)))
        known = {event.name for event, at in self.events if at >= t - near}
        leapt = leapt_over(events, *(values[: len(events)] for values in seen)) if seen else []
        met = [(event, t) for event in leapt if event.name not in known]
        self.events += met
        return ended_by(up_to_a_break(met, 0.0)[1], met) or End("finished", f"reached t = {t:g}")

    def _sample_up_to(self, end: float, dense: Callable[[float], Array], ends: bool) -> None:
        """The samples before `end`, by the states along a step, and the one there if the motion ends there."""
        before = self.times[(self.times > self.t[-1]) & (self.times < end)]
        for t in [*before, *([end] if ends and end > self.t[-1] else [])]:
            self.sample(float(t), dense(float(t)))

    def stopped(self, message: str, at: tuple[float, Array] | None = None) -> End:
        """What there is up to a time and state, those of the solver where none are given, is the motion."""
        t, y = at or self.solver.at
        if t > self.t[-1] and np.all(np.isfinite(y)):
            self.sample(t, y)
        return End("stopped", message)

    def interrupted(self) -> End:
        """Ctrl-C ends it after the last step that was gone on from."""
        self.stopped("", self.solver.reached)
        return End("stopped", f"{MESSAGE}{self.t[-1]:.6g}")
