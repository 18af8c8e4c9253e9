# SPDX-License-Identifier: BSD-3-Clause
"""Integrators of SciPy and SUNDIALS as solvers of a motion (`course.Solver`): single steps, continued from the projected state."""

import warnings
from typing import Any

import numpy as np

from kane.dynamics.poles import KinematicsEnd
from kane.motion.broken import NESTED, broken_off, chattering
from kane.motion.course import Counts, Course, StepFound, StepVerdict, Verdict
from kane.motion.hybrid.events import PARTS, StepSeen, leapt, still_there, thresholds
from kane.motion.inputs.breakpoints import on_from, stretch
from kane.motion.inputs.expressions import controllers
from kane.motion.projection import Numbers
from kane.motion.right_hand_side import pattern
from kane.motion.solvers.cvode import CVODE, CvodeSolver
from kane.numeric.arrays import Array
from kane.numeric.polynomials import SHARES

STEPPED = "DOP853"
"""The method that "auto" chooses for a motion that does not run in machine code."""
IMPLICIT = "Radau"
"""The method that continues a motion whose equations are stiff."""
_ILLEGAL = -3
"""SciPy's code for illegal input. As the input has been checked, the solver's memory is that of another motion."""
_IMPLICIT = ("Radau", "BDF", "LSODA", CVODE)
"""Methods that use derivatives of the rates."""
_ONE_STEP = ("RK23", "RK45", "DOP853", "Radau")
"""One-step methods, which store only y and f, so that a projected state can replace theirs."""
_DRIFT = 10.0
"""Change by projection, in tolerances, at which the other solvers are restarted; their results are projected in any case."""
_NEAR_POLE = 0.25
"""Share of the largest absolute value of a pivot of W so far below which W may have a pole nearby."""


class SolverInPython:
    """A solver of SciPy or SUNDIALS that steps a course from t and y; each step is inspected."""

    by_itself = False

    def __init__(self, course: Course, name: str, t: float, y: Array) -> None:
        self.course, self.stepper, self.name, self._begun = course, course.stepper, name, (t, y)
        self.solver = self._made(t, y, course.method.first)
        self.watched = self.stepper.now.watch(t, y)
        self.largest = np.abs(self.watched)
        self.steps = 0
        self._spent = 0
        self.ahead = np.inf

    @property
    def at(self) -> tuple[float, Array]:
        """The time that the solver has reached, and the state there."""
        return float(self.solver.t), self.solver.y

    @property
    def reached(self) -> tuple[float, Array]:
        """The last accepted time and state."""
        states = self.course.pace.states
        return states[-1] if states else self._begun

    @property
    def counts(self) -> Counts:
        """The number of attempted steps, and of evaluations of the right-hand side, including those of replaced solvers."""
        return self.steps, self._spent + int(self.solver.nfev)

    def step(self, most: int) -> StepFound | str:
        """Take one step; returns it, or the reason why there is none."""
        solver, stepper, pace = self.solver, self.stepper, self.course.pace
        before, last = solver.t, solver.y.copy()
        pace.note(before, last)
        if told := pace.chatters(stepper.now, self.steps):
            return told
        failure = _step(solver)
        self.steps += 1
        if solver.status == "failed" or solver.t <= before or not np.all(np.isfinite(solver.y)):
            told = chattering(stepper.now, pace.states, pace.before)
            return broken_off(stepper, before, last, self.course.span, failure, told)
        return StepFound(before, solver.t, solver.dense_output(), last, solver.y)

    def singular(self, step: StepFound, numbers: Numbers | None, narrow: float) -> StepVerdict:
        """The verdict on a step: SHORTER if it crosses a singular state, or if a load switches and switches back in it."""
        stepper, h = self.stepper, step.end - step.t
        if (stepper.jumped(numbers) or stepper.crosses(step.dense, step.t, step.end)) and h > narrow:
            return StepVerdict(Verdict.SHORTER)
        within = self._leapt(step)
        if within is not None and within - step.t > narrow:
            return StepVerdict(Verdict.SHORTER, within - step.t)
        return StepVerdict(Verdict.TAKEN)

    def _leapt(self, step: StepFound) -> float | None:
        """The time at which a load switches, if it switches back within the step, which is then repeated up to there; else None."""
        now = self.stepper.now
        if now.switches is None:
            return None
        times = np.linspace(step.t, step.end, PARTS + 1)
        return leapt(now.switch, step.dense, times, now.switch(times, step.dense(times).T))

    def seen(self, step: StepFound, kept: Array) -> StepSeen:
        """The values of the event quantities along a step."""
        now = self.stepper.now
        times = step.t + (step.end - step.t) * np.array(SHARES)
        states = step.dense(times[1:]).T
        values = np.vstack([self.watched, now.watch(times[1:-1], states[:-1]), now.watch(step.end, kept)])
        self.largest = np.fmax(self.largest, np.abs(values).max(axis=0))
        return StepSeen(now, times, values, self.largest, self.course.span[0])

    def shorten(self, step: StepFound, length: float) -> None:
        """Repeats the step with a length, or with half of it, and then approaches its end, where it failed, by short steps."""
        self._restart(step.t, step.first, length or (step.end - step.t) / 2)
        if not length:
            self.ahead = step.end

    def avoid(self, step: StepFound, t: float) -> None:
        """Approaches the time t by short steps."""
        self._restart(step.t, step.first, (t - step.t) / 2)
        self.ahead = t

    def go_on(self, step: StepFound, kept: Array, numbers: Numbers | None) -> None:
        """Continues from the projected state, with other dependent speeds if necessary, by short steps before an obstacle ahead."""
        stepper, end, events, course = self.stepper, step.end, self.stepper.eom.events, self.course
        self.watched = stepper.now.watch(end, kept)
        course.fresh = still_there(course.fresh, events, self.watched - thresholds(events, self.largest))
        pivots = [k for k, e in enumerate(events) if isinstance(e, KinematicsEnd)]
        near = bool(np.any(np.abs(self.watched[pivots]) < _NEAR_POLE * self.largest[pivots]))
        changed = stepper.settle(end, kept, numbers, pole=near or self.ahead < np.inf)
        if changed:
            self.watched = stepper.now.watch(end, kept)
            had = {e.name: x for e, x in zip(events, self.largest, strict=True)}
            self.largest = np.fmax(np.abs(self.watched), [had.get(e.name, 0.0) for e in stepper.eom.events])
        if self.solver.status == "finished":  # at a breakpoint, beyond which rates may differ
            for held in controllers(stepper.now.drives):
                held.due(on_from(end), kept[: stepper.now.width])
            self._restart(on_from(end), kept)
        elif changed or not np.array_equal(kept, self.solver.y):
            self._take(kept, changed)
        self.ahead = self.ahead if end < self.ahead and not changed else np.inf
        if np.isfinite(self.ahead) and hasattr(self.solver, "h_abs"):
            self.solver.h_abs = min(self.solver.h_abs, (self.ahead - end) / 2)

    def _take(self, y: Array, changed: bool) -> None:
        """Replaces the solver's state by the projected one."""
        method = self.course.method
        if self.name in _ONE_STEP:
            self.solver.y = y
            self.solver.f = self.stepper.rate(self.solver.t, y)
            self._spent += 1
            return
        slack = _DRIFT * (method.atol + method.rtol * np.abs(y))
        if changed or not np.all(np.abs(y - self.solver.y) <= slack):
            self._restart(self.solver.t, y)

    def _restart(self, t: float, y: Array, first_step: float | None = None) -> None:
        self._spent += int(self.solver.nfev)
        self.solver = self._made(t, y, first_step)

    def _made(self, t: float, y: Array, first_step: float | None = None) -> Any:
        """The solver at a state, up to just before the next breakpoint, where rates may jump."""
        from scipy import integrate

        method, name = self.course.method, self.name
        t, end = stretch(method.breakpoints, t, self.course.span[1])
        first_step = first_step and min(first_step, end - t, method.max_step)
        more: dict[str, Any] = {"jac": self.stepper.slopes} if name in _IMPLICIT else {}
        if name == CVODE:
            more["pattern"] = pattern(self.stepper.now)
        made = CvodeSolver if name == CVODE else getattr(integrate, name)
        options = {"rtol": method.rtol, "atol": method.atol, "max_step": method.max_step, **more}
        return made(self.stepper.rate, t, y, end, first_step=first_step, **options)


def _step(solver: Any) -> str | None:
    """Take one step; returns an error message if it fails, else None."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            warnings.filterwarnings("ignore", message="lsoda", category=UserWarning)
            message: str | None = solver.step()
            return NESTED if _refused(solver) else message
    except (ValueError, np.linalg.LinAlgError) as error:  # the implicit methods' linear algebra on NaN
        return str(error)


def _refused(solver: Any) -> bool:
    """Whether LSODA found that its memory belongs to another motion."""
    integrator = getattr(getattr(solver, "_lsoda_solver", None), "_integrator", None)
    return getattr(integrator, "istate", 0) == _ILLEGAL
