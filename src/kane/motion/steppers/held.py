# SPDX-License-Identifier: BSD-3-Clause
"""The constraint solver of a kernel: projection of states, choice of dependent speeds, detection of singular constraints in a step.

With rows and columns of A divided by their scales, Ã = R⁻¹ A C⁻¹, the corrections of a state have the least norm of C δ, C Δu,

    δ  = −C⁻¹ Ãᵀ (Ã Ãᵀ)⁻¹ R⁻¹ f,  Δq = W δ          repeated until f is rounding
    Δu = −C⁻¹ Ãᵀ (Ã Ãᵀ)⁻¹ R⁻¹ (A u + b)

without redundant rows. B consists of the columns of Ã of the dependent speeds. Between two states of a step B is regular if 1/‖B₁⁻¹‖
+ 1/‖B₂⁻¹‖ exceeds the change of B from one to the other; intervals are refined until it does (`kane.motion.projection`). The kernel
detects only that B may be singular: Python then examines the step as it does for all methods.
"""

from collections.abc import Callable
from typing import NamedTuple

from kane.motion.steppers.context import RATE, ReturnCode, Slot, StepperContext
from kane.numeric.scale import BETTER, POOR, ROUNDED, ROUNDED_SUM, UNUSABLE
from kane.program.kernel.language import INT
from kane.program.kernel.writer import Array, Term, factor, invert, solve, total, unit

_ROUNDS = 6
_CLOSED, _LEVEL = 2.0**-46, 2.0**-49
"""Residuals of f and of A u + b, as shares of their terms, that are rounding."""
POORLY = 0.25
"""Share of the required quality below which dependent speeds are given up even if no others are better."""
CHANGES = 64
"""Capacity of the log of changes of dependent speeds, which Python empties."""
_GROWN = 2.0
"""Entry of Ã above which the scales are computed anew."""
_FAR, _CURVED, _FIRST, _SHORTEST = 0.25, 1.5, 1 / 8, 2.0**-10
_WIDE, _GOLDEN = 3.0, 0.381966011250105
"""`_CURVED` for a step inspected in two parts, and the share of the first, the golden section: only many whole turns fit both."""
POORER, DOUBTFUL = 1.0, 2.0
"""Values of HELD: dependent speeds are poorly determined at the end of a step; constraints may be singular in it or violated."""
Dense = Callable[[Term, Array, Term], None]
"""Writes the state at a share of the step into an array, from an index on."""


class RoughDense(NamedTuple):
    """An interpolant of the step from states and rates at its ends, and a function that prepares the exact one on a condition."""

    dense: Dense
    prepare: Callable[[Term], None]


COUNTS = (
    "closures", "rows", "speeds", "chosen", "chosen_closures", "entries", "turns", "spheres", "branches", "coordinates",
)  # fmt: skip
"""Numbers of rows of f and of A, speeds, rows of B and of those from closures, nonzero entries of A and of W, sets of Euler
parameters, branches, coordinates."""


def room(n: int, counts: dict[str, int]) -> int:
    """The length of the array `room` of `ConstraintSolver` for n components."""
    c, m, s, d = (counts[name] for name in ("closures", "rows", "speeds", "chosen"))
    numbers = 2 * c + m + sum(counts[name] for name in ("branches", "entries", "turns"))
    return numbers + 2 * m + d * s + 7 * d * d + 2 * d + s + 2 * n


class ConstraintSolver:
    """The kernel's arguments for constraints, and the operations on them.

    The routine `constraints` returns f, the sizes of its terms, b, the cosines of the branches, and the nonzero entries of A and of
    W. `quiet` is the value of ‖Ã‖ ‖B⁻¹‖ up to which poor dependent speeds at the start are known to have no better alternative.
    """

    def __init__(self, context: StepperContext) -> None:
        self.context, self.writer = context, context.writer
        w = self.writer
        self.call = w.callee("constraints", *RATE)
        counts = [w.number(f"held_{name}") for name in COUNTS]
        self.c, self.m, self.s, self.d, self.dc, self.a_count, self.w_count = counts[:7]
        self.spheres, self.branches, self.coordinates = counts[7:]
        self.h = w.hoisted("held_h")
        names = ("entry_at", "weights", "turn_at", "chosen_at", "dependent", "row_sizes", "column_sizes", "sphere_at")
        arrays = [w.array(f"held_{name}") for name in names]
        self.entries, self.weights, self.w_at, self.chosen, self.dependent = arrays[:5]
        self.row_sizes, self.column_sizes, self.sphere_at = arrays[5:]
        self.reach, self.marks, self.room = (w.array(f"held_{name}") for name in ("reach", "marks", "room"))
        self.choices, self.choice_at = w.number("held_choices"), w.number("held_choice_at")
        self.ready, self.log, self.quiet = (w.array(f"held_{name}") for name in ("ready", "log", "quiet"))
        self.next = w.variable("held_next", INT)
        self.best = w.variable("held_best")
        self._room_layout()
        self.doubt, self.rounds, self.open = (w.variable(f"held_{name}", INT) for name in ("doubt", "rounds", "open"))
        self.grown = w.variable("held_grown", INT)
        self.least, self.share, self.most, self.inverse = (
            w.variable(f"held_{name}") for name in ("least", "share", "most", "inverse")
        )
        self.known = w.variable("held_known", INT)
        self.least_first, self.least_end, self.done, self.ahead, self.before = (
            w.variable(f"held_{name}") for name in ("least_first", "least_end", "done", "ahead", "least_before")
        )

    def _room_layout(self) -> None:
        """Assigns the indices in `room`."""
        counts = (self.c, self.c, self.m, self.branches, self.a_count, self.w_count, self.m, self.m)
        square = self.d * self.d
        wide = (self.d * self.s, square * 2, square, square, square, square, square, self.d, self.d, self.s)
        at, places = self.writer.integer(0), []
        for count in (*counts, *wide):
            places.append(at)
            at = at + count
        self.f, self.terms, self.b, self.cosines, self.a, self.w, self.left, self.sizes = places[:8]
        (
            self.rows,
            self.block,
            self.here,
            self.last,
            self.first,
            self.final,
            self.gram,
            self.columns,
            self.x,
            self.delta,
        ) = places[8:]
        self.probe, self.state = at, at + self.context.n

    def index(self, array: Array, at: Term) -> Term:
        """An index that is stored as a double."""
        return self.writer.compute("int", array[at])

    def take(self, choice: Term) -> None:
        """Selects a choice of dependent speeds."""
        with self.writer.few(self.d) as j:
            self.room[self.columns + j] = self.dependent[choice * self.d + j]

    def pick(self) -> None:
        """Copies B from Ã. Lanes may differ in the choice of dependent speeds: columns are compared, and all lanes read one index."""
        w, room = self.writer, self.room

        def column(j: Term, k: Term) -> None:
            with w.few(self.d) as i:
                room[self.here + i * self.d + j] = room[self.rows + i * self.s + k]

        def own(j: Term, k: Term) -> Term:
            return room[self.columns + j].equals(w.compute("float", k))

        with w.when(self.choices > 1), w.few(self.d) as j, w.few(self.s) as k, w.when(own(j, k)):
            column(j, k)
        with w.otherwise(), w.few(self.d) as j:
            column(j, self.index(self.dependent, j))

    def entry(self, i: Term, j: Term) -> Term:
        """Entry (i, j) of B."""
        return self.room[self.here + i * self.d + j]

    def copy(self, block: Term, to: Term) -> None:
        """Copies one stored B to another."""
        with self.writer.few(self.d * self.d) as k:
            self.room[to + k] = self.room[block + k]

    def present(self) -> None:
        """Selects the dependent speeds in use."""
        self.take(self.writer.compute("int", self.context.get(Slot.CHOICE)))

    # --------------------------------------------------------------------------------------------- at a state

    def numbers(self, t: Term, array: Array, place: Term) -> None:
        """Evaluates f, A, b and the rest at time t and the state at an index, whose Euler parameters are normalized first.

        Routines read the state from `room`: all lanes must pass them the same index.
        """
        w, o = self.writer, self.context
        with w.few(self.spheres) as k:
            at = [self.index(self.sphere_at, k * 4 + j) + place for j in range(4)]
            e = [array[i] for i in at]
            length = w.compute("sqrt", w.sum([x * x for x in e]))
            for i, x in zip(at, e, strict=True):
                array[i] = x / length
        if array is not self.room:
            with w.few(o.n) as i:
                self.room[self.state + i] = array[place + i]
            array, place = self.room, self.state
        o.drive(t, array.at(place), single=True)
        self.call(t, array.at(place), o.p.at(0), o.single_r.at(0), self.h.at(0), self.room.at(0))

    def matrix(self) -> None:
        """Writes Ã of the chosen rows to `room`."""
        w, room = self.writer, self.room
        with w.few(self.d * self.s) as k:
            room[self.rows + k] = 0.0
        with w.few(self.a_count) as e:
            slot = self.index(self.entries, e * 3)
            with w.when(slot >= 0):
                column = self.index(self.entries, e * 3 + 2)
                room[self.rows + slot * self.s + column] = room[self.a + e] * self.weights[e]

    def change(self, count: Term, right: Callable[[Term], Term]) -> None:
        """Solves for the δ by which the first `count` of the chosen rows change by `right`."""
        w, room, s = self.writer, self.room, self.s
        with w.few(count) as i, w.few(i + 1) as j:
            one, two = self.rows + i * s, self.rows + j * s
            room[self.gram + i * self.d + j] = total(w, s, lambda k: room[one + k] * room[two + k])
        with w.few(count) as i:
            room[self.x + i] = right(i) * self.row_sizes[self.index(self.chosen, i)]
        factor(room, self.gram, self.d, count)
        solve(room, self.gram, self.d, count, self.x)
        with w.few(s) as j:
            along = total(w, count, lambda i: room[self.rows + i * s + j] * room[self.x + i])
            room[self.delta + j] = along * self.column_sizes[j]

    def rates_left(self, array: Array, place: Term) -> None:
        """Computes the residuals A u + b and their scales |b_i| + R_i Σ_j C_j |u_j|, with the largest entries of A so far."""
        w, room, u = self.writer, self.room, place + self.coordinates
        fast = total(w, self.s, lambda j: w.compute("abs", array[u + j]) / self.column_sizes[j])
        with w.few(self.m) as i:
            room[self.left + i] = room[self.b + i]
            room[self.sizes + i] = w.compute("abs", room[self.b + i]) + fast / self.row_sizes[i]
        with w.few(self.a_count) as e:
            row, column = (self.index(self.entries, e * 3 + j) for j in (1, 2))
            room[self.left + row] = room[self.left + row] + room[self.a + e] * array[u + column]

    def is_open(self, count: Term, left: Term, sizes: Term, share: float) -> Term:
        """Whether a residual of the first `count` chosen rows exceeds the share of its terms."""
        w, room = self.writer, self.room
        self.open.put(0)
        with w.few(count) as k:
            i = self.index(self.chosen, k)
            with w.when(w.compute("abs", room[left + i]) > room[sizes + i] * share):
                self.open.put(1)
        return self.open.get() > 0

    def project(self, t: Term, array: Array, place: Term) -> None:
        """Projects the state at an index onto the constraints at time t; `doubt` is 1 if residuals remain or a branch is left."""
        w, room = self.writer, self.room
        self.numbers(t, array, place)
        self.rounds.put(0)
        with w.repeat(lambda: self.is_open(self.dc, self.f, self.terms, _CLOSED) & (self.rounds.get() < _ROUNDS)):
            self.matrix()
            self.change(self.dc, lambda k: -room[self.f + self.index(self.chosen, k)])
            with w.few(self.w_count) as e:
                i, j = (self.index(self.w_at, e * 2 + k) for k in (0, 1))
                array[place + i] = array[place + i] + room[self.w + e] * room[self.delta + j]
            self.numbers(t, array, place)
            self.rounds.put(self.rounds.get() + 1)
        self.matrix()
        self.rates_left(array, place)
        with w.when(self.is_open(self.d, self.left, self.sizes, _LEVEL)):
            self.move_speeds(array, place)
        self.doubt.put(0)
        for count, left, sizes, first in ((self.c, self.f, self.terms, 0), (self.m, self.left, self.sizes, self.c)):
            with w.few(count, first) as i, w.when(~(w.compute("abs", room[left + i]) <= room[sizes + i] * ROUNDED_SUM)):
                self.doubt.put(1)
        with w.few(self.branches) as k, w.when(~(room[self.cosines + k] > 0.0)):
            self.doubt.put(1)

    def move_speeds(self, array: Array, place: Term) -> None:
        """Corrects the speeds of the state by the least change that removes the residuals in `left`."""
        w, room = self.writer, self.room
        self.change(self.d, lambda k: -room[self.left + self.index(self.chosen, k)])
        with w.few(self.s) as j:
            at = place + self.coordinates + j
            array[at] = array[at] + room[self.delta + j]
        self.rates_left(array, place)

    def follow(self, t: Term, to: tuple[Array, Term], bound: tuple[Array, Term]) -> None:
        """Solves the constraints for the speeds of a state that are not `bound`; `doubt` is 1 if residuals remain."""
        w, room, (array, place), (kept, first) = self.writer, self.room, to, bound
        self.numbers(t, array, place)
        self.doubt.put(0)
        with w.when(self.is_open(self.dc, self.f, self.terms, _CLOSED)):
            self.doubt.put(1)
        self.matrix()
        with w.few(self.s) as j, w.when(kept[first + j] > 0.5), w.few(self.d) as i:
            room[self.rows + i * self.s + j] = 0.0
        self.rates_left(array, place)
        self.rounds.put(0)
        with w.repeat(lambda: self.is_open(self.d, self.left, self.sizes, _LEVEL) & (self.rounds.get() < _ROUNDS)):
            self.move_speeds(array, place)
            self.rounds.put(self.rounds.get() + 1)
        with w.few(self.m) as i, w.when(~(w.compute("abs", room[self.left + i]) <= room[self.sizes + i] * ROUNDED_SUM)):
            self.doubt.put(1)

    def regularity(self) -> None:
        """Computes `least` = 1/‖B⁻¹‖ and `share` = ‖Ã‖ ‖B⁻¹‖, the reciprocal of the quality of the dependent speeds."""
        self.pick()
        self.bound()
        self.share.put(self.norm(self.d * self.s, lambda k: self.room[self.rows + k]) * self.inverse.get())

    def norm(self, count: Term, of: Callable[[Term], Term]) -> Term:
        """√ Σ x_k²."""
        return self.writer.compute("sqrt", total(self.writer, count, lambda k: of(k) * of(k)))

    def bound(self) -> None:
        """Computes `inverse` = ‖B⁻¹‖ and `least`, its reciprocal. For two rows, as most loops have, ‖B⁻¹‖ = ‖B‖/|det B|."""
        w, room, d = self.writer, self.room, self.d
        with w.when((d < 2) | (d > 2)):
            with w.few(d) as i, w.few(d) as j:
                at = self.block + i * d * 2 + j
                room[at] = self.entry(i, j)
                room[at + d] = unit(i, j)
            invert(room, self.block, d)
            with w.few(d) as i:
                room[self.x + i] = self.norm(d, lambda k: room[self.block + i * d * 2 + d + k])
            self.inverse.put(self.norm(d, lambda k: room[self.x + k]))
        with w.otherwise():
            zero, one = w.integer(0), w.integer(1)
            a, b, c, e = self.entry(zero, zero), self.entry(zero, one), self.entry(one, zero), self.entry(one, one)
            self.inverse.put(w.compute("sqrt", a * a + b * b + c * c + e * e) / w.compute("abs", a * e - b * c))
        self.least.put(1.0 / self.inverse.get())

    # -------------------------------------------------------------------------------------------- along a step

    def begin(self) -> None:
        """If QUIET is zero, initializes the scales from the state at the beginning and the entries of A so far, and QUIET."""
        w, o = self.writer, self.context
        self.known.put(0)
        with w.when(~(o.get(Slot.QUIET) > 0.0)):
            self.numbers(o.get(Slot.TIME), o.y, w.integer(0))
            with w.few(self.a_count) as e:
                self.reach[e] = w.compute("max", self.reach[e], w.compute("abs", self.room[self.a + e]))
            self.measure()
            with w.when(o.get(Slot.FRESH) > 1.0):
                self.admit()
            o.put(Slot.QUIET, w.compute("max", self.quiet[0], 1 / POOR))

    def admit(self) -> None:
        """Projects the initial state; speeds that the constraints stop become zero, since only rounding would remain of them."""
        w, y, probe = self.writer, self.context.y, self.room
        with w.few(self.s) as j:
            probe[self.probe + j] = y[self.coordinates + j]
        self.project(self.context.get(Slot.TIME), y, w.integer(0))
        self.move_speeds(y, w.integer(0))
        with w.few(self.s) as j:
            left, was = y[self.coordinates + j], probe[self.probe + j]
            stopped = w.compute("abs", left) <= w.compute("abs", was - left) * ROUNDED
            y[self.coordinates + j] = w.select(stopped, 0.0, left)

    def measure(self) -> None:
        """Computes R, the largest entries of the rows of A so far, and C, those of the columns of R⁻¹ A.

        Entries that are rounding of the largest one are ignored.
        """
        w = self.writer
        self.known.put(0)
        self.most.put(0.0)
        with w.few(self.a_count) as e:
            self.most.put(w.compute("max", self.most.get(), self.reach[e]))
        for sizes, count, axis in ((self.row_sizes, self.m, 1), (self.column_sizes, self.s, 2)):
            with w.few(count) as i:
                sizes[i] = 0.0
            with w.few(self.a_count) as e, w.when(self.reach[e] > self.most.get() * ROUNDED):
                row, i = (self.index(self.entries, e * 3 + k) for k in (1, axis))
                size = self.reach[e] if axis == 1 else self.reach[e] * self.row_sizes[row]
                sizes[i] = w.compute("max", sizes[i], size)
            with w.few(count) as i:
                sizes[i] = 1.0 / w.select(sizes[i] > 0.0, sizes[i], 1.0)
        with w.few(self.a_count) as e:
            row, column = (self.index(self.entries, e * 3 + k) for k in (1, 2))
            self.weights[e] = self.row_sizes[row] * self.column_sizes[column]

    def look(
        self, begin: Term, h: Term, end: Term, to: tuple[Array, Term], dense: Dense, rough: RoughDense | None
    ) -> None:
        """Projects the `end` of a step and tests its constraints; a doubt that Python has not yet examined sets `asks`.

        Before that it updates the scales, on which projections depend, since entries of A may have grown, and repeats the step.
        """
        w, o = self.writer, self.context
        self.present()
        self.end(end, *to)
        poor = (self.d > 0) & ~(self.share.get() <= o.get(Slot.QUIET))
        looked, own = o.get(Slot.LOOKED) > 0.0, w.compute("int", o.get(Slot.CHOICE))
        whole = self.d >= self.s  # all speeds are dependent: no other choice exists
        chooses = ((self.choices > 1) | whole) & ~looked
        self.next.put(w.select(poor & looked, own, w.integer(-1)))
        with w.when(poor & chooses):
            self.choose()
        self.open.put(self.doubt.get())
        self.copy(self.here, self.final)
        self.least_end.put(self.least.get())
        if rough is None:
            self.passage(begin, h, dense)
        else:
            far = self.goes_far(begin, h, rough.dense)
            rough.prepare(far | poor | (self.open.get() > 0))
            with w.when(far):
                self.passage(begin, h, dense)
        passed = self.doubt.get() > self.open.get()
        with w.when(passed & chooses):
            self.choose()
        next_ = self.next.get()
        shorter = passed & (next_ >= 0) & ((next_ < own) | (own < next_)) & (h > 4.0 * o.shortest())
        unknown = (next_ < 0) | (self.ready[w.select(next_ < 0, w.integer(0), next_)] < 1.0)
        o.put(Slot.HELD, w.select(self.doubt.get() > 0, DOUBTFUL, w.select(poor, POORER, 0.0)))
        with w.when(self.log[0] >= float(CHANGES)):
            o.asks.put(ReturnCode.FULL)
        with w.when((o.get(Slot.HELD) > 0.0) & ~looked):
            with w.when(o.get(Slot.MEASURED) < 1.0):
                self.measure()
                o.put(Slot.MEASURED, 1.0)
                o.asks.put(ReturnCode.AGAIN)
            with w.otherwise():
                with w.when(shorter):  # only the present choice is singular there, another one is not
                    o.put(Slot.STEP, h * 0.5)
                    o.asks.put(ReturnCode.AGAIN)
                with w.otherwise():
                    with w.when((self.doubt.get() > 0) | unknown):
                        o.put(Slot.WORST, w.compute("float", next_))
                        o.asks.put(ReturnCode.LOOK)
                    with w.otherwise():  # the kernel changes the choice: a LOOK for events is no doubt
                        o.put(Slot.HELD, 0.0)

    def choose(self) -> None:
        """Sets `next` to the best determined dependent speeds at the current state, if far better than the present ones.

        Otherwise `next` is the present choice if that is acceptable, else −1.
        """
        w, o = self.writer, self.context
        own = w.compute("int", o.get(Slot.CHOICE))
        self.regularity()
        self.best.put(self.share.get() * (1 / BETTER))
        self.next.put(-1)
        with w.few(self.choices) as k, w.when((self.ready[k] >= 0.0) & ((k < own) | (own < k))):
            self.take(k)
            self.regularity()
            with w.when(self.share.get() < self.best.get()):
                self.best.put(self.share.get())
                self.next.put(k)
        self.present()
        self.regularity()
        least = w.select(self.d >= self.s, 1 / UNUSABLE, 1 / (POORLY * POOR))
        with w.when((self.next.get() < 0) & (self.share.get() <= least)):
            self.next.put(own)

    def end(self, t: Term, array: Array, place: Term) -> None:
        """Projects the state at the end of a step and updates the largest entries of A; repeats that if the scales change."""
        w, room = self.writer, self.room
        self.grown.put(1)
        with w.repeat(lambda: self.grown.get() > 0):
            self.grown.put(0)
            self.project(t, array, place)
            with w.few(self.a_count) as e:
                size = w.compute("abs", room[self.a + e])
                with w.when(size > self.reach[e]):
                    self.reach[e] = size
                    with w.when((size * self.weights[e] > _GROWN) & (self.entries[e * 3] >= 0.0)):
                        self.grown.put(1)
            with w.when(self.grown.get() > 0):
                self.measure()
        self.regularity()
        self.context.put(Slot.SHARE, self.share.get())

    def sample(self, k: Term, t: Term, array: Array, place: Term) -> None:
        """Projects sample k, and marks it if Python must project it instead."""
        w = self.writer
        self.project(t, array, place)
        self.regularity()
        with w.when((self.d > 0) & ~(self.share.get() <= 1 / UNUSABLE)):
            self.doubt.put(1)
        self.marks[k] = w.compute("float", self.doubt.get())

    def look_at(self, share: Term, t: Term, h: Term, dense: Dense) -> None:
        """Evaluates B and `least` at a share of the step of length h from t."""
        dense(share, self.room, self.probe)
        self.numbers(t + share * h, self.room, self.probe)
        self.matrix()
        self.pick()
        self.bound()

    def goes_far(self, t: Term, h: Term, dense: Dense) -> Term:
        """Whether B may be singular in a step, according to one state between its ends, so that the step needs a closer inspection.

        B at the beginning is known if a step ended there.
        """
        self.look_at(self.writer.constant(_GOLDEN), t, h, dense)
        far = self.known.get() < 1
        for block, least in ((self.first, self.least_first), (self.final, self.least_end)):
            moved = self.moved(block)
            far = far | ~((least.get() + self.least.get() > _WIDE * moved) & (moved <= _FAR))
        return far

    def passage(self, t: Term, h: Term, dense: Dense) -> None:
        """Sets `doubt` if B may be singular within the step of length h from t."""
        w, done, ahead, before = self.writer, self.done, self.ahead, self.before
        ahead.put(w.select(self.known.get() > 0, _FIRST, -1.0))
        done.put(0.0)
        before.put(self.least_first.get())
        self.copy(self.first, self.last)
        with w.repeat(lambda: (done.get() < 1.0) & (self.doubt.get() < 1)):
            share = w.compute("min", done.get() + w.compute("max", ahead.get(), 0.0), 1.0)
            with w.when(share < 1.0):
                self.look_at(share, t, h, dense)
            with w.otherwise():
                self.copy(self.final, self.here)
                self.least.put(self.least_end.get())
            moved = self.moved(self.last)
            near = (before.get() + self.least.get() > _CURVED * moved) & (moved <= _FAR)
            with w.when((ahead.get() < 0.0) | near):
                self.copy(self.here, self.last)
                before.put(self.least.get())
                done.put(share)
                ahead.put(w.select(ahead.get() < 0.0, _FIRST, w.compute("min", ahead.get() * 2.0, _FIRST)))
            with w.otherwise():
                ahead.put(ahead.get() * 0.5)
                with w.when(~(ahead.get() > _SHORTEST)):
                    self.doubt.put(1)

    def moved(self, block: Term) -> Term:
        """The Frobenius norm of the change of B from a stored one."""
        return self.norm(self.d * self.d, lambda k: self.room[self.here + k] - self.room[block + k])

    def kept(self) -> None:
        """Follows an accepted step; requests the change of dependent speeds, or tolerates poor ones until a quarter poorer."""
        w, o = self.writer, self.context
        self.copy(self.final, self.first)
        self.least_first.put(self.least_end.get())
        self.known.put(1)
        o.put(Slot.MEASURED, 0.0)
        quarter = o.get(Slot.SHARE) * 1.25
        own = w.compute("float", self.next.get()) >= o.get(Slot.CHOICE)
        stays = (self.next.get() >= 0) & own & (w.compute("float", self.next.get()) <= o.get(Slot.CHOICE))
        most = w.select(
            stays, w.compute("max", o.get(Slot.QUIET), quarter), w.compute("min", o.get(Slot.QUIET), quarter)
        )
        o.put(Slot.QUIET, w.compute("max", most, 1 / POOR))
        o.renewed.put(w.select((self.next.get() >= 0) & ~stays, w.integer(1), w.integer(0)))

    def change_speeds(self) -> None:
        """Changes to the dependent speeds `next`, and logs the time."""
        w, o = self.writer, self.context
        self.known.put(0)
        new = w.compute("float", self.next.get())
        at = w.compute("int", self.log[0]) * 2 + 1
        self.log[at] = o.get(Slot.TIME)
        self.log[at + 1] = new
        self.log[0] = self.log[0] + 1.0
        o.put(Slot.CHOICE, new)
        o.put(Slot.TIME_LAG, 0.0)
        with w.count(o.n) as i:
            o.lag[i] = 0.0
        o.p[self.choice_at] = new
        o.put(Slot.QUIET, 1 / POOR)
