# SPDX-License-Identifier: BSD-3-Clause
"""Decisions after an event of a contact, in a kernel: impacts if a gap closes, then the modes. See `kane.motion.contact_motion`."""

from collections.abc import Callable

from kane.motion.hybrid.contact_decisions import SLIP, STICK, Decisions
from kane.motion.hybrid.contact_impacts import ImpactKernel
from kane.motion.steppers.context import Slot
from kane.numeric.scale import EQUAL, GIVEN, ROUNDED, ROUNDED_SUM, ROUNDED_TERMS, SAME_TIME
from kane.program.kernel.language import INT
from kane.program.kernel.writer import Array, Term, Variable, Writer, factor, solve

NOTHING = 1e-10
"""Fraction of its terms up to which a velocity counts as zero, as where a slip or an approach ends."""
STARTS, ENDS = 1e-8, 1e-10
"""Slip has a fixed direction up to the speed gained in this fraction of the span after its beginning; and before its end, below this
fraction of its terms, or below the error that tolerances or rounding of the time leave, as it would oscillate about its end."""
FLAT, LOW = 1e-3, 1e-10
"""Fractions of the tolerance of a gap, and of the highest rebound, below which rebounds are omitted."""
KINDS = ("closes", "opens", "slips", "sticks", "turns", "slows")
"""The kinds of events that end the mode of a contact."""
SEPARATED, STICKS, STRAIGHT, SLIPS, HELD = 0.0, 1.0, 2.0, 3.0, 4.0
"""Values of `ContactMode`."""
CLOSES, OPENS, SLIPPING, STICKING, TURNS, SLOWS, BEGINS = range(7)
"""The kinds as numbers, and the start of a motion, at which numerical values decide which contacts are closed."""
_FIRST, _HIT, _FORCE, _APART, _REST, _LAST, _DONE = range(7)
"""Tasks after an event: to select tasks; impacts; friction forces that beginning slip opposes; the choice of modes without the contact
that opens, that of contacts that stay closed, to detect rest, and that of all."""
Which = Callable[[Term], Term]


class After:
    """The writer of decisions after an event; its arguments are arrays with the data of contacts.

    `modes` and `directions` of slip are the present ones; `slack`, `fastest`, `highest`, `rebound`, `slip_rate` as in
    `kane.motion.contact_motion`;
    `next_modes` and `next_ways` are the results, `sliding`, `friction`, `touching`, `hits` the input of a decision. `tolerances` are
    atol, rtol and the first step of the motion, 0 if the kernel chooses it.
    """

    def __init__(self, w: Writer) -> None:
        self.w, self.of = w, Decisions(w)
        self.impacts = ImpactKernel(self.of)
        self.s, self.y, self.calls, self.tolerances = self._arrays("s", "y", "calls", "tolerances")
        self.modes, self.directions, self.slip_count = self._arrays("modes", "directions", "slip_count")
        self.kept_arrays = self._arrays("slack", "fastest", "highest", "rebound", "slip_rate")
        self.slack, self.fastest, self.highest, self.rebound, self.slip_rate = self.kept_arrays
        self.next, self.next_ways, self.sliding, self.friction = self._arrays(
            "next_modes", "next_ways", "sliding", "friction"
        )
        self.touching, self.hits, self.leaving, self.kept = self._arrays("touching", "hits", "leaving", "kept")
        self.off, self.others = w.array("off"), w.variable("others", INT)
        self.drives = w.callee("drive", "float", "array", "array", "array", "array")
        self.driven = w.number("driven")
        self.which, self.kind, self.hit, self.found, self.last, self.task, self.next_task, self.still = self._cells(
            "which", "event_kind", "hit", "found", "last", "task", "next_task", "still"
        )
        self.over, self.t, self.rate, self.terms = (
            w.variable(name) for name in ("over", "time", "rate_of", "terms_of")
        )

    def _arrays(self, *names: str) -> list[Array]:
        return [self.w.array(name) for name in names]

    def _cells(self, *names: str) -> list[Variable]:
        return [self.w.variable(name, INT) for name in names]

    def drive(self) -> None:
        """Evaluates the inputs at the present state."""
        with self.w.when(self.driven > 0):
            self.drives(self.t.get(), self.y.at(0), self.of.r.at(0), self.calls.at(0), self.of.r.at(0))

    def keep(self, back: bool) -> None:
        """Saves the data of contacts, or restores them (`back`) for Python to decide."""
        for k, one in enumerate(self.kept_arrays):
            with self.w.few(self.of.k) as i:
                at = self.of.k * k + i
                if back:
                    one[i] = self.kept[at]
                else:
                    self.kept[at] = one[i]

    def is_(self, *kinds: int) -> Term:
        """Whether the event is one of these kinds."""
        result = self.kind.get().equals(kinds[0])
        for k in kinds[1:]:
            result = result | self.kind.get().equals(k)
        return result

    def here(self, i: Term) -> Term:
        """Whether the event is one of contact i."""
        return i.equals(self.which.get())

    def leads(self, modes: Array, i: Term) -> Term:
        """Whether others may be held with contact i in these modes: it has friction and sticks."""
        return modes[i].equals(STICKS) & (self.slip_count[i] > 0.0)

    def slipping(self, i: Term) -> Term:
        """Whether contact i slips."""
        return (self.modes[i] >= STRAIGHT) & (self.modes[i] <= SLIPS)

    def decide_after(self) -> None:
        """Sets `next_modes` and `next_ways`, and y to the state after impacts."""
        w, of = self.w, self.of
        self.task.put(_FIRST)
        with w.repeat(lambda: (self.task.get() < _DONE) & (of.unsure.get() < 1)):
            self.drive()
            of.touch(self.t.get(), self.y)
            with w.when(self.doing(_FIRST)):
                self.first()
                self.impacts.begin()
            with w.when(self.doing(_HIT)):
                self.impacts.meet(self.touching)
                with w.when(self.impacts.over.get() > 0):
                    self.thrown()
                    self.task.put(_REST)
            with w.when(self.doing(_REST) | (self.doing(_LAST) & (self.hit.get() > 0))):
                self.find_slips(lambda i: self.touching[i] > 0.0)
            with w.when(self.task.get() < _DONE):
                self.decide_on()

    def doing(self, task: int) -> Term:
        """Whether this is the present task."""
        return self.task.get().equals(task)

    def first(self) -> None:
        """Selects the first task after an event and sets its input."""
        w, of = self.w, self.of
        k, d = of.k, of.d
        self.hit.put(0)
        with w.when(self.is_(BEGINS)):
            self.begin_closed()
        with w.few(k) as i:
            self.next[i] = self.modes[i]
            self.off[i] = w.select(self.here(i), 1.0, 0.0)
            with w.few(d - 1) as j:
                self.next_ways[i * (d - 1) + j] = self.directions[i * (d - 1) + j]
            self.touching[i] = w.select(self.modes[i] > SEPARATED, 1.0, 0.0)
            self.friction[i] = of.numbers[of.laws + i * 3]
            self.hits[i] = 0.0
            begins = self.is_(BEGINS) & (self.touching[i] > 0.0) & (self.approach(i) < -GIVEN)
            closes = (self.here(i) & self.is_(CLOSES)) | (self.closes(i) & ~self.is_(BEGINS))
            with w.when(begins | closes):
                self.hits[i] = 1.0
                self.hit.put(1)
                of.doubt(of.room[of.velocity + i * d] > 0.0)  # negative gap, though it opens
        slips = w.select(self.is_(BEGINS), w.integer(1), w.integer(0))
        self.find_slips(
            lambda i: (
                ((slips > 0) & (self.touching[i] > 0.0)) | (self.slipping(i) & ~(self.here(i) & self.is_(STICKING)))
            )
        )
        self.task.put(_LAST)
        i = self.which.get()
        with w.when(self.is_(TURNS, SLOWS)):
            self.task.put(_DONE)
            self.next[i] = w.select(self.is_(TURNS), SLIPS, STRAIGHT)
            with w.when(self.is_(SLOWS)), w.few(d - 1) as j:
                self.next_ways[i * (d - 1) + j] = of.room[of.velocity + i * d + 1 + j] / self.slip(i)
        with w.when((self.hit.get() < 1) & self.is_(OPENS)):
            self.task.put(_FORCE)
        with w.when((self.hit.get() < 1) & self.is_(SLIPPING)):
            static, kinetic = (of.numbers[of.laws + i * 3 + j] for j in (0, 1))
            self.last.put(-1)
            with w.few(k) as m:  # those that are held with it slip with it
                self.last.put(w.select(self.leads(self.modes, m), m, self.last.get()))
                with w.when((self.here(m) | (self.modes[m] >= HELD)) & self.last.get().equals(i)):
                    self.friction[m] = of.numbers[of.laws + m * 3 + 1]
            with w.when(kinetic >= static * (1 - ENDS)):
                self.task.put(_FORCE)
        with w.when((self.hit.get() > 0) & (self.task.get() < _DONE)):
            self.task.put(_HIT)
            with w.few(k) as i:
                self.friction[i] = of.numbers[of.laws + i * 3 + 1]
                self.hits[i] = w.select(self.touches(i), 1.0, self.hits[i])  # another impact may make it rebound
                with w.few(d - 1) as j:
                    self.sliding[i * (d - 1) + j] = 0.0
                with w.when(self.hits[i] > 0.0):
                    gap, v = of.numbers[of.gaps + i], of.room[of.velocity + i * d]
                    self.slack[i] = w.select(v > 0.0, of.largest(-gap, 0.0), 0.0)  # it has rebounded at this instant
                    self.touching[i] = 1.0

    def begin_closed(self) -> None:
        """The contacts closed at the start of a motion get the mode STICK; unsure if bodies penetrate or coefficients are invalid."""
        w, of = self.w, self.of
        with w.few(of.k) as i:
            static, kinetic, e = (of.numbers[of.laws + i * 3 + j] for j in range(3))
            of.doubt((static < 0.0) | (kinetic < 0.0) | (kinetic > static) | (e < 0.0) | (e > 1.0))
            gap, near = of.numbers[of.gaps + i], of.numbers[of.gap_terms + i] * GIVEN
            has_gap = of.places[i * of.d] > -0.5
            of.doubt(has_gap & (gap < -near))
            closed = ~has_gap | ((gap <= near) & (self.approach(i) <= GIVEN))
            self.modes[i] = w.select(closed, STICKS, SEPARATED)
        with w.few(of.k) as i, w.when(of.pressed_by[i] > -0.5):
            self.modes[i] = self.modes[w.compute("int", of.pressed_by[i])]

    def approach(self, i: Term) -> Term:
        """The rate of a gap relative to its terms, negative if it closes."""
        terms = self.of.room[self.of.velocity_terms + i * self.of.d]
        return self.w.select(terms > 0.0, self.of.room[self.of.velocity + i * self.of.d] / terms, 0.0)

    def decide_on(self) -> None:
        """Executes the present task and selects the next one."""
        w, of = self.w, self.of
        apart, hit = self.doing(_APART), self.doing(_HIT)

        def solved(may: Which) -> None:
            def closed(i: Term) -> Term:
                by = w.select(of.pressed_by[i] < 0.0, i, w.compute("int", of.pressed_by[i]))
                off = apart & (self.off[by] > 0.0)
                return (self.touching[i] > 0.0) & ~off & ~(hit & (self.impacts.part[i] < 0.5)) & may(i)

            of.problem(closed, self.sliding, self.friction, self.doing(_HIT))
            with w.when(self.doing(_FORCE)):
                self.as_it_was()
            with w.when(self.doing(_HIT)):
                self.impacts.ask()
            chosen = (self.task.get() >= _APART) & (self.task.get() <= _LAST)
            with w.when((chosen | (self.doing(_HIT) & (self.impacts.together.get() > 0))) & (of.unsure.get() < 1)):
                of.choose()

        of.until_forces_agree(solved)
        self.next_task.put(_LAST)
        with w.when(hit):
            self.impact()
            self.next_task.put(_HIT)
        with w.when(self.doing(_FORCE)):
            self.press()
            with w.when(self.is_(OPENS)):
                self.next_task.put(_APART)
        with w.when((self.task.get() >= _APART) & (self.task.get() <= _LAST)):
            self.found.put(0)
            with w.when(apart):
                self.part()
            with w.when(self.doing(_REST)):
                self.flat()
            with w.when(self.doing(_LAST) | (apart & (self.found.get() > 0))):
                self.settle()
                self.next_task.put(_DONE)
        self.task.put(self.next_task.get())

    def slip(self, i: Term) -> Term:
        """|v_t| of contact i."""
        return self.of.length(self.of.velocity + i * self.of.d + 1)

    def slip_terms(self, i: Term) -> Term:
        """The largest of the terms of the slip velocities of contact i, and of its slip speeds so far."""
        w, of = self.w, self.of
        of.cell.put(self.fastest[i])
        with w.few(of.d - 1) as j:
            of.cell.put(of.largest(of.cell.get(), of.room[of.velocity_terms + i * of.d + 1 + j]))
        return of.cell.get()

    def find_slips(self, of_contact: Which) -> None:
        """Sets `sliding` to the directions of slip of the selected contacts, zero where slip is zero up to rounding."""
        w, of = self.w, self.of
        with w.few(of.k) as i:
            size = self.slip(i)
            moves = of_contact(i) & (size > self.slip_terms(i) * NOTHING)
            with w.few(of.d - 1) as j:
                way = of.room[of.velocity + i * of.d + 1 + j] / size
                self.sliding[i * (of.d - 1) + j] = w.select(moves, way, 0.0)

    def closes(self, i: Term) -> Term:
        """Whether an open gap closes at the same instant."""
        of = self.of
        at = i * of.d
        approaches = of.room[of.velocity + at] < -(of.room[of.velocity_terms + at] * NOTHING)
        return approaches & self.touches(i)

    def touches(self, i: Term) -> Term:
        """Whether an open gap is zero up to the resolution of event times."""
        of = self.of
        near = of.numbers[of.gaps + i] + self.slack[i] <= self.resolution(i)
        return (of.places[i * of.d] > -0.5) & ~(self.modes[i] > SEPARATED) & near

    def resolution(self, i: Term) -> Term:
        """The gap of contact i that the resolution of event times leaves."""
        of = self.of
        far = of.absolute(of.room[of.velocity + i * of.d]) * self.s[int(Slot.SPAN)]
        return (of.numbers[of.gap_terms + i] + far) * SAME_TIME

    def settle(self) -> None:
        """Sets the next modes to the chosen ones; contacts that are not closed are separated."""
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
                of.doubt(~(of.places[i * d] > -0.5))  # the coordinates keep it closed
            sticks = (kind >= STICK) & ((kind <= STICK) | ~(self.slip_count[i] > 0.0))
            held = (kind <= STICK) & (of.room[of.lead + n] < w.compute("float", n))
            with w.when(sticks):
                self.next[i] = w.select(held, HELD, STICKS)
                with w.when(held):  # the kernel of a mode holds it with the last one before it that sticks
                    self.last.put(-1)
                    with w.few(n) as m:
                        other = of.index(of.own + m)
                        self.last.put(w.select(self.leads(self.next, other), m, self.last.get()))
                    lead = of.index(of.lead + n)
                    of.doubt((self.last.get() < lead) | (lead < self.last.get()))
            with w.when((kind > STICK) & ~sticks):
                with w.few(d - 1) as j:
                    self.next_ways[i * (d - 1) + j] = of.room[of.dirs + n * d + j]
                slides = self.slip(i) > self.level(
                    i, of.largest(self.slip_terms(i), self.gained(n)), self.rate_of_slip(n)
                )
                of.doubt(
                    self.here(i) & self.is_(STICKING) & (self.slip_count[i] > 1.5)
                )  # it may have turned before its end
                self.next[i] = w.select((self.slip_count[i] > 1.5) & slides, SLIPS, STRAIGHT)
        with w.few(of.k) as i, w.when((self.touching[i] > 0.0) & ~(self.next[i] > SEPARATED)):  # opens without speed
            gap, terms = of.numbers[of.gaps + i], of.numbers[of.gap_terms + i]
            least = self.tolerances[0] * FLAT
            self.slack[i] = of.largest(terms * ROUNDED, least) + 2.0 * of.absolute(gap)
            of.doubt(self.slack[i] > EQUAL * terms + least)
        # thrown off: its gap begins where the impact found it; what event times leave counts as zero, or levels sink with each rebound
        with w.few(of.k) as i:
            parted = ~(self.touching[i] > 0.0) & ~(self.next[i] > SEPARATED)
            took_part = (self.hit.get() > 0) & ((self.hits[i] > 0.0) | (self.modes[i] > SEPARATED))
            below = -of.numbers[of.gaps + i]
            with w.when(took_part & parted & (below > self.resolution(i))):
                self.slack[i] = below

        with w.few(of.k) as i, w.when((self.hit.get() < 1) & (of.places[i * d] > -0.5)):  # falls back within rounding
            gap, v, terms = of.numbers[of.gaps + i], of.room[of.velocity + i * d], of.numbers[of.gap_terms + i]
            with w.when(~(self.modes[i] > SEPARATED) & (gap <= terms * ROUNDED)):
                twice = self.gap_acceleration(i) * 2.0
                of.doubt((twice < 0.0) & (v * v <= (gap - terms * ROUNDED) * twice))

    def gained(self, n: Term) -> Term:
        """The slip speed up to which the n-th chosen contact slips in a fixed direction after its slip begins: see `STARTS`."""
        return self.rate_of_slip(n) * self.s[int(Slot.SPAN)] * STARTS

    def rate_of_slip(self, n: Term) -> Term:
        """The magnitude of the slip acceleration of the n-th chosen contact."""
        return self.of.length(self.of.a + n * self.of.d + 1)

    def level(self, i: Term, fastest: Term, rate: Term) -> Term:
        """The slip speed below which contact i, by its `fastest` one and its `rate`, slips in a fixed direction: see `ENDS`."""
        w, of = self.w, self.of
        sums = of.cell
        sums.put(0.0)
        with w.few(of.d, 1) as j:
            row = of.J + (i * of.d + j) * of.width
            sums.put(of.largest(sums.get(), of.sum(of.nu, lambda l: of.absolute(of.room[row + l]))))
        left = self.tolerances[1] * fastest + self.tolerances[0] * sums.get()
        return of.largest(fastest * ENDS, left, rate * of.absolute(self.t.get()) * ROUNDED_TERMS)

    def gap_acceleration(self, i: Term) -> Term:
        """The acceleration of a gap due to the present contact forces."""
        of, kd = self.of, self.of.k * self.of.d

        def pushed(c: Term) -> Term:
            return of.room[of.mobility + i * of.d * kd + of.row_of(c)] * of.room[of.force + c]

        return of.sum(of.count.get() * of.d, pushed) + of.unforced(i * of.d)[0]

    def part(self) -> None:
        """Sets `found` if no gap of the contacts assumed open closes again; then the choice without these is final.

        Else, if others were assumed open as well, the next choice assumes this of the event's contact alone.
        """
        w, of = self.w, self.of
        count, others = self.last, self.others  # gaps that close again; contacts besides the event's
        for cell in (count, others):
            cell.put(0)
        with w.few(of.k) as i, w.when(self.off[i] > 0.0):
            self.found.put(0)
            self.parts(i)
            count.put(count.get() + 1 - self.found.get())
            with w.when(~self.here(i)):
                others.put(1)
        self.found.put(0)
        with w.when(count.get() < 1):
            self.found.put(1)
        with w.otherwise(), w.when(others.get() > 0):
            self.next_task.put(_APART)
            with w.few(of.k) as i:
                self.off[i] = w.select(self.here(i), 1.0, 0.0)

    def parts(self, i: Term) -> None:
        """Sets `found` if the gap of contact i, assumed open, does not close again.

        This holds if the mode lasted no time: the force N of the event, positive when the mode began, has fallen through zero since.
        """
        w, of = self.w, self.of
        kd = of.k * of.d
        row = i * of.d
        a, terms = self.rate, self.terms
        for place, free in zip((a, terms), of.unforced(row), strict=True):
            place.put(free)
        with w.few(of.count.get() * of.d) as c:
            part = of.room[of.mobility + row * kd + of.row_of(c)] * of.room[of.force + c]
            a.put(a.get() + part)
            terms.put(terms.get() + of.absolute(part))
        brief = (self.still.get() > 0) & self.here(i)
        with w.when((of.places[row] > -0.5) & ((a.get() >= -(terms.get() * NOTHING)) | brief)):
            self.found.put(1)
        with w.when(self.found.get() < 1), w.few(of.k) as n:  # forces depend on directions of slow slips
            slow = self.slip(n) * NOTHING < self.slip_terms(n) * ROUNDED_TERMS
            of.doubt(self.slipping(n) & (self.slip_count[n] > 1.5) & slow)

    def as_it_was(self) -> None:
        """Forces in the present modes."""
        w, of = self.w, self.of
        with w.few(of.count.get()) as n:
            of.room[of.kind + n] = w.select(of.room[of.slides + n] > 0.0, SLIP, STICK)
            of.room[of.mu + n] = of.room[of.kinetic + n]
        of.group()
        of.solve()

    def press(self) -> None:
        """Sets directions of beginning slip, against present friction, and `off`: contacts whose N vanishes with the event's."""
        w, of = self.w, self.of
        room, d = of.room, of.d
        with w.few(of.count.get()) as n:
            i, row = of.index(of.own + n), n * d
            with w.when(self.is_(OPENS) & ~of.lacks_row(i, 0) & (of.pressed_by[i] < 0.0)):
                most = room[of.terms + row] / room[of.W + row * of.k * d + row]
                self.off[i] = w.select(room[of.force + row] <= most * NOTHING, 1.0, self.off[i])
            with w.when(self.is_(SLIPPING) & self.here(i)):
                size = of.length(of.force + row + 1)
                of.doubt(~(size > 0.0))
                with w.few(of.count.get()) as m, w.when(of.leads(m, n)):
                    laws = of.laws + of.index(of.own + m) * 3
                    with w.when(of.numbers[laws + 1] >= of.numbers[laws] * (1 - ENDS)):
                        of.doubt(
                            self.slip_count[of.index(of.own + m)] > 1.5
                        )  # its direction changes at once: steps must be implicit
                        with w.few(d - 1) as j:
                            self.sliding[of.index(of.own + m) * (d - 1) + j] = -room[of.force + row + 1 + j] / size

    def together(self) -> None:
        """Closes contacts that depend on the N of others if these are closed."""
        w, by = self.w, self.of.pressed_by
        with w.few(self.of.k) as i, w.when(by[i] > -0.5):
            self.touching[i] = self.touching[w.compute("int", by[i])]

    def impact(self) -> None:
        """Changes y by the impacts of the contacts that take part, simultaneous or sequential."""
        of = self.of
        size = of.count.get() * of.d
        self.impacts.run(size)
        self.change(size, of.row_of, lambda c: self.impacts.impulse[c])
        self.impacts.grow(size)

    def thrown(self) -> None:
        """Sets `touching` to the contacts that stay closed after all impacts."""
        w, of, d = self.w, self.of, self.of.d
        with w.few(of.k) as i:
            self.friction[i] = of.numbers[of.laws + i * 3]
            self.leaving[i] = 0.0
            with w.when(self.touching[i] > 0.0):
                with w.few(d, 1) as j:
                    self.fastest[i] = of.largest(self.fastest[i], self.impacts.terms(i * d + j))
                with w.when(of.room[of.velocity + i * d] > self.impacts.terms(i * d) * NOTHING):
                    self.leaving[i] = 1.0
                    self.touching[i] = 0.0
        self.together()

    def change(self, count: Term, row: Which, impulse: Which) -> None:
        """Changes the speeds by `count` impulses on rows of all contacts; speeds that are then zero up to rounding become zero."""
        w, of = self.w, self.of
        with w.few(of.nu) as j:

            def moved(c: Term, j: Term = j) -> Term:
                return of.room[of.spread + row(c) * of.width + j] * impulse(c)

            def size(c: Term, moved: Which = moved) -> Term:
                return of.absolute(moved(c))

            before = self.y[of.nq + j]
            after = before + of.sum(count, moved)
            terms = of.absolute(before) + of.sum(count, size)
            self.y[of.nq + j] = w.select(of.absolute(after) > terms * ROUNDED_TERMS, after, 0.0)

    def flat(self) -> None:
        """Brings contacts to rest if further rebounds are below tolerances: sets `touching`, and `over` to the end of rebounds."""
        w, of = self.w, self.of
        room, d = of.room, of.d
        rests = self.last
        rests.put(0)
        with w.few(of.k) as i, w.when((self.leaving[i] > self.touching[i]) & (of.unsure.get() < 1)):
            a, v, given = self.gap_acceleration(i), room[of.velocity + i * d], of.numbers[of.laws + i * 3 + 2]
            before = self.kept[of.k * 3 + i]
            guessed = w.select(before > v, v / before, 0.0)
            e = w.select(given > 0.0, given, guessed)
            self.rebound[i] = v
            falls = a < 0.0
            height = w.select(falls, -(v * v) / (a * 2.0), 1e301)
            open_ = self.tolerances[0] + self.tolerances[1] * of.numbers[of.gap_terms + i]
            with w.when(falls):
                self.highest[i] = of.largest(self.highest[i], height)
            left = of.largest(of.numbers[of.gap_terms + i] * ROUNDED, self.shifted(i))
            with w.when(height <= of.largest(open_ * FLAT, self.highest[i] * LOW, left)):
                rests.put(1)
                self.hits[i] = 2.0
                after = self.t.get() - v * 2.0 / (a * (1.0 - e))
                self.over.put(w.select(e < 1.0, of.largest(self.over.get(), after), self.over.get()))
        with w.when((rests.get() > 0) & (of.unsure.get() < 1)):
            self.hold()
            self.next_task.put(_REST)  # beside these others fall faster

    def shifted(self, i: Term) -> Term:
        """How far at most gap i is shifted when the gaps of closed contacts, zero up to the resolution of times, are made zero."""
        w, of, d, kd = self.w, self.of, self.of.d, self.of.k * self.of.d
        shift = of.cell
        shift.put(0.0)
        with w.few(of.k) as n, w.when((self.touching[n] > 0.0) & (of.places[n * d] > -0.5)):
            own, mine = (of.room[of.mobility + m * d * kd + n * d] for m in (n, i))
            shift.put(shift.get() + of.absolute(of.numbers[of.gaps + n] * mine / own))
        return shift.get() * 2.0

    def hold(self) -> None:
        """Makes the least change of speeds after which rates of closed gaps are zero, and slips of contacts that do not slip."""
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
                own = ~of.lacks_row(i, j) & ((stuck & ~self.is_held(i)) | (j < 1))
                with w.when(own):
                    of.room[of.at_row + count.get()] = w.compute("float", i * d + j)
                    count.put(count.get() + 1)
        with w.few(count.get()) as u:
            row = of.index(of.at_row + u)
            room[of.x + u] = -room[of.velocity + row]
            with w.few(count.get()) as v:
                room[of.bound + u * kd + v] = room[of.mobility + row * kd + of.index(of.at_row + v)]
        factor(room, of.bound, kd, count.get())
        of.least.put(1.0)
        with w.few(count.get()) as u:
            pivot = room[of.bound + u * kd + u]
            row = of.index(of.at_row + u)
            of.doubt_pivot(pivot * pivot, room[of.mobility + row * kd + row])
        solve(room, of.bound, kd, count.get(), of.x)
        with (
            w.few(of.k) as i,
            w.when(self.leaving[i] > self.touching[i]),
        ):  # Python brings contacts to rest that these push down

            def pressed(u: Term, i: Term = i) -> Term:
                return room[of.mobility + i * d * kd + of.index(of.at_row + u)] * room[of.x + u]

            rate = room[of.velocity + i * d] + of.sum(count.get(), pressed)
            of.doubt(rate < -(room[of.velocity_terms + i * d] * NOTHING))
        self.change(count.get(), lambda u: of.index(of.at_row + u), lambda u: room[of.x + u])
        self.together()

    def is_held(self, i: Term) -> Term:
        """Whether a constraint of an earlier contact, already imposed, equals that of contact i."""
        w, of = self.w, self.of
        kd, d = of.k * of.d, of.d
        self.last.put(0)
        with w.few(of.unknowns.get()) as u:
            a, b = i * d + 1, of.index(of.at_row + u)
            ab, aa, bb = (of.room[of.mobility + x * kd + y] for x, y in ((a, b), (a, a), (b, b)))
            with w.when((ab > 0.0) & (ab * ab >= aa * bb * (1 - ROUNDED_SUM)) & (of.rest_of(b) > 0)):
                self.last.put(1)
        return self.last.get() > 0
