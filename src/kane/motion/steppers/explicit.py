# SPDX-License-Identifier: BSD-3-Clause
"""The kernel of an explicit embedded Runge–Kutta method, generated from its tableau."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from kane.motion.steppers.context import RATE, Slot, StepperContext, add_exactly
from kane.motion.steppers.held import Dense, RoughDense
from kane.motion.steppers.inspection import StepInspection
from kane.motion.steppers.tableau import Row, Tableau
from kane.numeric.arrays import Array as Numbers
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Array, Term, Variable, Writer

_SAFETY, _LEAST, _MOST = 0.9, 0.2, 10.0
"""Safety factor of the step size, and the bounds of its change from one step to the next."""
_RISING = 0.5
"""If the step size that the error allows decreases from step to step, a further decrease is extrapolated, by this factor at most."""
_STABLE = 4.0
"""h |λ| at the border of the stability region of an explicit method."""


def explicit_kernel(
    tableau: Tableau, held: bool = False, watched: bool = False, sided: bool = False, queued: bool = False
) -> Kernel:
    """The kernel with adaptive steps: the error of each component is kept below atol + rtol |y|.

    With `held`, the end of each step and each sample are projected onto the constraints; with `watched`, events are detected, with
    `sided` switches too. With `queued`, the kernel integrates the instances of a queue, one after the other.

    `work` contains `rows(tableau)` rows of n: the k_s, the state of a stage, y' and its rounding error, dense output.
    """
    return _Explicit(tableau, StepperContext(tableau.name, queued), held, watched, sided).kernel()


def rows(tableau: Tableau) -> int:
    """The number of rows of n doubles in `work`."""
    return tableau.stages + 1 + len(tableau.later) + 3 + len(tableau.dense)


def explicit_work(tableau: Tableau, n: int) -> int:
    """The length of `work` for n components."""
    return rows(tableau) * n


def explicit_end(tableau: Tableau, n: int) -> int:
    """The index in `work` of the end of a step, projected onto the constraints."""
    return (rows(tableau) - len(tableau.dense) - 2) * n


def explicit_dense(tableau: Tableau, given: Mapping[str, Any], h: float, start: float) -> Callable[[Numbers], Numbers]:
    """The state (k × n) as a function of times (k) in the step of length h from `start`, from the arrays of the kernel."""
    begin, n, parts = (given["y"] + given["lag"]).copy(), len(given["y"]), len(tableau.dense)
    weights = given["work"].reshape(rows(tableau), n)[-parts:].copy()

    def state(times: Numbers) -> Numbers:
        theta = ((times - start) / h)[:, None]
        value = np.broadcast_to(weights[-1], (len(times), n))
        for k in reversed(range(parts - 1)):
            value = weights[k] + (theta if k % 2 else 1 - theta) * value
        result: Numbers = begin + theta * value
        return result

    return state


class _Explicit:
    """Builds the kernel."""

    def __init__(self, tableau: Tableau, context: StepperContext, held: bool, watched: bool, sided: bool) -> None:
        self.tableau, self.context = tableau, context
        self.writer = self.context.writer
        self.rhs = self.writer.callee("rhs", *RATE)
        self.context.drives(*RATE)
        self.inspection = StepInspection(context, self.dense, held, watched, sided)
        last = tableau.stages + 1 + len(tableau.later)
        self.state, self.after, self.after_lag = (self.context.row(last + k) for k in range(3))
        self.weights = last + 3

    def kernel(self) -> Kernel:
        """The kernel: initial rates, then the loop over steps."""
        o = self.context
        shorter = self.writer.variable("shorter", INT)

        def begin() -> None:
            self.inspection.begin()
            o.rate(self.rhs, o.get(Slot.TIME), o.y, 0, 0)
            if self.tableau.errors:
                o.first_step(self.tableau.exponent, self.rhs, 0, self.state, o.row(self.tableau.stages))
            o.put(Slot.FRESH, 0.0)
            o.put(Slot.PACE, 0.0)

        def step(h: Term, last: Term) -> None:
            self.stages(h)
            self.decide(h, last, self.error(h), shorter)

        return o.steps(begin, step, fixed=not self.tableau.errors)

    def stages(self, h: Term) -> None:
        """Computes k_1, …, y' and k_S."""
        o = self.context
        for s, (c, row) in enumerate(zip(self.tableau.c[1:], self.tableau.a, strict=True), 1):
            self.stage(h, s, c, row)
        with self.writer.count(o.n) as i:
            new, lag = add_exactly(o.y, o.lag, i, h * self.combined(self.tableau.b, i))
            o.work[self.after + i] = new
            o.work[self.after_lag + i] = lag
        o.rate(self.rhs, o.get(Slot.TIME) + h, o.work, self.after, o.row(self.tableau.stages))

    def stage(self, h: Term, s: int, c: float, row: Row) -> None:
        """Computes k_s."""
        o = self.context
        with self.writer.count(o.n) as i:
            o.work[self.state + i] = o.y[i] + h * self.combined(row, i)
        o.rate(self.rhs, o.get(Slot.TIME) + h * c, o.work, self.state, o.row(s))

    def combined(self, weights: Row, i: Term) -> Term:
        """Σ w_j k_j of component i."""
        o = self.context
        return self.writer.sum([o.work[o.row(j) + i] * x for j, x in enumerate(weights) if x])

    def error(self, h: Term) -> Term:
        """The largest error of a component in units of its tolerance; WORST is its index. Without estimates it is zero, or NaN."""
        w, o = self.writer, self.context
        largest = w.variable("error")

        def of(i: Term) -> Term:
            return self.error_of(h, i) if self.tableau.errors else w.compute("abs", o.work[self.after + i] * 0.0)

        o.largest_error(largest, of)
        return largest.get()

    def error_of(self, h: Term, i: Term) -> Term:
        """The error of component i in units of its tolerance."""
        w, o = self.writer, self.context
        allowed = o.allowed(i, o.work[self.after + i])
        return _joined(w, [w.compute("abs", h * self.combined(row, i)) / allowed for row in self.tableau.errors])

    def decide(self, h: Term, last: Term, error: Term, shorter: Variable) -> None:
        """Accepts or rejects the step, and chooses the size of the next one."""
        w, o = self.writer, self.context
        self.count_stiff(h, error)
        finite, power = o.power(error, self.tableau.exponent)
        factor = w.select(finite, w.compute("max", _SAFETY / power, _LEAST), _LEAST)
        pace, before = power / h, o.get(Slot.PACE)
        rising = w.select(before > 0.0, w.compute("min", w.compute("max", before / pace, _RISING), 1.0), 1.0)
        ahead = w.compute("max", factor * rising, _LEAST)
        with w.when(error <= 1.0):
            along, ahead_of = (self.state, self.after), o.has_sample(h)
            if self.inspection.watched is not None:
                self.prepare(h)
            rough = RoughDense(self.between(h), lambda wanted: self.prepare_where(h, wanted | ahead_of))
            self.inspection.look(h, last, self.after, lambda w: w.look_along(o.get(Slot.TIME), h, *along), rough)
            longer = h * w.compute("min", ahead, w.select(shorter.get() > 0, 1.0, _MOST))
            self.inspection.follow(lambda: self.go_on(h, last, longer, pace))
            shorter.put(0)
        with w.otherwise():
            shorter.put(1)
            o.shorten(h * w.compute("min", factor, 1.0), finite)

    def go_on(self, h: Term, last: Term, longer: Term, pace: Term) -> None:
        """Accepts the step; the next one has the size `longer`; `pace` is stored for its error control."""
        w, o, held, looks = self.writer, self.context, self.inspection.held, self.inspection.looks
        o.sample(h, lambda: None if looks else self.prepare(h), self.inspection.sample)
        o.put(Slot.PACE, pace)
        o.advance(h, last)
        with w.count(o.n) as i:
            o.y[i] = o.work[self.after + i]
            o.lag[i] = o.work[self.after_lag + i]
            o.work[i] = o.work[o.row(self.tableau.stages) + i]
        if held is not None:
            held.kept()
            o.rate(self.rhs, o.get(Slot.TIME), o.y, 0, 0)
        # a step that was cut at the end is no measure for the next one
        with w.when(~last):
            o.put(Slot.STEP, longer)

    def count_stiff(self, h: Term, error: Term) -> None:
        """Counts steps that stability limits, by the largest rate that the last two stages, at t + h, show: HW II, sec. IV.2.

        Omitted for the instances of a queue.
        """
        w, o, s = self.writer, self.context, self.tableau.stages
        if self.tableau.c[-1] != 1.0 or not self.tableau.errors or o.queued:
            return
        rates, states = w.variable("rates_apart"), w.variable("states_apart")
        rates.put(0.0)
        states.put(0.0)
        with w.count(o.n) as i:
            allowed = o.get(Slot.ATOL) + o.get(Slot.RTOL) * w.compute("abs", o.y[i])
            one = (o.work[o.row(s) + i] - o.work[o.row(s - 1) + i]) / allowed
            two = (o.work[self.after + i] - o.work[self.state + i]) / allowed
            rates.put(rates.get() + one * one)
            states.put(states.get() + two * two)
        large = h * w.compute("sqrt", rates.get()) > _STABLE * w.compute("sqrt", states.get())
        with w.when(large & (error <= 1.0)):
            o.more(Slot.SMOOTH, 1.0)
            o.more(Slot.LIMITED, 1.0)

    def prepare(self, h: Term) -> None:
        """Computes the stages of dense output, and its coefficients."""
        w, o, first = self.writer, self.context, self.tableau.stages + 1
        for s, (c, row) in enumerate(self.tableau.later, first):
            self.stage(h, s, c, row)
        with w.count(o.n) as i:
            for k, row in enumerate(self.tableau.dense):
                o.work[o.row(self.weights + k) + i] = h * self.combined(row, i)

    def prepare_where(self, h: Term, wanted: Term) -> None:
        """The same if `wanted`, unless event detection has done it before."""
        if self.inspection.watched is None:
            with self.writer.when(wanted):
                self.prepare(h)

    def between(self, h: Term) -> Dense:
        """The cubic Hermite interpolant through the states and rates at the ends of the step, without further stages."""
        w, o = self.writer, self.context

        def dense(theta: Term, array: Array, at: Term) -> None:
            rest = 1.0 - theta
            with w.count(o.n) as i:
                change = o.work[self.after + i] - o.y[i]
                first, last = h * o.work[i] - change, h * o.work[o.row(self.tableau.stages) + i] - change
                array[at + i] = o.y[i] + theta * (change + rest * (rest * first - theta * last))

        return dense

    def dense(self, theta: Term, array: Array, at: Term) -> None:
        """Writes y at a share of the step into an array, from an index on."""
        o = self.context
        rest = 1.0 - theta
        with self.writer.count(o.n) as i:
            terms = [o.work[o.row(self.weights + k) + i] for k in range(len(self.tableau.dense))]
            value = terms[-1]
            for k in reversed(range(len(terms) - 1)):
                value = terms[k] + (theta if k % 2 else rest) * value
            array[at + i] = o.y[i] + (theta * value + o.lag[i])


def _joined(w: Writer, errors: Sequence[Term]) -> Term:
    """The error from one estimate, or from two, a and b, as a/√(a² + b²/100) times a: Hairer, Nørsett & Wanner, sec. II.10."""
    if len(errors) == 1:
        return errors[0]
    a, b = errors
    square = a * a
    both = square + 0.01 * (b * b)
    return w.select(both > 0.0, square / w.compute("sqrt", both), both)
