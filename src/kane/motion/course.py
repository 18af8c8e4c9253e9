# SPDX-License-Identifier: BSD-3-Clause
"""The integration of a motion over a span: a loop over the steps of a solver, with the same checks for all solvers.

A `Solver` is a kernel, which takes many steps by itself and returns those that it cannot decide (`native.py`), or a solver of SciPy or
SUNDIALS (`solvers/`). A `Course` checks whether the constraints of a step are satisfied and regular, and locates its events; it also
takes samples, limits the number of steps and the elapsed time, and changes from one solver to another.
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
from kane.progress import MESSAGE, is_noted


@dataclass(frozen=True, slots=True)
class Method:
    """An integration method by name, its tolerances, limits of steps and of elapsed time, breakpoints, and the `first` step (s).

    `bounded`: the user limited the number of steps, and slow progress does not stop the motion. `free`: the method is "auto", and may
    be replaced. `whole`: the limit of steps of the whole motion if this is for a part of it, else 0.
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
        """The method for the rest of a motion of which so many steps were taken."""
        return replace(self, max_steps=max(self.max_steps - steps, 0), whole=self.whole or self.max_steps)

    def spent(self, t: float) -> str:
        """The message if no step is left at t."""
        return f"{self.whole or self.max_steps} steps were not enough; at t = {t:.6g}"


RECENT = 200
"""Number of recent steps that are examined for chattering."""
HELD = 1e-5
"""Share of the span by which these steps must advance, or a switch that changes sides repeatedly is reported."""
MANY_STEPS, _LEAST = 10_000, 1e-4
"""A motion is stopped if so many steps advance by less than that share of the span."""


class Pace:
    """The progress of a motion: recent `states` (t, y), some earlier ones `before`, steps taken, and elapsed time."""

    def __init__(self, span: tuple[float, float], max_seconds: float, bounded: bool) -> None:
        self.length, self.end, self.bounded, self.max_seconds = span[1] - span[0], span[1], bounded, max_seconds
        self.begun = time.monotonic()
        self.states: deque[tuple[float, Array]] = deque(maxlen=RECENT + 1)
        self.before: list[tuple[float, Array]] = []
        self.noted = 0
        self.mark, self.marked = span[0], 0

    def note(self, t: float, y: Array) -> None:
        """Records an accepted state."""
        self.states.append((t, y))
        if self.noted % RECENT == 0 and len(self.before) < RECENT:
            self.before.append((t, y))
        self.noted += 1

    def anew(self, t: float, steps: int, first: tuple[float, Array]) -> None:
        """Restarts at t, after so many steps, for another solver; sizes at switches are compared with those at `first` (t, y) too."""
        self.length, self.mark, self.marked, self.noted = self.end - t, t, steps, 0
        self.states.clear()
        self.before = [first]

    def chatters(self, now: Routines, steps: int) -> str:
        """A message on a load that chatters at a switch in the states recorded by this number of steps; "" if there is none."""
        if steps % RECENT or len(self.states) <= RECENT:
            return ""
        t, since = self.states[-1][0], self.states[0][0]
        told = chattering(now, self.states, self.before) if t - since < HELD * self.length else ""
        return (
            f"the motion makes no progress beyond t = {t:.6g}, where {RECENT} steps advanced by {t - since:.1e} s: {told}"
            if told
            else ""
        )

    def late(self, t: float) -> str:
        """A message if the limit of elapsed time is exceeded, else ""."""
        if self.max_seconds < math.inf and time.monotonic() - self.begun > self.max_seconds:
            return f"max_seconds={self.max_seconds:g} have passed; at t = {t:.6g}"
        return ""

    def why(self, t: float) -> str:
        """The message of a motion that an `Interrupted` ended at t."""
        return ("" if is_noted() else self.late(t)) or f"{MESSAGE}{t:.6g}"

    def crawls(self, t: float, steps: int) -> str:
        """A message if many steps advanced by almost nothing, else ""; always "" if the user limited the number of steps."""
        if self.bounded or steps - self.marked < MANY_STEPS:
            return ""
        gained, self.mark, self.marked = t - self.mark, t, steps
        if gained >= _LEAST * self.length:
            return ""
        return (
            f"the motion makes too little progress: {MANY_STEPS} steps advanced from t = {t - gained:.6g} to {t:.6g}, "
            f'{gained / self.length:.1e} of the span. Choose method="Radau" if the equations are stiff, end the motion '
            "earlier, or give max_steps= to continue nevertheless"
        )


class Verdict(Enum):
    """The decision on an inspected step."""

    TAKEN = "taken"
    SHORTER = "taken again, shorter"
    SINGULAR = "left to SciPy's solver, which passes singular states"
    TURNED = "not taken: another branch of a closure lies there"
    MISSED = "not taken: a constraint does not hold there"
    BENT = "not taken: constraints require other positions or velocities there"


class StepVerdict(NamedTuple):
    """The verdict on a step, the length `t` of a shorter one (s; 0 if unspecified), and a message on what was found."""

    verdict: Verdict
    t: float = 0.0
    message: str = ""


class StepFound(NamedTuple):
    """A step from t to `end` that a solver proposes and has not accepted yet.

    `held`: its constraints are to be checked; `met`: its events are to be located. `dense` returns the state at a time (n), or states
    at times (n × k); `first` and `last` are the states at its ends.
    """

    t: float
    end: float
    dense: Callable[[Any], Array]
    first: Array
    last: Array
    held: bool = True
    met: bool = True


Came = StepFound | End | str | None
"""What a solver returns: a step to be checked, the end of the motion, a message why there is no step, or None if all was decided."""


Counts = tuple[int, int]


class Solver(Protocol):
    """An integrator of a motion. One that works `by_itself` takes samples, and accepts steps that need no check.

    `ahead` is the time of a singularity of the equations detected ahead of the motion, infinite if there is none.
    """

    by_itself: bool
    ahead: float

    @property
    def at(self) -> tuple[float, Array]:
        """The time up to which the motion is integrated, and the state there."""

    @property
    def reached(self) -> tuple[float, Array]:
        """The last accepted time and state."""

    @property
    def counts(self) -> Counts:
        """Steps tried or taken, and evaluations of the right-hand side; an evaluation of all stages at once counts as one."""

    def step(self, most: int) -> Came:
        """Takes a step, or up to `most` steps."""

    def singular(self, step: StepFound, numbers: Numbers | None, narrow: float) -> StepVerdict:
        """The verdict on a step that satisfies its constraints, in which these may be singular, or loads switch and switch back."""

    def seen(self, step: StepFound, kept: Array) -> StepSeen:
        """The quantities of events along a step that ends at the projected state `kept`."""

    def shorten(self, step: StepFound, length: float) -> None:
        """Rejects the step; the next one has this length, or if it is 0 half that of the step."""

    def avoid(self, step: StepFound, t: float) -> None:
        """Rejects the step because the equations are singular at t."""

    def go_on(self, step: StepFound, kept: Array, numbers: Numbers | None) -> None:
        """Accepts the step; the motion continues from the projected state `kept`."""


class Course:
    """The integration of a motion over `span`: call `advance()` until it returns an End.

    `t` and `rows` are the samples: times, and pairs of y and the equations valid there. `events` are pairs of an event and its time;
    `jumps` are, per phase, the index of its first sample, the events that caused it, and the state before. The motion begins at the
    thresholds of the events `fresh`. `made(course, method, t, y)` returns a solver; `since` is the time from the last action (s).
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
        # the start is already on the constraints: the sample must not change the sizes of A
        self.rows: list[tuple[Array, Equations]] = [(start.copy(), stepper.sample(span[0], start)[1])]
        stepper.reach = reach
        self.events: list[tuple[Event, float]] = []
        self.jumps: list[tuple[int, tuple[Event, ...], Array]] = []
        self.pace = Pace(span, method.max_seconds, method.bounded)
        self.pace.before.append((span[0], start.copy()))  # a reference for the sizes of quantities at switches
        self.names, self.counted = {method.name: None}, (0, 0)
        self.back: Callable[[float, Array], Solver] | None = None
        self.solver: Solver
        self.solver = self.first = made(self, method.name, span[0], start)

    @property
    def name(self) -> str:
        """The names of the methods that were used, in order."""
        return ", ".join(self.names)

    @property
    def counts(self) -> Counts:
        """Steps, and evaluations of the right-hand side, of all solvers so far."""
        both = (self.first,) if self.solver is self.first else (self.first, self.solver)
        steps, evaluations = zip(self.counted, *(s.counts for s in both), strict=True)
        return sum(steps), sum(evaluations)

    def far(self) -> str:
        """The progress as text."""
        return f"t = {self.solver.at[0]:.4g} of {self.span[1]:.4g} s"

    def advance(self) -> End | None:
        """Takes a step, or as many as the solver takes by itself; returns the End of the motion, or None."""
        solver, steps, t = self.solver, self.counts[0], self.solver.at[0]
        most = self.method.max_steps - steps
        if most <= 0:
            return self.stopped(self.method.spent(t))
        told = self.pace.late(t) or self.pace.crawls(t, steps)
        if told:
            return self.stopped(told)
        end = self.follow(solver.step(most))
        if end is None and self.back is not None and solver is self.solver:  # it has taken a step since it took over
            self._return(self.back)
        return end

    def follow(self, came: Came) -> End | None:
        """Processes what a solver returned; the End of the motion, or None."""
        if isinstance(came, StepFound):
            return self.judge(came)
        return self.stopped(came) if isinstance(came, str) else came

    def judge(self, step: StepFound) -> End | None:
        """Checks a proposed step; the End of the motion, or None.

        Events are located between projected states, so that projection neither hides an event nor repeats it.
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
            self.counted = self.counted[0] + solver.by_itself, self.counted[1]  # a solver in Python has counted it
        return end

    def _inspect(self, step: StepFound, narrow: float) -> tuple[StepVerdict, Array, Numbers | None]:
        """The verdict on the constraints of a step, with its projected end; steps up to `narrow` long are not shortened."""
        stepper, solver, h = self.stepper, self.solver, step.end - step.t
        tolerances = self.method.rtol, self.method.atol
        bent = stepper.bent(step.dense, step.t, step.end, tolerances)
        if bent is not None:  # approached from before, since states beyond are not of this motion
            ahead = bent.t - step.t
            shorter = StepVerdict(Verdict.SHORTER, min(0.9 * ahead, h / 2))
            return shorter if ahead > narrow else StepVerdict(Verdict.BENT, message=bent.message), step.last, None
        kept, numbers = stepper.keep(step.end, step.last)
        turned, missed = stepper.turned(numbers), stepper.missed(step.end, kept, numbers, tolerances)
        if (turned or missed) and h > narrow:
            # steps are halved until a state is near enough to the place for `settle` to detect it
            return StepVerdict(Verdict.SHORTER), kept, numbers
        if turned:
            return StepVerdict(Verdict.TURNED, message=turned), kept, numbers
        if missed:
            return StepVerdict(Verdict.MISSED, message=missed), kept, numbers
        return solver.singular(step, numbers, narrow), kept, numbers

    def _otherwise(self, step: StepFound, found: StepVerdict) -> End | None:
        """Rejects a step: it is repeated shorter or by another solver, or the motion ends."""
        if found.verdict is Verdict.SHORTER:
            self.solver.shorten(step, found.t)
            return None
        if found.verdict is Verdict.SINGULAR:
            self.solver.avoid(step, math.inf)
            return None
        if found.verdict is Verdict.BENT:
            return self.stopped(found.message, (step.t, step.first))
        if found.verdict is Verdict.TURNED:
            return self.stopped(f"the closures are on another branch beyond t = {step.t:.6g}: {found.message}")
        return self.stopped(constraint_failure(self.stepper, step.t, step.first, self.span, found.message))

    def _meets(self, step: StepFound, kept: Array) -> tuple[list[tuple[Event, float]], End | None, float]:
        """The events of a step, the End that they cause, and its time, or without one the beginning of the step."""
        noted, end = events_along(self.solver.seen(step, kept), step.dense, self.fresh, self.method.rtol, self.span[1])
        return noted, end, step.t if end is None else next(t for event, t in noted if event.breaks)

    def _passes(self, end: End, t: float, dense: Callable[[float], Array]) -> bool:
        """Whether the singularity of kinematics that ends a motion at t is absent with other dependent speeds."""
        return isinstance(end.event, KinematicsEnd) and self.stepper.regular(t, dense(t)) is not None

    def hand_over(self, t: float, y: Array, name: str, back: Callable[[float, Array], Solver] | None) -> None:
        """Continues with another solver; `back`, if given, resumes the present one where constraints are regular again."""
        self.pace.anew(t, self.counts[0], (self.t[0], self.rows[0][0]))
        self.solver, self.back = self.made(self, name, t, y), back
        self.names[name] = None

    def _return(self, back: Callable[[float, Array], Solver]) -> None:
        """Resumes the previous solver if the constraints are regular again."""
        solver, (t, y) = self.solver, self.solver.at
        if solver.ahead < math.inf or unheld(self.stepper) or not regular(self.stepper, self.stepper.keep(t, y)[1]):
            return
        steps, evaluations = solver.counts
        self.counted = self.counted[0] + steps, self.counted[1] + evaluations
        self.solver, self.back = back(t, y), None

    def sample(self, t: float, y: Array) -> None:
        """Adds a sample, projected onto the constraints."""
        self.t.append(t)
        self.rows.append(self.stepper.sample(t, y))

    def noted(self, log: Array, jumps: Array, sample_to: Callable[[float], None]) -> None:
        """Adds what a kernel has logged: events, rows (t, index), and the instants at which they ended or changed the motion.

        Rows of `jumps` are t, the number of events logged by then, the states before and after. `sample_to(t)` adds samples up to t.
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
        """The End at the end of the span. `seen`: event quantities when last examined and at the end; rounding may make them cross."""
        events, t = self.stepper.eom.events, self.span[1]
        near = SAME_TIME * (t - self.span[0]) + 4 * float(np.spacing(abs(t)))
        known = {event.name for event, at in self.events if at >= t - near}
        leapt = leapt_over(events, *(values[: len(events)] for values in seen)) if seen else []
        met = [(event, t) for event in leapt if event.name not in known]
        self.events += met
        return ended_by(up_to_a_break(met, 0.0)[1], met) or End("finished", f"reached t = {t:g}")

    def _sample_up_to(self, end: float, dense: Callable[[float], Array], ends: bool) -> None:
        """Adds the samples of a step before `end`, by its dense output, and one at `end` if the motion ends there."""
        before = self.times[(self.times > self.t[-1]) & (self.times < end)]
        for t in [*before, *([end] if ends and end > self.t[-1] else [])]:
            self.sample(float(t), dense(float(t)))

    def stopped(self, message: str, at: tuple[float, Array] | None = None) -> End:
        """Stops the motion at a time and state, by default those of the solver, with a message."""
        t, y = at or self.solver.at
        if t > self.t[-1] and np.all(np.isfinite(y)):
            self.sample(t, y)
        return End("stopped", message)

    def interrupted(self) -> End:
        """Stops the motion after Ctrl-C or a limit of time, at the last accepted step."""
        self.stopped("", self.solver.reached)
        return End("stopped", self.pace.why(self.t[-1]))
