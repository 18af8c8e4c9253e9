# SPDX-License-Identifier: BSD-3-Clause
"""Motions that run in machine code: an integrator's kernel takes a thousand steps at a time, Python looks at the clock between."""

import numpy as np

from kane.expr.node import as_expr
from kane.model.declarations import Event
from kane.motion.bounds import SHARES
from kane.motion.chatter import Pace
from kane.motion.collocated import Given, by_kind, polynomial, watching
from kane.motion.drives import constant
from kane.motion.formulas import Formula, driving
from kane.motion.met import crossings, thresholds, vanishing
from kane.motion.singular_rates import nearly_singular
from kane.motion.steppers.outline import SIZE, At, Back
from kane.motion.steppers.table import INTEGRATORS, compiled
from kane.motion.stepping import End, Method
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array
from kane.program.native.entry import Hook, aligned, entry, hoisted, wide_entry
from kane.program.native.machine import Settings

_AT_ONCE = 1000
"""Steps between two looks at the clock."""
_DOUBLINGS = 80


class NativeCourse:
    """A motion on its way over `span`, as `Course`, where nothing is left to Python between two steps (`methods.py`)."""

    def __init__(self, stepper: Stepper, method: Method, span: tuple[float, float], start: Array, times: Array) -> None:
        self.stepper, self.method, self.span = stepper, method, span
        self.t, self.rows = [span[0]], [(start, stepper.eom)]
        self.events: list[tuple[Event, float]] = []
        self.pace = Pace(span, method.max_seconds, method.bounded)
        self.times = np.append(times[times > span[0]], np.inf)
        self.s = np.zeros(SIZE)
        self.y, self.out = start.copy(), np.empty((len(self.times) - 1, len(start)))
        self.kernel = compiled(method.name, stepper.now.settings or Settings())
        self.hook: Hook | None = None
        self.given = self._given()
        self._begin(span[0])

    def _given(self) -> Given:
        """What the kernel is called with."""
        now, y, integrator = self.stepper.now, self.y, INTEGRATORS[self.method.name]
        r, work = now.inputs(self.span[0]), aligned(integrator.work(len(self.y)))
        h = hoisted(now.rates, self.span[0], y[: now.width], now.p, r)
        arrays: Given = {
            "s": self.s,
            "y": y,
            "lag": np.zeros_like(y),
            "work": work,
            "p": now.p.copy(),
            "h": h,
        }
        samples: Given = {"times": self.times, "rows": self.out, "samples": len(self.out)}
        given: Given = {"n": len(y), **arrays, **samples, **self._driving()}
        if integrator.width == 1:
            return {**given, "rhs": entry(now.rates)}
        wide: Given = {
            "rhs": wide_entry(now.rates, integrator.width),
            "r": np.repeat(np.append(r, 0.0), integrator.width),
        }
        return {**given, **wide, **by_kind(self.stepper.eom), **watching(self.stepper, self.span[0], y)}

    def _driving(self) -> Given:
        """r, and what gives it where an input is a function of time."""
        now = self.stepper.now
        r = np.repeat(np.append(now.inputs(self.span[0]), 0.0), INTEGRATORS[self.method.name].width)
        if all(constant(f) is not None for f in now.drives):
            return {"r": r, "driven": 0, "hd": np.zeros(1), "drive": entry(now.rates)}
        if all(constant(f) is not None or isinstance(f, Formula) for f in now.drives):
            values = [f.expr if isinstance(f, Formula) else as_expr(constant(f)) for f in now.drives]
            given = self.stepper.eom.numeric(now.settings).routine(driving, *values).flat
            h = hoisted(given, self.span[0], self.y[: now.width], now.p, r[: len(now.drives)])
            width = INTEGRATORS[self.method.name].width
            code = entry(given) if width == 1 else wide_entry(given, width)
            return {"r": r, "driven": 1, "hd": h, "drive": code}

        def drive(t: float) -> None:
            r[:-1] = np.nan
            r[:-1] = now.inputs(min(t, float(self.s[At.END])))  # rounding may lead beyond the end

        self.hook = Hook(drive)
        return {"r": r, "driven": 1, "hd": np.zeros(1), "drive": self.hook}

    def _begin(self, t: float) -> None:
        """From t on, up to the next breakpoint: to the last number before it, as rates may jump there."""
        ahead = [b for b in self.method.breakpoints if t < b < self.span[1]]
        end = float(np.nextafter(min(ahead), t)) if ahead else self.span[1]
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
    def steps(self) -> int:
        """Steps so far."""
        return int(self.s[At.STEPS])

    @property
    def evaluations(self) -> int:
        """Evaluations of the right-hand side; those of all stages at once are one."""
        return int(self.s[At.RATES])

    def far(self) -> str:
        """How far the motion is, in words."""
        return f"t = {self.s[At.TIME]:.4g} of {self.span[1]:.4g} s"

    def advance(self) -> End | None:
        """Some steps."""
        if self.steps >= self.method.max_steps:
            return self._stopped(f"{self.method.max_steps} steps were not enough; at t = {self.s[At.TIME]:.6g}")
        late = self.pace.late(float(self.s[At.TIME])) or self.pace.crawls(float(self.s[At.TIME]), self.steps)
        if late:
            return self._stopped(late)
        limit = min(_AT_ONCE, self.method.max_steps - self.steps)
        back = Back(self.kernel(self.given | {"limit": limit}))
        if self.hook is not None and self.hook.raised is not None:
            raise self.hook.raised
        self._collect()
        if back is Back.LOOK:
            return self._look()
        if back in (Back.UNDERFLOW, Back.NOT_FINITE):
            return self._stopped(self._why(back))
        if back is Back.END and self.s[At.END] >= self.span[1]:
            if self.t[-1] < self.span[1]:
                self._sample(self.span[1], self.y.copy())
            return End("finished", f"reached t = {self.span[1]:g}")
        if back is Back.END:  # at a breakpoint, beyond which rates may be others
            self._begin(float(np.nextafter(self.s[At.END], np.inf)))
        return None

    def _collect(self) -> None:
        """The samples that were taken."""
        while len(self.t) <= int(self.s[At.SAMPLE]):
            k = len(self.t) - 1
            self._sample(float(self.times[k]), self.out[k].copy())

    def _sample(self, t: float, y: Array) -> None:
        self.t.append(t)
        self.rows.append((y, self.stepper.eom))

    def _stopped(self, message: str) -> End:
        """What there is up to here is the motion."""
        if self.s[At.TIME] > self.t[-1]:
            self._sample(float(self.s[At.TIME]), self.y.copy())
        return End("stopped", message)

    def _look(self) -> End | None:
        """The events of the step that is taken next, up to one that ends the motion; without such a one it is gone on from."""
        s, now, events = self.s, self.stepper.now, self.stepper.eom.events
        start, h = float(s[At.TIME]), self._next()
        dense = polynomial(self.given, h, start)
        times = start + h * np.array(SHARES)
        seen, largest = self.given["seen"], self.given["largest"]
        values = np.vstack([seen[: len(events)], now.watch_all(times[1:], dense(times[1:]))])
        sizes = np.fmax(largest[: len(events)], np.abs(values).max(axis=0))

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
                    self._sample(float(at), one(float(at)))
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
