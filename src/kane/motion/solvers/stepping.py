# SPDX-License-Identifier: BSD-3-Clause
"""The loop over a solver's steps: project, look for events on the solver's own interpolant, sample; and why there is no step.

A motion breaks off where a drive cannot hold its constraints any further, or where the equations are singular.
"""

import warnings
from collections.abc import Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from kane.dynamics.constraints.manifold import manifold
from kane.dynamics.poles import KinematicsEnd
from kane.expr.evaluation import free_symbols
from kane.expr.symbols import input_of, time
from kane.motion.course import Course, Method, chattering
from kane.motion.hybrid.events import PARTS, End, Fresh, Met, StepSeen, leapt
from kane.motion.inputs.breakpoints import next_end, on_from, told_apart
from kane.motion.inputs.expressions import controllers
from kane.motion.projection import Numbers
from kane.motion.solvers.cvode import CVODE, CvodeSolver
from kane.motion.start import nearly_singular
from kane.motion.steps import Stepper, share_of_rank
from kane.numeric.arrays import Array
from kane.numeric.polynomials import SHARES
from kane.numeric.scale import CLOSED_FULLY, CLOSED_NEARLY, LATER, POOR, SAME_TIME

STEPPED = "DOP853"
"""What "auto" is where a motion does not run in machine code."""
IMPLICIT = "Radau"
"""What leads on where equations are stiff."""
_ILLEGAL = -3
"""SciPy's code for illegal input. What it is given has been checked, so its memory is that of another motion."""
_NESTED = (
    "LSODA runs once at a time, and a function asked during the motion, of an input or an event, runs another LSODA: take another "
    "method for one of them, such as method='auto' here or 'DOP853' there. The motion ends"
)
_IMPLICIT = ("Radau", "BDF", "LSODA", CVODE)
"""Those that take derivatives of the rates."""
_ONE_STEP = ("RK23", "RK45", "DOP853", "Radau")
"""Solvers that remember nothing but y and f, so that a projected state can take the place of theirs."""
_DRIFT = 10.0
"""Change by projection, in tolerances, at which the other solvers are started anew; what they return is projected all the same."""
_NEAR_POLE = 0.25
"""Share of the size that a pivot of W has had below which W may have a pole nearby."""


class ScipyCourse(Course):
    """A motion that is stepped by one of SciPy's solvers, or SUNDIALS', and looked at after each step."""

    def __init__(
        self,
        stepper: Stepper,
        method: Method,
        span: tuple[float, float],
        start: Array,
        times: Array,
        fresh: Fresh = MappingProxyType({}),
    ) -> None:
        super().__init__(stepper, method, span, start, times, fresh)
        self.solver = _solver(method, stepper, span[0], start, span[1], method.first)
        self.watched = stepper.now.watch(span[0], start)
        self.largest = np.abs(self.watched)
        self.steps = 0
        self._spent = 0
        self._jump = np.inf

    @property
    def evaluations(self) -> int:
        """Evaluations of the right-hand side, those of solvers that were given up too."""
        return self._spent + int(self.solver.nfev)

    def far(self) -> str:
        """How far the motion is, in words."""
        return f"t = {self.solver.t:.4g} of {self.span[1]:.4g} s"

    def beware(self, t: float) -> None:
        """A place lies ahead at t at which the equations that are stepped are singular."""
        self._jump = t

    @property
    def clear(self) -> bool:
        """Whether no place lies ahead at which constraints are singular, so far as was seen."""
        return bool(np.isinf(self._jump))

    def advance(self) -> End | None:
        """One step."""
        solver, stepper, span = self.solver, self.stepper, self.span
        if self.steps >= self.method.max_steps:
            return self._stopped(self.method.spent(solver.t))
        before, last = solver.t, solver.y.copy()
        self.pace.note(before, last)
        halted = self.pace.halts(stepper.now, self.steps)
        if halted:
            return self._stopped(halted)
        failure = _step(solver)
        self.steps += 1
        if solver.status == "failed" or solver.t <= before or not np.all(np.isfinite(solver.y)):
            told = chattering(stepper.now, self.pace)
            return self._stopped(broken_off(stepper, before, last, span, failure, told))
        dense = solver.dense_output()
        narrow, tolerances = SAME_TIME * max(abs(solver.t), span[1] - span[0]), (self.method.rtol, self.method.atol)
        bent = stepper.bent(dense, before, solver.t, tolerances)
        if bent is not None:  # closed in on from before, as no state beyond belongs to the motion
            ahead = bent.t - before
            self._restart(before, last, min(0.9 * ahead, (solver.t - before) / 2) if ahead > narrow else None)
            return self._stopped(bent.message) if ahead <= narrow else None
        kept, numbers = stepper.keep(solver.t, solver.y)
        turned = stepper.turned(numbers)
        missed = stepper.missed(solver.t, kept, numbers, tolerances)
        jumped = stepper.jumped(numbers) or stepper.crosses(dense, before, solver.t)
        if (turned or missed or jumped) and solver.t - before > narrow:
            # the place is closed in on by halves, until a state lies so near to it that `settle` sees it
            self._restart(before, last, (solver.t - before) / 2)
            self._jump = solver.t
            return None
        within = self._leapt(dense)
        if within is not None and within - before > narrow:
            self._restart(before, last, within - before)
            return None
        if turned:
            return self._stopped(f"another branch of the closures lies beyond t = {before:.6g}: {turned}")
        if missed:
            return self._stopped(not_held(stepper, before, last, span, missed))
        # what is met is read off the states that are gone on from: projection cannot hide it, nor make it be met twice
        after = stepper.now.watch(solver.t, kept)
        noted, end, at = self._met(dense, after)
        if at - before > narrow and self.passes(end, at, dense):
            self._restart(before, last, (at - before) / 2)
            self._jump = at
            return None
        self.events += noted
        at = solver.t if end is None else at
        if end is None and solver.t >= span[1]:
            end = End("finished", f"reached t = {span[1]:g}")
        self.sample_up_to(at, dense, end is not None)
        if end is None:
            self.watched = after
            self.leave(after, self.largest)
            self._go_on(kept, numbers)
        return end

    def _stopped(self, message: str) -> End:
        return self.stopped(message, float(self.solver.t), self.solver.y)

    def interrupted(self) -> End:
        """It ends after the last step that was looked at whole."""
        return self.broken(*(self.pace.states[-1] if self.pace.states else (self.span[0], self.rows[0][0])))

    def _leapt(self, dense: Any) -> float | None:
        """When a load switches there and back within the step, if it does: the step is taken again, up to there."""
        now = self.stepper.now
        if now.switches is None:
            return None
        times = np.linspace(self.solver.t_old, self.solver.t, PARTS + 1)
        return leapt(now.switch, dense, times, now.switch_all(times, dense(times).T))

    def _met(self, dense: Any, after: Array) -> tuple[Sequence[Met], End | None, float]:
        """The events of a step, up to one that ends the motion, and when."""
        now = self.stepper.now
        if not self.stepper.eom.events:
            return (), None, self.solver.t_old
        times = self.solver.t_old + (self.solver.t - self.solver.t_old) * np.array(SHARES)
        states = dense(times[1:]).T
        values = np.vstack([self.watched, now.watch_all(times[1:-1], states[:-1]), after])
        self.largest = np.fmax(self.largest, np.abs(values).max(axis=0))
        return self.meets(now, dense, StepSeen(times, values), self.largest)

    def _go_on(self, kept: Array, numbers: Numbers | None) -> None:
        """From the projected state, with other dependent speeds where they are needed; gently where a jump was seen ahead."""
        end, events = self.solver.t, self.stepper.eom.events
        pivots = [k for k, e in enumerate(events) if isinstance(e, KinematicsEnd)]
        near = bool(np.any(np.abs(self.watched[pivots]) < _NEAR_POLE * self.largest[pivots]))
        changed = self.stepper.settle(end, kept, numbers, pole=near or not self.clear)
        if changed:
            self.watched = self.stepper.now.watch(end, kept)
            had = {e.name: x for e, x in zip(events, self.largest, strict=True)}
            self.largest = np.fmax(np.abs(self.watched), [had.get(e.name, 0.0) for e in self.stepper.eom.events])
        if self.solver.status == "finished":  # at a breakpoint, beyond which rates may be others
            for held in controllers(self.stepper.now.drives):
                held.due(on_from(end), kept[: self.stepper.now.width])
            self._restart(on_from(end), kept)
        elif changed or not np.array_equal(kept, self.solver.y):
            self._take(kept, changed)
        self._jump = self._jump if end < self._jump and not changed else np.inf
        if np.isfinite(self._jump) and hasattr(self.solver, "h_abs"):
            self.solver.h_abs = min(self.solver.h_abs, (self._jump - end) / 2)

    def _take(self, y: Array, changed: bool) -> None:
        """The projected state in the place of the solver's."""
        if self.method.name in _ONE_STEP:
            self.solver.y = y
            self.solver.f = self.stepper.rate(self.solver.t, y)
            self._spent += 1
            return
        slack = _DRIFT * (self.method.atol + self.method.rtol * np.abs(y))
        if changed or not np.all(np.abs(y - self.solver.y) <= slack):
            self._restart(self.solver.t, y)

    def _restart(self, t: float, y: Array, first_step: float | None = None) -> None:
        self._spent += int(self.solver.nfev)
        self.solver = _solver(self.method, self.stepper, t, y, self.span[1], first_step)


def _step(solver: Any) -> str | None:
    """One step; what went wrong, if anything."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            warnings.filterwarnings("ignore", message="lsoda", category=UserWarning)
            message: str | None = solver.step()
            return _NESTED if _refused(solver) else message
    except (ValueError, np.linalg.LinAlgError) as error:  # the implicit methods' linear algebra on NaN
        return str(error)


def _refused(solver: Any) -> bool:
    """Whether LSODA found its own memory to be of another motion."""
    integrator = getattr(getattr(solver, "_lsoda_solver", None), "_integrator", None)
    return getattr(integrator, "istate", 0) == _ILLEGAL


def broken_off(stepper: Stepper, t: float, y: Array, span: tuple[float, float], failure: str | None, told: str) -> str:
    """Why there is no step from y at t; `failure` is what the solver said, `told` which load stands at a switch."""
    if failure == _NESTED:
        return f"{failure} at t = {t:.6g}"
    if told:
        return f"the motion does not get on beyond t = {t:.6g} ({failure or 'no progress'}): {told}"
    coarse = told_apart(t, span)
    if coarse:
        return f"no step is short enough at t = {t:.17g}: {coarse}"
    return _locked(stepper, t, y, t + LATER * (span[1] - span[0])) or (
        f"the right-hand side is singular or not finite near t = {t:.6g} ({failure or 'no progress'})"
        f"{nearly_singular(stepper.eom, stepper.now.values(t, y))}"
    )


def not_held(stepper: Stepper, t: float, y: Array, span: tuple[float, float], missed: str) -> str:
    """Why constraints hold up to y at t and not beyond, where one of them is `missed`."""
    return _locked(stepper, t, y, t + LATER * (span[1] - span[0])) or (
        f"the constraints cannot be kept beyond t = {t:.6g}: {missed} there, more than the tolerances leave open. They contradict "
        "each other from there on, or those that were redundant before hold something else: leave one out, or correct it"
    )


def _locked(stepper: Stepper, t: float, y: Array, later: float) -> str:
    """Which constraint a drive cannot hold beyond t, as no configuration near y closes it at `later`; "" without that evidence."""
    eom = stepper.eom
    driving = free_symbols(c.expr for c in eom.system.holonomic)
    if not any(s is time or input_of(s) is not None for s in driving):
        return ""
    kept, numbers = stepper.keep(t, y)
    if numbers is None or not all(np.all(np.isfinite(v)) for v in (numbers.a, numbers.f)):
        return ""
    least = share_of_rank(numbers.a, len(eom.dependent_speeds), stepper.reach, stepper.mixes[1])
    constraints, moving = manifold(eom.system), set(eom.coordinates)
    rest = {s: v for s, v in stepper.now.values(later, kept).items() if s not in moving}
    level = constraints.at(rest)
    nearest = level.closest(kept[: len(moving)], CLOSED_FULLY)
    left = level.shares(nearest.residual)
    if not (least < POOR and CLOSED_NEARLY < left.max(initial=0) < np.inf):
        return ""
    worst = int(np.argmax(left))
    return (
        f"{constraints.names[worst]!r} cannot be held beyond t = {t:.6g}, where the constraints lose rank (least singular value "
        f"{least:.1e} of the largest): at t = {later:.6g} {nearest.residual[worst]:.2g} is left of it in the nearest "
        "configuration. The drive carries the parts further than they reach: end before, drive them another way, or correct the "
        "lengths"
    )


def _solver(method: Method, stepper: Stepper, t: float, y: Array, end: float, first_step: float | None = None) -> Any:
    """The solver at a state, up to just before the next of the breakpoints, as rates may jump there."""
    from scipy import integrate

    end = next_end(method.breakpoints, t, end)
    first_step = first_step and min(first_step, end - t, method.max_step)
    more: dict[str, Any] = {"jac": stepper.slopes} if method.name in _IMPLICIT else {}
    if method.name == CVODE:
        more["pattern"] = stepper.pattern()
    return (CvodeSolver if method.name == CVODE else getattr(integrate, method.name))(
        stepper.rate,
        t,
        y,
        end,
        first_step=first_step,
        rtol=method.rtol,
        atol=method.atol,
        max_step=method.max_step,
        **more,
    )
