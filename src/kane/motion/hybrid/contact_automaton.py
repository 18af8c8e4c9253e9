# SPDX-License-Identifier: BSD-3-Clause
"""The hybrid automaton of contacts as a kernel: it calls the kernel of a mode, decides the mode that follows its event, and repeats.

It implements `kane.motion.contact_motion`. It returns if a decision is not certain numerically, or if a mode's kernel returns for any
reason other than the end or an event: Python then decides, or runs that mode from its beginning. If `alone`, without Python, it
returns more specific codes and is called again.
"""

from enum import IntEnum
from functools import cache

from kane.motion.hybrid.contact_events import (
    BEGINS,
    ENDS,
    NOTHING,
    OPENS,
    SEPARATED,
    SLIPPING,
    SLIPS,
    SLOWS,
    STRAIGHT,
    TURNS,
    After,
)
from kane.motion.steppers.context import ReturnCode, Slot
from kane.motion.steppers.crossings import LEAVES
from kane.numeric.scale import GIVEN, ROUNDED_TERMS, SAME_TIME, SOON
from kane.program.kernel.language import Kernel
from kane.program.kernel.writer import Term, Writer
from kane.program.native.entry import RESULT

AT_ONCE = 100
"""Largest number of modes at one instant; after more, no mode counts as consistent."""


class Back(IntEnum):
    """Return codes: at the end; at an event of no contact; for Python to decide after an event, or to run a mode; to collect results.

    UNKNOWN: the next mode has no kernel yet. Only if `alone`: LIMIT, after the largest number of steps of a mode's kernel; LATE, at
    a mode that begins at the end.
    """

    END = 1
    EVENT = 2
    DECIDE = 3
    TAKE = 4
    FULL = 5
    LIMIT = 6
    UNKNOWN = 7
    LATE = 8


NOTED = 4
"""Average number of events per mode for which `noted` has room."""
AGAIN = 10
"""`enter` is 2 at a start, 1 if a mode begins, 0 if it continues; from AGAIN on, the mode ends at its event `enter` − AGAIN."""


class Record(IntEnum):
    """Indices in a row of `records`, one row per mode; from `MORE` on: its contact parameters in p, its first and its last y.

    `STEPS` and `RATES` are the counts before the mode.
    """

    BEGIN = 0
    END = 1
    MODE = 2
    EVENT = 3
    FIRST_SAMPLE = 4
    SAMPLE = 5
    NOTED = 6
    OVER = 7
    STEPS = 8
    RATES = 9
    MORE = 10


@cache
def automaton_kernel() -> Kernel:
    """The kernel of the hybrid automaton."""
    return _Automaton(Writer("contacts")).kernel()


class _Automaton(After):
    """The writer of the kernel.

    Arrays with one part per mode: `ps`, `seen`, `largest`, `least`, `leaves` are arguments of its kernel, `own_events` its number of
    events, `p_at` indices of contact parameters in p; `meaning` (contact, kind) of events, `begun` those that may leave upward.
    """

    def __init__(self, w: Writer) -> None:
        super().__init__(w)
        names = ("n", "event_count", "p_count", "known", "most", "room_for", "enter", "alone", "at_once")
        self.n, self.e, self.np_, self.known, self.most, self.room_for, self.enter, self.alone, self.at_once = map(
            w.number, names
        )
        self.lag, self.log, self.held_log, self.glanced = self._arrays("lag", "log", "held_log", "glanced")
        self.records, self.noted, self.codes, self.extra = self._arrays("records", "noted", "codes", "extra")
        self.ps, self.seen, self.largest, self.least = self._arrays("ps", "seen", "largest", "least")
        self.own, self.leaves, self.p_at, self.meaning, self.begun = self._arrays(
            "own_events", "leaves", "p_at", "meaning", "begun"
        )
        self.make, self.hoist = (w.callee(name, "array") for name in ("make", "hoist"))
        self.look = w.callee("look", "float", "array", "array", "array", "array")
        self.back, self.mode, self.rows, self.noted_count, self.begins, self.decides = self._cells(
            "back", "mode", "row_count", "noted_count", "begins", "decides"
        )
        self.code = w.variable("code")

    def kernel(self) -> Kernel:
        """The complete kernel."""
        w = self.w
        self.mode.put(w.compute("int", self.calls[0]))
        self.t.put(self.s[int(Slot.TIME)])
        self.begins.put(self.enter)
        self.decides.put(0)
        self.still.put(w.compute("int", self.kept[self.of.k * len(self.kept_arrays)]))
        with w.when(self.enter >= AGAIN):
            self.begins.put(0)
            at = (self.mode.get() * self.e + self.enter - AGAIN) * 2
            self.meets(self.meaning[at + 1], self.meaning[at])
        with w.when(self.enter.equals(2)):
            self.meets(w.constant(float(BEGINS)), w.constant(-1.0))
            self.still.put(0)
        with w.repeat(lambda: self.back.get() < 1):
            with w.when((self.begins.get() > 0) & (self.decides.get() < 1)):
                self.begin()
            with w.when((self.back.get() < 1) & (self.decides.get() < 1)):
                self.one_mode()
            with w.when(self.decides.get() > 0):
                self.follow()
        self.records[0] = w.compute("float", self.rows.get())
        self.records[1] = w.compute("float", self.noted_count.get())
        self.kept[self.of.k * len(self.kept_arrays)] = w.compute("float", self.still.get())
        return w.finished(self.back)

    def meets(self, kind: Term, contact: Term) -> None:
        """Requests a decision after an event of a contact, or at the start of the motion."""
        self.t.put(self.s[int(Slot.TIME)])
        self.kind.put(self.w.compute("int", kind))
        self.which.put(self.w.compute("int", contact))
        self.decides.put(1)

    def row(self, which: Term | None = None) -> Term:
        """The index at which a row of `records`, by default the present one, begins; two counts precede the first row."""
        return (self.rows.get() if which is None else which) * (self.extra_count() + self.n * 2 + int(Record.MORE)) + 2

    def extra_count(self) -> Term:
        """The number of contact parameters of a mode in p: directions, slacks and slowest slips."""
        return self.of.k * (self.of.d + 1)

    def one_mode(self) -> None:
        """Runs a mode to its end and records it."""
        w, s, row = self.w, self.s, self.row()
        self.make(self.calls.at(0))
        code = self.calls[RESULT]
        ends, event = code <= float(ReturnCode.END), (code >= float(ReturnCode.EVENT)) & (code < float(ReturnCode.FULL))
        count = w.compute("int", s[int(Slot.LOGGED)])
        full = self.noted_count.get() + count > self.room_for * NOTED
        too_many = s[int(Slot.STEPS)] > w.compute("float", self.most)
        with w.when(~(ends | event) | ((self.held_log[0] > 0.0) & (self.alone < 1)) | full | too_many):
            self.back.put(self.unless_alone(Back.TAKE, Back.LIMIT, code.equals(float(ReturnCode.LIMIT)) & ~too_many))
        with w.otherwise():
            which = w.select(
                event, w.compute("int", self.log[w.select(event, count - 1, w.integer(0)) * 2 + 1]), w.integer(-1)
            )
            self.which.put(which)
            for place, value in (
                (Record.END, w.select(event, s[int(Slot.TIME)], s[int(Slot.END)])),
                (Record.EVENT, w.compute("float", which)),
                (Record.SAMPLE, s[int(Slot.SAMPLE)]),
                (Record.OVER, w.constant(0.0)),
            ):
                self.records[row + int(place)] = value
            with w.few(count) as k:
                at = (self.noted_count.get() + k) * 2
                self.noted[at] = self.log[k * 2]
                self.noted[at + 1] = self.log[k * 2 + 1]
            self.noted_count.put(self.noted_count.get() + count)
            self.records[row + int(Record.NOTED)] = w.compute("float", self.noted_count.get())
            with w.few(self.n) as i:
                self.records[row + int(Record.MORE) + self.extra_count() + self.n + i] = self.y[i]
            self.rows.put(self.rows.get() + 1)
            with w.when(ends):
                self.back.put(int(Back.END))
            with w.otherwise():
                self.arrive(row)

    def unless_alone(self, back: Back, other: Back, condition: Term) -> Term:
        """The return code `other` if `alone` and the condition holds, else `back`."""
        w = self.w
        return w.select((self.alone > 0) & condition, w.integer(int(other)), w.integer(int(back)))

    def arrive(self, row: Term) -> None:
        """At the event that ends the mode of a row: requests a decision if it is a contact's, else returns."""
        w = self.w
        at = (self.mode.get() * self.e + self.which.get()) * 2
        contact, kind = self.meaning[at], self.meaning[at + 1]
        with w.when(contact < 0.0):
            self.back.put(int(Back.EVENT))
        with w.otherwise():
            self.meets(kind, contact)
            self.still.put(w.select(self.t.get() > self.records[row], w.integer(0), self.still.get() + 1))

    def follow(self) -> None:
        """Decides the next mode after an event or at the start, or returns for Python to decide."""
        w, of = self.w, self.of
        self.decides.put(0)
        of.unsure.put(0)
        of.doubt(self.still.get() > AT_ONCE)
        self.over.put(self.t.get())
        self.keep(back=False)
        self.decide_after()
        with w.when(of.unsure.get() > 0):
            self.keep(back=True)
            self.back.put(int(Back.DECIDE))
        with w.otherwise():
            self.go_over()
            with w.when(self.rows.get() > 0):
                self.records[self.row(self.rows.get() - 1) + int(Record.OVER)] = self.over.get()
            full = (self.rows.get() >= self.at_once) | (self.noted_count.get() > self.room_for * 2)
            with w.when((self.back.get() < 1) & full):
                self.back.put(int(Back.FULL))
            self.begins.put(1)

    def go_over(self) -> None:
        """Sets the contact parameters of the next mode, and its index; returns if it has no kernel yet."""
        w, of = self.w, self.of
        d = of.d
        self.code.put(0.0)
        with w.few(of.k) as i:
            self.code.put(self.code.get() * 5.0 + self.next[i])
            at = i * (d + 1)
            parted, hit = self.modes[i] > SEPARATED, (self.hits[i] > 0.0) & self.is_(*range(4))
            at_zero = self.is_(BEGINS) & (of.numbers[of.gaps + i] <= of.numbers[of.gap_terms + i] * GIVEN)
            fresh = (self.next[i] <= SEPARATED) & (parted | hit | at_zero)
            begins = self.next[i].equals(STRAIGHT) & ~self.is_(TURNS, SLOWS)
            begins = begins & ~(self.slip(i) > self.slip_terms(i) * NOTHING)
            self.leaving[i] = w.select(fresh | begins, 1.0, 0.0)
            with w.when((self.next[i] >= STRAIGHT) & (self.next[i] <= SLIPS)):
                self.slowest(i, at)
            with w.few(d - 1) as j:
                self.extra[at + j] = self.next_ways[i * (d - 1) + j]
            self.extra[at + d] = self.slack[i]
        self.found.put(-1)
        with w.few(self.known) as m, w.when(self.codes[m].equals(self.code.get())):
            self.found.put(m)
        with w.when(self.found.get() < 0):
            self.back.put(int(Back.UNKNOWN))
        with w.otherwise():
            self.mode.put(self.found.get())
            self.calls[0] = w.compute("float", self.found.get())
            with w.few(of.k) as i:
                self.modes[i] = self.next[i]
                with w.few(d - 1) as j:
                    self.directions[i * (d - 1) + j] = self.next_ways[i * (d - 1) + j]

    def slowest(self, i: Term, at: Term) -> None:
        """Sets the slip speed below which contact i slips in a fixed direction."""
        w, of = self.w, self.of
        d = of.d
        gains = self.rate
        gains.put(0.0)
        with (
            w.when(~self.is_(TURNS, SLOWS)),
            w.few(of.count.get()) as n,
            w.when(of.index(of.own + n).equals(i)),
        ):
            gains.put(self.gained(n))
            self.slip_rate[i] = self.rate_of_slip(n)
        v, gained = self.slip(i), gains.get()
        self.fastest[i] = of.largest(self.slip_terms(i), v, gained)
        level = self.level(i, self.fastest[i], self.slip_rate[i])
        straight = of.largest(level * 2.0, gained, v * (1 + ENDS))
        self.extra[at + d - 1] = w.select(self.next[i] <= STRAIGHT, straight, level)

    def begin(self) -> None:
        """Begins a mode: its parameters in p, hoisted operations of its routines, initial quantities of its events."""
        w, s, of, row = self.w, self.s, self.of, self.row()
        self.begins.put(0)
        mode, extra = self.mode.get(), self.extra_count()
        for what, slot in ((Record.STEPS, Slot.STEPS), (Record.RATES, Slot.RATES)):
            self.records[row + int(what)] = s[int(slot)]
        with w.few(extra) as i:
            self.records[row + int(Record.MORE) + i] = self.extra[i]
            place = self.p_at[mode * extra + i]
            with w.when(place > -0.5):
                self.ps[mode * self.np_ + w.compute("int", place)] = self.extra[i]
        self.hoist(self.calls.at(0))
        for slot in _ZERO:
            s[int(slot)] = 0.0
        s[int(Slot.STEP)] = w.select(self.rows.get() < 1, self.tolerances[2], 0.0)
        s[int(Slot.TIME)] = self.t.get()
        s[int(Slot.PHASE)] = self.t.get()
        s[int(Slot.FRESH)] = 2.0
        with w.few(self.n) as i:
            self.lag[i] = 0.0
        self.make(self.calls.at(0))
        with w.few(self.n) as i:
            self.records[row + int(Record.MORE) + extra + i] = self.y[i]
        for where, number in (
            (Record.BEGIN, self.t.get()), (Record.MODE, w.compute("float", mode)), (Record.FIRST_SAMPLE, s[int(Slot.SAMPLE)])
        ):  # fmt: skip
            self.records[row + int(where)] = number
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
            band = self.glanced[w.compute("int", self.own[mode]) + e] * ROUNDED_TERMS
            beside = of.absolute(value - self.least[at]) > band
            contact = w.compute("int", self.meaning[at * 2])
            leaves = (contact >= 0) & (self.leaving[w.select(contact < 0, w.integer(0), contact)] > 0.0)
            leaves = leaves & (self.begun[at] > 0.0)
            kind = self.meaning[at * 2 + 1]
            beyond = (contact >= 0) & (kind >= float(OPENS)) & (kind <= float(SLIPPING)) & (value < 0.0)
            with w.when(leaves):
                self.seen[at] = self.least[at]
                # projection may have moved it below its threshold
                within = of.largest(band, (self.least[at] - value) * 2.0)
                for j, x in enumerate((*map(w.constant, (1.0, 1.0, 1.0)), within, w.constant(SOON))):
                    self.leaves[at * LEAVES + j] = x
            with w.otherwise(), w.when((~beside & (self.begun[at] > -0.5)) | beyond):
                self.found.put(1)
        ahead = s[int(Slot.END)] - self.t.get() > 10.0 * s[int(Slot.SHORTEST)] + SAME_TIME * of.absolute(self.t.get())
        admitted = self.calls[RESULT].equals(float(ReturnCode.LIMIT))
        with w.when((self.found.get() > 0) | ~ahead | ~admitted):
            unsure = (self.found.get() > 0) | ~admitted
            self.back.put(self.unless_alone(Back.TAKE, Back.LATE, ~unsure))


_ZERO = (
    Slot.TIME_LAG, Slot.LAST_STEP, Slot.LOOKED, Slot.HELD, Slot.QUIET, Slot.SINCE, Slot.SIDED, Slot.TURNING, Slot.CHOICE,
    Slot.MEASURED, Slot.LOGGED, Slot.JUMPS,
)  # fmt: skip
"""Slots that are zero when a mode begins."""
