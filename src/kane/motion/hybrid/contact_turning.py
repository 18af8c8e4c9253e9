# SPDX-License-Identifier: BSD-3-Clause
"""Slip in space with turning direction during an impact, in a kernel: see `kane.contacts.routh`.

With dp = |v_t| ds the rates of y = (v_t, v_n, p, ∫ v_n dp) are regular, and cost no more than a square root:

    dv_t/ds = |v_t| W_tn − μ W_tt v_t,  dv_n/ds = |v_t| W_nn − μ W_nt·v_t,  dp/ds = |v_t|,  d(∫ v_n dp)/ds = |v_t| v_n.

They are homogeneous in v_t, so the error of v_t is measured relative to |v_t|.
"""

from typing import NamedTuple

from kane.motion.hybrid.contact_decisions import Decisions
from kane.numeric.scale import EQUAL, LAST_DIGIT, ROUNDED_CHAIN
from kane.program.kernel.language import INT
from kane.program.kernel.writer import Term

_COUNT = 5
_LEVELS = 6
"""Number of extrapolated results of the midpoint rule with 2, 4, … steps (Gragg 1965): order 12."""
_Y, _NEW, _OLD, _NEXT, _RATES, _TABLE = (k * _COUNT for k in range(6))
ROOM = _TABLE + _LEVELS * _COUNT
"""Size, in doubles, of the array `turning`."""
_TRIALS = 2000
_STEPS, _LOCATES, _LAST = range(3)
"""States: a step is tried; the part of it at which compression or restitution ends is sought; that part has been found."""
_A, _B, _NORMAL, _IMPULSE, _WORK = range(5)


class Mobility(NamedTuple):
    """The entries of W (3 × 3) of a contact with normal n and tangents a and b."""

    nn: Term
    na: Term
    nb: Term
    aa: Term
    ab: Term
    bb: Term


def mobility(of: Decisions, row: Term) -> Mobility:
    """The mobility of the contact whose normal has this row."""
    at, kd = of.W + row * (of.k * of.d) + row, of.k * of.d
    places = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    return Mobility(*(of.room[at + i * kd + j] for i, j in places))


class TurningSlip:
    """The state `y` of an impact; `ends`: it has ended; `compressed`: compression has, with p and ∫ v_n dp in `p_c` and `work_c`."""

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
        """Integrates from v = (v_n, v_t), v_t ≠ 0, until the impact ends, slip vanishes, or its direction is constant.

        `laws` are two flags, for Newton's and for Poisson's law.
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
        """|v_t| of the y at an index of `turning`."""
        a, b = self.cells[at], self.cells[at + 1]
        return self.w.compute("sqrt", a * a + b * b)

    def rates(self, m: Mobility, mu: Term, at: int) -> None:
        """Sets `_RATES` to dy/ds for the y at an index of `turning`."""
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
        """Sets `_NEW` to y after a step of length `at`; the last row but one of the table has one extrapolation less."""
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
        """Accepts a step or halves it, by its error, and detects the end of compression or restitution within it."""
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
        """Accepts the new y."""
        for k in range(_COUNT):
            self.cells[_Y + k] = self.cells[_NEW + k]

    def missing(self, at: int, e: Term, laws: tuple[Term, Term], before: Term) -> Term:
        """A function that is zero at the end of the present part, compression or restitution, and negative before."""
        newton, poisson = laws
        normal, impulse, work = (self.cells[at + k] for k in (_NORMAL, _IMPULSE, _WORK))
        stronge = work + e * e * self.work_c.get()
        by_law = self.w.select(poisson, impulse - (e + 1.0) * self.p_c.get(), stronge)
        return self.w.select(self.compressed.get() < 1, normal, self.w.select(newton, normal + e * before, by_law))

    def slope(self, laws: tuple[Term, Term]) -> Term:
        """The derivative of `missing` by s."""
        newton, poisson = laws
        normal, impulse, work = (self.cells[_RATES + k] for k in (_NORMAL, _IMPULSE, _WORK))
        return self.w.select((self.compressed.get() < 1) | newton, normal, self.w.select(poisson, impulse, work))

    def locate(self, m: Mobility, mu: Term, e: Term, laws: tuple[Term, Term], before: Term) -> None:
        """Newton's method for the length of a step to the end of compression or restitution, with bisection outside the bracket."""
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
        """Ends the impact."""
        self.ends.put(1)
        self.goes.put(0)
