# SPDX-License-Identifier: BSD-3-Clause
"""What a kernel looks at of each step that it has found, before it goes on from it: constraints, events, switches."""

from collections.abc import Callable

from kane.motion.steppers.context import ReturnCode, Slot, StepperContext
from kane.motion.steppers.held import ConstraintSolver, RoughDense
from kane.motion.steppers.watched import Dense, Watched
from kane.program.kernel.writer import Term


class StepInspection:
    """Constraints that are `held` at the end of a step and events that are `watched` along it; `dense` is the state there."""

    def __init__(
        self, context: StepperContext, dense: Dense, held: bool, watched: bool, sided: bool, wide: bool = False
    ) -> None:
        self.context, self.dense = context, dense
        self.held = ConstraintSolver(context) if held else None
        self.watched = Watched(context, wide, dense, self.held, sided) if watched else None
        self.looks = held or watched

    def begin(self) -> None:
        """Before a step that begins anew switches have their sides, and the choice of dependent speeds is at hand."""
        if self.watched is not None and self.watched.sided:
            self.watched.settle()
        if self.held is not None:
            self.held.begin()

    def look(
        self, h: Term, last: Term, at: Term, along: Callable[[Watched], None], rough: RoughDense | None = None
    ) -> None:
        """A step of length h whose end stands in `work` at a place: `asks` tells whether Python looks before it is gone on from.

        `along` gives the quantities of events along it, `rough` the states where these need not be exact.
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
        """The step is gone on from, ended at an event, or left to Python."""
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
        """Row k of the samples, at a share of the step."""
        o = self.context
        self.dense(theta, o.rows, k * o.n)
        if self.held is not None:
            self.held.sample(k, o.times[k], o.rows, k * o.n)
