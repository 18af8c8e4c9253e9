# SPDX-License-Identifier: BSD-3-Clause
"""SciPy's solvers, and SUNDIALS', as what steps a course: a step at a time, and on from the state on its constraints."""

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
"""What "auto" is where a motion does not run in machine code."""
IMPLICIT = "Radau"
"""What leads on where equations are stiff."""
_ILLEGAL = -3
"""SciPy's code for illegal input. What it is given has been checked, so its memory is that of another motion."""
_IMPLICIT = ("Radau", "BDF", "LSODA", CVODE)
"""Those that take derivatives of the rates."""
_ONE_STEP = ("RK23", "RK45", "DOP853", "Radau")
"""Solvers that remember nothing but y and f, so that a projected state can take the place of theirs."""
_DRIFT = 10.0
"""Change by projection, in tolerances, at which the other solvers are started anew; what they return is projected all the same."""
_NEAR_POLE = 0.25
"""Share of the size that a pivot of W has had below which W may have a pole nearby."""


class SolverInPython:
    """One of SciPy's solvers, or SUNDIALS', which steps a course from t and y; each step is looked at."""

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
        """Up to when the motion is stepped, and the state there."""
        return float(self.solver.t), self.solver.y

    @property
    def reached(self) -> tuple[float, Array]:
        """The last time and state that were gone on from."""
        states = self.course.pace.states
        return states[-1] if states else self._begun

    @property
    def counts(self) -> Counts:
        """Steps that were tried, and evaluations of the right-hand side, those of solvers that were given up too."""
        return self.steps, self._spent + int(self.solver.nfev)

    def step(self, most: int) -> StepFound | str:
        """One step, or why there is none."""
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
        """Whether a step leads across a singular state, which is closed in on, or where a load switches there and back."""
        stepper, h = self.stepper, step.end - step.t
        if (stepper.jumped(numbers) or stepper.crosses(step.dense, step.t, step.end)) and h > narrow:
            return StepVerdict(Verdict.SHORTER)
        within = self._leapt(step)
        if within is not None and within - step.t > narrow:
            return StepVerdict(Verdict.SHORTER, within - step.t)
        return StepVerdict(Verdict.TAKEN)

    def _leapt(self, step: StepFound) -> float | None:
        """When a load switches there and back within the step, if it does: the step is taken again, up to there."""
        now = self.stepper.now
        if now.switches is None:
            return None
        times = np.linspace(step.t, step.end, PARTS + 1)
        return leapt(now.switch, step.dense, times, now.switch_all(times, step.dense(times).T))

    def seen(self, step: StepFound, kept: Array) -> StepSeen:
        """What events see of a step."""
        now = self.stepper.now
        times = step.t + (step.end - step.t) * np.array(SHARES)
        states = step.dense(times[1:]).T
        values = np.vstack([self.watched, now.watch_all(times[1:-1], states[:-1]), now.watch(step.end, kept)])
        self.largest = np.fmax(self.largest, np.abs(values).max(axis=0))
        return StepSeen(now, times, values, self.largest, self.course.span[0])

    def shorten(self, step: StepFound, length: float) -> None:
        """The step is taken again; where it was too long by what lies at its end, gently up to there."""
        self._restart(step.t, step.first, length or (step.end - step.t) / 2)
        if not length:
            self.ahead = step.end

    def avoid(self, step: StepFound, t: float) -> None:
        """The place at t is closed in on."""
        self._restart(step.t, step.first, (t - step.t) / 2)
        self.ahead = t

    def go_on(self, step: StepFound, kept: Array, numbers: Numbers | None) -> None:
        """From the projected state, with other dependent speeds where they are needed; gently where a jump was seen ahead."""
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
        if self.solver.status == "finished":  # at a breakpoint, beyond which rates may be others
            for held in controllers(stepper.now.drives):
                held.due(on_from(end), kept[: stepper.now.width])
            self._restart(on_from(end), kept)
        elif changed or not np.array_equal(kept, self.solver.y):
            self._take(kept, changed)
        self.ahead = self.ahead if end < self.ahead and not changed else np.inf
        if np.isfinite(self.ahead) and hasattr(self.solver, "h_abs"):
            self.solver.h_abs = min(self.solver.h_abs, (self.ahead - end) / 2)

    def _take(self, y: Array, changed: bool) -> None:
        """The projected state in the place of the solver's."""
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
        """The solver at a state, up to just before the next of the breakpoints, as rates may jump there."""
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
    """One step; what went wrong, if anything."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            warnings.filterwarnings("ignore", message="lsoda", category=UserWarning)
            message: str | None = solver.step()
            return NESTED if _refused(solver) else message
    except (ValueError, np.linalg.LinAlgError) as error:  # the implicit methods' linear algebra on NaN
        return str(error)


def _refused(solver: Any) -> bool:
    """Whether LSODA found its own memory to be of another motion."""
    integrator = getattr(getattr(solver, "_lsoda_solver", None), "_integrator", None)
    return getattr(integrator, "istate", 0) == _ILLEGAL
