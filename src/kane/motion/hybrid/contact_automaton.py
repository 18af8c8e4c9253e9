# SPDX-License-Identifier: BSD-3-Clause
"""A motion with contacts from mode to mode in a kernel: it calls the kernel of a mode, decides what follows its event, and goes on.

It has what `kane.motion.contact_motion` says. Where that is not sure in numbers, or a mode's kernel comes back with anything but the
end or an event, it returns: Python decides, or takes that one mode from its beginning.
"""

from collections.abc import Callable
from enum import IntEnum

from kane.motion.hybrid.contact_decisions import STICK, Decisions
from kane.motion.steppers.context import ReturnCode, Slot
from kane.motion.steppers.crossings import LEAVES
from kane.motion.steppers.dense import factor, solve
from kane.numeric.scale import ROUNDED, ROUNDED_CHAIN, ROUNDED_SUM, ROUNDED_TERMS, SAME_TIME, SOON
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Term, Writer
from kane.program.native.calls import RESULT

STARTS, ENDS = 1e-8, 1e-10
"""A slip goes straight on over this share of the span from its beginning, and below this share of its terms before its end."""
NOTHING = 1e-10
"""Share of the terms of a velocity that is nothing: what is left where a slip or an approach ends."""
FLAT, LOW = 1e-3, 1e-10
"""Shares of what tolerances leave open of a gap, and of the highest rebound, up to which rebounds are followed."""
AT_ONCE = 100
"""Modes at one instant after which none is consistent in numbers."""
KINDS = ("closes", "opens", "slips", "sticks", "turns", "slows")
"""How an event ends the mode of a contact."""
LAWS = ("newton", "poisson", "stronge")
SEPARATED, STICKS, STRAIGHT, SLIPS, HELD = 0.0, 1.0, 2.0, 3.0, 4.0
"""`ContactMode`."""
_CLOSES, _OPENS, _SLIPS, _STICKS, _TURNS, _SLOWS = range(6)
_FIRST, _HIT, _FORCE, _APART, _REST, _LAST, _DONE = range(7)
"""What is to be done after an event: to find that out; impacts; the force that slip begins against; the choice without the contact
that opens, that of those that stay closed for those that rest, and of all."""

Which = Callable[[Term], Term]


class Back(IntEnum):
    """Why it returns: at the end; at an event that is no contact's; to have Python decide after an event, or take a mode; to collect."""

    END = 1
    EVENT = 2
    DECIDE = 3
    TAKE = 4
    FULL = 5


class Row(IntEnum):
    """Places in a row of `records`, one a mode: what stands at `MORE` are the numbers in p that it had, its first and last state."""

    BEGIN = 0
    END = 1
    MODE = 2
    EVENT = 3
    FIRST_SAMPLE = 4
    SAMPLE = 5
    NOTED = 6
    OVER = 7
    MORE = 8


def automaton_kernel() -> Kernel:
    """The kernel."""
    return _Automaton(Writer("contacts")).kernel()


class _Automaton:
    """The kernel while it is written.

    Arrays with a number a contact: `modes` and, of slips, `directions` now; `slack`, `fastest`, `highest`, `rebound` as Python has
    them; `next_modes`, `next_ways` are decided; `sliding`, `friction`, `touching` what a decision is asked. Arrays with a part a
    mode: `ps`, `seen`, `largest`, `least`, `own`, `leaves` with `events` each, `p_at` where in p what stands, `meaning` of events, and
    `begun` by what events a mode begins.
    """

    def __init__(self, w: Writer) -> None:
        self.w, self.of = w, Decisions(w)
        names = ("n", "event_count", "p_count", "known", "most", "room_for", "enter")
        self.n, self.e, self.np_, self.known, self.most, self.room_for, self.enter = map(w.number, names)
        names = ("s", "y", "lag", "log", "held_log", "glanced", "records", "noted", "calls", "codes", "tolerances")
        self.s, self.y, self.lag, self.log, self.held_log, self.glanced = map(w.array, names[:6])
        self.records, self.noted, self.calls, self.codes, self.tolerances = map(w.array, names[6:])
        names = ("modes", "directions", "slack", "fastest", "highest", "rebound", "next_modes", "next_ways")
        self.modes, self.ways, self.slack, self.fastest, self.highest, self.rebound = map(w.array, names[:6])
        self.next, self.next_ways = map(w.array, names[6:])
        names = ("sliding", "friction", "touching", "hits", "leaving", "extra", "slip_count", "law", "kept", "impulse")
        self.sliding, self.friction, self.touching, self.hits, self.leaving, self.extra = map(w.array, names[:6])
        self.slip_count, self.law, self.kept, self.impulse = map(w.array, names[6:])
        names = ("ps", "seen", "largest", "least", "own_events", "leaves", "p_at", "meaning", "begun")
        self.ps, self.seen, self.largest, self.least, self.own, self.leaves = map(w.array, names[:6])
        self.p_at, self.meaning, self.begun = map(w.array, names[6:])
        self.make, self.hoist = (w.callee(name, "array") for name in ("make", "hoist"))
        self.look, self.drives = (w.callee(name, "float", "array", "array", "array", "array") for name in ("look", "drive"))
        self.driven = w.number("driven")
        self.back, self.mode, self.rows = (w.variable(name, INT) for name in ("back", "mode", "row_count"))
        names = ("noted_count", "still", "which", "event_kind", "hit", "found", "last", "begins", "task", "next_task")
        cells = [w.variable(name, INT) for name in names]
        self.noted_count, self.still, self.which, self.kind, self.hit, self.found, self.last = cells[:7]
        self.begins, self.task, self.next_task = cells[7:]
        self.over, self.code, self.t = (w.variable(name) for name in ("over", "code", "time"))
        self.put = {
            name: w.variable(name)
            for name in ("v_n", "v_t", "p_n", "work", "p_c", "work_c", "left", "length", "slope", "rate", "need")
        }
        self.compressed, self.done, self.ended, self.rebounds = (
            w.variable(x, INT) for x in ("compressed", "done", "ended", "rebounds")
        )

    # ---------------------------------------------------------------------------------------------------------- the loop

    def kernel(self) -> Kernel:
        """The whole."""
        w = self.w
        self.mode.put(w.compute("int", self.calls[0]))
        self.t.put(self.s[int(Slot.TIME)])
        self.begins.put(self.enter)
        with w.repeat(lambda: self.back.get() < 1):
            with w.when(self.begins.get() > 0):
                self.begin()
            with w.when(self.back.get() < 1):
                self.one_mode()
        self.records[0] = w.compute("float", self.rows.get())
        self.records[1] = w.compute("float", self.noted_count.get())
        return w.finished(self.back)

    def row(self) -> Term:
        """Where the present row of `records` begins: two numbers stand before the first."""
        return self.rows.get() * (self.extra_count() + self.n * 2 + int(Row.MORE)) + 2

    def extra_count(self) -> Term:
        """How many numbers of a mode stand in p: directions, slack and slowest slips."""
        return self.of.k * (self.of.d + 1)

    def one_mode(self) -> None:
        """A mode up to its end, and what follows."""
        w, s, row = self.w, self.s, self.row()
        self.make(self.calls.at(0))
        code = self.calls[RESULT]
        ends, event = code <= float(ReturnCode.END), (code >= float(ReturnCode.EVENT)) & (code < float(ReturnCode.FULL))
        count = w.compute("int", s[int(Slot.LOGGED)])
        full = self.noted_count.get() + count > self.room_for
        too_many = s[int(Slot.STEPS)] > w.compute("float", self.most)
        with w.when(~(ends | event) | (self.held_log[0] > 0.0) | full | too_many):
            self.back.put(int(Back.TAKE))
        with w.otherwise():
            which = w.select(event, w.compute("int", self.log[w.select(event, count - 1, w.integer(0)) * 2 + 1]), w.integer(-1))
            self.which.put(which)
            for at, value in (
                (Row.END, w.select(event, s[int(Slot.TIME)], s[int(Slot.END)])),
                (Row.EVENT, w.compute("float", which)),
                (Row.SAMPLE, s[int(Slot.SAMPLE)]),
                (Row.OVER, w.constant(0.0)),
            ):
                self.records[row + int(at)] = value
            with w.few(count) as k:
                at = (self.noted_count.get() + k) * 2
                self.noted[at] = self.log[k * 2]
                self.noted[at + 1] = self.log[k * 2 + 1]
            self.noted_count.put(self.noted_count.get() + count)
            self.records[row + int(Row.NOTED)] = w.compute("float", self.noted_count.get())
            with w.few(self.n) as i:
                self.records[row + int(Row.MORE) + self.extra_count() + self.n + i] = self.y[i]
            self.rows.put(self.rows.get() + 1)
            with w.when(ends):
                self.back.put(int(Back.END))
            with w.otherwise():
                self.follow(row)

    def follow(self, row: Term) -> None:
        """What follows an event."""
        w = self.w
        at = (self.mode.get() * self.e + self.which.get()) * 2
        contact, kind = self.meaning[at], self.meaning[at + 1]
        with w.when(contact < 0.0):
            self.back.put(int(Back.EVENT))
        with w.otherwise():
            self.of.unsure.put(0)
            self.t.put(self.s[int(Slot.TIME)])
            self.still.put(w.select(self.t.get() > self.records[row], w.integer(0), self.still.get() + 1))
            self.of.doubt(self.still.get() > AT_ONCE)
            self.kind.put(w.compute("int", kind))
            self.which.put(w.compute("int", contact))
            self.over.put(0.0)
            self.keep(back=False)
            self.decide_after()
            with w.when(self.of.unsure.get() < 1):
                self.go_over()
            with w.when(self.of.unsure.get() > 0):
                self.keep(back=True)
                self.back.put(int(Back.DECIDE))
            with w.otherwise():
                self.records[row + int(Row.OVER)] = self.over.get()
                with w.when(self.rows.get() >= self.room_for):
                    self.back.put(int(Back.FULL))
                self.begins.put(1)

    def drive(self) -> None:
        """The inputs at the state at hand."""
        with self.w.when(self.driven > 0):
            self.drives(self.t.get(), self.y.at(0), self.of.r.at(0), self.calls.at(0), self.of.r.at(0))

    def keep(self, back: bool) -> None:
        """What is known of the contacts is kept, or is again what was kept, for Python to decide."""
        for k, one in enumerate((self.slack, self.fastest, self.highest, self.rebound)):
            with self.w.few(self.of.k) as i:
                at = self.of.k * k + i
                if back:
                    one[i] = self.kept[at]
                else:
                    self.kept[at] = one[i]

    # ------------------------------------------------------------------------------------------------- what follows an event

    def is_(self, *kinds: int) -> Term:
        """Whether the event is one of these kinds."""
        found = (self.kind.get() <= kinds[0]) & (self.kind.get() >= kinds[0])
        for k in kinds[1:]:
            found = found | ((self.kind.get() <= k) & (self.kind.get() >= k))
        return found

    def here(self, i: Term) -> Term:
        """Whether it is the event of contact i."""
        return (i <= self.which.get()) & (i >= self.which.get())

    def slipping(self, i: Term) -> Term:
        """Whether contact i slips."""
        return (self.modes[i] >= STRAIGHT) & (self.modes[i] <= SLIPS)

    def decide_after(self) -> None:
        """`next_modes` and `next_ways`; the state after impacts is in y."""
        w, of = self.w, self.of
        self.task.put(_FIRST)
        with w.repeat(lambda: (self.task.get() < _DONE) & (of.unsure.get() < 1)):
            self.drive()
            of.touch(self.t.get(), self.y)
            with w.when(self.doing(_FIRST)):
                self.first()
            with w.when(self.doing(_REST) | (self.doing(_LAST) & (self.hit.get() > 0))):
                self.find_slips(lambda i: self.touching[i] > 0.0)
            with w.when(self.task.get() < _DONE):
                self.decide_on()

    def doing(self, task: int) -> Term:
        """Whether it is this task."""
        return (self.task.get() <= task) & (self.task.get() >= task)

    def first(self) -> None:
        """What is to be done after an event."""
        w, of = self.w, self.of
        k, d = of.k, of.d
        self.hit.put(0)
        with w.few(k) as i:
            self.next[i] = self.modes[i]
            with w.few(d - 1) as j:
                self.next_ways[i * (d - 1) + j] = self.ways[i * (d - 1) + j]
            self.touching[i] = w.select(self.modes[i] > SEPARATED, 1.0, 0.0)
            self.friction[i] = of.numbers[of.laws + i * 3]
            self.hits[i] = 0.0
            with w.when(~(self.modes[i] > SEPARATED) & ((self.here(i) & self.is_(_CLOSES)) | self.closes(i))):
                self.hits[i] = 1.0
                self.hit.put(1)
        self.find_slips(lambda i: self.slipping(i) & ~(self.here(i) & self.is_(_STICKS)))
        self.task.put(_LAST)
        i = self.which.get()
        with w.when(self.is_(_TURNS, _SLOWS)):
            self.task.put(_DONE)
            self.next[i] = w.select(self.is_(_TURNS), SLIPS, STRAIGHT)
            with w.when(self.is_(_SLOWS)), w.few(d - 1) as j:
                self.next_ways[i * (d - 1) + j] = of.room[of.velocity + i * d + 1 + j] / self.slip(i)
        with w.when((self.hit.get() < 1) & self.is_(_OPENS)):
            self.task.put(_APART)
        with w.when((self.hit.get() < 1) & self.is_(_SLIPS)):
            static, kinetic = (of.numbers[of.laws + i * 3 + j] for j in (0, 1))
            self.friction[i] = kinetic
            with w.when(kinetic >= static):
                self.task.put(_FORCE)
        with w.when((self.hit.get() > 0) & (self.task.get() < _DONE)):
            self.task.put(_HIT)
            with w.few(k) as i:
                self.friction[i] = of.numbers[of.laws + i * 3 + 1]
                with w.few(d - 1) as j:
                    self.sliding[i * (d - 1) + j] = 0.0
                with w.when(self.hits[i] > 0.0):
                    self.slack[i] = 0.0
                    self.touching[i] = 1.0

    def decide_on(self) -> None:
        """One task, and which is next."""
        w, of = self.w, self.of
        apart = self.doing(_APART)
        of.problem(
            lambda i: (self.touching[i] > 0.0) & ~(apart & self.here(i)), self.sliding, self.friction, self.doing(_HIT)
        )
        self.next_task.put(_LAST)
        with w.when(self.doing(_HIT)):
            self.impact()
            self.next_task.put(_REST)
            with w.few(of.k) as i:
                self.friction[i] = of.numbers[of.laws + i * 3]
        with w.when(self.doing(_FORCE)):
            self.along_force(self.which.get())
        with w.when((self.task.get() >= _APART) & (self.task.get() <= _LAST)):
            of.choose()
            self.found.put(0)
            with w.when(apart):
                self.parts()
            with w.when(self.doing(_REST)):
                self.flat()
            with w.when(self.doing(_LAST) | (apart & (self.found.get() > 0))):
                self.settle()
                self.next_task.put(_DONE)
        self.task.put(self.next_task.get())

    def slip(self, i: Term) -> Term:
        """|v_t| of a contact."""
        of = self.of
        at = of.velocity + i * of.d + 1
        return self.w.compute("sqrt", of.sum(of.d - 1, lambda j: of.room[at + j] * of.room[at + j]))

    def slip_terms(self, i: Term) -> Term:
        """The largest of the terms of its slips, and of what they have been."""
        w, of = self.w, self.of
        of.cell.put(self.fastest[i])
        with w.few(of.d - 1) as j:
            of.cell.put(of.largest(of.cell.get(), of.room[of.velocity_terms + i * of.d + 1 + j]))
        return of.cell.get()

    def find_slips(self, of_contact: Which) -> None:
        """`sliding` becomes the directions of slip of some contacts, zero where there is none but for rounding."""
        w, of = self.w, self.of
        with w.few(of.k) as i:
            size = self.slip(i)
            moves = of_contact(i) & (size > self.slip_terms(i) * NOTHING)
            with w.few(of.d - 1) as j:
                way = of.room[of.velocity + i * of.d + 1 + j] / size
                self.sliding[i * (of.d - 1) + j] = w.select(moves, way, 0.0)

    def closes(self, i: Term) -> Term:
        """Whether a gap that is open closes at this instant, too."""
        of = self.of
        rate, terms = of.room[of.velocity + i * of.d], of.room[of.velocity_terms + i * of.d]
        level = of.numbers[of.gap_terms + i] - rate * self.s[int(Slot.SPAN)]
        has_gap = of.places[i * of.d] > -0.5
        return has_gap & (rate < -(terms * NOTHING)) & (of.numbers[of.gaps + i] + self.slack[i] <= level * SAME_TIME)

    def settle(self) -> None:
        """The modes that were chosen are next; contacts that are not among the closed ones are separated."""
        w, of = self.w, self.of
        d = of.d
        with w.few(of.k) as i:
            self.next[i] = SEPARATED
            with w.few(d - 1) as j:
                self.next_ways[i * (d - 1) + j] = 0.0
        with w.few(of.count.get()) as n:
            i = of.index(of.own + n)
            kind = of.room[of.kind + n]
            with w.when(kind < STICK):
                of.doubt(~(of.places[i * d] > -0.5))  # what the coordinates do not let open
            sticks = (kind >= STICK) & ((kind <= STICK) | ~(self.slip_count[i] > 0.0))
            held = (kind <= STICK) & (of.room[of.lead + n] < w.compute("float", n))
            with w.when(sticks):
                self.next[i] = w.select(held, HELD, STICKS)
                with w.when(held):  # by the last one before it that sticks
                    self.last.put(-1)
                    with w.few(n) as m:
                        other = of.index(of.own + m)
                        leads = (self.next[other] <= STICKS) & (self.next[other] >= STICKS) & (self.slip_count[other] > 0.0)
                        self.last.put(w.select(leads, m, self.last.get()))
                    lead = of.index(of.lead + n)
                    of.doubt((self.last.get() < lead) | (lead < self.last.get()))
            with w.when((kind > STICK) & ~sticks):
                with w.few(d - 1) as j:
                    self.next_ways[i * (d - 1) + j] = of.room[of.dirs + n * d + j]
                slides = self.slip(i) > self.slip_terms(i) * NOTHING
                self.next[i] = w.select((self.slip_count[i] > 1.5) & slides, SLIPS, STRAIGHT)
        with w.few(of.k) as i, w.when((self.hits[i] > 0.0) & (self.touching[i] > 0.0) & ~(self.next[i] > SEPARATED)):
            gap, terms = of.numbers[of.gaps + i], of.numbers[of.gap_terms + i]
            self.slack[i] = ROUNDED * terms + 2.0 * of.absolute(gap)

    def parts(self) -> None:
        """Whether the gap of the event does not close again, its contact taken for open: then that is what follows."""
        w, of = self.w, self.of
        i, kd = self.which.get(), of.k * of.d
        row = i * of.d
        a, terms = self.put["left"], self.put["need"]
        a.put(of.room[of.bias + row])
        terms.put(of.room[of.bias_terms + row])
        with w.few(of.count.get() * of.d) as c:
            other = of.index(of.own + of.whole(c)) * of.d + of.rest_of(c)
            part = of.room[of.mobility + row * kd + other] * of.room[of.force + c]
            a.put(a.get() + part)
            terms.put(terms.get() + of.absolute(part))
        with w.when((of.places[row] > -0.5) & (a.get() >= -(terms.get() * NOTHING))):
            self.found.put(1)
            self.slack[i] = ROUNDED * of.numbers[of.gap_terms + i]

    def along_force(self, i: Term) -> None:
        """`sliding` of a contact whose friction has reached its most becomes the direction against it."""
        w, of = self.w, self.of
        with w.few(of.count.get()) as n:
            slides = of.room[of.slides + n] > 0.0
            of.room[of.kind + n] = w.select(slides, 3.0, STICK)
            of.room[of.mu + n] = of.room[of.kinetic + n]
        of.group()
        of.solve()
        with w.few(of.count.get()) as n, w.when(self.here(of.index(of.own + n))):
            at = of.force + n * of.d + 1
            size = w.compute("sqrt", of.sum(of.d - 1, lambda j: of.room[at + j] * of.room[at + j]))
            of.doubt(~(size > 0.0))
            with w.few(of.count.get()) as m, w.when(of.leads(m, n)):
                other = of.index(of.own + m)
                with w.few(of.d - 1) as j:
                    self.sliding[other * (of.d - 1) + j] = -of.room[at + j] / size

    # ---------------------------------------------------------------------------------------------------------- impacts

    def impact(self) -> None:
        """y after the impacts of those that touch, and which of them stay closed: `touching`."""
        w, of = self.w, self.of
        room, d, kd = of.room, of.d, of.k * of.d
        with w.few(of.k) as i, w.when(self.touching[i] > 0.0):
            self.fastest[i] = self.slip_terms(i)
        size = of.count.get() * d
        with w.few(size) as c:
            self.impulse[c] = 0.0
            room[of.a + c] = room[of.b + c]
            room[of.a_errors + c] = room[of.terms + c]
        self.rebounds.put(0)
        self.done.put(0)
        limit = of.count.get() * of.count.get() * 100
        with w.repeat(lambda: (self.done.get() < 1) & (of.unsure.get() < 1)):
            self.one_impact(size)
            self.rebounds.put(self.rebounds.get() + 1)
            of.doubt(self.rebounds.get() > limit)
        energy = of.sum(size, lambda c: self.impulse[c] * (room[of.b + c] + room[of.a + c]))
        spent = of.sum(size, lambda c: of.absolute(self.impulse[c]) * room[of.terms + c])
        of.doubt(energy > spent * (2 * ROUNDED_CHAIN))
        self.change(size, lambda c: self.impulse[c])
        with w.few(of.k) as i:
            self.leaving[i] = 0.0
        with w.few(size) as c:  # sizes of the terms of velocities after the impacts
            through = of.sum(size, lambda b, c=c: of.absolute(room[of.W + c * kd + b] * self.impulse[b]))
            room[of.a_errors + c] = room[of.terms + c] + through
        with w.few(of.count.get()) as n:
            i, v, terms = of.index(of.own + n), room[of.a + n * d], room[of.a_errors + n * d]
            with w.few(d, 1) as j:
                self.fastest[i] = of.largest(self.fastest[i], room[of.a_errors + n * d + j])
            with w.when(v > terms * NOTHING):
                self.leaving[of.index(of.own + n)] = 1.0
                self.touching[of.index(of.own + n)] = 0.0

    def change(self, size: Term, impulse: Callable[[Term], Term]) -> None:
        """The speeds after impulses of the rows of the problem."""
        w, of = self.w, self.of
        with w.few(of.nu) as j:

            def moved(c: Term, j: Term = j) -> Term:
                row = of.index(of.own + of.whole(c)) * of.d + of.rest_of(c)
                return of.room[of.spread + row * of.width + j] * impulse(c)

            self.y[of.nq + j] = self.y[of.nq + j] + of.sum(size, moved)

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
            put["length"].put(w.select(along < 0.0, of.absolute(put["v_t"].get()) / -along, 1e301))
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
            put["length"].put(1e301)
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
            step, ends = w.compute("min", put["left"].get(), put["length"].get()), put["left"].get() < put["length"].get()
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
        linear = (self.compressed.get() < 1) | (law < 0.5)
        target = w.select(self.compressed.get() < 1, 0.0, -(e * before))
        met = w.compute("max", (target - v) / slope, 0.0)
        poisson = w.compute("max", (e + 1.0) * put["p_c"].get() - put["p_n"].get(), 0.0)
        need = -(put["work"].get() + e * e * put["work_c"].get())
        square = v * v + slope * need * 2.0
        root = v + w.compute("sqrt", w.select(square > 0.0, square, 0.0))
        stronge = w.select(need > 0.0, w.select((square >= 0.0) & (root > 0.0), need * 2.0 / root, 1e301), 0.0)
        by_law = w.select(law < 1.5, poisson, stronge)
        put["left"].put(w.select(linear, w.select(slope > 0.0, met, 1e301), by_law))

    def flat(self) -> None:
        """Contacts whose further rebounds are less than tolerances tell rest: `touching`, and when the last of these is over."""
        w, of = self.w, self.of
        room, d, kd = of.room, of.d, of.k * of.d
        rests = self.last
        rests.put(0)
        self.over.put(self.t.get())
        with w.few(of.k) as i, w.when((self.leaving[i] > 0.0) & (of.unsure.get() < 1)):
            pushed = of.sum(
                of.count.get() * d,
                lambda c: room[of.mobility + i * d * kd + of.index(of.own + of.whole(c)) * d + of.rest_of(c)] * room[of.force + c],
            )
            a, v, given = pushed + room[of.bias + i * d], room[of.velocity + i * d], of.numbers[of.laws + i * 3 + 2]
            guessed = w.select(self.rebound[i] > v, v / self.rebound[i], 0.0)
            e = w.select(given > 0.0, given, guessed)
            self.rebound[i] = v
            falls = a < 0.0
            height = w.select(falls, -(v * v) / (a * 2.0), 1e301)
            open_ = self.tolerances[0] + self.tolerances[1] * of.numbers[of.gap_terms + i]
            with w.when(falls):
                self.highest[i] = of.largest(self.highest[i], height)
            with w.when(height <= of.largest(open_ * FLAT, self.highest[i] * LOW)):
                rests.put(1)
                self.hits[i] = 2.0
                after = self.t.get() - v * 2.0 / (a * (1.0 - e))
                self.over.put(w.select(e < 1.0, of.largest(self.over.get(), after), self.over.get()))
        with w.when((rests.get() > 0) & (of.unsure.get() < 1)):
            self.hold()

    def hold(self) -> None:
        """The least change of speeds after which gaps that rest have no rates, and contacts that do not slip no slip."""
        w, of = self.w, self.of
        room, d, kd = of.room, of.d, of.k * of.d
        count = of.unknowns
        count.put(0)
        with w.few(of.k) as i, w.when((self.touching[i] > 0.0) | (self.hits[i] > 1.5)):
            stuck = (self.touching[i] > 0.0) & ~(
                of.sum(d - 1, lambda j: of.absolute(self.sliding[i * (d - 1) + j])) > 0.0
            )
            self.touching[i] = 1.0
            with w.few(d) as j:
                own = ~of.no_place(i, j) & ((stuck & ~self.is_held(i)) | (j < 1))
                with w.when(own):
                    of.room[of.at_row + count.get()] = w.compute("float", i * d + j)
                    count.put(count.get() + 1)
        with w.few(count.get()) as u:
            row = of.index(of.at_row + u)
            room[of.x + u] = -room[of.velocity + row]
            with w.few(count.get()) as v:
                room[of.bound + u * kd + v] = room[of.mobility + row * kd + of.index(of.at_row + v)]
        factor(room, of.bound, kd, count.get())
        with w.few(count.get()) as u:
            pivot = room[of.bound + u * kd + u]
            row = of.index(of.at_row + u)
            of.doubt(~(pivot * pivot > room[of.mobility + row * kd + row] * ROUNDED_SUM))
        solve(room, of.bound, kd, count.get(), of.x)
        with w.few(of.nu) as j:

            def moved(u: Term, j: Term = j) -> Term:
                return room[of.spread + of.index(of.at_row + u) * of.width + j] * room[of.x + u]

            self.y[of.nq + j] = self.y[of.nq + j] + of.sum(count.get(), moved)

    def is_held(self, i: Term) -> Term:
        """Whether a row of an earlier contact that is held is that of contact i, too."""
        w, of = self.w, self.of
        kd, d = of.k * of.d, of.d
        self.last.put(0)
        with w.few(of.unknowns.get()) as u:
            a, b = i * d + 1, of.index(of.at_row + u)
            ab, aa, bb = (of.room[of.mobility + x * kd + y] for x, y in ((a, b), (a, a), (b, b)))
            with w.when((ab > 0.0) & (ab * ab >= aa * bb * (1 - ROUNDED_SUM)) & (of.rest_of(b) > 0)):
                self.last.put(1)
        return self.last.get() > 0

    # -------------------------------------------------------------------------------------------------- the next mode begins

    def go_over(self) -> None:
        """The numbers of the next mode, and which it is."""
        w, of = self.w, self.of
        d = of.d
        self.code.put(0.0)
        with w.few(of.k) as i:
            self.code.put(self.code.get() * 5.0 + self.next[i])
            at = i * (d + 1)
            parted, hit = self.modes[i] > SEPARATED, (self.hits[i] > 0.0) & self.is_(*range(4))
            fresh = (self.next[i] <= SEPARATED) & (parted | hit)
            begins = (self.next[i] >= STRAIGHT) & (self.next[i] <= STRAIGHT) & ~self.slipping(i)
            begins = begins & ~(self.slip(i) > self.slip_terms(i) * NOTHING)
            self.leaving[i] = w.select(fresh | begins, 1.0, 0.0)
            with w.when((self.next[i] >= STRAIGHT) & (self.next[i] <= SLIPS)):
                self.slowest(i, at)
            with w.few(d - 1) as j:
                self.extra[at + j] = self.next_ways[i * (d - 1) + j]
            self.extra[at + d] = self.slack[i]
        self.found.put(-1)
        with w.few(self.known) as m, w.when((self.codes[m] <= self.code.get()) & (self.codes[m] >= self.code.get())):
            self.found.put(m)
        of.doubt(self.found.get() < 0)
        with w.when(of.unsure.get() < 1):
            self.mode.put(self.found.get())
            self.calls[0] = w.compute("float", self.found.get())
            with w.few(of.k) as i:
                self.modes[i] = self.next[i]
                with w.few(d - 1) as j:
                    self.ways[i * (d - 1) + j] = self.next_ways[i * (d - 1) + j]

    def slowest(self, i: Term, at: Term) -> None:
        """The slip below which contact i goes straight on."""
        w, of = self.w, self.of
        d = of.d
        gains = self.put["need"]
        gains.put(0.0)
        with w.when(~self.is_(_TURNS, _SLOWS)), w.few(of.count.get()) as n, w.when(
            (of.index(of.own + n) <= i) & (of.index(of.own + n) >= i)
        ):
            along = of.a + n * d + 1
            gains.put(w.compute("sqrt", of.sum(d - 1, lambda j: of.room[along + j] * of.room[along + j])))
        v, gained = self.slip(i), gains.get() * self.s[int(Slot.SPAN)] * STARTS
        self.fastest[i] = of.largest(self.slip_terms(i), v, gained)
        level = self.fastest[i] * ENDS
        straight = of.largest(level * 2.0, gained, v * (1 + ENDS))
        self.extra[at + d - 1] = w.select(self.next[i] <= STRAIGHT, straight, level)

    def begin(self) -> None:
        """A mode begins: its numbers in p, its routines' hoists, its events' quantities."""
        w, s, of, row = self.w, self.s, self.of, self.row()
        self.begins.put(0)
        mode, extra = self.mode.get(), self.extra_count()
        with w.few(extra) as i:
            self.records[row + int(Row.MORE) + i] = self.extra[i]
            place = self.p_at[mode * extra + i]
            with w.when(place > -0.5):
                self.ps[mode * self.np_ + w.compute("int", place)] = self.extra[i]
        self.hoist(self.calls.at(0))
        with w.few(self.n) as i:
            self.records[row + int(Row.MORE) + extra + i] = self.y[i]
            self.lag[i] = 0.0
        for at, value in (
            (Row.BEGIN, self.t.get()), (Row.MODE, w.compute("float", mode)), (Row.FIRST_SAMPLE, s[int(Slot.SAMPLE)])
        ):  # fmt: skip
            self.records[row + int(at)] = value
        for slot in _ZERO:
            s[int(slot)] = 0.0
        s[int(Slot.TIME)] = self.t.get()
        s[int(Slot.PHASE)] = self.t.get()
        s[int(Slot.FRESH)] = 2.0
        self.drive()
        self.look(self.t.get(), self.y.at(0), of.r.at(0), self.calls.at(0), self.glanced.at(0))
        self.found.put(0)
        first = mode * self.e
        with w.few(w.compute("int", self.own[mode])) as e:
            value = self.glanced[e]
            at = first + e
            self.seen[at] = value
            self.largest[at] = of.absolute(value)
            for j in range(LEAVES):
                self.leaves[at * LEAVES + j] = 0.0
            beside = of.absolute(value - self.least[at]) > self.glanced[w.compute("int", self.own[mode]) + e] * ROUNDED_TERMS
            contact = w.compute("int", self.meaning[at * 2])
            leaves = (contact >= 0) & (self.leaving[w.select(contact < 0, w.integer(0), contact)] > 0.0)
            leaves = leaves & (self.begun[at] > 0.0)
            with w.when(leaves):
                self.seen[at] = self.least[at]
                for j, x in enumerate((1.0, 1.0, 1.0, 0.0, SOON)):
                    self.leaves[at * LEAVES + j] = x
            with w.otherwise(), w.when(~beside & (self.begun[at] > -0.5)):
                self.found.put(1)
        ahead = s[int(Slot.END)] - self.t.get() > 10.0 * s[int(Slot.SHORTEST)] + SAME_TIME * of.absolute(self.t.get())
        with w.when((self.found.get() > 0) | ~ahead):
            self.back.put(int(Back.TAKE))


_ZERO = (
    Slot.TIME_LAG, Slot.STEP, Slot.LAST_STEP, Slot.LOOKED, Slot.HELD, Slot.QUIET, Slot.SINCE, Slot.SIDED, Slot.TURNING, Slot.CHOICE,
    Slot.MEASURED, Slot.LOGGED, Slot.JUMPS,
)  # fmt: skip
"""What a mode begins with."""
