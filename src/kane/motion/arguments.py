# SPDX-License-Identifier: BSD-3-Clause
"""The arguments of an integrator's kernel: state, right-hand side, Jacobian, inputs and events, as arrays and entry points."""

from collections.abc import Callable
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from kane.dynamics.readings.quantities import without_unknowns
from kane.equations.equations import Equations
from kane.expr.node import Expr
from kane.motion.hybrid.automaton import Fresh, automaton
from kane.motion.inputs.expressions import ControlLaw, Formula, HeldInput, LawInput, driving
from kane.motion.inputs.functions import asked, constant, following, follows, law_of
from kane.motion.right_hand_side import Given, Routines, derivatives, exact
from kane.motion.steppers.context import Slot
from kane.motion.steppers.table import INTEGRATORS
from kane.numeric.arrays import Array
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.entry import Hook, aligned, doubles, entry, wide_entry

Fill = Callable[[float, Array, Array], None]
"""fill(t, x, r) writes the inputs at time t and state x = (q, u, a) to r."""


def filling(now: Routines) -> Fill:
    """A function that writes the inputs, with little overhead; a control law is called once for all its inputs."""
    laws: dict[ControlLaw, list[tuple[int, int]]] = {}
    others: list[tuple[int, Callable[[Any], Any]]] = []
    written = any(isinstance(f, Formula) for f in now.drives)
    for k, f in enumerate(list[Any](now.drives)):
        if isinstance(f, LawInput):
            laws.setdefault(f.law, []).append((k, f.place))
        elif not isinstance(f, Formula):
            others.append((k, f))
    each = list(laws.items())
    law = law_of(now.laid, now.eom.inputs, functions=True) if written else None
    routine = now.routine(driving, *law.values).flat if law else None
    numbers = law.numbers if law else ()

    def fill(t: float, x: Array, r: Array) -> None:
        for law, places in each:
            answer = law.at(t, x)
            for k, place in places:
                r[k] = answer[place]
        for k, f in others:
            r[k] = f(t)
        if routine is not None:
            r[:] = routine(t, x, np.append(now.p, numbers), r)

    return fill


def by_kind(eom: Equations) -> dict[str, Array | int]:
    """`pairs` (i, j) of coordinates i whose rate is the speed at index j of the state; `free`, indices of the others; both counts."""
    place: dict[Expr, int] = {u: len(eom.coordinates) + k for k, u in enumerate(eom.speeds)}
    roots = without_unknowns(eom.solved, eom.right_hand_side)
    pairs = [(i, place[root]) for i, root in enumerate(roots[: len(eom.coordinates)]) if root in place]
    paired = {i for i, _ in pairs}
    free = [i for i in range(len(roots)) if i not in paired]
    # padded by one entry, so that no array is empty
    arrays = {"pairs": np.array([*pairs, (0, 0)], dtype=float).reshape(-1), "free": np.array([*free, 0], dtype=float)}
    return {**arrays, "pair_count": len(pairs), "free_count": len(free)}


class Hooks:
    """The callbacks of the kernels of a motion, which work on s (slots) and y (state).

    After an exception in one of them no function is called any more. As kernels run on where its answer does not enter the rates, they
    are told that all steps are taken, and `left` undoes what follows the last step before.
    """

    def __init__(self, s: Array, y: Array) -> None:
        self.s, self.y = s, y
        self.every: list[Hook] = []
        self._left: tuple[BaseException, Array, Array] | None = None

    def add(self, function: Callable[[float, int, int], None]) -> Hook:
        """A callback for kernels."""

        def call(t: float, x: int, out: int) -> None:
            try:
                if self._left is None:
                    function(t, x, out)
            except BaseException as error:
                self._left = error, self.s.copy(), self.y.copy()
                self.s[Slot.STEPS] = np.inf

        self.every.append(Hook(call))
        return self.every[-1]

    def left(self) -> BaseException | None:
        """The exception that has occurred since the last call, if any; s and y are then those after the last step before it."""
        if self._left is None:
            return None
        error, self.s[:], self.y[:] = self._left
        self._left = None
        return error


class Arguments:
    """The kernel's arguments by name, `given`, and the `hooks`, callbacks by which the kernel evaluates inputs in Python.

    `now` are the equations to integrate from time t. The kernel reads and writes s (slots), y (state) and `lag` (rounding error of y).
    `fresh` are events at whose thresholds the motion begins, `hooks` those of other kernels of the motion, too. `self.now.p` is the
    kernel's own array, with the sides of switches.
    `driving` is the routine of inputs that are expressions, if any.
    """

    def __init__(
        self,
        name: str,
        now: Routines,
        t: float,
        s: Array,
        y: Array,
        fresh: Fresh = MappingProxyType({}),
        hooks: Hooks | None = None,
    ) -> None:
        p = np.append(now.p, [*now.numbers, 0.0])  # the last entry is the number of the choice of dependent speeds
        now = replace(now, p=p[: len(now.p)])
        self.integrator, self.now, self.s, self.y = INTEGRATORS[name], now, s, y
        self.hooks = hooks or Hooks(s, y)
        self.controlled = [(k, f) for k, f in enumerate(now.drives) if isinstance(f, HeldInput)]
        self.law = law_of(now.laid, now.eom.inputs)
        self.driving: CompiledRoutine | None = None
        work = aligned(self.integrator.work(len(y)))
        self.given: Given = {
            "n": len(y),
            "s": s,
            "y": y,
            "lag": np.zeros_like(y),
            "work": work,
            "p": p,
            **now.hoisted("h", now.rates, t, y, now.inputs(t, y)),
            "breakpoints": 0,
            "pauses": np.zeros(1),
            "control": entry(now.rates),
        }
        self.given |= self._driving(t)
        if now.events is not None:
            self.given |= automaton(now, t, y, fresh, self.integrator.width > 1)
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
        """The array r, and the routines that evaluate it; `driven` is 0 for constants, 2 for expressions of the state, else 1."""
        now, width = self.now, self.integrator.width
        single = np.append(now.inputs(t, self.y), 0.0)
        r = single if width == 1 else np.repeat(single, width)
        none, at = entry(now.rates), (t, self.y, r[: len(now.drives)])
        inputs: Given = {"r": r, "single_r": single, "driven": 0, **now.hoisted("hd", now.rates, *at)}
        if all(constant(f) is not None or isinstance(f, HeldInput) for f in now.drives):  # constant between breakpoints
            return inputs | {"drive": none, "single_drive": none}
        if self.law is None:
            hook = self._hook()
            return inputs | {"driven": 1, "drive": hook, "single_drive": hook}
        self.driving = routine = now.routine(driving, *self.law.values).flat
        own = entry(routine)
        inputs |= {"driven": 2 if follows(now.drives) else 1, **now.hoisted("hd", routine, *at)}
        return inputs | {"drive": own if width == 1 else wide_entry(routine, width), "single_drive": own}

    def hold(self) -> None:
        """Writes the latest values of sampled controllers to r."""
        width = self.integrator.width
        for k, one in self.controlled:
            value = one.now
            self.given["r"][k * width : (k + 1) * width] = value
            if width > 1:
                self.given["single_r"][k] = value

    def _hook(self) -> Hook:
        """A callback that evaluates the inputs in Python."""
        s, width, fill, follow = self.s, self.now.width, filling(self.now), following(self.now.drives)
        here, count = self.y[:width], len(self.now.drives)
        views: dict[int, Array] = {}

        def drive(t: float, x: int, out: int) -> None:
            own = views.get(out)
            if own is None:
                own = views[out] = doubles(out, count)
            try:  # rounding may place t beyond the end
                fill(min(t, float(s[Slot.END])), doubles(x, width) if follow else here, own)
            except BaseException:
                own[:] = np.nan
                raise

        return self.hooks.add(drive)

    def _slopes(self) -> Hook:
        """A callback that evaluates J in Python, for inputs that are Python functions of the state."""
        s, width, j = self.s, self.now.width, exact(self.now)

        def slopes(t: float, x: int, out: int) -> None:
            found = doubles(out, (width + 1) * width)
            found[:] = 0.0
            found[:] = j(min(t, float(s[Slot.END])), np.append(doubles(x, width), 0.0))[:, :width].reshape(-1)

        return self.hooks.add(slopes)

    def check(self) -> None:
        """Raises the exception that occurred in a callback, if any."""
        error = self.hooks.left()
        if error is not None:
            raise error
