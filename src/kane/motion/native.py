# SPDX-License-Identifier: BSD-3-Clause
"""The solver in machine code: the kernel of an integrator takes up to a thousand steps a call, and Python handles its returns."""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import replace
from itertools import repeat

import numpy as np

from kane.expr.node import ZERO
from kane.model.declarations import Event
from kane.motion.arguments import Arguments
from kane.motion.broken import chattering, no_step, standing
from kane.motion.constraint_kernels import KernelConstraints
from kane.motion.course import HELD, RECENT, Came, Counts, Course, Method, StepFound, StepVerdict
from kane.motion.hybrid.automaton import ended_by_last, leaving, on_their_sides
from kane.motion.hybrid.events import StepSeen
from kane.motion.inputs.breakpoints import on_from, stretch
from kane.motion.inputs.expressions import SampleAndHold, controllers
from kane.motion.methods import implicit, kernel_of
from kane.motion.projection import Numbers
from kane.motion.right_hand_side import Given, Routines, exact, switches
from kane.motion.solvers.stepping import STEPPED
from kane.motion.steppers.context import SIZE, ReturnCode, Slot
from kane.motion.steppers.held import POORER
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.steppers.watched import ROOM
from kane.motion.steps import unheld
from kane.numeric.arrays import Array
from kane.numeric.polynomials import DEGREE as PARTS
from kane.numeric.polynomials import SHARES
from kane.numeric.scale import EPS
from kane.program.native.entry import entry
from kane.progress import is_noted

_PACE = (Slot.STEPS, Slot.SMOOTH, Slot.LIMITED)
_MANY, _SMOOTH, _LIMITED = 100, 0.5, 0.2
"""Least number of steps between tests for stiffness, which has set in if these shares of them are smooth, and limited by stability."""
_SOON = 25
"""Steps of an implicit method between tests whether it is still needed, at first and while it seems not to be."""
LOOKS = 1000
"""Largest number of steps in one call of a kernel."""
_CALM = 1.0
"""h ρ(J) below which it is not needed."""
_TWICE, _DOUBTED = 2, 4
"""Number of successive tests with this result after which the explicit method resumes; its factor each time thereafter."""


class Stiffness:
    """The detection of stiffness with method "auto", from the steps taken; `left` is the method that an implicit one has replaced."""

    def __init__(self, breakpoints: bool) -> None:
        self.left, self.breakpoints = "", breakpoints
        self._seen = np.zeros(len(_PACE))
        self._wait, self._calm, self._needed = _SOON, 0, _TWICE

    @property
    def limit(self) -> int:
        """Number of steps until the next test; smaller with breakpoints, beyond which equations may differ."""
        return self._wait if self.left else _MANY if self.breakpoints else LOOKS

    def sets_in(self, s: Array) -> bool:
        """Whether the steps since the last test were limited by stability alone."""
        if self.left or s[Slot.STEPS] - self._seen[0] < _MANY:
            return False
        steps, smooth, limited = (s[at] - seen for at, seen in zip(_PACE, self._seen, strict=True))
        self._seen = s[[*_PACE]]
        return bool(limited >= _LIMITED * steps and smooth >= _SMOOTH * steps)

    def leaves(self, method: str) -> None:
        """Records that an implicit method replaces `method`."""
        self.left, self._wait, self._calm = method, _SOON, 0

    def is_over(self, now: Routines, t: float, y: Array, length: float) -> bool:
        """Whether steps of the implicit method, of this length at y, would have been stable in the explicit one in enough tests."""
        fastest = np.abs(np.linalg.eigvals(exact(now)(t, y))).max(initial=0.0)
        calm = length * fastest < _CALM
        self._calm = self._calm + 1 if calm else 0
        self._wait = _SOON if calm else min(2 * self._wait, LOOKS)
        return self._calm >= self._needed

    def comes_back(self, s: Array) -> str:
        """The explicit method, which resumes; the next return will need more tests."""
        method, self.left, self._needed = self.left, "", _DOUBTED * self._needed
        self._seen = s[[*_PACE]]
        return method


def pauses(breakpoints: Sequence[float], span: tuple[float, float], controllers: Sequence[SampleAndHold]) -> Array:
    """For each of k breakpoints in a span: the time just after it, the end of steps from there, whether a controller acts (3 k)."""
    found, instants = list[float](), {t for one in controllers for t in one.instants(span[1])}
    _, end = stretch(breakpoints, *span)
    while end < span[1]:
        before, (begin, until) = end, stretch(breakpoints, on_from(end), span[1])
        asks = not instants.isdisjoint(breakpoints[bisect_left(breakpoints, before) : bisect_right(breakpoints, begin)])
        end = until
        found += [begin, end, float(asks)]
    return np.array(found)


def first_slots(method: Method, span: tuple[float, float], t: float, end: float) -> tuple[float, ...]:
    """The slots up to `Slot.FRESH` for a kernel that integrates from t to `end`, in a motion over `span`."""
    first = method.first if t == span[0] else None
    length = method.max_step if INTEGRATORS[method.name].fixed else min(first or 0.0, end - t)
    # near t = 0, where the spacing of times is small, the shortest step is EPS² of the span
    return t, 0.0, length, end, method.max_step, method.rtol, method.atol, EPS**2 * (span[1] - span[0]), 1.0


class KernelSolver:
    """The kernel that integrates a course from y at t; it accepts steps by itself unless they need a check in Python."""

    by_itself = True
    ahead = np.inf

    def __init__(self, course: Course, t: float, y: Array) -> None:
        self.course, self.stepper, self.span = course, course.stepper, course.span
        self.times = np.append(course.times[course.times > t], np.inf)
        self.s = np.zeros(SIZE)
        self.s[Slot.SPAN], self.s[Slot.PHASE] = self.span[1] - self.span[0], self.span[0]
        self.s[Slot.SINCE] = course.since  # limits the first step to a few such intervals
        self.y, self.out = y.copy(), np.empty((len(self.times) - 1, len(y)))
        self.marks = np.zeros(len(self.times))
        self.stiffness = Stiffness(bool(course.method.breakpoints))
        self.cursor, self.given = 0, Given()
        self.switching = bool(switches(self.stepper.eom, self.stepper.now.laws))
        self.controllers = controllers(self.stepper.now.drives)
        self._take_up(t)

    @property
    def method(self) -> str:
        """The name of the integrator."""
        return self.course.method.name

    @property
    def t(self) -> float:
        """The time up to which the motion is integrated."""
        return float(self.s[Slot.TIME])

    @property
    def at(self) -> tuple[float, Array]:
        """That time, and the state there."""
        return self.t, self.y.copy()

    @property
    def reached(self) -> tuple[float, Array]:
        """That time and state, after collecting the samples and events up to there."""
        self._collect()
        return self.at

    @property
    def counts(self) -> Counts:
        """Steps and evaluations of the right-hand side."""
        return int(self.s[Slot.STEPS]), int(self.s[Slot.RATES])

    def _take_up(self, t: float) -> None:
        """Binds the kernel of the present equations, to continue from the present state at t."""
        stepper = self.stepper
        self._note_fresh()
        now = on_their_sides(stepper.now)
        kernel = kernel_of(self.method, now, held=stepper.projection is not None)
        self.arguments = Arguments(self.method, now, t, self.s, self.y, self.course.fresh)
        self.now = self.arguments.now
        self.given = self.arguments.given | {"times": self.times, "rows": self.out, "samples": len(self.out)}
        self.holding = KernelConstraints(stepper, self.arguments, t, self.y) if stepper.projection else None
        if self.holding is not None:
            self.given |= self.holding.given | {"held_marks": self.marks}
            self.holding.begin(self.s)
        table = pauses(self.course.method.breakpoints, self.span, self.controllers)
        hook = self.arguments.hooks.add(self._control) if self.controllers else entry(self.now.rates)
        self.given |= {"breakpoints": len(table) // 3, "pauses": np.append(table, 0.0), "control": hook}
        self.kernel = kernel.bound(self.given | {"limit": 0})
        self.looked, self.s[Slot.LOOKED] = False, 0.0
        self._begin(t)

    def _begin(self, t: float) -> None:
        """Sets the slots to integrate from t to just before the next breakpoint, where rates may jump."""
        t, end = stretch(self.course.method.breakpoints, t, self.span[1])
        self._control(t)
        self.s[: Slot.FRESH + 1] = first_slots(self.course.method, self.span, t, end)
        self.s[Slot.BREAKPOINT] = np.searchsorted(self.given["pauses"][:-1:3], t, side="right")
        self.s[Slot.SIDED] = self.s[Slot.TURNING] = 0.0

    def _control(self, t: float, x: int = 0, out: int = 0) -> None:
        """Evaluates the sampled controllers that are due."""
        for one in self.controllers:
            one.due(t, self.y[: self.now.width])
        self.arguments.hold()
        self.s[Slot.STOPPED] = float(is_noted())

    def step(self, most: int) -> Came:
        """Takes up to `most` steps, until one needs a check."""
        limit = min(1 if self.looked else self.stiffness.limit, most)
        before, done = self.t, self.s[Slot.STEPS]
        back = ReturnCode(self.kernel(limit=min(limit, RECENT) if self.switching else limit))
        return self._after(back, before, done)

    def take_over(self, given: Given, stiffness: Stiffness) -> Came:
        """Continues from the arrays `given` of another kernel of the same equations, which returned at its limit of steps."""
        self.stiffness = stiffness
        for name, array in given.items():
            if isinstance(array, np.ndarray):
                self.given[name][:] = array
        return self._after(ReturnCode.LIMIT, self.span[0], 0.0)

    def _after(self, back: ReturnCode, before: float, done: float) -> Came:
        """Handles the return code `back` of a call that began at time `before`, after `done` steps."""
        self.arguments.check()
        self._collect()
        if back is ReturnCode.EVENT:
            return ended_by_last(self.course.events)
        if back is ReturnCode.FULL:
            return None
        over = back is ReturnCode.END and self.s[Slot.END] >= self.span[1]
        if back is not ReturnCode.END and (self._stiff() or self._eased(back, before, done)):
            return None
        if back in (ReturnCode.STANDS, ReturnCode.RESTS):
            return self._turning(back)
        if back is ReturnCode.LOOK:
            return self._step_for_python()
        changed = self.looked and self._settled()
        told = self._stalled(back, before)
        if told:
            return told
        if back in (ReturnCode.UNDERFLOW, ReturnCode.NOT_FINITE):
            if self.holding is None:
                fixed = self.course.method.max_step if INTEGRATORS[self.method].fixed else None
                return no_step(back, fixed, self.stepper, self.s, self.y, self.span)
            self._hand_over(self.t)
            return None
        if over:
            if self.course.t[-1] < self.span[1]:
                self.course.sample(self.span[1], self.y.copy())
            seen = [] if self.now.events is None else [self.given["seen"], self.now.watch(self.span[1], self.y)]
            return self.course.end_of_span(*seen)
        self._lead_on(back, changed)
        return None

    def _lead_on(self, back: ReturnCode, changed: bool) -> None:
        """Continues with other equations if dependent speeds or rank have `changed`, or beyond a breakpoint."""
        t = on_from(float(self.s[Slot.END])) if back is ReturnCode.END else float(self.s[Slot.TIME])
        if changed and unheld(self.stepper):
            self._hand_over(t)
            return
        if changed:
            self._take_up(t)
        elif back is ReturnCode.END:
            self._begin(t)
        if back is ReturnCode.END:  # stiffness detected up to a breakpoint counts beyond it
            self._stiff()

    def _stiff(self) -> bool:
        """Whether the steps of "auto" are limited by stability alone; then changes to an implicit method."""
        if not self.course.method.free or not self.stiffness.sets_in(self.s) or self.s[Slot.TIME] >= self.span[1]:
            return False
        name = implicit(self.stepper, self.stepper.now.drives)
        own, of_scipy = name in INTEGRATORS, f"SciPy's {name}"
        told = f"steps of {self.method} were limited by stability, not accuracy; {name if own else of_scipy} continues"
        self._told("the equations are stiff", told)
        if own:
            self.stiffness.leaves(self.method)
            self._go_over(self.t, name)
        else:
            self._hand_over(self.t, name, for_good=True)
        return True

    def _eased(self, back: ReturnCode, before: float, done: float) -> bool:
        """Whether the implicit method chosen by `_stiff` is no longer needed; then changes back to the explicit one."""
        t, steps = float(self.s[Slot.TIME]), self.s[Slot.STEPS] - done
        if not self.stiffness.left or back is not ReturnCode.LIMIT or self.looked or steps < 1:
            return False
        if not self.stiffness.is_over(self.now, t, self.y, (t - before) / steps):
            return False
        name = self.stiffness.comes_back(self.s)
        self._told(
            "the equations are stiff no more", f"steps of {self.method} are short enough for {name}, which continues"
        )
        self._go_over(t, name)
        return True

    def _told(self, name: str, message: str) -> None:
        self.stepper.changes.append((Event(name, ZERO, terminal=False, message=message), float(self.s[Slot.TIME])))

    def _go_over(self, t: float, name: str) -> None:
        """Continues with another method in machine code."""
        self.course.method = replace(self.course.method, name=name, first=None)
        self.course.names[name] = None
        self._take_up(t)

    def _stalled(self, back: ReturnCode, before: float) -> str:
        """A message if the motion stalls at a switch of a load, else ""."""
        t = float(self.s[Slot.TIME])
        if not self.switching or back is ReturnCode.LOOK:
            return ""
        self.course.pace.note(t, self.y.copy())
        held = back is ReturnCode.LIMIT and t - before < HELD * (self.span[1] - self.span[0])
        told = (
            chattering(self.stepper.now, self.course.pace.states, self.course.pace.before)
            if held or back in (ReturnCode.UNDERFLOW, ReturnCode.NOT_FINITE)
            else ""
        )
        return f"the motion makes no progress beyond t = {t:.6g}: {told}" if told else ""

    def _collect(self) -> None:
        """Collects the samples, changes of dependent speeds, and events with their actions that the kernel has logged."""
        for t, now in self.holding.changes() if self.holding is not None else ():
            self._sample_to(t)
            self.stepper.go_over(now, t)
        if self.now.events is not None:
            s, own, width = self.s, self.stepper.now.p, 2 * len(self.y) + 2
            log, jumps = self.given["log"].reshape(-1, 2), self.given["jumps"].reshape(-1, width)
            self.course.noted(log[: int(s[Slot.LOGGED])], jumps[: int(s[Slot.JUMPS])], self._sample_to)
            own[:] = self.given["p"][: len(own)]
            s[Slot.LOGGED] = s[Slot.JUMPS] = 0.0
        self._sample_to(math.inf)

    def _note_fresh(self) -> None:
        """Passes the kernel's record of events at whose thresholds the motion is to the course."""
        if "leaves" in self.given:
            self.course.fresh = leaving(self.given, self.arguments.now.eom.events)

    def _sample_to(self, end: float) -> None:
        """Adds the kernel's samples before a time to the course; those marked as near a doubtful state are projected again."""
        course, times = self.course, self.times[self.cursor : int(self.s[Slot.SAMPLE])]
        last = self.cursor + int(np.searchsorted(times, end))
        first = self.cursor + int(np.searchsorted(times, course.t[-1], side="right"))  # beyond the instant of an event
        self.cursor = last
        if first >= last:
            return
        if not self.marks[first:last].any():
            course.t += self.times[first:last].tolist()
            course.rows += zip(self.out[first:last], repeat(self.stepper.eom), strict=False)
            return
        for k in range(first, last):
            t, y = float(self.times[k]), self.out[k].copy()
            if self.marks[k]:
                course.sample(t, y)
            else:
                course.t.append(t)
                course.rows.append((y, self.stepper.eom))

    # ------------------------------------------------------------------------------------------------ steps to be checked

    def _step_for_python(self) -> StepFound | None:
        """The kernel's next step, whose constraints or events are to be checked; None if a missing choice of speeds was the cause."""
        s, holding = self.s, self.holding
        held = bool(s[Slot.HELD]) and not s[Slot.LOOKED]
        if held and holding is not None:
            if holding.completes(ReturnCode.LOOK, s):
                return None
            holding.measure()
        along = INTEGRATORS[self.method].dense
        assert along is not None
        start, h = self.t, self._next()
        states = along(self.given, h, start)

        def dense(t: float | Array) -> Array:
            found = states(np.atleast_1d(t))
            return found.T if np.ndim(t) else found[0]

        return StepFound(start, start + h, dense, self.y.copy(), dense(start + h), held, not held)

    def singular(self, step: StepFound, numbers: Numbers | None, narrow: float) -> StepVerdict:
        """The verdict on a step in which constraints may be singular, or dependent speeds poorly determined."""
        assert self.holding is not None
        assert numbers is not None
        return self.holding.singular(step.dense, step.t, step.end, narrow, numbers)

    def seen(self, step: StepFound, kept: Array) -> StepSeen:
        """The quantities of events along a step, by the kernel's values at both ends."""
        self._note_fresh()
        times = step.t + self._next() * np.array(SHARES)
        states = step.dense(times[1:]).T
        if self.holding is not None:
            end_of, n = INTEGRATORS[self.method].end, len(self.y)
            assert end_of is not None
            states[-1] = self.given["work"][end_of(n) : end_of(n) + n]
        count, own = int(self.given["events"]), len(self.stepper.eom.events)
        values = np.vstack([self.given["seen"][:count], self.now.watch(times[1:], states)])
        # at the end the kernel's values, with which it begins the next step: rounding must not hide a crossing
        values[-1] = self.given["values"][ROOM:][: PARTS * count].reshape(count, PARTS)[:, -1]
        largest = np.fmax(self.given["largest"][:count], np.abs(values).max(axis=0))
        return StepSeen(self.now, times, values[:, :own], largest[:own], float(self.s[Slot.PHASE]))

    def shorten(self, step: StepFound, length: float) -> None:
        """Repeats the step with this length, or if it is 0 with half its length."""
        self.looked, self.s[Slot.LOOKED] = False, 0.0
        self.s[Slot.STEP] = length or self._next() / 2

    def avoid(self, step: StepFound, t: float) -> None:
        """Lets SciPy's solver integrate past the singularity at t."""
        if step.held:
            self.looked, self.s[Slot.LOOKED] = False, 0.0
        self._hand_over(step.t)
        self.course.solver.ahead = t

    def go_on(self, step: StepFound, kept: Array, numbers: Numbers | None) -> None:
        """Lets the kernel take the step without the check that Python has made."""
        self.looked, self.s[Slot.LOOKED] = (True, 1.0) if step.held else (self.looked, 2.0)

    def _turning(self, back: ReturnCode) -> str | None:
        """No side of a switch leads on: stops, or at the start, or if its quantity stays zero, changes to SciPy's solver for good."""
        if back is ReturnCode.STANDS and self.t > self.span[0]:
            which = self.now.quantities[int(self.s[Slot.WORST]) - len(self.stepper.eom.events)]
            return f"the motion makes no progress beyond t = {self.t:.6g}: {standing(self.stepper.now, [which])}"
        self._hand_over(self.t, for_good=True)
        return None

    def _settled(self) -> bool:
        """After a step checked in Python: projects the state, and returns whether dependent speeds or rank have changed there."""
        t, self.looked = float(self.s[Slot.TIME]), False
        kept, numbers = self.stepper.keep(t, self.y)
        if self.s[Slot.HELD] > POORER:  # otherwise the kernel has projected it
            self.given["lag"][kept != self.y] = 0.0
            self.y[:] = kept
        return self.stepper.settle(t, self.y, numbers)

    def _hand_over(self, t: float, name: str = STEPPED, for_good: bool = False) -> None:
        """Continues with a solver of SciPy, `for_good` or until constraints are regular again."""
        self._note_fresh()
        self.course.method = replace(self.course.method, first=None)
        self.course.hand_over(t, self.y.copy(), name, None if for_good else self._resumed)

    def _resumed(self, t: float, y: Array) -> "KernelSolver":
        """Resumes the kernel; its record of events at their thresholds is outdated, that of the course counts."""
        self.y[:] = y
        self.given.pop("leaves", None)
        self._take_up(t)
        self.cursor = int(np.searchsorted(self.times, t, side="right"))
        self.s[Slot.SAMPLE] = self.cursor
        return self

    def _next(self) -> float:
        """The length of the step that is checked."""
        s = self.s
        shortest = s[Slot.SHORTEST] + 10 * EPS * abs(s[Slot.TIME])
        # `start + h` of a step up to END may round to a time before END
        left = s[Slot.END] - s[Slot.TIME] - s[Slot.TIME_LAG]
        return float(min(max(s[Slot.STEP], shortest), s[Slot.LONGEST], left))
