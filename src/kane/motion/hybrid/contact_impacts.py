# SPDX-License-Identifier: BSD-3-Clause
"""Impacts of contacts at one instant in a kernel, one after the other by Routh's process in the plane: see `kane.contacts.routh`."""

from kane.model.contacts import LAWS
from kane.motion.hybrid.contact_decisions import Decisions
from kane.numeric.scale import ROUNDED, ROUNDED_CHAIN, ROUNDED_SUM
from kane.program.kernel.language import INT
from kane.program.kernel.writer import Term

_POISSON, _NEWTON, _MOREAU = (float(LAWS.index(law)) for law in ("poisson", "newton", "moreau"))
_ENDLESS = 1e301
_MOST = 100
"""Impacts of a sequence, times k², after which Python decides."""


class Impacts:
    """`impulse`, p of the rows of the problem at hand, and the `law` of each contact; velocities after impacts are in `a`."""

    def __init__(self, of: Decisions) -> None:
        self.of, self.w = of, of.writer
        w = self.w
        self.impulse, self.law = w.array("impulse"), w.array("law")
        names = ("v_n", "v_t", "p_n", "work", "p_c", "work_c", "left", "length", "slope", "rate")
        self.put = {name: w.variable(name) for name in names}
        counted = ("impact", "compressed", "done", "ended", "rebounds")
        self.found, self.compressed, self.done, self.ended, self.rebounds = (w.variable(name, INT) for name in counted)

    def run(self, size: Term) -> None:
        """All impacts of the problem, whose rows are so many."""
        w, of = self.w, self.of
        room = of.room
        with w.few(size) as c:
            self.impulse[c] = 0.0
            room[of.a + c] = room[of.b + c]
            room[of.a_errors + c] = room[of.terms + c]
        with w.few(of.k) as i:
            of.doubt(self.law[i].equals(_MOREAU))  # all at once
        self.rebounds.put(0)
        self.done.put(0)
        limit = of.count.get() * of.count.get() * _MOST
        with w.repeat(lambda: (self.done.get() < 1) & (of.unsure.get() < 1)):
            self.one_impact(size)
            self.rebounds.put(self.rebounds.get() + 1)
            of.doubt(self.rebounds.get() > limit)
        energy = of.sum(size, lambda c: self.impulse[c] * (room[of.b + c] + room[of.a + c]))
        spent = of.sum(size, lambda c: of.absolute(self.impulse[c]) * room[of.terms + c])
        of.doubt(energy > spent * (2 * ROUNDED_CHAIN))

    def one_impact(self, size: Term) -> None:
        """The one that closes fastest of those that close, by Routh's process in the plane; none is left where it is `done`."""
        w, of = self.w, self.of
        room, d, kd = of.room, of.d, of.k * of.d
        fastest = of.other
        fastest.put(0.0)
        with w.few(of.count.get()) as n:
            v, terms = room[of.a + n * d], room[of.a_errors + n * d]
            with w.when((v < -(terms * ROUNDED)) & (-v * (1 - ROUNDED_CHAIN) > fastest.get())):
                fastest.put(-v)
                self.found.put(n)
        with w.when(~(fastest.get() > 0.0)):
            self.done.put(1)
        with w.otherwise():
            n = self.found.get()
            row, i = n * d, of.index(of.own + n)
            rubs = (room[of.rubs + n] > 0.0) & (room[of.static + n] > 0.0)
            of.doubt(rubs & (d > 2))
            of.doubt(of.no_place(i, 0))
            self.routh(row, room[of.static + n], of.numbers[of.laws + i * 3 + 2], self.law[i])
            w_tt, w_nt = room[of.W + (row + 1) * kd + row + 1], room[of.W + row * kd + row + 1]
            slip = self.put["v_t"].get() - room[of.a + row + 1] - w_nt * self.put["p_n"].get()
            p_n, p_t = self.put["p_n"].get(), w.select(rubs, slip / w_tt, 0.0)
            of.doubt(~(of.absolute(p_n) + of.absolute(p_t) < 1e300))
            self.impulse[row] = self.impulse[row] + p_n
            self.impulse[row + 1] = self.impulse[row + 1] + p_t
            with w.few(size) as c:
                by = room[of.W + c * kd + row], room[of.W + c * kd + row + 1]
                room[of.a + c] = room[of.a + c] + by[0] * p_n + by[1] * p_t
                more = of.absolute(by[0] * p_n) + of.absolute(by[1] * p_t)
                room[of.a_errors + c] = room[of.a_errors + c] + more
            room[of.a + row] = self.put["v_n"].get()
            with w.when(rubs):
                room[of.a + row + 1] = self.put["v_t"].get()

    def routh(self, row: Term, mu: Term, e: Term, law: Term) -> None:
        """Routh's process in the plane: `v_n`, `v_t` after it and the normal impulse `p_n`."""
        w, of = self.w, self.of
        room, kd = of.room, of.k * of.d
        nn, nt, tt = (room[of.W + (row + a) * kd + row + b] for a, b in ((0, 0), (0, 1), (1, 1)))
        put = self.put
        before = room[of.a + row]
        put["v_n"].put(before)
        put["v_t"].put(room[of.a + row + 1])
        for name in ("p_n", "work", "p_c", "work_c"):
            put[name].put(0.0)
        self.compressed.put(0)
        ended = self.ended
        ended.put(0)
        with w.when(of.absolute(put["v_t"].get()) > 0.0):
            way = w.select(put["v_t"].get() > 0.0, 1.0, -1.0)
            rate = nt - mu * tt * way
            along = rate * way
            put["length"].put(w.select(along < 0.0, of.absolute(put["v_t"].get()) / -along, _ENDLESS))
            put["slope"].put(nn - mu * nt * way)
            put["rate"].put(rate)
            self.straight(e, law, before)
            with w.when(ended.get() < 1):
                put["v_t"].put(0.0)
        with w.when(ended.get() < 1):
            q = nt / tt
            sticks = of.absolute(q) <= mu
            way = w.select(nt > 0.0, 1.0, -1.0)
            slope = w.select(sticks, nn - nt * q, nn - mu * nt * way)
            of.doubt(~(slope > nn * ROUNDED_SUM))
            put["slope"].put(slope)
            put["rate"].put(w.select(sticks, 0.0, nt - mu * tt * way))
            put["length"].put(_ENDLESS)
            self.straight(e, law, before)
            of.doubt(ended.get() < 1)

    def straight(self, e: Term, law: Term, before: Term) -> None:
        """On a piece with constant rates, at most as long as `length`; `ended` where the impact ends there."""
        w, put = self.w, self.put
        again = self.of.changed
        again.put(1)
        with w.repeat(lambda: again.get() > 0):
            again.put(0)
            self.impulse_left(e, law, before)
            step, ends = (
                w.compute("min", put["left"].get(), put["length"].get()),
                put["left"].get() < put["length"].get(),
            )
            work = put["work"].get() + step * (put["v_n"].get() + put["slope"].get() * step * 0.5)
            put["work"].put(work)
            put["v_n"].put(put["v_n"].get() + put["slope"].get() * step)
            put["v_t"].put(put["v_t"].get() + put["rate"].get() * step)
            put["p_n"].put(put["p_n"].get() + step)
            with w.when(ends & (self.compressed.get() > 0)):
                self.ended.put(1)
            with w.otherwise(), w.when(ends):
                put["p_c"].put(put["p_n"].get())
                put["work_c"].put(put["work"].get())
                put["v_n"].put(0.0)
                put["work"].put(0.0)
                put["length"].put(put["length"].get() - step)
                self.compressed.put(1)
                again.put(1)

    def impulse_left(self, e: Term, law: Term, before: Term) -> None:
        """`left`: the impulse until compression or restitution ends, where v_n has a constant slope."""
        w, put = self.w, self.put
        v, slope = put["v_n"].get(), put["slope"].get()
        linear = (self.compressed.get() < 1) | law.equals(_NEWTON)
        target = w.select(self.compressed.get() < 1, 0.0, -(e * before))
        met = w.compute("max", (target - v) / slope, 0.0)
        poisson = w.compute("max", (e + 1.0) * put["p_c"].get() - put["p_n"].get(), 0.0)
        need = -(put["work"].get() + e * e * put["work_c"].get())
        square = v * v + slope * need * 2.0
        root = v + w.compute("sqrt", w.select(square > 0.0, square, 0.0))
        stronge = w.select(need > 0.0, w.select((square >= 0.0) & (root > 0.0), need * 2.0 / root, _ENDLESS), 0.0)
        by_law = w.select(law.equals(_POISSON), poisson, stronge)
        put["left"].put(w.select(linear, w.select(slope > 0.0, met, _ENDLESS), by_law))
