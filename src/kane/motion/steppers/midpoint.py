# SPDX-License-Identifier: BSD-3-Clause
"""The implicit midpoint rule with fixed steps: symplectic, so that the energy error of conservative systems stays bounded.

k = f(t + h/2, y + h k/2) by fixed-point iteration down to rounding, y' = y + h k. Source: Hairer, Lubich & Wanner, *Geometric
Numerical Integration*, 2nd ed. 2006, sec. II.1.3, VI.4.
"""

from collections.abc import Callable

from kane.motion.steppers.context import RATE, Slot, StepperContext, add_exactly
from kane.numeric.scale import EPS, ROUNDED
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Term

_ITERATIONS = 50
_FOUND, _LOST = 1, 2
ROWS = 6
"""Rows of `work`: k, its next iterate, the state of the stage; the end of the step, and the rates at both ends."""


def midpoint_kernel() -> Kernel:
    """The kernel; `work` contains `ROWS` rows of n."""
    o = StepperContext("midpoint")
    w = o.writer
    rhs = w.callee("rhs", *RATE)
    o.drives(*RATE)
    status, rounds = w.variable("status", INT), w.variable("rounds", INT)
    change, before = w.variable("change"), w.variable("before_last")
    new, stage = o.row(1), o.row(2)

    def begin() -> None:
        o.rate(rhs, o.get(Slot.TIME), o.y, 0, 0)
        o.put(Slot.FRESH, 0.0)

    def step(h: Term, last: Term) -> None:
        status.put(0)
        rounds.put(0)
        before.put(1e300)
        with w.repeat(lambda: status.get() < 1):
            with w.count(o.n) as i:
                o.work[stage + i] = o.y[i] + (h * 0.5) * o.work[i]
            o.rate(rhs, o.get(Slot.TIME) + h * 0.5, o.work, stage, new)
            change.put(0.0)
            with w.count(o.n) as i:
                size = w.compute("abs", o.y[i]) + w.compute("abs", h * o.work[new + i]) + o.get(Slot.ATOL) * EPS
                moved = w.compute("abs", h * (o.work[new + i] - o.work[i])) / size
                change.put(w.compute("max", change.get(), w.select(size > 0.0, moved, 0.0)))
                o.work[i] = o.work[new + i]
            _judge(o, change.get(), before.get(), rounds.get(), status.put)
            before.put(change.get())
            rounds.put(rounds.get() + 1)
        with w.when(status.get() < _LOST):
            o.sample(h, lambda: _ends(o, rhs, h), lambda k, theta: _between(o, h, k * o.n, theta))
            o.advance(h, last)
            with w.count(o.n) as i:
                y, lag = add_exactly(o.y, o.lag, i, h * o.work[i])
                o.y[i] = y
                o.lag[i] = lag
        with w.otherwise():
            o.shorten(w.constant(0.0), change.get() < 1e300)

    return o.steps(begin, step, fixed=True)


def _judge(o: StepperContext, change: Term, before: Term, rounds: Term, put: Callable[[int], None]) -> None:
    """The iteration has converged if only rounding changes k; it is given up after `_ITERATIONS` or if it diverges."""
    w = o.writer
    still = (change <= EPS) | ((rounds > 1) & (change >= before) & (change <= ROUNDED))
    with w.when(still):
        put(_FOUND)
    with w.otherwise(), w.when(~(change < 1e300) | (rounds >= _ITERATIONS)):
        put(_LOST)


def _ends(o: StepperContext, rhs: Callable[..., None], h: Term) -> None:
    """Computes the end of the step, and the rates at both ends."""
    with o.writer.count(o.n) as i:
        o.work[o.row(3) + i] = o.y[i] + (h * o.work[i] + o.lag[i])
    o.rate(rhs, o.get(Slot.TIME), o.y, 0, o.row(4))
    o.rate(rhs, o.get(Slot.TIME) + h, o.work, o.row(3), o.row(5))


def _between(o: StepperContext, h: Term, row: Term, theta: Term) -> None:
    """Writes y at a share of the step, by the cubic Hermite interpolant."""
    with o.writer.count(o.n) as i:
        change = o.work[o.row(3) + i] - o.y[i]
        begin = h * o.work[o.row(4) + i] - change
        bend = change * 2.0 - h * (o.work[o.row(4) + i] + o.work[o.row(5) + i])
        o.rows[row + i] = o.y[i] + theta * (change + (1.0 - theta) * (begin + theta * bend))
