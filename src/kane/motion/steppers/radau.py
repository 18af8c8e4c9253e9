# SPDX-License-Identifier: BSD-3-Clause
"""Radau IIA collocation with five stages, order 9, for stiff equations: stages by Newton's method with exact derivatives.

With z_i the state at node i minus y, Σ_j A⁻¹_ij z_j / h = f(t + c_i h, y + z_i), and y' = y + z_s. Each iteration solves for one real
and two complex unknowns into which these decouple (`radau_stages`), the complex ones as real systems of twice the size. J and its
factors are kept while iterations converge fast and the step size stays. The first guess is the last step's polynomial.

The error estimate, of order 5, is (λ/h − J)⁻¹ times the difference, at t, of f(y) from the polynomial of the stages' rates. A step is
accepted if it is within the tolerance; between the nodes the state is ten times more accurate than that, at the end far more. A
larger estimate is repeated at y + error, where stiff components have decayed. Source: Hairer & Wanner, *Solving Ordinary Differential
Equations II*, 2nd ed. 1996, sec. IV.8.
"""

from collections.abc import Callable, Mapping
from typing import Any, Literal

import numpy as np

from kane.motion.steppers.collocation import radau_stages
from kane.motion.steppers.context import RATE, Slot, StepperContext, add_exactly, of_others
from kane.motion.steppers.inspection import StepInspection
from kane.numeric.arrays import Array as Numbers
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Array, Term, decompose, substitute

STAGES = 5
_M = radau_stages(STAGES)
_PAIRS = len(_M.eigenvalues) - 1
_FIRST, _STATE, AFTER, _AFTER_LAG, _SPARE, _RIGHT, Z = range(7)
"""Rows of n doubles: f(y), a state, the end of the step and its rounding error, two free ones, the z_i."""
_BEFORE, _RATES, _PARTS = (Z + STAGES * k for k in (1, 2, 3))
_ROWS = Z + 4 * STAGES
_REST = 0.1
_SAFETY, _LEAST, _MOST, _SAME = 0.9, 0.2, 5.0, 1.2
_EXPONENT = 11 / 64
_ROUNDS, _FAST = 10, 0.03
_HUGE = 1e300
_GOING, _FOUND, _LOST = range(3)
_OLD, _NEW = 1.0, 2.0
LONG: tuple[Literal["float", "array"], ...] = (*RATE, "array")
"""Types of the arguments of the routine of J v: v follows r."""


def radau_work(n: int) -> int:
    """The length of `work` for n components."""
    return _ROWS * n + n * n * (2 + 4 * _PAIRS) + n * (1 + 2 * _PAIRS) + 3


def radau_kernel(held: bool = False, watched: bool = False, sided: bool = False) -> Kernel:
    """The kernel. Besides the arguments of all steppers, `jac` returns J without its last, zero column; if `long`, `along` J v.

    With `held`, the end of each step and each sample are projected onto the constraints; with `watched`, events are detected, with
    `sided` switches too.
    """
    return _Radau(held, watched, sided).kernel()


def radau_end(n: int) -> int:
    """The index in `work` of the end of a step, projected onto the constraints."""
    return AFTER * n


def radau_dense(given: Mapping[str, Any], h: float, start: float) -> Callable[[Numbers], Numbers]:
    """The state (k × n) as a function of times (k) in the step of length h from `start`, from the arrays of the kernel."""
    begin, n, stages = (given["y"] + given["lag"]).copy(), len(given["y"]), _M
    z, c = given["work"][Z * n : (Z + STAGES) * n].reshape(STAGES, n).copy(), np.array(stages.c)

    def state(times: Numbers) -> Numbers:
        theta = ((times - start) / h)[:, None]
        others = np.array([np.delete(c, i) for i in range(STAGES)])
        weights = theta * np.prod(theta[:, :, None] - others, axis=2) * stages.lagrange
        result: Numbers = begin + weights @ z
        return result

    return state


class _Radau:
    """Builds the kernel; indices in `work` are terms."""

    def __init__(self, held: bool, watched: bool, sided: bool) -> None:
        self.context = o = StepperContext("radau9")
        self.writer = w = o.writer
        self.rhs, self.jac = (w.callee(name, *RATE) for name in ("rhs", "jac"))
        self.along = w.callee("along", *LONG)
        self.long, self.hj = w.number("long"), w.hoisted("hj")
        o.drives(*RATE)
        self.inspection = StepInspection(o, self.dense, held, watched, sided)
        self._work_layout()
        self.status, self.round = w.variable("status", INT), w.variable("round", INT)
        self.change, self.before = w.variable("change"), w.variable("before_last")
        self.rate_of = w.variable("convergence")
        self.error, self.shorter = w.variable("error"), w.variable("shorter", INT)

    def _work_layout(self) -> None:
        """Assigns the indices in `work` of matrices and of the numbers that are kept between calls."""
        n, at = self.context.n, self.context.row(_ROWS)
        self.slopes, at = at, at + n * n
        sizes = [n, *[n * 2] * _PAIRS]
        self.factors = []
        for size in sizes:
            self.factors.append((at, size, at + size * size))
            at = at + size * size + size
        self.known, self.factored, self.followed = at, at + 1, at + 2

    def row(self, k: int, j: int = 0) -> Term:
        """The index of row k + j."""
        return self.context.row(k + j)

    # ------------------------------------------------------------------------------------------------------ kernel

    def kernel(self) -> Kernel:
        """The kernel: initial rates, then the loop over steps."""
        o = self.context

        def begin() -> None:
            self.inspection.begin()
            o.rate(self.rhs, o.get(Slot.TIME), o.y, 0, self.row(_FIRST))
            o.first_step(_EXPONENT, self.rhs, self.row(_FIRST), self.row(_STATE), self.row(_SPARE))
            for place in (self.known, self.factored, self.followed):
                o.work[place] = 0.0
            o.put(Slot.FRESH, 0.0)

        def step(h: Term, last: Term) -> None:
            self.linearize(h)
            self.guess(h)
            self.iterate(h)
            self.decide(h, last)

        return o.steps(begin, step)

    def linearize(self, h: Term) -> None:
        """Evaluates J, unless it is kept, and factorizes λ/h − J if h or J has changed."""
        w, o, n = self.writer, self.context, self.context.n
        with w.when(o.work[self.known] <= 0.0):
            o.drive(o.get(Slot.TIME), o.y.at(0))
            with w.when(self.long > 0):
                self.by_columns()
            with w.otherwise():
                given = o.y.at(0), o.p.at(0), o.r.at(0), self.hj.at(0)
                self.jac(o.get(Slot.TIME), *given, o.work.at(self.slopes))
            # a derivative that does not exist counts as zero: J affects convergence, not the solution
            with w.count(n * (n - 1)) as i:
                slope = o.work[self.slopes + i]
                o.work[self.slopes + i] = w.select(w.compute("abs", slope) < _HUGE, slope, 0.0)
            o.work[self.known] = _NEW
            o.work[self.factored] = 0.0
        with w.when((o.work[self.factored] < h) | (h < o.work[self.factored])):
            for value, (at, size, swaps) in zip(_M.eigenvalues, self.factors, strict=True):
                self.matrix(value, h, at, size)
                decompose(o.work, at, size, swaps)
            o.work[self.factored] = h

    def by_columns(self) -> None:
        """Evaluates J column by column."""
        w, o, n = self.writer, self.context, self.context.n
        unit, found = self.row(_SPARE), self.row(_RIGHT)
        with w.count(n) as j:
            o.work[unit + j] = 0.0
        with w.count(n - 1) as j:
            o.work[unit + j] = 1.0
            given = o.y.at(0), o.p.at(0), o.r.at(0), o.work.at(unit), self.hj.at(0)
            self.along(o.get(Slot.TIME), *given, o.work.at(found))
            o.work[unit + j] = 0.0
            with w.count(n) as i:
                o.work[self.slopes + i * (n - 1) + j] = o.work[found + i]

    def matrix(self, value: complex, h: Term, at: Term, size: Term) -> None:
        """Writes λ/h − J to an index, with complex λ as [[ℜ − J, −ℑ], [ℑ, ℜ − J]]."""
        w, o, n = self.writer, self.context, self.context.n
        work, copies = o.work, (0, 1) if value.imag else (0,)
        with w.count(size * size) as i:
            work[at + i] = 0.0
        with w.few(n) as i:
            for copy in copies:
                corner = at + (i + n * copy) * size + n * copy
                with w.count(n - 1) as j:
                    work[corner + j] = -work[self.slopes + i * (n - 1) + j]
                work[corner + i] = work[corner + i] + value.real / h
            if value.imag:
                work[at + i * size + n + i] = -value.imag / h
                work[at + (i + n) * size + i] = value.imag / h

    def guess(self, h: Term) -> None:
        """Sets z from the polynomial of the last step, or to zero."""
        w, o = self.writer, self.context
        with w.when(o.work[self.followed] > 0.0):
            share = h / o.get(Slot.LAST_STEP)
            weights = [self.lagrange(1.0 + share * c) for c in _M.c]
            with w.count(o.n) as i:
                last = [o.work[self.row(_BEFORE, j) + i] for j in range(STAGES)]
                for k, own in enumerate(weights):
                    o.work[self.row(Z, k) + i] = w.sum([x * z for x, z in zip(own, last, strict=True)]) - last[-1]
        with w.otherwise(), w.count(o.n * STAGES) as i:
            o.work[self.row(Z) + i] = 0.0

    def lagrange(self, theta: Term) -> list[Term]:
        """The weights of the z_i in the state at a share of the step."""
        others = of_others([theta - c for c in _M.c], theta, self.writer.constant(1.0))
        return [a * x for a, x in zip(others, _M.lagrange, strict=True)]

    # --------------------------------------------------------------------------------------------------- iteration

    def iterate(self, h: Term) -> None:
        """Newton iteration, down to a tenth of the tolerance."""
        w = self.writer
        self.status.put(_GOING)
        self.round.put(0)
        self.before.put(_HUGE)
        self.rate_of.put(0.0)
        with w.repeat(lambda: self.status.get() < 1):
            self.residuals(h)
            for k, (at, size, swaps) in enumerate(self.factors):
                substitute(self.context.work, at, size, swaps, self.row(_PARTS, max(0, 2 * k - 1)))
            self.move()
            self.judge(self.change.get())

    def residuals(self, h: Term) -> None:
        """Computes f − A⁻¹ z / h, transformed by `split`."""
        w, o = self.writer, self.context
        for k, c in enumerate(_M.c):
            with w.count(o.n) as i:
                o.work[self.row(_STATE) + i] = o.y[i] + (o.work[self.row(Z, k) + i] + o.lag[i])
            o.rate(self.rhs, o.get(Slot.TIME) + h * c, o.work, self.row(_STATE), self.row(_RATES, k))
        with w.count(o.n) as i:
            z = [o.work[self.row(Z, j) + i] / h for j in range(STAGES)]
            left = []
            for k, own in enumerate(_M.inverse):
                left.append(o.work[self.row(_RATES, k) + i] - w.sum([x * y for x, y in zip(z, own, strict=True)]))
            for k, own in enumerate(_M.split):
                o.work[self.row(_PARTS, k) + i] = w.sum([x * y for x, y in zip(left, own, strict=True)])

    def move(self) -> None:
        """Adds the solution to z; sets `change` to its largest component in units of the tolerance."""
        w, o = self.writer, self.context
        self.change.put(0.0)
        with w.count(o.n) as i:
            parts = [o.work[self.row(_PARTS, j) + i] for j in range(STAGES)]
            allowed = o.allowed(i, o.work[self.row(Z, STAGES - 1) + i] + o.y[i])
            for k, own in enumerate(_M.joined):
                moved = w.sum([x * y for x, y in zip(parts, own, strict=True)])
                at = self.row(Z, k) + i
                o.work[at] = o.work[at] + moved
                self.change.put(w.compute("max", self.change.get(), w.compute("abs", moved) / allowed))

    def judge(self, change: Term) -> None:
        """Decides whether z has converged, or the iteration is given up."""
        w, rounds, before = self.writer, self.round.get(), self.before.get()
        rate = w.select(rounds > 0, change / before, 1.0)
        left = w.select(rounds > 0, change * (rate / (1.0 - rate)), change)
        still = (rounds > 1) & (change >= 0.3 * before) & (change < 1.0)
        with w.when((rounds > 0) & (rate > self.rate_of.get())):
            self.rate_of.put(rate)
        with w.when(((rate < 1.0) & (left <= _REST)) | ((rounds < 1) & (left <= _REST)) | still):
            self.status.put(_FOUND)
        with w.otherwise():
            grows = (rounds > 0) & (rate >= 2.0) | (rounds > 2) & (rate >= 1.0)
            with w.when(~(change < _HUGE) | grows | (rounds >= _ROUNDS)):
                self.status.put(_LOST)
        self.before.put(change)
        self.round.put(rounds + 1)

    # ------------------------------------------------------------------------------------------------------- error

    def measure(self, h: Term) -> None:
        """Sets `error` to the largest error of a component in units of its tolerance; stores the index in WORST."""
        w, o = self.writer, self.context
        with w.count(o.n) as i:
            z = [o.work[self.row(Z, j) + i] * x for j, x in enumerate(_M.estimate)]
            o.work[self.row(_SPARE) + i] = w.sum(z) / h
            new, lag = add_exactly(o.y, o.lag, i, o.work[self.row(Z, STAGES - 1) + i])
            o.work[self.row(AFTER) + i] = new
            o.work[self.row(_AFTER_LAG) + i] = lag
        self.filtered(_FIRST)
        with w.when((self.error.get() > 1.0) & (self.error.get() < _HUGE)):
            with w.count(o.n) as i:
                o.work[self.row(_STATE) + i] = o.y[i] + o.work[self.row(_RIGHT) + i]
            o.rate(self.rhs, o.get(Slot.TIME), o.work, self.row(_STATE), self.row(_RATES))
            self.filtered(_RATES)

    def filtered(self, rates: int) -> None:
        """The error estimate with the initial rates that are in a row."""
        w, o = self.writer, self.context
        right, (at, size, swaps) = self.row(_RIGHT), self.factors[0]
        with w.count(o.n) as i:
            o.work[right + i] = o.work[self.row(rates) + i] + o.work[self.row(_SPARE) + i]
        substitute(o.work, at, size, swaps, right)

        def error(i: Term) -> Term:
            allowed = o.allowed(i, o.work[self.row(AFTER) + i])
            return w.compute("abs", o.work[right + i]) / allowed

        o.largest_error(self.error, error)

    def decide(self, h: Term, last: Term) -> None:
        """Accepts the step or repeats it: with a new J first, if the iteration failed with an old one."""
        w, o = self.writer, self.context
        with w.when(self.status.get() > _FOUND):
            with w.when(o.work[self.known] < _NEW):
                o.work[self.known] = 0.0
            with w.otherwise():
                self.shorter.put(1)
                o.shorten(h * 0.5, self.change.get() < _HUGE)
        with w.otherwise():
            self.measure(h)
            error = self.error.get()
            finite, power = o.power(error, _EXPONENT)
            factor = w.select(finite, w.compute("max", _SAFETY / power, _LEAST), _LEAST)
            with w.when(error <= 1.0):
                along = self.row(_STATE), self.row(AFTER)
                self.inspection.look(h, last, along[1], lambda w: w.look_along(o.get(Slot.TIME), h, *along))
                most = w.compute("min", factor, w.select(self.shorter.get() > 0, 1.0, _MOST))
                self.inspection.follow(lambda: self.go_on(h, last, most))
                self.shorter.put(0)
            with w.otherwise():
                self.shorter.put(1)
                o.shorten(h * w.compute("min", factor, _SAFETY), finite)

    # -------------------------------------------------------------------------------------------------------- steps

    def go_on(self, h: Term, last: Term, factor: Term) -> None:
        """Accepts the step; keeps J and its factors if the iteration converged fast."""
        w, o, held = self.writer, self.context, self.inspection.held
        o.sample(h, lambda: None, self.inspection.sample)
        o.advance(h, last)
        with w.count(o.n) as i:
            o.y[i] = o.work[self.row(AFTER) + i]
            o.lag[i] = o.work[self.row(_AFTER_LAG) + i]
        with w.count(o.n * STAGES) as i:
            o.work[self.row(_BEFORE) + i] = o.work[self.row(Z) + i]
        o.work[self.followed] = 1.0
        if held is not None:
            held.kept()
        o.rate(self.rhs, o.get(Slot.TIME), o.y, 0, self.row(_FIRST))
        fast = self.rate_of.get() <= _FAST
        o.work[self.known] = w.select(fast, _OLD, 0.0)
        same = fast & (factor >= 1.0) & (factor <= _SAME)
        # a step that was cut at the end is no measure for the next one
        with w.when(~last):
            o.put(Slot.STEP, h * w.select(same, 1.0, factor))

    def dense(self, theta: Term, array: Array, at: Term) -> None:
        """Writes y at a share of the step into an array, from an index on."""
        w, o = self.writer, self.context
        weights = self.lagrange(theta)
        with w.count(o.n) as i:
            z = [o.work[self.row(Z, j) + i] * x for j, x in enumerate(weights)]
            array[at + i] = o.y[i] + (w.sum(z) + o.lag[i])
