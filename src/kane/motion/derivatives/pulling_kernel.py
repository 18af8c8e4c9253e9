# SPDX-License-Identifier: BSD-3-Clause
"""The kernel that integrates the adjoint backwards over a stretch of a motion, by Gauss collocation with eight stages (order 16).

With K(t) = Jᵀ Λ + ∂L/∂x of an integrand L, the adjoint obeys Λ′ = −K. In a step from t to t + h with the adjoint λ at its end

    Λ_i = λ + h Σ_j (b_j − a_ij) K_j,   at the start of the step: λ + h Σ_j b_j K_j,   added to ∂J/∂p: h Σ_j b_j (∂f/∂p)ᵀ Λ_j

with the coefficients a, b of Gauss's method, which is its own adjoint (Hager 2000, Numer. Math. 87; Sanz-Serna 2016, SIAM Rev. 58).
The states at the stages are known, so that K is linear in Λ. The stages are solved by fixed-point iteration; the first iterate is
the extrapolated polynomial of the following step, and all stages are evaluated by one call of the routine on eight lanes. If
q_i′ = u_j, K of u_j contains Λ of q_i and uses its newest value (Gauss–Seidel), so that the iteration contracts as h².

The error estimate uses the Legendre coefficients c_k of K. Where K is smooth they decay as ρ^k, and the error of the quadrature,
exact to degree 15, is about h A ρ⁸ with A = max(c_6, c_7). The ratio of A to max(c_4, c_5) is ρ², that to max(c_2, c_3) is ρ⁴, and
the smaller estimate of ρ⁸ is used, because coefficients may vanish by chance. Where K or its derivative jumps, ρ is about 1. A jump
before the first or behind the last node, a fiftieth of the step at either end, leaves no trace in the coefficients; there the
polynomials of adjacent steps differ at their common point by more than their errors. Errors are relative to Λ.
"""

from collections.abc import Sequence
from enum import IntEnum

from kane.motion.steppers.collocation import gauss
from kane.motion.steppers.context import WIDE, of_others
from kane.motion.steppers.gauss import lagrange
from kane.program.kernel.language import INT, Kernel, Type
from kane.program.kernel.writer import Array, Term, Writer

STAGES = 8
NODES = gauss(STAGES)
LAST = tuple(
    tuple((2 * k + 1) * x * b for x, b in zip(NODES.legendre[k], NODES.b, strict=True)) for k in range(2, STAGES)
)
"""Rows that map values at the nodes to the last six Legendre coefficients, c_2 to c_7."""
_ENDS = lagrange(NODES, 0.0), lagrange(NODES, 1.0)
_USUAL = 20.0
"""For smooth K, polynomials of adjacent steps differ at their common point by at most this multiple of their last coefficients."""
ROUNDS = 24
"""Largest number of fixed-point iterations."""
_FOUND_AT = 1e-12
"""Relative change of Λ at which the iteration has converged; the remaining error is the change times the contraction factor."""
_HUGE = 1e300
_LANES = Type("float", STAGES)
_GOING, _FOUND, _FAILED = range(3)


class Place(IntEnum):
    """Indices into the array `told`, which is kept from call to call."""

    PACE = 0
    """Contraction factor in the step whose iteration did not converge."""


ARRAYS = (
    "times", "x", "p", "r", "h", "lengths", "through", "source", "sourced", "pairs", "scale", "seeds", "seeded", "w", "k", "out",
    "lam", "last", "edge", "tail", "own", "sized", "bent", "of_inputs", "rough", "told",
)  # fmt: skip
"""
`times` (steps × 8), `x` (steps × n × 8), `r` (steps × inputs × 8): stages of the steps with `lengths`; parameters `p`, and values `h`
computed from p alone. `through` (steps × laws × n × 8): ∂r/∂x of input laws; `source` (steps × n × 8): ∂L/∂x, multiplied by the factor
`sourced` of each row. `pairs`: (i, j) with q_i′ = u_j; `scale` (n): sizes of states. `seeds` (… × rows × n) are added to the weights
at the ends of steps; `seeded` (steps) is the index of the seed, −1 for none. `lam` (rows × n): the weights. `own`, `sized`, `bent`
(rows × p): contributions to ∂J/∂p, their absolute sums and errors; `of_inputs` (rows × steps × laws × 8): weights of input laws.
`rough` (steps): error estimates, infinite where the iteration failed, which ends the kernel. `w`, `out`: workspace. From the following
step, kept from call to call: `k` (rows × n × 8), `last` (rows): its length or 0, `edge`, `tail` (rows × n): K at its start, and A.
"""


class _Pulling:
    """The kernel under construction."""

    def __init__(self) -> None:
        self.writer = w = Writer("pull_back")
        names = ("rows", "steps", "n", "count", "laws", "wide", "pair_count")
        self.rows, self.steps, self.n, self.count, self.laws, self.wide, self.pair_count = map(w.number, names)
        self.a = {name: w.array(name) for name in ARRAYS}
        self.routine = w.callee("pull", *WIDE[:2], "array", *WIDE[2:])
        self.columns = [w.variable(f"a{j}", _LANES) for j in range(STAGES)]
        self.status, self.round = w.variable("status", INT), w.variable("round", INT)
        cells = ("before", "worst", "roughness", "gap")
        self.before, self.worst, self.rough, self.gap = map(w.variable, cells)
        self.change, self.size = (w.variable(name, _LANES) for name in ("change", "size"))
        self.done = w.variable("done", INT)

    def splat(self, x: Term) -> Term:
        """A number in each lane."""
        return self.writer.compute("splat8", x)

    def eight(self, name: str, i: Term) -> Term:
        """The values of component i at the eight stages."""
        return self.a[name].lanes(i * STAGES, STAGES)

    def combined(self, array: Array, at: Term, columns: Sequence[Term]) -> Term:
        """Σ_j column_j times the number at node j."""
        return self.writer.sum([self.splat(array[at + j]) * column for j, column in enumerate(columns)])

    def larger(self, cell: Term, x: Term) -> Term:
        """The maximum of both; a non-finite value propagates."""
        return self.writer.select(x > cell, x, cell) + x * 0.0

    # ------------------------------------------------------------------------------------------------------ kernel

    def kernel(self) -> Kernel:
        """The loop over steps from last to first, and over rows in each; returns the number of steps left, or −1 − step on failure."""
        w, a = self.writer, self.a
        self.done.put(self.steps)
        with w.repeat(lambda: self.done.get() > 0):
            step = self.done.get() - 1
            h = a["lengths"][step]
            for j, (b, column) in enumerate(zip(NODES.b, NODES.a, strict=True)):
                self.columns[j].put(self.splat(h) * tuple(b - x for x in column))
            self.worst.put(0.0)
            self.status.put(_FOUND)
            with w.count(self.rows) as row, w.when(self.status.get() < _FAILED):
                self.seed(step, row)
                with w.when(self.moves(row)):
                    self.row(step, row, h)
            with w.when(self.status.get() < _FAILED):
                a["rough"][step] = self.worst.get()
                self.done.put(step)
            with w.otherwise():
                a["rough"][step] = w.constant(float("inf"))
                self.done.put(-1 - step)
        return w.finished(self.done)

    def seed(self, step: Term, row: Term) -> None:
        """Adds the seed at the end of a step."""
        w, a = self.writer, self.a
        which = w.compute("int", a["seeded"][step])
        with w.when(which >= 0), w.count(self.n) as j:
            a["lam"][row * self.n + j] = a["lam"][row * self.n + j] + a["seeds"][(which * self.rows + row) * self.n + j]

    def moves(self, row: Term) -> Term:
        """Whether a row has nonzero weights or an integrand."""
        w, a = self.writer, self.a
        size = w.variable("weights")
        size.put(w.compute("abs", a["sourced"][row]))
        with w.count(self.n) as j:
            size.put(size.get() + w.compute("abs", a["lam"][row * self.n + j]))
        return ~(size.get() <= 0.0)

    def row(self, step: Term, row: Term, h: Term) -> None:
        """Integrates one row over one step."""
        w = self.writer
        k = row * self.n * STAGES
        self.guess(row, k, h)
        with w.count(self.n) as j:
            self.put_weights(row, k, j)
        self.status.put(_GOING)
        self.round.put(0)
        self.before.put(0.0)
        with w.repeat(lambda: self.status.get() < _FOUND):
            self.pull(step)
            self.gather(step, row)
            self.exchange(row)
            self.settle(row, k)
            self.judge(h)
        with w.when(self.status.get() < _FAILED):
            self.go_on(step, row, k, h)

    def guess(self, row: Term, k: Term, h: Term) -> None:
        """The initial iterate of K, extrapolated from the following step; zero for the first step."""
        w, a = self.writer, self.a
        last = a["last"][row]
        with w.when(last > 0.0):
            share = self.splat(h / last) * tuple(c - 1.0 for c in NODES.c)
            others = of_others([share - c for c in NODES.c], *[w.lanes(*[1.0] * STAGES)] * 2)
            columns = [x * top for x, top in zip(others, NODES.top, strict=True)]
            with w.count(self.n) as j:
                a["k"].store(k + j * STAGES, self.combined(a["k"], k + j * STAGES, columns))
        with w.otherwise(), w.count(self.n) as j:
            a["k"].store(k + j * STAGES, w.lanes(*[0.0] * STAGES))

    def put_weights(self, row: Term, k: Term, j: Term) -> Term:
        """Λ of component j from K, also stored."""
        a = self.a
        columns = [c.get() for c in self.columns]
        result = self.splat(a["lam"][row * self.n + j]) + self.combined(a["k"], k + j * STAGES, columns)
        a["w"].store(j * STAGES, result)
        return result

    def pull(self, step: Term) -> None:
        """wᵀ ∂f/∂(x, p, r) at all stages."""
        a = self.a
        places = (a["p"].at(0), a["r"].at(step * self.wide * STAGES), a["h"].at(0), a["out"].at(0))
        self.routine(a["times"].at(step * STAGES), a["x"].at(step * self.n * STAGES), a["w"].at(0), *places)

    def gather(self, step: Term, row: Term) -> None:
        """Adds the contributions of the integrand and of input laws to K."""
        w, a = self.writer, self.a
        share = a["sourced"][row]
        with w.when(~(share.equals(0.0))), w.count(self.n) as j:
            at = step * self.n + j
            a["out"].store(j * STAGES, self.eight("out", j) + self.splat(share) * self.eight("source", at))
        with w.count(self.laws) as m, w.count(self.n) as j:
            given = self.eight("out", self.n + self.count + m) * self.eight(
                "through", (step * self.laws + m) * self.n + j
            )
            a["out"].store(j * STAGES, self.eight("out", j) + given)

    def exchange(self, row: Term) -> None:
        """Replaces Λ of q_i in K of u_j by its value of this iteration."""
        w, a = self.writer, self.a
        with w.count(self.pair_count) as at:
            i, j = (w.compute("int", a["pairs"][at * 2 + m]) for m in range(2))
            columns = [c.get() for c in self.columns]
            new = self.splat(a["lam"][row * self.n + i]) + self.combined(a["out"], i * STAGES, columns)
            a["out"].store(j * STAGES, self.eight("out", j) + (new - self.eight("w", i)))

    def settle(self, row: Term, k: Term) -> None:
        """K and Λ of this iteration, the change of K, and the size of Λ."""
        w, a = self.writer, self.a
        self.change.put(w.lanes(*[0.0] * STAGES))
        self.size.put(w.lanes(*[0.0] * STAGES))
        with w.count(self.n) as j:
            scale, new = self.splat(a["scale"][j]), self.eight("out", j)
            moved = w.compute("abs", new - a["k"].lanes(k + j * STAGES, STAGES)) * scale
            self.change.put(self.larger(self.change.get(), moved))
            a["k"].store(k + j * STAGES, new)
            self.size.put(self.larger(self.size.get(), w.compute("abs", self.put_weights(row, k, j)) * scale))

    def judge(self, h: Term) -> None:
        """Ends the iteration if it has converged, diverged or exceeded its limit."""
        w, a = self.writer, self.a
        lanes, before = self.change.get(), self.before.get()
        change = h * (w.compute("largest", lanes) + w.compute("sum", lanes) * 0.0)
        with w.when(change <= w.compute("largest", self.size.get()) * _FOUND_AT):
            self.status.put(_FOUND)
        with w.otherwise(), w.when(~(change < _HUGE) | (self.round.get() >= ROUNDS)):
            self.status.put(_FAILED)
            a["told"][Place.PACE] = change / before
        self.before.put(change)
        self.round.put(self.round.get() + 1)

    def left(self, k: Term) -> tuple[Term, Term]:
        """The estimated quadrature error of a step divided by its length; A."""
        w, none = self.writer, self.writer.constant(1.0)
        sizes = [w.compute("abs", w.compute("sum", k * row)) for row in LAST]
        first, second, last = (w.compute("max", *sizes[m : m + 2]) for m in (0, 2, 4))
        by_first = w.select(last < first, last / first, none)
        by_second = w.select(last < second, last / second, none)
        return last * w.compute("min", by_first * by_first, (by_second * by_second) * (by_second * by_second)), last

    def leap(self, k: Term, at: Term, tail: Term, h: Term, last: Term) -> Term:
        """The estimated error from a jump of K between the last node of a step and the first of the following one."""
        w, a = self.writer, self.a
        gap = w.compute("abs", w.compute("sum", k * _ENDS[1]) - a["edge"][at]) - (tail + a["tail"][at]) * _USUAL
        return w.compute("max", gap, 0.0) * w.compute("max", h, last) * NODES.c[0]

    def go_on(self, step: Term, row: Term, k: Term, h: Term) -> None:
        """The weights at the start of the step, and the contributions to ∂J/∂p."""
        w, a = self.writer, self.a
        last, meets = a["last"][row], w.compute("int", a["seeded"][step]) < 0
        self.rough.put(0.0)
        self.gap.put(0.0)
        with w.count(self.n) as j:
            own, at = a["k"].lanes(k + j * STAGES, STAGES), row * self.n + j
            a["lam"][at] = a["lam"][at] + h * w.compute("sum", own * NODES.b)
            left, tail = self.left(own)
            self.rough.put(self.larger(self.rough.get(), h * left * a["scale"][j]))
            with w.when(meets & (last > 0.0)):
                self.gap.put(self.larger(self.gap.get(), self.leap(own, at, tail, h, last) * a["scale"][j]))
            a["edge"][at] = w.compute("sum", own * _ENDS[0])
            a["tail"][at] = tail
        a["last"][row] = h
        size = w.compute("largest", self.size.get())
        with w.when(size > 0.0):
            gap = self.gap.get() / size
            self.worst.put(self.larger(self.worst.get(), self.rough.get() / size + gap))
            with w.when(step + 1 < self.steps):
                a["rough"][step + 1] = self.larger(a["rough"][step + 1], gap)
        with w.count(self.count) as j:
            own, at = self.eight("out", self.n + j), row * self.count + j
            a["own"][at] = a["own"][at] + h * w.compute("sum", own * NODES.b)
            a["sized"][at] = a["sized"][at] + h * w.compute("sum", w.compute("abs", own) * NODES.b)
            a["bent"][at] = a["bent"][at] + h * self.left(own)[0]
        with w.count(self.laws) as m:
            given = self.eight("out", self.n + self.count + m) * self.splat(h) * NODES.b
            a["of_inputs"].store(((row * self.steps + step) * self.laws + m) * STAGES, given)


def pulling_kernel() -> Kernel:
    """The kernel, with the arguments `ARRAYS`. It returns 0, or −1 − step if the iteration failed in a step."""
    return _Pulling().kernel()
