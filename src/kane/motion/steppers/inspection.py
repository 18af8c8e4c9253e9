# SPDX-License-Identifier: BSD-3-Clause
"""The inspection of a computed step before it is accepted: constraints, events, switches."""

from collections.abc import Callable

from kane.motion.steppers.context import ReturnCode, Slot, StepperContext
from kane.motion.steppers.held import ConstraintSolver, RoughDense
from kane.motion.steppers.watched import Dense, Watched
from kane.program.kernel.writer import Term


class StepInspection:
    """Constraints that are `held` at the end of a step, and events that are `watched` along it; `dense` is the state in the step."""

    def __init__(
        self, context: StepperContext, dense: Dense, held: bool, watched: bool, sided: bool, wide: bool = False
    ) -> None:
        self.context, self.dense = context, dense
        self.held = ConstraintSolver(context) if held else None
        self.watched = Watched(context, wide, dense, self.held, sided) if watched else None
        self.looks = held or watched

    def begin(self) -> None:
        """Before a step that starts anew: sets the sides of switches, and initializes the constraint solver."""
        if self.watched is not None and self.watched.sided:
            self.watched.settle()
        if self.held is not None:
            self.held.begin()

    def look(
        self, h: Term, last: Term, at: Term, along: Callable[[Watched], None], rough: RoughDense | None = None
    ) -> None:
        """Inspects a step of length h whose end is in `work` at an index: sets `asks` if it is not to be accepted as it is.

        `along` evaluates event quantities along it; `rough` is an interpolant for tests that need no exact states.
        """
        if not self.looks:
            return
        w, o = self.context.writer, self.context
        begin = o.get(Slot.TIME)
        o.asks.put(ReturnCode.ON)
        if self.held is not None:
            end = w.select(last, o.get(Slot.END), begin + (h + o.get(Slot.TIME_LAG)))
            self.held.look(begin, h, end, (o.work, at), self.dense, rough)
        if self.watched is not None:
            with w.when(~(o.asks.get() > 0)):
                along(self.watched)
                self.watched.decide(begin, h, last)

    def follow(self, go_on: Callable[[], None]) -> None:
        """Accepts the step by `go_on`, ends it at an event, or sets the return code."""
        w, o = self.context.writer, self.context
        if not self.looks:
            go_on()
            return
        with w.when(o.asks.get() > 0):
            again = o.asks.get() >= int(ReturnCode.AGAIN)
            o.back.put(w.select(again, w.integer(ReturnCode.ON), o.asks.get()))
        with w.otherwise():
            if self.watched is None:
                go_on()
            else:
                with w.when(self.watched.breaks):
                    self.watched.jump(self.sample)
                with w.otherwise():
                    self.watched.keep()
                    go_on()
                    self.watched.turned()
            if self.held is not None:
                with w.when(o.renewed.get() > 0):
                    o.renewed.put(0)
                    self.held.change_speeds()
                    o.begin_step_anew()

    def sample(self, k: Term, theta: Term) -> None:
        """Writes row k of the samples, at a share of the step."""
        o = self.context
        self.dense(theta, o.rows, k * o.n)
        if self.held is not None:
            self.held.sample(k, o.times[k], o.rows, k * o.n)
