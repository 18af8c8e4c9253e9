# SPDX-License-Identifier: BSD-3-Clause
"""Motions that run in machine code: an integrator's kernel takes a thousand steps at a time, Python looks at the clock between."""

from dataclasses import replace

import numpy as np

from kane.expr.node import as_expr
from kane.model.declarations import Event
from kane.motion.bounds import SHARES
from kane.motion.breakpoints import on_from, up_to
from kane.motion.chatter import Pace
from kane.motion.collocated import Given, after, by_kind, watching
from kane.motion.drives import constant
from kane.motion.formulas import Formula, driving
from kane.motion.holding import Holding, Verdict, regular, unheld
from kane.motion.interpolants import interpolant
from kane.motion.met import crossings, thresholds, vanishing
from kane.motion.singular_rates import nearly_singular
from kane.motion.steppers.outline import SIZE, At, Back
from kane.motion.steppers.table import INTEGRATORS, compiled
from kane.motion.stepping import NARROW, STEPPED, Course, End, Method, not_held
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.entry import Hook, aligned, entry, hoisted, wide_entry
from kane.program.native.machine import Settings

_AT_ONCE = 1000
"""Steps between two looks at the clock."""
_DOUBLINGS = 80


class NativeCourse:
    """A motion on its way over `span`, as `Course`, where nothing is left to Python between two steps (`methods.py`)."""

    def __init__(self, stepper: Stepper, method: Method, span: tuple[float, float], start: Array, times: Array) -> None:
        self.stepper, self.method, self.span = stepper, method, span
        self.t, self.rows = [span[0]], [stepper.sample(span[0], start)]
        self.events: list[tuple[Event, float]] = []
        self.pace = Pace(span, method.max_seconds, method.bounded)
        self.times = np.append(times[times > span[0]], np.inf)
        self.s = np.zeros(SIZE)
        self.y, self.out = start.copy(), np.empty((len(self.times) - 1, len(start)))
        self.marks = np.zeros(len(self.times))
        self.kernel = compiled(method.name, stepper.now.settings or Settings(), stepper.manifold is not None)
        self.hooks: list[Hook] = []
        self.stepped: Course | None = None
        self.passed = False
        self.handed = (0, 0)
        self._take_up(span[0])

    def _take_up(self, t: float) -> None:
        """From the state at hand on, by the equations that are stepped now."""
        self.hooks.clear()
        self.holding = Holding(self.stepper, t, self.y) if self.stepper.manifold else None
        self.given = self._given(t)
        if self.holding is not None:
            self.given |= (
                self.holding.given | {"held_marks": self.marks} | self._held_drive(self.holding.given["held_r"])
            )
            self.holding.begin(self.s)
        self.looked = False
        self._begin(t)

    def _given(self, t: float) -> Given:
        """What the kernel is called with."""
        now, y, integrator = self.stepper.now, self.y, INTEGRATORS[self.method.name]
        r, work = now.inputs(t), aligned(integrator.work(len(self.y)))
        h = hoisted(now.rates, t, y[: now.width], now.p, r)
        arrays: Given = {
            "s": self.s,
            "y": y,
            "lag": np.zeros_like(y),
            "work": work,
            "p": now.p.copy(),
            "h": h,
        }
        samples: Given = {"times": self.times, "rows": self.out, "samples": len(self.out)}
        given: Given = {"n": len(y), **arrays, **samples, **self._driving(t)}
        if integrator.width == 1:
            return {**given, "rhs": entry(now.rates)}
        wide: Given = {
            "rhs": wide_entry(now.rates, integrator.width),
            "r": np.repeat(np.append(r, 0.0), integrator.width),
        }
        return {**given, **wide, **by_kind(self.stepper.eom), **watching(self.stepper, t, y)}

    def _driving(self, t: float) -> Given:
        """r, and what gives it where an input is a function of time."""
        now, width = self.stepper.now, INTEGRATORS[self.method.name].width
        r = np.repeat(np.append(now.inputs(t), 0.0), width)
        if all(constant(f) is not None for f in now.drives):
            return {"r": r, "driven": 0, "hd": np.zeros(1), "drive": entry(now.rates)}
        given = self._formulas()
        if given is None:
            return {"r": r, "driven": 1, "hd": np.zeros(1), "drive": self._hook(r)}
        h = hoisted(given, t, self.y[: now.width], now.p, r[: len(now.drives)])
        return {"r": r, "driven": 1, "hd": h, "drive": entry(given) if width == 1 else wide_entry(given, width)}

    def _held_drive(self, r: Array) -> Given:
        """What gives the inputs at one state of the constraints."""
        given = self._formulas()
        if self.given["driven"] and given is None:
            return {"held_drive": self._hook(r)}
        return {"held_drive": entry(given or self.stepper.now.rates)}

    def _formulas(self) -> CompiledRoutine | None:
        """The inputs as a routine, where all are expressions."""
        now = self.stepper.now
        if not all(constant(f) is not None or isinstance(f, Formula) for f in now.drives):
            return None
        values = [f.expr if isinstance(f, Formula) else as_expr(constant(f)) for f in now.drives]
        return self.stepper.eom.numeric(now.settings).routine(driving, *values).flat

    def _hook(self, r: Array) -> Hook:
        """What asks Python for the inputs and writes them to r."""
        now = self.stepper.now

        def drive(t: float) -> None:
            r[:-1] = np.nan
            r[:-1] = now.inputs(min(t, float(self.s[At.END])))  # rounding may lead beyond the end

        self.hooks.append(Hook(drive))
        return self.hooks[-1]

    def _begin(self, t: float) -> None:
        """From t on, up to just before the next breakpoint, as rates may jump there."""
        ahead = [b for b in self.method.breakpoints if t < b < self.span[1]]
        end = up_to(min(ahead)) if ahead else self.span[1]
        told = {At.TIME: t, At.TIME_LAG: 0.0, At.END: end, At.LONGEST: self.method.max_step, At.FRESH: 1.0}
        told |= {At.RTOL: self.method.rtol, At.ATOL: self.method.atol, At.STEP: self._first_step(t, end)}
        # beside t = 0 the shortest step is as short as rounding of the span's square allows
        told |= {At.SHORTEST: np.finfo(float).eps ** 2 * (self.span[1] - self.span[0])}
        for place, value in told.items():
            self.s[place] = value

    def _first_step(self, t: float, end: float) -> float:
        """A step over which an Euler step and the change of rates are small: Hairer, Nørsett & Wanner, sec. II.4."""
        order = INTEGRATORS[self.method.name].order
        if INTEGRATORS[self.method.name].fixed:
            return self.method.max_step
        scale = self.method.atol + np.abs(self.y) * self.method.rtol
        rate = self.stepper.rate(t, self.y)
        size, speed = np.abs(self.y / scale).max(), np.abs(rate / scale).max()
        tried = min(0.01 * size / speed if min(size, speed) > 1e-5 else 1e-6, end - t)
        change = np.abs((self.stepper.rate(t + tried, self.y + tried * rate) - rate) / scale).max() / tried
        self.s[At.RATES] += 2
        most = max(speed, change)
        step = (0.01 / most) ** (1 / order) if most > 1e-15 else max(1e-6, tried * 1e-3)
        return float(min(100 * tried, step, end - t)) if np.isfinite(step) else tried

    @property
    def name(self) -> str:
        """The method, with SciPy's where that has led past a place."""
        return f"{self.method.name}, {STEPPED}" if self.passed else self.method.name

    @property
    def steps(self) -> int:
        """Steps so far."""
        return int(self.s[At.STEPS]) + self.handed[0] + (self.stepped.steps if self.stepped else 0)

    @property
    def evaluations(self) -> int:
        """Evaluations of the right-hand side; those of all stages at once are one."""
        return int(self.s[At.RATES]) + self.handed[1] + (self.stepped.evaluations if self.stepped else 0)

    def far(self) -> str:
        """How far the motion is, in words."""
        return self.stepped.far() if self.stepped else f"t = {self.s[At.TIME]:.4g} of {self.span[1]:.4g} s"

    def advance(self) -> End | None:
        """Some steps."""
        if self.stepped is not None:
            return self._step_by_scipy(self.stepped)
        if self.steps >= self.method.max_steps:
            return self._stopped(f"{self.method.max_steps} steps were not enough; at t = {self.s[At.TIME]:.6g}")
        late = self.pace.late(float(self.s[At.TIME])) or self.pace.crawls(float(self.s[At.TIME]), self.steps)
        if late:
            return self._stopped(late)
        limit = 1 if self.looked else min(_AT_ONCE, self.method.max_steps - self.steps)
        back = Back(self.kernel(self.given | {"limit": limit}))
        for hook in self.hooks:
            if hook.raised is not None:
                raise hook.raised
        self._collect()
        if back is Back.LOOK:
            return self._doubt() if self.s[At.HELD] else self._look()
        changed = self.looked and self._settled()
        if back in (Back.UNDERFLOW, Back.NOT_FINITE):
            if self.holding is None:
                return self._stopped(self._why(back))
            self._hand_over(float(self.s[At.TIME]))
            return None
        if back is Back.END and self.s[At.END] >= self.span[1]:
            if self.t[-1] < self.span[1]:
                self._sample(self.span[1], self.y.copy())
            return End("finished", f"reached t = {self.span[1]:g}")
        # at a breakpoint, beyond which rates may be others
        t = on_from(float(self.s[At.END])) if back is Back.END else float(self.s[At.TIME])
        if changed and unheld(self.stepper):
            self._hand_over(t)
        elif changed:
            self._take_up(t)
        elif back is Back.END:
            self._begin(t)
        return None

    def _collect(self) -> None:
        """The samples that were taken."""
        while len(self.t) <= int(self.s[At.SAMPLE]):
            k = len(self.t) - 1
            self._sample(float(self.times[k]), self.out[k].copy(), bool(self.marks[k]))

    def _sample(self, t: float, y: Array, doubtful: bool = False) -> None:
        self.t.append(t)
        self.rows.append(self.stepper.sample(t, y) if doubtful else (y, self.stepper.eom))

    def _stopped(self, message: str) -> End:
        """What there is up to here is the motion."""
        if self.s[At.TIME] > self.t[-1]:
            self._sample(float(self.s[At.TIME]), self.y.copy(), doubtful=True)
        return End("stopped", message)

    def _doubt(self) -> End | None:
        """The constraints of the step that is taken next, in which they may be singular or not be kept."""
        s, stepper, holding = self.s, self.stepper, self.holding
        assert holding is not None
        start, h = float(s[At.TIME]), self._next()
        dense = interpolant(self.method.name, self.given, h, start)
        narrow = NARROW * max(abs(start + h), self.span[1] - self.span[0])
        verdict, told = holding.look(dense, start, start + h, narrow, (self.method.rtol, self.method.atol))
        if verdict is Verdict.SHORTER:
            s[At.STEP] = h / 2
            return None
        if verdict is Verdict.SINGULAR:
            self._hand_over(start)
            return None
        if verdict is Verdict.TURNED:
            return self._stopped(f"another branch of the closures lies beyond t = {start:.6g}: {told}")
        if verdict is Verdict.MISSED:
            return self._stopped(not_held(stepper, start, self.y.copy(), self.span, told))
        self.looked, s[At.LOOKED] = True, 1.0
        return self._look() if stepper.eom.events else None

    def _settled(self) -> bool:
        """After a step that Python has looked at: whether other dependent speeds are stepped from there on, or rank is lost."""
        holding, t = self.holding, float(self.s[At.TIME])
        assert holding is not None
        self.looked = False
        holding.taken(self.s)
        kept, numbers = self.stepper.keep(t, self.y)
        self.given["lag"][kept != self.y] = 0.0
        self.y[:] = kept
        changed = self.stepper.settle(t, kept, numbers)
        holding.measure()
        return changed

    def _hand_over(self, t: float) -> None:
        """SciPy's steps lead on from here, past where constraints are singular."""
        method = replace(self.method, name=STEPPED, max_steps=self.method.max_steps - self.steps)
        self.stepped = Course(self.stepper, method, (t, self.span[1]), self.y.copy(), self.times[:-1])
        self.stepped.t, self.stepped.rows, self.stepped.events = self.t, self.rows, self.events
        self.stepped.span, self.passed = self.span, True

    def _step_by_scipy(self, course: Course) -> End | None:
        """One of SciPy's steps; machine code goes on where constraints are regular again."""
        end = course.advance()
        if end is not None or not course.clear or unheld(self.stepper):
            return end
        t, y = float(course.solver.t), course.solver.y
        if not regular(self.stepper, self.stepper.keep(t, y)[1]):
            return None
        self.handed = (self.handed[0] + course.steps, self.handed[1] + course.evaluations)
        self.stepped = None
        self.y[:] = y
        self._take_up(t)
        self.s[At.SAMPLE] = len(self.t) - 1
        return None

    def _look(self) -> End | None:
        """The events of the step that is taken next, up to one that ends the motion; without such a one it is gone on from."""
        s, now, events = self.s, self.stepper.now, self.stepper.eom.events
        start, h = float(s[At.TIME]), self._next()
        dense = interpolant(self.method.name, self.given, h, start)
        times = start + h * np.array(SHARES)
        states = dense(times[1:])
        if self.holding is not None:
            states[-1] = after(self.given)
        values = np.vstack([self.given["seen"][: len(events)], now.watch_all(times[1:], states)])
        sizes = np.fmax(self.given["largest"][: len(events)], np.abs(values).max(axis=0))

        def one(t: float) -> Array:
            state: Array = dense(np.array([t]))[0]
            return state

        met = crossings(events, now.watch, one, times, values, thresholds(events, sizes))
        met += vanishing(events, now.watch, one, times, values, sizes, self.method.rtol)
        s[At.LOOKED] = 1.0
        for event, t in sorted(met, key=lambda pair: pair[1]):
            self.events.append((event, t))
            if event.terminal:
                before = self.times[(self.times > self.t[-1]) & (self.times < t)]
                for at in [*before, t]:
                    self._sample(float(at), one(float(at)), doubtful=True)
                s[At.STEPS] += 1
                return End("event", f"{event.name} at t = {t:.6g}: {event.message or 'terminal event'}", event)
        return None

    def _next(self) -> float:
        """The length of the step that was looked at."""
        s = self.s
        shortest = s[At.SHORTEST] + 10 * np.finfo(float).eps * abs(s[At.TIME])
        return float(min(max(s[At.STEP], shortest), s[At.LONGEST], s[At.END] - s[At.TIME] - s[At.TIME_LAG]))

    def _why(self, back: Back) -> str:
        """Why there is no step."""
        t, now = float(self.s[At.TIME]), self.stepper.now
        if back is Back.UNDERFLOW and INTEGRATORS[self.method.name].fixed:
            return f"a step of max_step={self.method.max_step:g} from t = {t:.6g} is not found by iteration: give a shorter one"
        fastest = now.rates.labels[int(self.s[At.WORST])]
        told = (
            f"no step is short enough for {fastest}, which changes fastest"
            if back is Back.UNDERFLOW
            else self._not_finite(t)
        )
        singular = nearly_singular(self.stepper.eom, now.values(t, self.y))
        return f"the right-hand side is singular or not finite near t = {t:.6g} ({told}){singular}"

    def _not_finite(self, t: float) -> str:
        """What is not finite first, on the way on from t by ever longer steps."""
        now, rate = self.stepper.now, self.stepper.rate(t, self.y)
        for k in range(_DOUBLINGS):
            step = float(self.s[At.SHORTEST]) * 2.0**k
            told = now.explain(t + step, self.y + step * np.nan_to_num(rate)) if np.isfinite(step) else ""
            if told:
                return told
        return "a stage of the step is not finite"
