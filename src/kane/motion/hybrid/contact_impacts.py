# SPDX-License-Identifier: BSD-3-Clause
"""Impacts of contacts at one instant in a kernel: sequential by Routh's method, or simultaneous by Moreau's law.

See `kane.contacts.routh` and `kane.contacts.several`.
"""

from kane.model.contacts import LAWS
from kane.motion.hybrid.contact_decisions import Decisions
from kane.motion.hybrid.contact_turning import Mobility, TurningSlip, mobility
from kane.numeric.scale import LAST_DIGIT, ROUNDED, ROUNDED_CHAIN, ROUNDED_SUM
from kane.program.kernel.language import INT
from kane.program.kernel.writer import Array, Term

_POISSON, _NEWTON, _MOREAU = (float(LAWS.index(law)) for law in ("poisson", "newton", "moreau"))
_ENDLESS = 1e301
_ROOT = 60
_MOST = 100
"""Largest number of impacts of a sequence, over k²; after more, Python decides."""


class ImpactKernel:
    """The writer of impacts: `impulse` is p of the problem's rows, `law` that of each contact; `a` are velocities after impacts."""

    def __init__(self, of: Decisions) -> None:
        self.of, self.w = of, of.writer
        w = self.w
        self.impulse, self.law, self.part, self.grown = (w.array(name) for name in ("impulse", "law", "part", "grown"))
        names = ("v_n", "v_t", "v_b", "p_n", "work", "p_c", "work_c", "left", "length", "slope", "rate")
        self.put = {name: w.variable(name) for name in names}
        counted = ("impact", "compressed", "done", "ended", "rebounds", "together", "over_impacts", "impact_rounds")
        self.turning, self.way_a, self.way_b = TurningSlip(of), w.variable("way_a"), w.variable("way_b")
        self.found, self.compressed, self.done, self.ended, self.rebounds, self.together, self.over, self.rounds = (
            w.variable(name, INT) for name in counted
        )

    def begin(self) -> None:
        """Selects sequential or simultaneous impacts, and resets the terms of earlier impacts."""
        w, of = self.w, self.of
        self.together.put(0)
        with w.few(of.k) as i, w.when(self.law[i].equals(_MOREAU)):
            self.together.put(1)
        self.rounds.put(0)
        with w.few(of.k * of.d) as i:
            self.grown[i] = 0.0

    def meet(self, touching: Array) -> None:
        """Sets `part`, the contacts that take part in the next impacts, or `over` if there are none.

        By Moreau's law these are the touching contacts that do not separate, repeatedly until none approaches; else all, once.
        """
        w, of = self.w, self.of
        d, close = of.d, self.found
        close.put(0)
        with w.few(of.k) as i:
            v, nothing = of.room[of.velocity + i * d], self.terms(i * d) * ROUNDED
            touches = touching[i] > 0.0
            with w.when(touches & (v < -w.select(self.rounds.get() < 1, nothing, self.terms(i * d) * ROUNDED_SUM))):
                close.put(1)
            self.part[i] = w.select(touches & ((v <= nothing) | (self.together.get() < 1)), 1.0, 0.0)
        alone = self.together.get() < 1
        self.over.put(1)
        with w.when((alone & (self.rounds.get() < 1)) | (~alone & (close.get() > 0))):
            self.over.put(0)
        self.rounds.put(self.rounds.get() + 1)
        of.doubt(self.rounds.get() > of.k * of.k * _MOST)

    def terms(self, row: Term) -> Term:
        """The magnitudes of the terms of a velocity, with those of the impulses so far."""
        return self.of.room[self.of.velocity_terms + row] + self.grown[row]

    def grow(self, size: Term) -> None:
        """Adds the terms due to the impulses of the problem, of `size` rows, to those of all velocities."""
        w, of = self.w, self.of
        room, kd = of.room, of.k * of.d

        def root(at: Term) -> Term:
            return w.compute("sqrt", room[at])

        self.put["work"].put(of.sum(size, lambda c: root(of.W + c * kd + c) * of.absolute(self.impulse[c])))
        with w.few(kd) as i:
            self.grown[i] = self.grown[i] + root(of.mobility + i * kd + i) * self.put["work"].get()

    def ask(self) -> None:
        """Sets b for the choice by Moreau's law, v_n⁺ + e v_n⁻ ≥ 0; with other laws b remains v."""
        w, of = self.w, self.of
        room, d = of.room, of.d
        with w.when(self.together.get() > 0):
            with w.few(of.count.get() * d) as c:
                self.impulse[c] = room[of.b + c]
            with w.few(of.count.get()) as n:
                i, v = of.index(of.own + n), room[of.b + n * d]
                e = of.numbers[of.laws + i * 3 + 2]
                with w.few(d) as j:
                    room[of.terms + n * d + j] = self.terms(i * d + j)
                room[of.b + n * d] = v + e * w.compute("min", v, 0.0)
            with w.few(of.count.get() * d) as c:
                room[of.terms + c] = room[of.terms + c] + of.absolute(room[of.b + c])

    def thrown(self, size: Term) -> None:
        """The impulses of the choice, and the velocities after them; resets b and its terms to those of v."""
        room, of = self.of.room, self.of
        with self.w.few(size) as c:
            v, asked = self.impulse[c], room[of.b + c]
            room[of.terms + c] = room[of.terms + c] - of.absolute(asked)
            room[of.a + c] = room[of.a + c] + (v - asked)
            room[of.b + c] = v
            self.impulse[c] = room[of.force + c]

    def run(self, size: Term) -> None:
        """All impacts of the problem, of `size` rows; unsure if energy increases."""
        w, of = self.w, self.of
        with w.when(self.together.get() > 0):
            self.thrown(size)
        with w.otherwise():
            self.one_by_one(size)
        energy = of.sum(size, lambda c: self.impulse[c] * (of.room[of.b + c] + of.room[of.a + c]))
        spent = of.sum(size, lambda c: of.absolute(self.impulse[c]) * of.room[of.terms + c])
        of.doubt(energy > spent * (2 * ROUNDED_CHAIN))

    def one_by_one(self, size: Term) -> None:
        """Sequential impacts, the fastest approach first, until no contact approaches."""
        w, of = self.w, self.of
        room = of.room
        with w.few(size) as c:
            self.impulse[c] = 0.0
            room[of.a + c] = room[of.b + c]
            room[of.a_errors + c] = room[of.terms + c]
        self.rebounds.put(0)
        self.done.put(0)
        limit = of.count.get() * of.count.get() * _MOST
        with w.repeat(lambda: (self.done.get() < 1) & (of.unsure.get() < 1)):
            self.one_impact(size)
            self.rebounds.put(self.rebounds.get() + 1)
            of.doubt(self.rebounds.get() > limit)

    def one_impact(self, size: Term) -> None:
        """The impact of the contact that approaches fastest, by Routh's method; sets `done` if none approaches."""
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
            of.doubt(of.lacks_row(i, 0))
            turns = rubs & (d > 2)
            mu, e, law = room[of.static + n], of.numbers[of.laws + i * 3 + 2], self.law[i]
            with w.when(turns):
                self.in_space(row, mu, e, law)
            with w.otherwise():
                self.routh(row, mu, e, law)
                slip = self.put["v_t"].get() - room[of.a + row + 1]
                slip = slip - room[of.W + row * kd + row + 1] * self.put["p_n"].get()
                tangential = slip / room[of.W + (row + 1) * kd + row + 1]
                self.way_a.put(w.select(rubs, tangential, 0.0))
                self.way_b.put(0.0)
            self.hit(size, row, turns)
            with w.when(rubs):
                room[of.a + row + 1] = self.put["v_t"].get()
            with w.when(turns):
                room[of.a + row + 2] = self.put["v_b"].get()

    def hit(self, size: Term, row: Term, turns: Term) -> None:
        """Adds the impulses of a contact, `p_n`, `way_a` and `way_b`, and their effect on all velocities."""
        w, of = self.w, self.of
        room, kd = of.room, of.k * of.d
        impulses = self.put["p_n"].get(), self.way_a.get(), self.way_b.get()
        of.doubt(~(of.absolute(impulses[0]) + of.absolute(impulses[1]) + of.absolute(impulses[2]) < 1e300))
        for j, p in enumerate(impulses[:2]):
            self.impulse[row + j] = self.impulse[row + j] + p
        with w.when(turns):
            self.impulse[row + 2] = self.impulse[row + 2] + impulses[2]
        with w.few(size) as c:
            across = w.select(turns, row + 2, row)  # in the plane way_b = 0
            places = zip((row, row + 1, across), impulses, strict=True)
            by = [room[of.W + c * kd + place] * p for place, p in places]
            room[of.a + c] = room[of.a + c] + by[0] + by[1] + by[2]
            more = of.absolute(by[0]) + of.absolute(by[1]) + of.absolute(by[2])
            room[of.a_errors + c] = room[of.a_errors + c] + more
        room[of.a + row] = self.put["v_n"].get()

    def in_space(self, row: Term, mu: Term, e: Term, law: Term) -> None:
        """Routh's method in space: sets `v_n`, `v_t` and `v_b` after the impact, and the impulses `p_n`, `way_a` and `way_b`."""
        w, of, put, turn = self.w, self.of, self.put, self.turning
        m, before = mobility(of, row), (of.room[of.a + row], of.room[of.a + row + 1], of.room[of.a + row + 2])
        det, trace = m.aa * m.bb - m.ab * m.ab, m.aa + m.bb
        of.doubt(~(det > trace * trace * ROUNDED_SUM))
        for name, x in (("v_n", before[0]), ("p_n", 0.0), ("work", 0.0), ("p_c", 0.0), ("work_c", 0.0), ("v_t", 0.0)):
            put[name].put(x)
        for count in (self.compressed, self.ended):
            count.put(0)
        self.way_a.put(0.0)
        self.way_b.put(0.0)
        with w.when((of.length(of.a + row + 1) > 0.0) & (of.unsure.get() < 1)):
            turn.run(m, mu, e, (law.equals(_NEWTON), law.equals(_POISSON)), before)
            for name, k in (("v_n", 2), ("p_n", 3), ("work", 4)):
                put[name].put(turn.y(k))
            put["p_c"].put(turn.p_c.get())
            put["work_c"].put(turn.work_c.get())
            self.compressed.put(turn.compressed.get())
            self.ended.put(turn.ends.get())
            a, b = turn.y(0), turn.y(1)
            size = w.compute("sqrt", a * a + b * b)
            put["v_t"].put(size)
            self.way_a.put(w.select(size > 0.0, a / size, 0.0))
            self.way_b.put(w.select(size > 0.0, b / size, 0.0))
            with w.when((self.ended.get() < 1) & (size > 0.0)):
                self.along(m, mu)
                along = put["rate"].get()
                put["length"].put(w.select(along < 0.0, size / -along, _ENDLESS))
                self.straight(e, law, before[0])
            with w.when(self.ended.get() < 1):
                put["v_t"].put(0.0)
        with w.when((self.ended.get() < 1) & (of.unsure.get() < 1)):
            self.from_rest(m, mu, det)
            put["length"].put(_ENDLESS)
            self.straight(e, law, before[0])
            of.doubt(self.ended.get() < 1)
        v = put["v_t"].get()
        a, b, p_n = v * self.way_a.get(), v * self.way_b.get(), put["p_n"].get()
        put["v_t"].put(a)
        put["v_b"].put(b)
        to_a, to_b = a - before[1] - m.na * p_n, b - before[2] - m.nb * p_n
        self.way_a.put((m.bb * to_a - m.ab * to_b) / det)
        self.way_b.put((m.aa * to_b - m.ab * to_a) / det)

    def along(self, m: Mobility, mu: Term) -> None:
        """Sets `slope` to dv_n/dp and `rate` to d|v_t|/dp, for slip along (`way_a`, `way_b`)."""
        a, b = self.way_a.get(), self.way_b.get()
        coupling = m.na * a + m.nb * b
        self.put["slope"].put(m.nn - mu * coupling)
        self.put["rate"].put(coupling - mu * (a * (m.aa * a + m.ab * b) + b * (m.ab * a + m.bb * b)))

    def from_rest(self, m: Mobility, mu: Term, det: Term) -> None:
        """Sets `slope`, `rate` and direction at v_t = 0: the contact sticks, or slips in the one direction in which |v_t| grows."""
        w, of, put = self.w, self.of, self.put
        q_a, q_b = (m.bb * m.na - m.ab * m.nb) / det, (m.aa * m.nb - m.ab * m.na) / det
        sticks = q_a * q_a + q_b * q_b <= mu * mu
        kappa, change, turns = self.turning.at, self.turning.step, self.turning.trials
        kappa.put(0.0)
        change.put(1.0)
        turns.put(0)

        def solved(x: Term, y: Term) -> tuple[Term, Term]:
            aa, ab, bb = kappa.get() + mu * m.aa, mu * m.ab, kappa.get() + mu * m.bb
            divisor = aa * bb - ab * ab
            return (bb * x - ab * y) / divisor, (aa * y - ab * x) / divisor

        with w.repeat(lambda: (of.absolute(change.get()) > kappa.get() * LAST_DIGIT) & (turns.get() < _ROOT) & ~sticks):
            z_a, z_b = solved(m.na, m.nb)
            y_a, y_b = solved(z_a, z_b)
            square = z_a * z_a + z_b * z_b
            change.put((w.compute("sqrt", square) - 1.0) * square / (z_a * y_a + z_b * y_b))
            kappa.put(kappa.get() + change.get())
            turns.put(turns.get() + 1)
        z_a, z_b = solved(m.na, m.nb)
        size = w.compute("sqrt", z_a * z_a + z_b * z_b)
        self.way_a.put(w.select(sticks, 0.0, z_a / size))
        self.way_b.put(w.select(sticks, 0.0, z_b / size))
        self.along(m, mu)
        put["slope"].put(w.select(sticks, m.nn - m.na * q_a - m.nb * q_b, put["slope"].get()))
        put["rate"].put(w.select(sticks, 0.0, put["rate"].get()))
        of.doubt(~(put["slope"].get() > m.nn * ROUNDED_SUM))

    def routh(self, row: Term, mu: Term, e: Term, law: Term) -> None:
        """Routh's method in the plane: sets `v_n`, `v_t` after the impact and the normal impulse `p_n`."""
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
        """Follows a piece with constant rates, of at most the impulse `length`; sets `ended` if the impact ends on it."""
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
        """Sets `left` to the impulse until compression or restitution ends, for constant dv_n/dp."""
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
