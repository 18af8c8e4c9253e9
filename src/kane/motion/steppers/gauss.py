# SPDX-License-Identifier: BSD-3-Clause
"""Gauss collocation with eight stages, order 16: all stages in one call of the right-hand side, on eight vector lanes.

In a step the rates are polynomials k(θ) of degree 7 through their values K at the nodes, and y + h ∫ k is the state. K is computed by
fixed-point iteration from the extrapolated polynomials of the last step. If q' is u_j, q is y_q + h c u_j + h² A² K_j and no unknown.
Samples cost no evaluation.

The error of component i is judged by r = h |leading coefficient of k_i| / (|y_i| + atol/rtol). The error at the end is about r², as
the order is twice that of the stages, and within the step 1e-6 r: r is kept to √rtol, and steps are accepted up to thirty times that,
as the end is far more accurate. The iteration stops when its error is a tenth of rtol. Source of the method: Hairer, Lubich & Wanner,
*Geometric Numerical Integration*, 2nd ed. 2006, sec. II.1.3, VIII.6.

A jump of the rates between two nodes distorts the polynomial through the stages, which shows it. A jump before the first node or
after the last one, in a fiftieth of the step at either end, does not affect the stages: the state is off by the jump times that part
of the step. Rates that may jump are therefore evaluated at both ends and between the nodes too, in one call. Smooth rates differ from
the polynomial only by the next divided difference, which is ω(1) = 1/12870 of the one that controls the step, times their ratio.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from kane.motion.steppers.collocation import Nodes, Vector, gauss, once_integrated
from kane.motion.steppers.context import WIDE, Slot, StepperContext, add_exactly, of_others
from kane.motion.steppers.inspection import StepInspection
from kane.motion.steppers.watched import Watched
from kane.numeric.arrays import Array as Numbers
from kane.numeric.polynomials import SHARES, D, legendre
from kane.program.kernel.language import INT, Kernel, Type
from kane.program.kernel.writer import Array, Term, Writer

STAGES = 8
_N = gauss(STAGES)
_V = Type("float", STAGES)
_SAFETY, _LEAST, _MOST = 0.95, 0.3, 2.0
_ACCEPTED, _SMOOTH, _STRAIGHT = 30.0, 1e-4, 2.0
_ITERATIONS = 12
_REST, _FLOOR = 0.1, 2.0**-50
_SLOW, _STALLED = 0.9, 1e-8
_HUGE = 1e300
_GOING, _FOUND, _DIVERGED = range(3)
Columns = Callable[[], Sequence[Term]]


def gauss_kernel(
    accepted: float = _ACCEPTED,
    rounds: int = _ITERATIONS,
    held: bool = False,
    watched: bool = False,
    sided: bool = False,
    cornered: bool = False,
) -> Kernel:
    """The kernel. Besides the arguments of all steppers, `pairs` contains the (i, j) with q_i' = u_j, `free` the others but the last.

    The last component is an integral on which no rate depends. If `cornered`, rates, which may jump, are compared with their
    polynomials along each step. `work` contains 35 n + 8 doubles: K, its extrapolation, the states and rates of the stages, their
    times, h over the sizes of the components, the end of the step. Steps are accepted with `accepted` times the desired error, after
    at most `rounds` iterations. With `held`, the end of each step and each sample are projected onto the constraints; with `watched`,
    events are detected, with `sided` switches too.
    """
    return _Gauss(accepted, rounds, held, watched, sided, cornered).kernel()


def gauss_end(n: int) -> int:
    """The index in `work` of the end of a step, projected onto the constraints, except for the last component."""
    return 4 * STAGES * n + STAGES + n


def gauss_dense(given: Mapping[str, Any], h: float, start: float) -> Callable[[Numbers], Numbers]:
    """The state (k × n) as a function of times (k) in the step of length h from `start`, from the arrays of the kernel."""
    y, lag, work, pairs, free = (given[name] for name in ("y", "lag", "work", "pairs", "free"))
    n = len(y)
    begin, rates = (y + lag).copy(), work[3 * STAGES * n : 4 * STAGES * n].reshape(n, STAGES)
    of, by = pairs.reshape(-1, 2)[: given["pair_count"]].astype(int).T
    others = [*free[: given["free_count"]].astype(int), n - 1]
    once, twice = _integrals()
    series = np.zeros((STAGES + 2, n))  # of y(θ) − y(0) in P_k(2 θ − 1)
    series[:, others] = h * once @ rates[others].T
    series[:, of] = h * h * twice @ rates[by].T
    series[:2, of] += h / 2 * begin[by]

    def state(times: Numbers) -> Numbers:
        rows: Numbers = begin + _legendre((times - start) / h) @ series
        return rows

    return state


def _legendre(theta: Numbers) -> Numbers:
    """P_0 … P_9 of 2 θ − 1 (k × 10) at shares of a step (k)."""
    x = 2 * theta - 1
    at = float(x[0]) if len(x) == 1 else x  # numbers are faster than arrays of one
    return np.array(legendre(STAGES + 2, at)).reshape(STAGES + 2, -1).T


@cache
def _integrals() -> tuple[Numbers, Numbers]:
    """Coefficients of ∫ L_j and ∫∫ L_j from 0 to θ in P_0 … P_9 of 2 θ − 1 (10 × 8 each)."""
    nodes, double = gauss(STAGES), 2.0 * np.arange(STAGES + 1) + 1
    p = np.eye(STAGES + 2)
    once = np.vstack([(p[0] + p[1]) / 2, (p[2:] - p[:-2]) / (2 * double[1:, None])])
    twice = np.vstack([p[0] / 6 + p[1] / 4 + p[2] / 12, (once[2:] - once[:-2]) / (2 * double[1:STAGES, None])])
    rows = double[:STAGES, None] * np.array(nodes.legendre[:STAGES]) * nodes.b
    return once[:STAGES].T @ rows, twice.T @ rows


def along(theta: Numbers) -> tuple[Numbers, Numbers]:
    """∫ L_j and ∫∫ L_j (k × 8 each) from 0 to shares of a step (k)."""
    once, twice = (_legendre(theta) @ x for x in _integrals())
    return once, twice


def integrals(nodes: Nodes, theta: float) -> tuple[Vector, Vector]:
    """∫ L_j and ∫∫ L_j from 0 to θ."""
    count, x = len(nodes.c), D(2 * theta - 1)
    p = legendre(count + 3, x)
    once = once_integrated(p, D(theta))
    twice = [D(theta) ** 2 / 2] + [(once[k + 1] - once[k - 1]) / (2 * (2 * k + 1)) for k in range(1, count)]
    rows = [[(2 * k + 1) * b * v for k, v in enumerate(column)] for b, column in _columns(nodes)]
    first, second = ([sum(float(i) * r for i, r in zip(of, row, strict=False)) for row in rows] for of in (once, twice))
    return tuple(first), tuple(second)


def lagrange(nodes: Nodes, theta: float) -> Vector:
    """L_j at θ."""
    p = legendre(len(nodes.c), D(2 * theta - 1))
    return tuple(
        float(sum((2 * k + 1) * float(p[k]) * v for k, v in enumerate(column)) * b) for b, column in _columns(nodes)
    )


def _columns(nodes: Nodes) -> Iterator[tuple[float, Vector]]:
    """For each node, its weight and P_0, P_1, … there."""
    return zip(nodes.b, zip(*nodes.legendre[: len(nodes.c)], strict=True), strict=True)


_BETWEEN = (0.0, 0.06, 0.17, 0.32, 0.5, 0.68, 0.83, 1.0)
_REACH = 0.02
"""Share of a step after its last node."""
_TOLERANCES, _BENT = 5.0, 1.5e-5
"""Tolerated differences: a multiple of rtol, and a share of the step's error estimate, ten times the one that smooth rates have."""


@dataclass(frozen=True, slots=True)
class DenseOutputWeights:
    """Weights of the rates at the nodes: row j of `once`, `twice`, `rates` has those of node j in ∫ k, ∫∫ k, k at eight `shares`.

    If `ended`, the last state is replaced by the projected one at which the motion continues.
    """

    shares: Vector
    once: tuple[Vector, ...]
    twice: tuple[Vector, ...]
    rates: tuple[Vector, ...]
    ended: bool

    def larger(self, w: Writer, before: Term, gap: Term) -> Term:
        """The larger sizes, lane by lane; what is not finite stays so."""
        size = w.compute("abs", gap)
        return w.select(size > before, size, before) + size * w.lanes(*[0.0] * len(self.shares))

    def share(self, w: Writer, gaps: Term, rtol: Term, error: Term) -> Term:
        """The error of the state that a jump may have caused, by the gaps times h over sizes, relative to the tolerated one."""
        largest = w.compute("largest", gaps) + w.compute("sum", gaps) * 0.0
        return largest * _REACH / (rtol * _TOLERANCES + error * _BENT)


@cache
def events() -> DenseOutputWeights:
    """Weights at the places where event quantities are evaluated, without the beginning of the step."""
    return _along(SHARES[1:], True)


@cache
def defects() -> DenseOutputWeights:
    """Weights at both ends of the step and at places between."""
    return _along(_BETWEEN, False)


def _along(shares: Vector, ended: bool) -> DenseOutputWeights:
    once, twice = (tuple(zip(*rows, strict=True)) for rows in zip(*(integrals(_N, s) for s in shares), strict=True))
    return DenseOutputWeights(shares, once, twice, tuple(zip(*(lagrange(_N, s) for s in shares), strict=True)), ended)


def weights(w: Writer, theta: Term, nodes: Nodes) -> tuple[Term, Term]:
    """The weights of the rates at the nodes in ∫ k and ∫∫ k up to θ, one per lane."""
    count = len(nodes.c)
    x = theta * 2.0 - 1.0
    p = [w.constant(1.0), x]
    for k in range(1, count + 1):
        p.append((x * p[k] * float(2 * k + 1) - p[k - 1] * float(k)) * (1 / (k + 1)))
    once = [theta] + [(p[k + 1] - p[k - 1]) * (0.5 / (2 * k + 1)) for k in range(1, count + 1)]
    twice = [theta * theta * 0.5] + [(once[k + 1] - once[k - 1]) * (0.5 / (2 * k + 1)) for k in range(1, count)]
    rows = [tuple((2 * k + 1) * b * v for b, v in zip(nodes.b, nodes.legendre[k], strict=True)) for k in range(count)]
    first, second = ([w.compute("splat8", v) * r for v, r in zip(i, rows, strict=False)] for i in (once, twice))
    return w.sum(first), w.sum(second)


class _Gauss:
    """Builds the kernel; indices in `work` are terms."""

    def __init__(self, accepted: float, rounds: int, held: bool, watched: bool, sided: bool, cornered: bool) -> None:
        self.accepted, self.rounds, self.cornered = accepted, rounds, cornered
        self.context = o = StepperContext("gauss16")
        self.writer = w = o.writer
        self.rhs = w.callee("rhs", *WIDE)
        o.drives(*WIDE, single=held or watched)
        self.pairs, self.free = w.array("pairs"), w.array("free")
        self.pair_count, self.free_count = w.number("pair_count"), w.number("free_count")
        self.inspection = StepInspection(o, self.along, held, watched, sided, wide=True)
        self.held = self.inspection.held
        n8 = o.n * STAGES
        self.k, self.next, self.states, self.rates = w.integer(0), n8, n8 * 2, n8 * 3
        self.clock, self.weight = n8 * 4, n8 * 4 + STAGES
        self.after, self.after_lag = (self.weight + o.n * k if held else self.weight for k in (1, 2))
        self.status, self.round = w.variable("status", INT), w.variable("round", INT)
        self.error, self.before, self.step_length = (w.variable(name) for name in ("error", "before_last", "length"))
        self.change = w.variable("change", _V)
        self.matrix = [w.variable(f"a{j}", _V) for j in range(STAGES)]
        self.square = [w.variable(f"aa{j}", _V) for j in range(STAGES)]

    # ----------------------------------------------------------------------------------------------------- helpers

    def splat(self, x: Term) -> Term:
        """A number in all lanes."""
        return self.writer.compute("splat8", x)

    def lanes(self, place: Term, i: Term, array: Array | None = None) -> Term:
        """The eight doubles of component i."""
        return (array or self.context.work).lanes(place + i * STAGES, STAGES)

    def keep(self, place: Term, i: Term, value: Term) -> None:
        """Stores the eight doubles of component i."""
        self.context.work.store(place + i * STAGES, value)

    def index(self, array: Array, at: Term) -> Term:
        """An index that is stored as a double."""
        return self.writer.compute("int", array[at])

    def each_free(self) -> AbstractContextManager[Term]:
        """A loop over the entries of `free`."""
        return self.writer.count(self.free_count)

    def combined(self, place: Term, i: Term, columns: Sequence[Term | tuple[float, ...]]) -> list[Term]:
        """The products of column_j and the rate of component i at node j, which the caller adds."""
        work = self.context.work
        return [self.splat(work[place + i * STAGES + j]) * column for j, column in enumerate(columns)]

    def scale(self, i: Term) -> Term:
        """|y_i| + atol/rtol."""
        o = self.context
        return self.writer.compute("abs", o.y[i]) + o.get(Slot.ATOL) / o.get(Slot.RTOL)

    # ------------------------------------------------------------------------------------------------------ kernel

    def kernel(self) -> Kernel:
        """The kernel: the loop over steps, the first one from its initial rates."""

        def step(h: Term, last: Term) -> None:
            self.guess(h)
            self.iterate(h)
            self.decide(h, last)

        return self.context.steps(self.begin, step)

    def begin(self) -> None:
        """Evaluates the initial rates, which become the first guess of K, and chooses the first step."""
        o = self.context
        self.inspection.begin()
        now = self.at_one_state(o.get(Slot.TIME), lambda i: o.y[i])
        with self.writer.count(o.n) as i:
            self.keep(self.next, i, self.splat(now(i)))
        o.choose_step(1 / STAGES, lambda i: o.work[self.next + i * STAGES], self.at_one_state)

    def guess(self, h: Term) -> None:
        """Extrapolates K from the last step, unless the step is FRESH."""
        w, o = self.writer, self.context
        with w.when(o.get(Slot.FRESH) <= 0.0):
            share = self.splat(h / o.get(Slot.LAST_STEP)) * _N.c + 1.0
            others = of_others([share - c for c in _N.c], *[w.lanes(*[1.0] * STAGES)] * 2)
            columns = [a * x for a, x in zip(others, _N.top, strict=True)]
            with self.each_free() as at:
                i = self.index(self.free, at)
                self.keep(self.next, i, w.sum(self.combined(self.k, i, columns)))

    def at_one_state(self, t: Term, y: Callable[[Term], Term]) -> Callable[[Term], Term]:
        """Evaluates the rates at one time and state, and returns them by component."""
        with self.writer.count(self.context.n) as i:
            self.keep(self.states, i, self.splat(y(i)))
        self.tick(self.splat(t))
        self.evaluate()
        return lambda i: self.context.work[self.rates + i * STAGES]

    def tick(self, times: Term) -> None:
        """Stores the times of the lanes, and evaluates the inputs there."""
        o = self.context
        o.work.store(self.clock, times)
        o.drive(o.work.at(self.clock), o.work.at(self.states))

    def evaluate(self, to: Term | None = None) -> None:
        """Evaluates the rates at the states of the stages."""
        o = self.context
        o.follow(*(o.work.at(x) for x in (self.clock, self.states)))
        rates = o.work.at(self.rates if to is None else to)
        self.rhs(*(o.work.at(x) for x in (self.clock, self.states)), o.p.at(0), o.r.at(0), o.h.at(0), rates)
        o.more(Slot.RATES, 1.0)

    def iterate(self, h: Term) -> None:
        """Solves for K by fixed-point iteration."""
        w, o = self.writer, self.context
        for j in range(STAGES):
            self.matrix[j].put(self.splat(h) * _N.a[j])
            self.square[j].put(self.splat(h * h) * _N.a2[j])
        self.tick(self.splat(o.get(Slot.TIME)) + self.splat(h) * _N.c)
        with w.count(o.n) as i:
            o.work[self.weight + i] = h / self.scale(i)
        self.status.put(_GOING)
        self.round.put(0)
        self.before.put(0.0)
        self.stages(h, self.next)
        with w.repeat(lambda: self.status.get() < 1):
            self.evaluate()
            self.change.put(w.lanes(*[0.0] * STAGES))
            with self.each_free() as at:
                i = self.index(self.free, at)
                rates = self.lanes(self.rates, i)
                moved = w.compute("abs", rates - self.lanes(self.next, i)) * self.splat(o.work[self.weight + i])
                self.change.put(self.larger(self.change.get(), moved))
                self.keep(self.next, i, rates)
            self.judge(self.largest(self.change.get()))
            with w.when(self.status.get() < 1):
                # from the rates just written, which are read faster than their copy
                self.stages(h, self.rates)

    def larger(self, a: Term, b: Term) -> Term:
        """The larger one, or b if a is NaN: rates that are not finite are detected by their leading coefficients."""
        return self.writer.select(a > b, a, b)

    def largest(self, lanes: Term) -> Term:
        """The largest lane."""
        found = [self.writer.compute("lane", lanes, lane=k) for k in range(STAGES)]
        while len(found) > 1:
            half = len(found) // 2
            found = [self.larger(a, b) for a, b in zip(found[:half], found[half:], strict=True)]
        return found[0]

    def stages(self, h: Term, place: Term) -> None:
        """Computes the states at the nodes from the rates at an index."""
        self.states_at(_N.c, h, place, lambda: [m.get() for m in self.matrix], lambda: [m.get() for m in self.square])

    def states_at(self, shares: Vector, h: Term, place: Term, once: Columns, twice: Columns) -> None:
        """Computes the states at eight shares of the step from the rates at an index, with weights h ∫ L_j and h² ∫∫ L_j."""
        w, o = self.writer, self.context
        with self.each_free() as at:
            i = self.index(self.free, at)
            self.keep(self.states, i, w.sum(self.combined(place, i, once())) + self.splat(o.y[i]))
        with w.count(self.pair_count) as at:
            i, j = self.index(self.pairs, at * 2), self.index(self.pairs, at * 2 + 1)
            terms = self.combined(place, j, twice())
            straight = self.splat(o.y[i]) + self.splat(h * o.y[j]) * shares
            self.keep(self.states, i, w.sum(terms) + straight)

    def judge(self, change: Term) -> None:
        """Decides whether the iteration has converged, or is given up."""
        w, o = self.writer, self.context
        before, rounds = self.before.get(), self.round.get()
        wanted = w.compute("max", o.get(Slot.RTOL) * _REST, _FLOOR)
        stalled = (rounds > 2) & (change >= before) & (change < _STALLED)
        # the next change is about change²/before, where `before` is 0 at first
        with w.when((change <= wanted) | (change * change <= wanted * before) | stalled):
            self.status.put(_FOUND)
        with w.otherwise():
            slow = (rounds >= self.rounds // 6) & (change > _SLOW * before) & (change > _STALLED)
            with w.when(~(change < _HUGE) | slow | (rounds >= self.rounds)):
                self.status.put(_DIVERGED)
        self.before.put(change)
        self.round.put(rounds + 1)

    def target(self) -> Term:
        """√rtol, the desired r."""
        return self.writer.compute("sqrt", self.context.get(Slot.RTOL))

    def measure(self) -> None:
        """Sets `error` to the largest r of a component, relative to the desired one."""
        w, o = self.writer, self.context

        def error(i: Term) -> Term:
            top = w.compute("abs", w.compute("sum", self.lanes(self.rates, i) * _N.top))
            return top * o.work[self.weight + i] / self.target()

        o.largest_error(self.error, error)

    def compare(self, h: Term) -> None:
        """Compares rates between and beyond the nodes with their polynomials, and raises `error` where they differ: a jump."""
        w, o = self.writer, self.context
        at = defects()
        self.inspection_states(h, at)
        self.evaluate(self.next)  # which is no longer needed
        self.change.put(w.lanes(*[0.0] * STAGES))
        with w.count(o.n) as i:
            gap = self.lanes(self.next, i) - w.sum(self.combined(self.rates, i, at.rates))
            self.change.put(at.larger(w, self.change.get(), gap * self.splat(o.work[self.weight + i])))
        share = at.share(w, self.change.get(), o.get(Slot.RTOL), self.error.get() * self.target())
        with w.when(~(share <= 1.0)):
            self.error.put(share * self.accepted)

    def bend(self) -> Term:
        """The largest change of a rate along the step, times h over the component's size; the iteration error hardly affects it."""
        w, o = self.writer, self.context
        largest = w.variable("bend")
        largest.put(0.0)
        with w.count(o.n) as i:
            rates = self.lanes(self.rates, i)
            change = w.compute("lane", rates, lane=STAGES - 1) - w.compute("lane", rates, lane=0)
            largest.put(w.compute("max", largest.get(), w.compute("abs", change) * o.work[self.weight + i]))
        return largest.get()

    def decide(self, h: Term, last: Term) -> None:
        """Accepts or rejects the step."""
        w, o = self.writer, self.context
        self.measure()
        if self.cornered:
            with w.when((self.status.get() < _DIVERGED) & (self.error.get() <= self.accepted)):
                self.compare(h)
        error = self.error.get()
        finite, power = o.power(error, 1 / STAGES)
        factor = _SAFETY / power
        found = (self.status.get() < _DIVERGED) & (error <= self.accepted)
        with w.when(found):
            self.look_at(h, last)
            self.inspection.follow(lambda: self.go_on(h, last, factor))
        with w.when((self.status.get() >= _DIVERGED) & finite):
            o.more(Slot.LIMITED, 1.0)
        with w.when(~found):
            half = (self.status.get() >= _DIVERGED) | ~finite
            o.shorten(h * w.select(half, 0.5, w.compute("max", w.compute("min", factor, _SAFETY), _LEAST)), finite)

    def look_at(self, h: Term, last: Term) -> None:
        """Inspects the step before it is accepted."""

        def along(watched: Watched) -> None:
            self.inspection_states(h, events())
            watched.look(self.clock, self.states)

        self.step_length.put(h)
        if self.held is not None:
            self.advance(h)
        self.inspection.look(h, last, self.after, along)

    def inspection_states(self, h: Term, at: DenseOutputWeights) -> None:
        """Computes the states at eight shares of the step, in place of the stages; the last is the end, projected if necessary."""
        w, o = self.writer, self.context
        once = [self.splat(h) * row for row in at.once]
        twice = [self.splat(h * h) * row for row in at.twice]
        self.tick(self.splat(o.get(Slot.TIME)) + self.splat(h) * at.shares)
        self.states_at(at.shares, h, self.rates, lambda: once, lambda: twice)
        if self.held is not None and at.ended:
            with w.count(o.n - 1) as i:
                o.work[self.states + i * STAGES + (STAGES - 1)] = o.work[self.after + i]

    def go_on(self, h: Term, last: Term, factor: Term) -> None:
        """Accepts the step; keeps its K for the next one, whose size changes by a factor."""
        w, o = self.writer, self.context
        with w.when((self.error.get() <= _SMOOTH) | (self.bend() <= _STRAIGHT * o.get(Slot.RTOL))):
            o.more(Slot.SMOOTH, 1.0)
        o.sample(h, lambda: None, self.inspection.sample)
        if self.held is None:
            self.advance(h)
        else:
            self.held.kept()
            with w.count(o.n) as i:
                o.y[i] = o.work[self.after + i]
                o.lag[i] = o.work[self.after_lag + i]
        with w.count(o.n) as i:
            self.keep(self.k, i, self.lanes(self.rates, i))
        o.advance(h, last)
        o.put(Slot.FRESH, 0.0)
        with w.when(~last):
            o.put(Slot.STEP, h * w.compute("max", w.compute("min", factor, _MOST), _LEAST))

    def advance(self, h: Term) -> None:
        """Computes y at the end of the step; in `work`, if it is to be projected."""
        w, o = self.writer, self.context
        with w.count(self.pair_count) as at:
            i, j = self.index(self.pairs, at * 2), self.index(self.pairs, at * 2 + 1)
            bent = w.compute("sum", self.lanes(self.rates, j) * _N.b2)
            self.add(i, h * o.y[j] + h * (h * bent + o.lag[j]))
        with self.each_free() as at:
            self.straight(h, self.index(self.free, at))
        self.straight(h, o.n - 1)

    def straight(self, h: Term, i: Term) -> None:
        """Computes y_i + h Σ b_j K_ij."""
        self.add(i, h * self.writer.compute("sum", self.lanes(self.rates, i) * _N.b))

    def add(self, i: Term, change: Term) -> None:
        """Computes y_i + change by compensated summation."""
        o = self.context
        new, lag = add_exactly(o.y, o.lag, i, change)
        if self.held is None:
            o.lag[i] = lag
            o.y[i] = new
        else:
            o.work[self.after + i] = new
            o.work[self.after_lag + i] = lag

    # ----------------------------------------------------------------------------------------------------- samples

    def along(self, theta: Term, array: Array, to: Term) -> None:
        """Writes y at a share of the step into an array, from an index on."""
        w, o, h = self.writer, self.context, self.step_length.get()
        once, twice = weights(w, theta, _N)

        def straight(i: Term) -> None:
            array[to + i] = o.y[i] + (h * w.compute("sum", self.lanes(self.rates, i) * once) + o.lag[i])

        with w.count(self.pair_count) as at:
            i, j = self.index(self.pairs, at * 2), self.index(self.pairs, at * 2 + 1)
            bent = w.compute("sum", self.lanes(self.rates, j) * twice)
            array[to + i] = o.y[i] + (h * (theta * o.y[j] + h * bent) + o.lag[i])
        with self.each_free() as at:
            straight(self.index(self.free, at))
        straight(o.n - 1)
