# SPDX-License-Identifier: BSD-3-Clause
"""Slip in space that turns while an impact lasts, in a kernel: see `kane.contacts.routh`.

With dp = |v_t| ds the rates of y = (v_t, v_n, p, ∫ v_n dp) are regular, and ask for no more than a root:

    dv_t/ds = |v_t| W_tn − μ W_tt v_t,  dv_n/ds = |v_t| W_nn − μ W_nt·v_t,  dp/ds = |v_t|,  d(∫ v_n dp)/ds = |v_t| v_n.

They are homogeneous in v_t, so the error of v_t is measured beside v_t itself.
"""

from typing import NamedTuple

from kane.motion.hybrid.contact_decisions import Decisions
from kane.numeric.scale import EQUAL, LAST_DIGIT, ROUNDED_CHAIN
from kane.program.kernel.language import INT
from kane.program.kernel.writer import Term

_COUNT = 5
_LEVELS = 6
"""Of the midpoint rule with 2, 4, … steps (Gragg 1965): order 12."""
_Y, _NEW, _OLD, _NEXT, _RATES, _TABLE = (k * _COUNT for k in range(6))
ROOM = _TABLE + _LEVELS * _COUNT
"""Doubles of the array `turning`."""
_TRIALS = 2000
_STEPS, _LOCATES, _LAST = range(3)
"""A step is tried; that part of it is sought at which a phase of the impact ends; it is found."""
_A, _B, _NORMAL, _IMPULSE, _WORK = range(5)


class Mobility(NamedTuple):
    """W of a contact by its rows n, a and b."""

    nn: Term
    na: Term
    nb: Term
    aa: Term
    ab: Term
    bb: Term


def mobility(of: Decisions, row: Term) -> Mobility:
    """Of the contact whose normal has this row."""
    at, kd = of.W + row * (of.k * of.d) + row, of.k * of.d
    places = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    return Mobility(*(of.room[at + i * kd + j] for i, j in places))


class TurningSlip:
    """`y` is what an impact has come to, `ends` whether it ends there, `compressed` whether compression has; p and ∫ v_n dp then."""

    def __init__(self, of: Decisions) -> None:
        self.of, self.w = of, of.writer
        w = self.w
        self.cells = w.array("turning")
        self.ends, self.compressed, self.does, self.goes, self.trials = (
            w.variable(f"turning_{name}", INT) for name in ("ends", "compressed", "does", "goes", "trials")
        )
        names = ("step", "at", "low", "high", "first", "p_c", "work_c", "wrong")
        self.step, self.at, self.low, self.high, self.first, self.p_c, self.work_c, self.wrong = (
            w.variable(f"turning_{name}") for name in names
        )

    def y(self, k: int) -> Term:
        """v_a, v_b, v_n, p or ∫ v_n dp."""
        return self.cells[_Y + k]

    def run(self, m: Mobility, mu: Term, e: Term, laws: tuple[Term, Term], v: tuple[Term, Term, Term]) -> None:
        """From v = (v_n, v_t) on, v_t ≠ 0, up to the end or to where slip is nothing or straight.

        `laws` are whether it is Newton's, and whether it is Poisson's.
        """
        w, of = self.w, self.of
        for k, x in enumerate((v[1], v[2], v[0], w.constant(0.0), w.constant(0.0))):
            self.cells[_Y + k] = x
        for cell in (self.ends, self.compressed, self.trials):
            cell.put(0)
        self.does.put(_STEPS)
        self.goes.put(1)
        self.first.put(self.slip(_Y))
        self.step.put(1.0 / ((m.nn + m.aa + m.bb) * (mu + 1.0)))
        self.p_c.put(0.0)
        self.work_c.put(0.0)
        before = v[0]
        with w.repeat(lambda: (self.goes.get() > 0) & (of.unsure.get() < 1)):
            with w.when(self.does.get() < _LOCATES):
                self.at.put(self.step.get())
                self.rates(m, mu, _Y)
                (a, b), (da, db) = (self.cells[_Y], self.cells[_Y + 1]), (self.cells[_RATES], self.cells[_RATES + 1])
                straight = of.absolute(a * db - b * da) <= of.absolute(a * da + b * db) * LAST_DIGIT
                with w.when((self.slip(_Y) < self.first.get() * LAST_DIGIT) | straight):
                    self.goes.put(0)
            with w.when(self.goes.get() > 0):
                self.extrapolate(m, mu)
                with w.when(self.does.get() < _LOCATES):
                    self.judge(m, e, laws, before)
                with w.otherwise():
                    self.locate(m, mu, e, laws, before)
            self.trials.put(self.trials.get() + 1)
            of.doubt(self.trials.get() > _TRIALS)

    def slip(self, at: int) -> Term:
        """|v_t|."""
        a, b = self.cells[at], self.cells[at + 1]
        return self.w.compute("sqrt", a * a + b * b)

    def rates(self, m: Mobility, mu: Term, at: int) -> None:
        """dy/ds of the y that stands at a place."""
        y, (a, b, speed) = self.cells, (self.cells[at], self.cells[at + 1], self.slip(at))
        found = (
            speed * m.na - mu * (m.aa * a + m.ab * b),
            speed * m.nb - mu * (m.ab * a + m.bb * b),
            speed * m.nn - mu * (m.na * a + m.nb * b),
            speed,
            speed * y[at + _NORMAL],
        )
        for k, x in enumerate(found):
            y[_RATES + k] = x

    def extrapolate(self, m: Mobility, mu: Term) -> None:
        """`_NEW` is y after a step `at`; the row before the last of the table the same with one order less."""
        w, y = self.w, self.cells
        with w.few(_LEVELS) as level:
            count = (level + 1) * 2
            h = self.at.get() / w.compute("float", count)
            self.rates(m, mu, _Y)
            for k in range(_COUNT):
                y[_OLD + k] = y[_Y + k]
                y[_NEXT + k] = y[_Y + k] + h * y[_RATES + k]
            with w.few(count - 1):
                self.rates(m, mu, _NEXT)
                for k in range(_COUNT):
                    further = y[_OLD + k] + h * 2.0 * y[_RATES + k]
                    y[_OLD + k] = y[_NEXT + k]
                    y[_NEXT + k] = further
            self.rates(m, mu, _NEXT)
            for k in range(_COUNT):
                y[level * _COUNT + _TABLE + k] = (y[_OLD + k] + y[_NEXT + k] + h * y[_RATES + k]) * 0.5
        with w.few(_LEVELS, 1) as order, w.few(w.integer(_LEVELS) - order) as back:
            level = w.integer(_LEVELS - 1) - back
            ratio = w.compute("float", level + 1) / w.compute("float", level - order + 1)
            for k in range(_COUNT):
                at = level * _COUNT + _TABLE + k
                y[at] = y[at] + (y[at] - y[at - _COUNT]) / (ratio * ratio - 1.0)
        for k in range(_COUNT):
            y[_NEW + k] = y[_TABLE + (_LEVELS - 1) * _COUNT + k]

    def judge(self, m: Mobility, e: Term, laws: tuple[Term, Term], before: Term) -> None:
        """Whether a step is right, and whether a phase of the impact ends within it."""
        w, of, y = self.w, self.of, self.cells
        speed = of.largest(self.first.get(), of.absolute(before))
        sizes = (self.slip(_NEW), self.slip(_NEW), speed, speed / m.nn, speed * speed / m.nn)
        self.wrong.put(0.0)
        for k, size in enumerate(sizes):
            error = of.absolute(y[_NEW + k] - y[_TABLE + (_LEVELS - 2) * _COUNT + k])
            self.wrong.put(of.largest(self.wrong.get(), error / of.largest(size, of.absolute(y[_NEW + k]))))
        wrong = self.wrong.get()
        with w.when(~(wrong <= ROUNDED_CHAIN)):
            self.step.put(self.step.get() * 0.5)
        with w.otherwise():
            with w.when(self.missing(_NEW, e, laws, before) < 0.0):
                self.takes()
                self.step.put(self.step.get() * w.select(wrong < ROUNDED_CHAIN * 1e-4, 2.0, 1.0))
            with w.otherwise():
                self.does.put(_LOCATES)
                self.low.put(0.0)
                self.high.put(self.step.get())

    def takes(self) -> None:
        """y is the new one."""
        for k in range(_COUNT):
            self.cells[_Y + k] = self.cells[_NEW + k]

    def missing(self, at: int, e: Term, laws: tuple[Term, Term], before: Term) -> Term:
        """What is missing until the phase ends: negative before, in units of its own."""
        newton, poisson = laws
        normal, impulse, work = (self.cells[at + k] for k in (_NORMAL, _IMPULSE, _WORK))
        stronge = work + e * e * self.work_c.get()
        by_law = self.w.select(poisson, impulse - (e + 1.0) * self.p_c.get(), stronge)
        return self.w.select(self.compressed.get() < 1, normal, self.w.select(newton, normal + e * before, by_law))

    def slope(self, laws: tuple[Term, Term]) -> Term:
        """The rate of what is missing."""
        newton, poisson = laws
        normal, impulse, work = (self.cells[_RATES + k] for k in (_NORMAL, _IMPULSE, _WORK))
        return self.w.select((self.compressed.get() < 1) | newton, normal, self.w.select(poisson, impulse, work))

    def locate(self, m: Mobility, mu: Term, e: Term, laws: tuple[Term, Term], before: Term) -> None:
        """Newton's method for the part of a step at which the phase ends, halves where that leaves the bracket."""
        w, of = self.w, self.of
        with w.when(self.does.get() > _LOCATES):
            self.does.put(_STEPS)
            self.takes()
            with w.when(self.compressed.get() > 0):
                self.finishes()
            with w.otherwise():
                self.compressed.put(1)
                self.p_c.put(self.cells[_Y + _IMPULSE])
                self.work_c.put(self.cells[_Y + _WORK])
                self.cells[_Y + _NORMAL] = 0.0
                self.cells[_Y + _WORK] = 0.0
                with w.when(self.missing(_Y, e, laws, before) >= 0.0):
                    self.finishes()
        with w.otherwise():
            self.rates(m, mu, _NEW)
            at, left = self.at.get(), self.missing(_NEW, e, laws, before)
            self.low.put(w.select(left < 0.0, at, self.low.get()))
            self.high.put(w.select(left < 0.0, self.high.get(), at))
            to = at - left / self.slope(laws)
            close = of.absolute(to - at) <= self.step.get() * EQUAL
            inside = (to > self.low.get()) & (to < self.high.get())
            self.at.put(w.select(close | inside, to, (self.low.get() + self.high.get()) * 0.5))
            with w.when(close | (self.high.get() - self.low.get() <= self.step.get() * LAST_DIGIT)):
                self.does.put(_LAST)

    def finishes(self) -> None:
        """The impact is over."""
        self.ends.put(1)
        self.goes.put(0)
