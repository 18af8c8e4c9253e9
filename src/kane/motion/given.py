# SPDX-License-Identifier: BSD-3-Clause
"""What a kernel is called with: the state, the right-hand side, inputs, samples."""

from collections.abc import Callable
from typing import Any

import numpy as np

from kane.motion.asking import filling
from kane.motion.collocated import Given, by_kind, watching
from kane.motion.compiled_equations import Routines
from kane.motion.drives import asked, constant, following, follows, law_of
from kane.motion.feedback import HeldInput
from kane.motion.implicit import derivatives, exact
from kane.motion.laws import driving
from kane.motion.steppers.outline import At
from kane.motion.steppers.table import INTEGRATORS
from kane.numeric.arrays import Array
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.entry import Hook, aligned, doubles, entry, hoisted, wide_entry


class Arguments:
    """The arguments by name, as `given`, and the `hooks` through which Python is asked for inputs.

    `now` are the equations from time t on, s, y and `lag` what a kernel reads and writes; of `switches` quantities stand behind the
    events' ones.
    """

    def __init__(self, name: str, now: Routines, t: float, s: Array, y: Array, switches: int = 0) -> None:
        self.integrator, self.now, self.s, self.y = INTEGRATORS[name], now, s, y
        self.hooks: list[Hook] = []
        self.law = law_of(now.drives, now.eom.inputs)
        work, r = aligned(self.integrator.work(len(y))), now.inputs(t, y)
        h = hoisted(now.rates, t, y[: now.width], now.p, r)
        self.given: Given = {
            "n": len(y),
            "s": s,
            "y": y,
            "lag": np.zeros_like(y),
            "work": work,
            "p": np.append(now.p, now.numbers),
            "h": h,
        }
        self.given |= self._driving(t)
        if self.integrator.watches:
            self.given |= watching(now, t, y, switches, self.integrator.width > 1)
        if self.integrator.implicit:
            self.given |= derivatives(now, t, y, self.law)
            if following(now.drives) and asked(now.drives):
                self.given["jac"] = self._slopes()
        if self.integrator.width == 1:
            self.given["rhs"] = entry(now.rates)
        else:
            self.given["rhs"] = wide_entry(now.rates, self.integrator.width)
            self.given |= now.eom.numeric(now.settings).value(by_kind)

    def _driving(self, t: float) -> Given:
        """r, and what gives it where an input is a function of time."""
        now, width = self.now, self.integrator.width
        r = np.repeat(np.append(now.inputs(t, self.y), 0.0), width)
        if all(_held(f) for f in now.drives):
            return {"r": r, "driven": 0, "hd": np.zeros(1), "drive": entry(now.rates)}
        given = self._formulas()
        if given is None:
            return {"r": r, "driven": 1, "hd": np.zeros(1), "drive": self._hook(r)}
        h = hoisted(given, t, self.y[: now.width], now.parameters(given), r[: len(now.drives)])
        driven = 2 if follows(now.drives) else 1
        return {"r": r, "driven": driven, "hd": h, "drive": entry(given) if width == 1 else wide_entry(given, width)}

    def hold(self, t: float) -> None:
        """What sampled controllers hold from t on."""
        r = np.append(self.now.inputs(t, self.y), 0.0)
        self.given["r"][:] = np.repeat(r, self.integrator.width)
        if "held_r" in self.given:
            self.given["held_r"][:] = r

    def held(self, given: Given, marks: Array) -> None:
        """With what tells of the constraints, and what gives the inputs at one state of theirs."""
        formulas = self._formulas()
        if self.given["driven"] and formulas is None:
            self.given["held_drive"] = self._hook(given["held_r"])
        else:
            self.given["held_drive"] = entry(formulas or self.now.rates)
        self.given |= given | {"held_marks": marks}

    def _formulas(self) -> CompiledRoutine | None:
        """The inputs as a routine, where all are expressions; those that are held stay as they are."""
        numeric = self.now.eom.numeric(self.now.settings)
        return None if self.law is None else numeric.routine(driving, *self.law.values).flat

    def _hook(self, r: Array) -> Hook:
        """What asks Python for the inputs and writes them to r."""
        s, width, fill, follow = self.s, self.now.width, filling(self.now), following(self.now.drives)
        here, own = self.y[:width], r[:-1]

        def drive(t: float, x: int, out: int) -> None:
            try:  # rounding may lead beyond the end
                fill(min(t, float(s[At.END])), doubles(x, width) if follow else here, own)
            except BaseException:
                own[:] = np.nan
                raise

        return self._hooked(drive)

    def _slopes(self) -> Hook:
        """What asks Python for J, of inputs that are its functions of the state."""
        s, width, j = self.s, self.now.width, exact(self.now)

        def slopes(t: float, x: int, out: int) -> None:
            found = doubles(out, (width + 1) * width)
            found[:] = 0.0
            found[:] = j(min(t, float(s[At.END])), np.append(doubles(x, width), 0.0))[:, :width].reshape(-1)

        return self._hooked(slopes)

    def _hooked(self, function: Callable[[float, int, int], None]) -> Hook:
        self.hooks.append(Hook(function))
        return self.hooks[-1]

    def check(self) -> None:
        """What went wrong in an input is raised."""
        for hook in self.hooks:
            if hook.raised is not None:
                raise hook.raised


def _held(drive: Any) -> bool:
    """Whether an input is a number from one breakpoint to the next."""
    return constant(drive) is not None or isinstance(drive, HeldInput)
