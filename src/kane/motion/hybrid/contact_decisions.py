# SPDX-License-Identifier: BSD-3-Clause
"""The choice of contact modes in a kernel, if the solution of the contact problem (`kane.contacts`) is certainly unique.

With W = J H Jᵀ and b of all rows (`kane.equations.mode_equations`) modes are tried, beginning with the present ones: a contact with
N < 0 opens, one with |F| > μ N slips against F, one that would slip along its friction sticks, one whose gap would close is closed.
Modes whose inequalities all hold by more than error bounds are the solution if friction is certainly too small for another
(`unique` in `kane.contacts.choice`). In all other cases `unsure` is set and Python decides.
"""

from collections.abc import Callable
from typing import Any

from kane.contacts.mode_solution import MET, U
from kane.numeric.scale import EQUAL, INVERSE_RANK, LAST_DIGIT, ROUNDED, ROUNDED_SUM, SIX_DIGITS
from kane.program.kernel.language import INT
from kane.program.kernel.writer import Array, Term, Writer, factor, invert, total, unit

OPEN, STICK, FRESH, SLIP = 0.0, 1.0, 2.0, 3.0
"""Values of `kane.contacts.problem.ContactStatus`."""
NO_PLACE = -1e6
"""The value in `places` of a row that a contact does not have."""
_TURNS = 60
"""Largest number of trials of modes and directions of slip; after more, Python decides."""
_ALONE = 20
"""Trials after which contacts change one at a time, and a closing one may slip at once: simultaneous changes may cycle."""
_AGREEMENTS = 100
"""Largest number of iterations until normal forces agree with the couples that depend on them; after more, Python decides."""
_TURNED = 4 * LAST_DIGIT
_WORST = 1e10
"""Condition number above which constraints count as redundant."""


def _sizes(k: Any, d: Any, n: Any, pa: Any) -> list[Any]:
    """Sizes, in doubles, of the parts of `room`, for k contacts of d rows, n speeds and pa permanent constraints."""
    kd = k * d
    of_touch = [kd * n, kd, kd, kd * n, n, n * n * 2, pa * n, pa * n, pa * pa * 2, pa, pa, kd * kd, kd, kd, n]
    of_problem = [k, kd * kd, kd, kd, k, k, k, kd, k, k]
    of_modes = [kd * kd * 2, kd * kd, kd * kd * 2, kd, kd, kd, kd, kd, kd, kd]
    return [*of_touch, *of_problem, *of_modes, kd, kd * kd, k, k, k, k, kd]


def room(k: int, d: int, width: int, always: int) -> int:
    """The size, in doubles, of the array `room` of `Decisions`."""
    return int(sum(_sizes(k, d, width, always)))


class Decisions:
    """The writer of contact problems: arguments for contacts, numbers at a state, and the choice of modes."""

    def __init__(self, w: Writer) -> None:
        self.writer = w
        names = ("contacts", "dimension", "width", "rows", "always_count", "speeds", "coordinates")
        self.k, self.d, self.width, self.m, self.always_count, self.nu, self.nq = map(w.number, names)
        self.call = w.callee("touch", "float", "array", "array", "array", "array", "array")
        arrays = ("h", "p", "r", "numbers", "places", "always", "pressed_by", "room")
        self.h, self.p, self.r, self.numbers, self.places, self.always, self.pressed_by, self.room = map(
            w.array, arrays
        )
        self.unsure, self.count = w.variable("unsure", INT), w.variable("closed_count", INT)
        self.unknowns, self.changed, self.again = (w.variable(n, INT) for n in ("unknowns", "changed", "again"))
        self.trials, self.rounds = w.variable("trials", INT), w.variable("rounds", INT)
        self.agreeing, self.agrees = w.variable("agreeing", INT), w.variable("agrees", INT)
        self.cell, self.other, self.least = (w.variable(name) for name in ("cell", "other_cell", "least_pivot"))
        self._offsets()

    def _offsets(self) -> None:
        """Sets the offsets of the parts of `numbers` and `room`."""
        k, d, n, m, zero = self.k, self.d, self.width, self.m, self.writer.integer(0)

        def placed(sizes: list[Any]) -> list[Term]:
            at, found = zero, []
            for size in sizes:
                found.append(at)
                at = at + size
            return [*found, at]

        sizes = [k, k, n * n, n, n, m * n, m, m, m, k * 3, k]
        (
            self.gaps, self.gap_terms, self.mass, self.forcing, self.forcing_terms,
            self.constraint_rows, self.rest, self.drift, self.drift_terms, self.laws, self.viscous, _,
        ) = placed(sizes)  # fmt: skip
        places = placed(_sizes(k, d, n, self.always_count))
        (
            self.J, self.velocity, self.velocity_terms, self.spread, self.free, self.inverse, self.P, self.moved, self.S,
            self.z, self.y, self.mobility, self.bias, self.bias_terms, self.spent,
        ) = places[:15]  # fmt: skip
        (
            self.own, self.W, self.b, self.terms, self.static, self.kinetic, self.mu, self.dirs, self.kind, self.slides,
            self.L, self.G, self.A, self.x, self.x_errors, self.force, self.a, self.a_errors, self.force_errors, self.at_row,
        ) = places[15:35]  # fmt: skip
        self.pressing, self.bound, self.first, self.rubs, self.lead, self.press, self.mobility_terms = places[35:42]

    # ------------------------------------------------------------------------------------------------- small helpers

    def index(self, at: Term) -> Term:
        """An index that is stored in `room`."""
        return self.writer.compute("int", self.room[at])

    def absolute(self, x: Term) -> Term:
        """|x|."""
        return self.writer.compute("abs", x)

    def largest(self, *of: Term | float) -> Term:
        """The largest of some values."""
        result = of[0]
        for x in of[1:]:
            result = self.writer.compute("max", result, x)
        assert isinstance(result, Term)
        return result

    def sum(self, count: Any, of: Callable[[Term], Term]) -> Term:
        """The sum of `of(i)` for i below `count`."""
        return total(self.writer, count, of)

    def length(self, at: Term) -> Term:
        """The norm of the d − 1 tangential values of a contact, from an index of `room` on."""
        return self.writer.compute("sqrt", self.sum(self.d - 1, lambda j: self.room[at + j] * self.room[at + j]))

    def doubt(self, condition: Term) -> None:
        """Sets `unsure`, so that Python decides, if the condition holds."""
        with self.writer.when(condition):
            self.unsure.put(1)

    def lacks_row(self, i: Term, j: Any) -> Term:
        """Whether contact i lacks its row j."""
        return self.places[i * self.d + j] < NO_PLACE / 2

    # ------------------------------------------------------------------------------------------------ numbers at a state

    def touch(self, t: Term, y: Array) -> None:
        """Sets W, b and the velocities of all rows, and their terms, at a time and a state."""
        w, room, numbers, n = self.writer, self.room, self.numbers, self.width
        self.call(t, y.at(0), self.p.at(0), self.r.at(0), self.h.at(0), numbers.at(0))
        with w.few(self.k * self.d) as i:
            self._row(self.places, i, self.J + i * n)
            room[self.velocity + i] = self.sum(self.nu, lambda j: room[self.J + i * n + j] * y[self.nq + j])
            speeds = self.sum(self.nu, lambda j: self.absolute(room[self.J + i * n + j] * y[self.nq + j]))
            room[self.velocity_terms + i] = speeds
            room[self.bias + i] = 0.0
            room[self.bias_terms + i] = 0.0
            with w.when(self.places[i] > -0.5):
                row = w.compute("int", self.places[i])
                room[self.velocity + i] = room[self.velocity + i] + numbers[self.rest + row]
                room[self.velocity_terms + i] = speeds + self.absolute(numbers[self.rest + row])
                room[self.bias + i] = numbers[self.drift + row]
                room[self.bias_terms + i] = numbers[self.drift_terms + row]
            sized = self.largest(room[self.velocity_terms + i], self.absolute(room[self.velocity + i]))
            room[self.velocity_terms + i] = sized
        with w.few(self.k) as i, w.few(self.d, 1) as j:
            at = self.velocity_terms + i * self.d
            room[at] = self.largest(room[at], room[at + j])
        with w.few(n) as i, w.few(n) as j:
            at = self.inverse + i * n * 2 + j
            room[at] = numbers[self.mass + i * n + j]
            room[at + n] = unit(i, j)
        invert(room, self.inverse, n)

        def by_inverse(i: Term, of: Callable[[Term], Term]) -> Term:
            return self.sum(n, lambda j: room[self.inverse + i * n * 2 + n + j] * of(j))

        with w.few(self.k * self.d) as i:
            row = self.J + i * n

            def mobile(j: Term, row: Term = row) -> Term:
                inverse = self.inverse + j * n * 2 + n
                moved = self.sum(n, lambda l: self.absolute(room[inverse + l] * room[row + l]))
                return self.absolute(room[row + j]) * moved

            room[self.mobility_terms + i] = self.sum(n, mobile)
            with w.few(n) as j:
                room[self.spread + i * n + j] = by_inverse(j, lambda l: room[row + l])
        with w.few(n) as j:
            room[self.free + j] = by_inverse(j, lambda l: numbers[self.forcing + l])
            inverse = self.inverse + j * n * 2 + n
            room[self.spent + j] = self.sum(
                n, lambda l: self.absolute(room[inverse + l]) * numbers[self.forcing_terms + l]
            )
        with w.when(self.always_count > 0):
            self._keep(by_inverse)
        with w.few(self.k * self.d) as i:
            row = self.J + i * n
            with w.few(self.k * self.d) as j:
                at = self.mobility + i * self.k * self.d + j
                room[at] = self.sum(n, lambda l: room[row + l] * room[self.spread + j * n + l])
            own = self.sum(n, lambda l: room[row + l] * room[self.free + l])
            room[self.bias + i] = own + room[self.bias + i]
            spent = self.sum(n, lambda l: self.absolute(room[row + l]) * room[self.spent + l])
            sized = self.largest(spent + room[self.bias_terms + i], self.absolute(room[self.bias + i]))
            room[self.bias_terms + i] = sized

    def _row(self, places: Array, i: Term, at: Term) -> None:
        """Copies to `at` the constraint row with index places[i], or the row of an auxiliary speed if that is negative."""
        w, room, n = self.writer, self.room, self.width
        with w.few(n) as j:
            room[at + j] = 0.0
        with w.when(places[i] > -0.5):
            row = self.constraint_rows + w.compute("int", places[i]) * n
            with w.few(n) as j:
                room[at + j] = self.numbers[row + j]
        with w.otherwise(), w.when(places[i] > NO_PLACE / 2):
            room[at + self.nu + w.compute("int", -1.0 - places[i])] = 1.0

    def _keep(self, by_inverse: Callable[[Term, Callable[[Term], Term]], Term]) -> None:
        """Replaces M⁻¹ by H = M⁻¹ − M⁻¹Pᵀ (P M⁻¹ Pᵀ)⁻¹ P M⁻¹ for the permanent constraints P."""
        w, room, n, pa = self.writer, self.room, self.width, self.always_count
        with w.few(pa) as i:
            self._row(self.always, i, self.P + i * n)
            with w.few(n) as j:
                room[self.moved + i * n + j] = by_inverse(j, lambda l: room[self.P + i * n + l])
        largest = self.cell
        largest.put(0.0)
        with w.few(pa) as i, w.few(pa) as j:
            at = self.S + i * pa * 2 + j
            value = self.sum(n, lambda l: room[self.P + i * n + l] * room[self.moved + j * n + l])
            room[at] = value
            room[at + pa] = unit(i, j)
            largest.put(self.largest(largest.get(), self.absolute(value)))
        invert(room, self.S, pa)
        back = self.other
        back.put(0.0)
        with w.few(pa) as i, w.few(pa) as j:
            back.put(self.largest(back.get(), self.absolute(room[self.S + i * pa * 2 + pa + j])))
        self.doubt(~(back.get() * largest.get() < _WORST))

        def without(of: Term, drift: bool) -> None:
            with w.few(pa) as i:
                room[self.y + i] = self.sum(n, lambda l: room[self.P + i * n + l] * room[of + l])
                if drift:
                    with w.when(self.always[i] > -0.5):
                        at = self.drift + w.compute("int", self.always[i])
                        room[self.y + i] = room[self.y + i] + self.numbers[at]
            with w.few(pa) as i:
                room[self.z + i] = self.sum(pa, lambda j: room[self.S + i * pa * 2 + pa + j] * room[self.y + j])
            with w.few(n) as j:
                room[of + j] = room[of + j] - self.sum(pa, lambda i: room[self.moved + i * n + j] * room[self.z + i])

        without(self.free, True)
        with w.few(self.k * self.d) as i:
            without(self.spread + i * n, False)

    # --------------------------------------------------------------------------------------- the problem of closed contacts

    def problem(self, closed: Callable[[Term], Term], sliding: Array, friction: Array, impulsive: Term) -> None:
        """Sets W, b and coefficients of the contacts that are `closed`; if `impulsive`, b are velocities.

        `sliding` (k × d − 1) are directions of present slip, `friction` (k) the μ_s to be used.
        """
        w, room, d = self.writer, self.room, self.d
        self.count.put(0)
        with w.few(self.k) as i, w.when(closed(i)):
            room[self.own + self.count.get()] = w.compute("float", i)
            self.count.put(self.count.get() + 1)
        kd, c = self.k * d, self.count
        of = w.select(impulsive, self.velocity, self.bias)
        sizes = w.select(impulsive, self.velocity_terms, self.bias_terms)
        with w.few(c.get() * d) as i:
            own = self.row_of(i)
            free, terms = self.unforced(own)
            room[self.b + i] = w.select(impulsive, room[of + own], free)
            room[self.terms + i] = w.select(impulsive, room[sizes + own], terms)
            with w.few(c.get() * d) as j:
                other = self.row_of(j)
                value = room[self.mobility + own * kd + other] + room[self.mobility + other * kd + own]
                room[self.W + i * kd + j] = value * 0.5
        with w.few(c.get()) as n:
            i = self.index(self.own + n)
            usual = self.cell
            usual.put(0.0)
            with w.few(d) as j:
                usual.put(self.largest(usual.get(), room[self.W + (n * d + j) * kd + n * d + j]))
            self.doubt_normal(n, i)
            with w.when(~(usual.get() > 0.0)):
                usual.put(1.0)
            room[self.rubs + n] = 0.0
            with w.few(d) as j:
                with w.when(self.lacks_row(i, j)):
                    room[self.W + (n * d + j) * kd + n * d + j] = usual.get()
                with w.otherwise(), w.when(j > 0):
                    room[self.rubs + n] = 1.0
            kinetic = self.numbers[self.laws + i * 3 + 1]
            room[self.slides + n] = 0.0
            with w.few(d - 1) as j:
                way = sliding[i * (d - 1) + j]
                room[self.dirs + n * d + j] = way
                with w.when(self.absolute(way) > 0.0):
                    room[self.slides + n] = 1.0
            static = self.largest(friction[i], w.select(room[self.slides + n] > 0.0, kinetic, 0.0))
            room[self.static + n] = static
            room[self.kinetic + n] = kinetic
            with w.when(self.lacks_row(i, 0)):
                most = self.largest(self.numbers[self.laws + i * 3], kinetic)
                pressed = w.select(self.pressed_by[i] < 0.0, 1.0, room[self.press + i])
                held = w.select(impulsive, 0.0, -(usual.get() * most * pressed))
                room[self.b + n * d] = held
                room[self.terms + n * d] = self.absolute(held)
                room[self.static + n] = w.select(most > 0.0, static / most, 0.0)
                room[self.kinetic + n] = w.select(most > 0.0, kinetic / most, 0.0)
            room[self.kinetic + n] = w.compute("min", room[self.kinetic + n], room[self.static + n])

    def doubt_normal(self, n: Term, i: Term) -> None:
        """Unsure if no force changes the gap of contact i, the nth closed one: Python reports it by name."""
        room, d = self.room, self.d
        terms, own = self.mobility_terms + i * d, n * d
        every = self.largest(*(room[terms + self.writer.integer(j)] for j in (0, 1)), room[terms + d - 1])
        least = self.largest(room[terms] * ROUNDED_SUM, every * ROUNDED)
        self.doubt(~self.lacks_row(i, 0) & ~(room[self.W + own * self.k * d + own] > least))

    def unforced(self, row: Term) -> tuple[Term, Term]:
        """b of a row and its terms, including viscous friction of the closed contacts."""
        room, d, kd = self.room, self.d, self.k * self.d

        def drag(c: Term) -> Term:
            i, j = self.index(self.own + self.whole(c)), self.rest_of(c)
            slip = self.writer.select(j > 0, room[self.velocity + i * d + j], 0.0)
            return room[self.mobility + row * kd + i * d + j] * self.numbers[self.viscous + i] * slip

        count = self.count.get() * d
        pulled = self.sum(count, drag)
        return room[self.bias + row] - pulled, room[self.bias_terms + row] + self.sum(
            count, lambda c: self.absolute(drag(c))
        )

    def group(self) -> None:
        """Sets `first` of each contact to the first one with the same slip, by equal tangential rows of W and b.

        Where rows are equal at one instant only, as where a joint passes the plane, what is left of their b differs.
        """
        w, room, d, kd, c = self.writer, self.room, self.d, self.k * self.d, self.count
        with w.few(c.get()) as n:
            room[self.first + n] = w.compute("float", n)
            with w.when(room[self.rubs + n] > 0.0), w.few(n) as m:
                self.cell.put(0.0)
                with w.few(d - 1) as j, w.few(c.get() * d) as i:
                    a, b = n * d + 1 + j, m * d + 1 + j
                    apart = self.absolute(room[self.W + a * kd + i] - room[self.W + b * kd + i])
                    size = w.compute("sqrt", room[self.W + a * kd + a] * room[self.W + i * kd + i])
                    self.cell.put(self.largest(self.cell.get(), w.select(apart > size * EQUAL, 1.0, 0.0)))
                with w.few(d - 1) as j:
                    a, b = n * d + 1 + j, m * d + 1 + j
                    size = room[self.terms + a] + room[self.terms + b]
                    apart = self.absolute(room[self.b + a] - room[self.b + b]) > size * EQUAL
                    self.cell.put(w.select(apart, 1.0, self.cell.get()))
                same = (self.cell.get() < 0.5) & (room[self.rubs + m] > 0.0)
                earlier = room[self.first + n] >= w.compute("float", n)
                with w.when(same & earlier):
                    room[self.first + n] = w.compute("float", m)

    def lead_of(self, n: Term) -> None:
        """Sets `lead` of a sticking contact to the first one with the same slip that sticks, possibly itself."""
        w, room = self.writer, self.room
        room[self.lead + n] = w.compute("float", n)
        with w.few(n) as m:
            sticks = room[self.kind + m].equals(STICK)
            one = room[self.first + m].equals(room[self.first + n])
            alone = room[self.lead + n] >= w.compute("float", n)
            with w.when(sticks & one & alone & (room[self.rubs + n] > 0.0)):
                room[self.lead + n] = w.compute("float", m)

    def leads(self, n: Term, m: Term) -> Term:
        """Whether contact n sticks by the constraints of contact m."""
        sticks = self.room[self.kind + n].equals(STICK)
        return sticks & self.index(self.lead + n).equals(m)

    def whole(self, i: Term) -> Term:
        """The closed contact to which a row of the problem belongs."""
        w = self.writer  # d is 2 or 3
        return w.compute("int", (w.compute("float", i) + 0.5) / w.compute("float", self.d))

    def rest_of(self, i: Term) -> Term:
        """The index of a row of the problem among the d rows of its contact."""
        return i - self.whole(i) * self.d

    def row_of(self, i: Term) -> Term:
        """The index of a row of the problem among the rows of all contacts."""
        return self.index(self.own + self.whole(i)) * self.d + self.rest_of(i)

    def until_forces_agree(self, solved: Callable[[Callable[[Term], Term]], None]) -> None:
        """Repeats `solved` until the N on which other contacts depend (rolling resistance) equal those that were assumed.

        `solved` takes a predicate of contacts that may be closed: in the first iteration not those that depend on others.
        """
        w, room, d = self.writer, self.room, self.d
        self.agreeing.put(0)
        self.agrees.put(0)
        with w.repeat(lambda: self.agrees.get() < 1):
            self.agrees.put(1)
            solved(lambda i: (self.pressed_by[i] < 0.0) | (self.agreeing.get() > 0))
            with w.few(self.k) as i, w.when(self.pressed_by[i] > -0.5):
                self.cell.put(0.0)
                with w.few(self.count.get()) as n, w.when(self.pressed_by[i].equals(room[self.own + n])):
                    self.cell.put(self.largest(room[self.force + n * d], 0.0))
                apart = self.absolute(self.cell.get() - room[self.press + i]) > self.cell.get() * ROUNDED
                with w.when(apart | (self.agreeing.get() < 1)):
                    self.agrees.put(0)
                room[self.press + i] = self.cell.get()
            self.agreeing.put(self.agreeing.get() + 1)
            self.doubt(self.agreeing.get() > _AGREEMENTS)
            with w.when(self.unsure.get() > 0):
                self.agrees.put(1)

    # -------------------------------------------------------------------------------------------------------- the choice

    def choose(self) -> None:
        """Sets `kind`, `dirs`, `force` and `a` of the closed contacts to the unique solution, or sets `unsure`."""
        w, room, c = self.writer, self.room, self.count
        with w.few(c.get()) as n:
            slides = room[self.slides + n] > 0.0
            room[self.kind + n] = w.select(slides, SLIP, STICK)
            room[self.mu + n] = w.select(slides, room[self.kinetic + n], room[self.static + n])
        self.group()
        self.again.put(1)
        self.rounds.put(0)
        with w.repeat(lambda: (self.again.get() > 0) & (self.rounds.get() <= c.get()) & (self.unsure.get() < 1)):
            self.again.put(0)
            self.is_unique()
            self.search()
            with w.few(c.get()) as n:
                fresh = (room[self.kind + n] > STICK) & (room[self.kind + n] < SLIP)
                with w.when(fresh & (room[self.mu + n] > room[self.kinetic + n])):
                    room[self.mu + n] = room[self.kinetic + n]
                    self.again.put(1)
            self.rounds.put(self.rounds.get() + 1)
        self.doubt(self.again.get() > 0)

    def is_unique(self) -> None:
        """Sets `unsure` unless friction is too small for two solutions, by the bound of `kane.contacts.choice.unique`."""
        w, room, d, c, kd = self.writer, self.room, self.d, self.count, self.k * self.d
        size = c.get() * d
        with w.few(size) as i, w.few(size) as j:
            room[self.L + i * kd * 2 + j] = room[self.W + i * kd + j]
        self._factor(size)
        with w.few(size) as i, w.few(size) as j:
            room[self.bound + i * kd + j] = w.select(i.equals(j), 1.0 - SIX_DIGITS, 0.0)
        with (
            w.when(self.unsure.get() < 1),
            w.few(c.get()) as n,
            w.when((room[self.mu + n] > 0.0) & (room[self.rubs + n] > 0.0)),
        ):
            self._press(n * d, size)
            squares = self.sum(size, lambda j: room[self.pressing + j] * room[self.pressing + j])
            most = self.cell
            most.put(0.0)
            slides = room[self.slides + n] > 0.0

            def moves(j: Term, l: Term) -> Term:
                """Entry l of row j of the linear map from y to a_t."""
                straight = self.sum(d - 1, lambda r: room[self.dirs + n * d + r] * self._lower(n * d + 1 + r, l))
                return w.select(slides, straight, self._lower(n * d + 1 + j, l))

            rows = w.select(slides, w.integer(1), d - 1)
            with w.few(rows) as j:
                most.put(self.largest(most.get(), self.sum(size, lambda l: moves(j, l) * moves(j, l))))
            s = w.compute("sqrt", most.get() / squares)
            self.doubt(~(s < 1e300))
            half = room[self.mu + n] * 0.5
            with w.few(size) as i, w.few(size) as j:
                at = self.bound + i * kd + j
                pressed = half * s * room[self.pressing + i] * room[self.pressing + j]
                moved = self.sum(rows, lambda r: moves(r, i) * moves(r, j)) * w.select(s > 0.0, half / s, 0.0)
                room[at] = room[at] - pressed - moved
        factor(room, self.bound, kd, size)
        with w.few(size) as i:
            self.doubt(~(room[self.bound + i * kd + i] > 0.0))

    def doubt_pivot(self, pivot: Term, own: Term) -> None:
        """Unsure if a row may depend on those before it: elimination leaves `pivot` of its diagonal entry `own`.

        Errors of W come divided by `least`, the smallest share left so far: beside rows that almost depend a zero does not look so.
        """
        share = pivot / own
        self.doubt(~(share > self.largest(U / self.least.get(), self.writer.constant(INVERSE_RANK))))
        self.least.put(self.writer.compute("min", self.least.get(), share))

    def _factor(self, size: Term) -> None:
        """L of W = L Lᵀ, with zero columns for contacts with the slip of an earlier one; unsure if other rows are dependent."""
        w, room, kd = self.writer, self.room, self.k * self.d
        self.least.put(1.0)
        with w.few(size) as i, w.few(i + 1) as j:
            row, above = self.L + i * kd * 2, self.L + j * kd * 2
            rest = room[row + j] - self.sum(j, lambda k: room[row + k] * room[above + k])
            pivot = room[above + j]
            with w.when(j < i):
                room[row + j] = w.select(pivot > 0.0, rest / w.select(pivot > 0.0, pivot, 1.0), 0.0)
            with w.otherwise():
                n = self.whole(i)
                follows = (room[self.first + n] < w.compute("float", n)) & (self.rest_of(i) > 0)
                own = room[self.W + i * kd + i]
                self.doubt_pivot(w.select(follows, own, rest), own)
                positive = w.select(rest > 0.0, rest, 0.0)
                room[row + j] = w.select(follows, 0.0, w.compute("sqrt", positive))

    def _lower(self, i: Term, j: Term) -> Term:
        """An entry of L."""
        return self.writer.select(j <= i, self.room[self.L + i * self.k * self.d * 2 + j], 0.0)

    def _press(self, row: Term, size: Term) -> None:
        """Sets `pressing` to L⁻¹ e for the unit vector e of a row: N = pressing · y for λ = L⁻ᵀ y."""
        w, room, kd = self.writer, self.room, self.k * self.d
        with w.few(size) as i:
            right = unit(i, row)
            before = self.sum(i, lambda j: room[self.L + i * kd * 2 + j] * room[self.pressing + j])
            pivot = room[self.L + i * kd * 2 + i]
            room[self.pressing + i] = w.select(pivot > 0.0, (right - before) / w.select(pivot > 0.0, pivot, 1.0), 0.0)

    def search(self) -> None:
        """Tries modes until all inequalities hold, or sets `unsure`."""
        w, d, c = self.writer, self.d, self.count
        self.changed.put(1)
        self.trials.put(0)
        with w.repeat(lambda: (self.changed.get() > 0) & (self.trials.get() < _TURNS) & (self.unsure.get() < 1)):
            self.changed.put(0)
            self.solve()
            with w.few(c.get()) as n:
                others = (self.trials.get() <= _ALONE) | (self.changed.get() < 1)
                with w.when((self.unsure.get() < 1) & others):
                    self._judge(n, n * d)
            self.trials.put(self.trials.get() + 1)
        self.doubt(self.changed.get() > 0)

    def _judge(self, n: Term, at: Term) -> None:
        """Changes the status of a contact if an inequality is violated; unsure if one is within its error bound."""
        w, room, d = self.writer, self.room, self.d
        kind, slides = room[self.kind + n], room[self.slides + n] > 0.0
        pressed, error = room[self.force + at], room[self.force_errors + at]

        def becomes(what: Term | float) -> None:
            room[self.kind + n] = what
            self.changed.put(1)

        with w.when(kind < STICK):
            self.doubt(self.absolute(room[self.a + at]) <= room[self.a_errors + at])
            with w.when(room[self.a + at] < -room[self.a_errors + at]):
                becomes(w.select(slides, SLIP, STICK))
                self._slip_on(n, at, slides)
        with w.otherwise():
            self.doubt(self.absolute(pressed) <= error)
            with w.when(pressed < -error):
                becomes(OPEN)
            with w.otherwise(), w.when((kind < SLIP) & (room[self.rubs + n] > 0.0)):

                def most(of: Term) -> Term:
                    self.cell.put(0.0)
                    with w.few(d - 1) as j:
                        self.cell.put(self.largest(self.cell.get(), room[of + at + 1 + j]))
                    return self.cell.get()

                with w.when((kind < FRESH) & ~(room[self.lead + n] < w.compute("float", n))):
                    self._judge_cone(n, at, self.length(self.force + at + 1), most)
                with w.when(kind >= FRESH):
                    self._judge_slip(n, at, most)

    def _slip_on(self, n: Term, at: Term, slides: Term) -> None:
        """After `_ALONE` trials, a contact that closes again slips at once, alternately along its acceleration and against it."""
        w, room, d = self.writer, self.room, self.d
        moves = self.length(self.a + at + 1)
        with w.when((self.trials.get() > _ALONE) & (room[self.rubs + n] > 0.0) & ~slides & (moves > 0.0)):
            even = w.compute("float", self.trials.get()) * 0.5
            back = even.equals(w.compute("float", w.compute("int", even)))
            with w.few(d - 1) as j:
                way = room[self.a + at + 1 + j] / moves
                room[self.dirs + at + j] = w.select(back, -way, way)
            room[self.kind + n] = FRESH

    def _judge_cone(self, n: Term, at: Term, friction: Term, most: Callable[[Term], Term]) -> None:
        """Checks |F| ≤ Σ μ N of the contacts that stick by the constraints of n; if violated, they slip against F."""
        w, room, d, c = self.writer, self.room, self.d, self.count

        def sum_of(what: Term) -> Term:
            return self.sum(c.get(), lambda m: w.select(self.leads(m, n), room[self.mu + m] * room[what + m * d], 0.0))

        left, slack = sum_of(self.force) - friction, sum_of(self.force_errors) + most(self.force_errors)
        self.doubt(self.absolute(left) <= slack)
        with w.when(left < -slack), w.few(c.get()) as m, w.when(self.leads(m, n)):
            with w.few(d - 1) as j:
                room[self.dirs + m * d + j] = -room[self.force + at + 1 + j] / friction
            with w.when((m < n) | (n < m)):
                room[self.kind + m] = FRESH
        with w.when(left < -slack):
            room[self.kind + n] = FRESH
            self.changed.put(1)

    def _judge_slip(self, n: Term, at: Term, most: Callable[[Term], Term]) -> None:
        """Updates the direction of a contact that begins to slip, by its acceleration; it sticks if friction does not oppose slip."""
        w, room, d = self.writer, self.room, self.d
        onward = self.sum(d - 1, lambda j: room[self.dirs + at + j] * room[self.a + at + 1 + j])
        slack, held = most(self.a_errors), self.other
        held.put(0.0)
        with w.few(self.count.get()) as m:  # by another one with the same slip that sticks
            one = room[self.kind + m].equals(STICK) & room[self.first + m].equals(room[self.first + n])
            held.put(w.select(one & (room[self.rubs + m] > 0.0), 1.0, held.get()))
        self.doubt((held.get() < 0.5) & (self.absolute(onward) <= slack))
        with w.when((onward < -slack) | (held.get() > 0.5)):
            with w.few(d - 1) as j:
                room[self.dirs + at + j] = 0.0
            room[self.kind + n] = STICK
            self.changed.put(1)
        with w.otherwise():
            length = self.length(self.a + at + 1)
            with w.few(d - 1) as j:
                turned = room[self.a + at + 1 + j] / length
                with w.when(self.absolute(turned - room[self.dirs + at + j]) > _TURNED):
                    self.changed.put(1)
                room[self.dirs + at + j] = turned

    def solve(self) -> None:
        """Sets forces and accelerations in the modes `kind`, with error bounds."""
        w, room, d, c, kd = self.writer, self.room, self.d, self.count, self.k * self.d
        size, nu = c.get() * d, self.unknowns
        nu.put(0)
        with w.few(c.get()) as n, w.when(room[self.kind + n] > OPEN):
            self.lead_of(n)
            held = room[self.lead + n] < w.compute("float", n)
            with w.few(w.select((room[self.kind + n] > STICK) | held, w.integer(1), d)) as j:
                room[self.at_row + nu.get()] = w.compute("float", n * d + j)
                nu.put(nu.get() + 1)
        with w.few(nu.get()) as u:
            row = self.index(self.at_row + u)
            n = self.whole(row)
            slips = room[self.kind + n] > STICK
            with w.few(size) as i:
                rubbing = self.sum(d - 1, lambda j: room[self.dirs + n * d + j] * room[self.W + i * kd + n * d + 1 + j])
                along = w.select(slips, room[self.mu + n] * rubbing, 0.0)
                room[self.G + i * kd + u] = room[self.W + i * kd + row] - along
        with w.few(nu.get()) as u, w.few(nu.get()) as v:
            at = self.A + u * nu.get() * 2 + v
            room[at] = room[self.G + self.index(self.at_row + u) * kd + v]
            room[at + nu.get()] = unit(u, v)
        invert(room, self.A, nu.get())
        self._forces(size)
        self._errors(size)

    def _inverse(self, u: Term, v: Term) -> Term:
        """An entry of A⁻¹."""
        count = self.unknowns.get()
        return self.room[self.A + u * count * 2 + count + v]

    def _forces(self, size: Term) -> None:
        """Sets x, λ and a."""
        w, room, d, nu, kd = self.writer, self.room, self.d, self.unknowns, self.k * self.d
        with w.few(size) as i:
            room[self.force + i] = 0.0
        with w.few(nu.get()) as u:
            room[self.x + u] = -self.sum(
                nu.get(), lambda v: self._inverse(u, v) * room[self.b + self.index(self.at_row + v)]
            )
            row = self.index(self.at_row + u)
            n = self.whole(row)
            room[self.force + row] = room[self.x + u]
            with w.when(room[self.kind + n] > STICK), w.few(d - 1) as j:
                room[self.force + row + 1 + j] = -(room[self.mu + n] * room[self.dirs + n * d + j] * room[self.x + u])
        with w.few(size) as i:
            pushed = self.sum(nu.get(), lambda u: room[self.G + i * kd + u] * room[self.x + u])
            room[self.a + i] = pushed + room[self.b + i]
            self.doubt(~(self.absolute(room[self.a + i]) < 1e300))

    def sized(self, i: Term, size: Term, of: Term) -> Term:
        """s_i Σ s_j |λ_j| with s² the diagonal of W, the scale of rounding errors of W."""
        w, room, kd = self.writer, self.room, self.k * self.d

        def root(j: Term) -> Term:
            return w.compute("sqrt", room[self.W + j * kd + j])

        return root(i) * self.sum(size, lambda j: root(j) * self.absolute(room[of + j]))

    def _errors(self, size: Term) -> None:
        """Sets bounds of |Δλ| and |Δa|; unsure if the equations are not satisfied."""
        w, room, d, nu, kd = self.writer, self.room, self.d, self.unknowns, self.k * self.d
        with w.few(size) as i:
            room[self.force_errors + i] = 0.0
            room[self.a_errors + i] = room[self.terms + i] + self.sized(i, size, self.force)
        with w.few(nu.get()) as u:  # terms of the equations
            room[self.x_errors + u] = room[self.a_errors + self.index(self.at_row + u)]
        with w.few(size) as i:

            def carried(u: Term, i: Term = i) -> Term:
                through = self.sum(nu.get(), lambda v: room[self.G + i * kd + v] * self._inverse(v, u))
                return self.absolute(through) * room[self.x_errors + u]

            room[self.a_errors + i] = (room[self.a_errors + i] + self.sum(nu.get(), carried)) * U
        with w.few(nu.get()) as u:
            error = self.sum(nu.get(), lambda v: self.absolute(self._inverse(u, v)) * room[self.x_errors + v]) * U
            row = self.index(self.at_row + u)
            n = self.whole(row)
            room[self.force_errors + row] = error
            with w.when(room[self.kind + n] > STICK), w.few(d - 1) as j:
                rubbed = self.absolute(room[self.mu + n] * room[self.dirs + n * d + j])
                room[self.force_errors + row + 1 + j] = rubbed * error
            self.doubt(~(self.absolute(room[self.a + row]) <= room[self.a_errors + row] * MET))
