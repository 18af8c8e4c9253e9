# SPDX-License-Identifier: BSD-3-Clause
"""Event location: all zero crossings in a step that the bounds of `numeric.polynomials` do not exclude, located and sorted by time.

An interval in which the polynomial leaves the number of crossings undecided is bisected, left half first. Between two points of
different sign, Chandrupatla's method locates the crossing to the resolution of times; a change of sign at a pole is no crossing. A
quantity at its threshold at the beginning of the step (`LEAVES`) crosses nothing until it shows to which side it leaves. Source:
Chandrupatla, *A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear function without using derivatives*,
Advances in Engineering Software 28 (1997), p. 145.
"""

from collections.abc import Callable
from enum import IntEnum

from kane.motion.steppers.context import RATE
from kane.numeric.polynomials import (
    AGREEING,
    BETWEEN,
    CLOSE,
    LEFT,
    MOST,
    SHARES,
    TO_BERNSTEIN,
    TO_BETWEEN,
    TO_LAST,
    TO_NEXT,
)
from kane.numeric.polynomials import DEGREE as PARTS
from kane.numeric.scale import EPS, EQUAL, NEAR_TIME, ROUNDED_TERMS, SAME_TIME
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Array, Term, Variable, Writer


class EventKind(IntEnum):
    """The effect of an event: it is only recorded; a switch changes sides; the motion ends; its state changes; or Python decides."""

    NOTED = 0
    TURNS = 1
    ENDS = 2
    ACTS = 3
    ASKED = 4


KINDS = 4
"""Length of a row of `kinds`: kind, direction, whether the event is one of the system's own, whether it ends the motion."""
LEAVES = 5
"""Length of a row of `leaves`: whether the quantity begins at its threshold, the side to which it leaves, the order of the derivative
that says so, the band within which rounding may give it any sign, and the share of the step from which on its side shows."""
MET = 512
"""Largest number of crossings in a step, and of brackets of one quantity."""
_PLACES = (*SHARES, *map(float, BETWEEN))
_AT, _COEFFICIENTS, _PADDED, _BRACKETS = (len(_PLACES) * k + 4 * k for k in (1, 2, 3, 4))
_BEYOND = _BRACKETS + 4 * MET
_ROUNDS, _BESIDE, _GROWN = 120, (8 * SAME_TIME, 1e-5), 10.0
_TINY, _HUGE = 2.0**-1022, 1e300
_STEPS = 64.0
"""Number of steps up to which rounding errors are added up: beyond it they tend to cancel."""


def room(count: int) -> int:
    """The length of `zoom` for `count` quantities."""
    return _BEYOND + 2 * count


class Crossings:
    """The search: `search(e)` for each quantity that may cross, then `sort()`; `met` has `found` rows (share of the step, quantity).

    `ask(θ, array, place)` writes the quantities at the share θ of the step, then the sizes of their terms, from index `place` on.
    """

    def __init__(self, writer: Writer, count: Term, ask: Callable[[Term, Array, Term], None]) -> None:
        self.writer, self.count, self.ask = w, *_ = writer, count, ask
        self.kinds, self.leaves, self.met, self.zoom = map(w.array, ("kinds", "leaves", "met", "zoom"))
        self.answer = w.integer(_BEYOND)
        integers = "found asked full firm over brackets early again level open halvings rounds last_of"
        doubles = "threshold begin end first_value last_value low width index sizes root usual broken"
        self.cells: dict[str, Variable] = {name: w.variable(f"at_{name}", INT) for name in integers.split()}
        self.cells |= {name: w.variable(f"at_{name}") for name in doubles.split()}
        self.points = [(w.variable(f"at_x{k}"), w.variable(f"at_f{k}")) for k in range(3)]
        self.part = w.variable("at_part")

    def get(self, name: str) -> Term:
        """The value of a variable."""
        return self.cells[name].get()

    def put(self, name: str, value: Term | float) -> None:
        """Assigns a variable."""
        self.cells[name].put(value)

    def clear(self) -> None:
        """Resets the results of the search."""
        for name in ("found", "asked", "full"):
            self.put(name, 0)
        self.put("broken", 2.0)

    def begin_search(self) -> None:
        """Writes the shares of an interval at which quantities are evaluated to `zoom`."""
        w = self.writer
        self.zoom.store(_AT, w.lanes(*_PLACES[:8]))
        self.zoom.store(_AT + 8, w.lanes(*_PLACES[8:]))

    def kind(self, e: Term) -> Term:
        """The `EventKind` of an event."""
        return self.kinds[e * KINDS]

    def direction(self, e: Term) -> Term:
        """The direction of an event: −1, 0 or 1."""
        return self.kinds[e * KINDS + 1]

    def leaf(self, e: Term, k: int) -> Term:
        """Entry k of an event's row of `leaves`."""
        return self.leaves[e * LEAVES + k]

    def search(self, e: Term, values: tuple[Term, Term], threshold: Term, longest: Term) -> None:
        """Locates the crossings of quantity e; `values` are its values at the beginning of the step and at the eight places.

        If it stays at its threshold but for the rounding errors of `longest` steps, its crossings mean nothing, and `asked` is set.
        """
        w = self.writer
        first, others = values
        self.put("threshold", threshold)
        fresh, side = self.leaf(e, 0) > 0.0, self.leaf(e, 1)
        for name in ("brackets", "early", "halvings", "over"):
            self.put(name, 0)
        self.put("sizes", 0.0)
        self.put("begin", self.leaf(e, 4))
        self.put("end", 1.0)
        self.put("first_value", first - threshold)
        self.put("last_value", self.beyond(e, w.compute("lane", others, lane=PARTS - 1) - threshold))
        # a value that projection has moved across the threshold at an end looks like a corner there
        self.put("firm", 1)
        for share, kept in ((0.0, "first_value"), (1.0, "last_value")):
            with w.when(self.gap(e, w.constant(share)) * self.get(kept) < 0.0):
                self.put("firm", 0)
        self.put("again", 1)
        with w.repeat(lambda: self.get("again") > 0):
            self.put("again", 0)
            self.traverse(e, first - threshold, others - w.compute("splat8", threshold))
            back = ~(side * self.get("first_value") > 0.0) & ((side < 0.0) | (side > 0.0))
            with w.when(fresh & (self.get("early") < 1) & back):
                self.put("early", 1)
                self.put("again", 1)
                self.put("last_value", self.get("first_value"))
                self.put("end", self.get("begin"))
                self.put("begin", 0.0)
                self.put("first_value", side * _TINY)
                self.put("last_of", self.get("brackets"))
        size = w.compute(
            "max", w.compute("abs", first - threshold), w.compute("largest", w.compute("abs", others - w.compute("splat8", threshold)))
        )  # fmt: skip
        still = size <= w.compute("min", longest, _STEPS) * (self.get("sizes") * ROUNDED_TERMS)
        with w.when(still & (longest < 1 / NEAR_TIME)), w.when((self.get("brackets") > 0) | (self.get("over") > 0)):
            self.put("asked", 1)
        with w.otherwise():
            with w.when(self.get("over") > 0):
                self.put("full", 1)
            self.median(first - threshold, others - w.compute("splat8", threshold))
            with w.few(self.get("brackets")) as k:
                self.locate(e, w.integer(_BRACKETS) + k * 4)

    def beyond(self, e: Term, value: Term) -> Term:
        """The value; within its band, where its sign may be rounding, a quantity counts as on the side to which it leaves."""
        w = self.writer
        return w.select(w.compute("abs", value) < self.leaf(e, 3), self.leaf(e, 1) * _TINY, value)

    # --------------------------------------------------------------------------------------- brackets of crossings

    def traverse(self, e: Term, first: Term, others: Term) -> None:
        """Stores brackets of the crossings between `begin` and `end`."""
        w, zoom = self.writer, self.zoom
        fresh = self.leaf(e, 0) > 0.0
        plain = ~fresh & (self.get("early") < 1)
        self.put("low", self.get("begin"))
        self.put("width", self.get("end") - self.get("begin"))
        self.put("index", 0.0)
        self.part.put(1.0)
        for name, value in (("level", 0), ("open", 1)):
            self.put(name, value)
        zoom[0] = self.get("first_value")
        with w.repeat(lambda: self.get("open") > 0):
            root = self.get("level") < 1
            known = root & plain
            unknown = root & fresh & (self.get("early") < 1)
            start = w.select(known, w.integer(PARTS + 1), w.select(unknown, w.integer(0), w.integer(1)))
            with w.when(known):
                zoom[0] = first
                zoom.store(1, others)
            with w.few(len(_PLACES), start) as j:
                self.ask(self.get("low") + self.get("width") * zoom[j + _AT], zoom, self.answer)
                zoom[j] = self.beyond(e, zoom[self.answer + e] - self.get("threshold"))
                with w.when(root):  # not in smaller intervals: near a pole terms are large
                    self.put("sizes", w.compute("max", self.get("sizes"), zoom[self.answer + self.count + e]))
            with w.when(unknown):
                self.put("first_value", zoom[0])
            with w.when(self.get("index") + 1.0 >= self.part.get()):
                zoom[PARTS] = self.get("last_value")
            self.decide(e)

    def decide(self, e: Term) -> None:
        """Bisects the current interval, or takes its sign changes as its crossings."""
        w, zoom = self.writer, self.zoom
        first, others = zoom[0], zoom.lanes(1, PARTS)
        coefficients, slack, size = bounds(w, first, others)
        zoom[_COEFFICIENTS] = first
        zoom.store(_COEFFICIENTS + 1, coefficients)
        seen = self.changes(lambda j: zoom[j], zero_is_beyond=True)
        more = self.changes(lambda j: zoom[j + _COEFFICIENTS] + slack)
        less = self.changes(lambda j: zoom[j + _COEFFICIENTS] - slack)
        zoom[_PADDED] = first
        zoom.store(_PADDED + 1, others)
        clear = (slack <= CLOSE * size) & ~(dips(w, zoom, _PADDED, w.constant(0.0)) & (self.get("firm") > 0))
        clear = clear & (more <= seen) & (seen <= more) & (less <= seen) & (seen <= less)
        off = w.compute("max", slack * AGREEING, size * EQUAL)
        for k, row in enumerate(TO_BETWEEN):
            polynomial = first * float(row[0]) + w.compute("sum", others * tuple(map(float, row[1:])))
            clear = clear & (w.compute("abs", zoom[PARTS + 1 + k] - polynomial) <= off)
        finite = (first * 0.0 + w.compute("sum", others * 0.0)) <= 0.0
        short = (self.get("width") <= SAME_TIME) | (self.get("halvings") >= MOST)
        between = (zoom[PARTS + 1] * 0.0 + zoom[PARTS + 2] * 0.0 + zoom[PARTS + 3] * 0.0) <= 0.0
        done = w.variable(f"at_done{len(w.cells)}", INT)
        done.put(w.select(clear | ~finite | short | ~between, w.integer(1), w.integer(0)))
        with w.when(done.get() > 0):
            self.take(e)
            self.go_on()
        with w.otherwise():
            self.put("halvings", self.get("halvings") + 1)
            self.put("level", self.get("level") + 1)
            self.put("index", self.get("index") * 2.0)
            self.part.put(self.part.get() * 2.0)
            self.put("width", self.get("width") * 0.5)

    def changes(self, value: Callable[[Term], Term], zero_is_beyond: bool = False) -> Term:
        """The number of sign changes along nine values; zeros are skipped, or end the interval in which the sign changes."""
        w = self.writer
        count = w.variable(f"changes{len(w.cells)}")
        count.put(0.0)
        if zero_is_beyond:
            with w.few(PARTS) as j:
                count.put(count.get() + w.select(crossed(value(j), value(j + 1)), 1.0, 0.0))
            return count.get()
        last = w.variable(f"sign{len(w.cells)}")
        last.put(0.0)
        with w.few(PARTS + 1) as j:
            here = value(j)
            count.put(count.get() + w.select(here * last.get() < 0.0, 1.0, 0.0))
            sign = w.select(here < 0.0, -1.0, 1.0)
            last.put(w.select((here < 0.0) | (here > 0.0), sign, last.get()))
        return count.get()

    def take(self, e: Term) -> None:
        """Stores brackets in the current interval; before a quantity leaves its threshold, only the last one from its side counts."""
        w, zoom = self.writer, self.zoom
        with w.few(PARTS) as j:
            a, b = zoom[j], zoom[j + 1]
            early = self.get("early") > 0
            with w.when(crossed(a, b) & (~early | (a * self.leaf(e, 1) > 0.0))):
                with w.when(early):
                    self.put("brackets", self.get("last_of"))
                with w.when(self.get("brackets") >= MET):
                    self.put("over", 1)
                    self.put("brackets", 0)
                at = self.get("brackets") * 4 + _BRACKETS
                for k, x in enumerate((j, j + 1)):
                    zoom[at + k] = self.get("low") + self.get("width") * zoom[x + _AT]
                zoom[at + 2] = a
                zoom[at + 3] = b
                self.put("brackets", self.get("brackets") + 1)

    def go_on(self) -> None:
        """Proceeds to the next interval, the longest of the dyadic ones that begin where the current one ends."""
        w = self.writer
        self.zoom[0] = self.zoom[PARTS]
        self.put("index", self.get("index") + 1.0)

        def even() -> Term:
            half = self.get("index") * 0.5
            return (self.get("level") > 0) & (half <= w.compute("float", w.compute("int", half)))

        with w.repeat(even):
            self.put("index", self.get("index") * 0.5)
            self.part.put(self.part.get() * 0.5)
            self.put("level", self.get("level") + (-1))
            self.put("width", self.get("width") * 2.0)
        length = self.get("end") - self.get("begin")
        self.put("low", self.get("begin") + length * (self.get("index") / self.part.get()))
        with w.when(self.get("level") < 1):
            self.put("open", 0)

    # ------------------------------------------------------------------------------------------ location of crossings

    def locate(self, e: Term, at: Term) -> None:
        """Locates the crossing in a bracket, unless it has the wrong direction or is a pole."""
        w, zoom = self.writer, self.zoom
        a, way = zoom[at + 2], self.direction(e)
        with w.when(((way <= 0.0) & (a > 0.0)) | ((way >= 0.0) & (a < 0.0))):
            self.zero(e, at)
            with w.when(~(self.points[0][1].get() <= self.get("usual"))):
                self.refuse_pole(e)
            with w.when(self.get("root") >= 0.0):
                self.meet(self.get("root"), e)

    def meet(self, share: Term, e: Term) -> None:
        """Stores a crossing of a quantity at a share of the step."""
        with self.writer.when(self.get("found") >= MET):
            self.put("full", 1)
            self.put("found", 0)
        self.met[self.get("found") * 2] = share
        self.met[self.get("found") * 2 + 1] = self.writer.compute("float", e)
        self.put("found", self.get("found") + 1)

    def drop(self, at: Term) -> None:
        """Removes the crossing at an index."""
        self.put("found", self.get("found") + (-1))
        with self.writer.few(self.get("found"), at) as k:
            for j in range(2):
                self.met[k * 2 + j] = self.met[k * 2 + (2 + j)]

    def gap(self, e: Term, share: Term) -> Term:
        """The quantity minus its threshold at a share of the step."""
        self.ask(share, self.zoom, self.answer)
        return self.zoom[self.answer + e] - self.get("threshold")

    def zero(self, e: Term, at: Term) -> None:
        """Sets `root` to the crossing in a bracket (start, end, values there), or to an end that now has the sign of the other end.

        The absolute value of the quantity at `root` is left in the first of the `points`.
        """
        w, zoom = self.writer, self.zoom
        start, end, a, b = (zoom[at + k] for k in range(4))
        (x1, f1), (x2, f2), (x3, f3) = self.points
        self.put("rounds", 0)
        self.put("open", 1)
        self.put("root", start)
        self.part.put(0.5)
        with w.repeat(lambda: (self.get("open") > 0) & (self.get("rounds") < _ROUNDS)):
            rounds = self.get("rounds")
            within = x1.get() + self.part.get() * (x2.get() - x1.get())
            x = w.select(rounds < 1, start, w.select(rounds < 2, end, within))
            f = self.gap(e, x)
            f = w.select(f * 0.0 <= 0.0, f, _HUGE)
            with w.when(rounds < 1):
                for cell, value in ((x1, x), (f1, f), (x2, x), (f2, f)):
                    cell.put(value)
                self.finish((f * a) <= 0.0, x, f)
            with w.otherwise():
                same = (f * f1.get() > 0.0) & (rounds >= 2)
                with w.when(same):
                    x3.put(x1.get())
                    f3.put(f1.get())
                with w.otherwise():
                    for cell, before in ((x3, x2), (f3, f2), (x2, x1), (f2, f1)):
                        cell.put(before.get())
                x1.put(x)
                f1.put(f)
                self.finish((rounds < 2) & (((b <= 0.0) & (b >= 0.0)) | (f * a > 0.0)), x, f)
                with w.when(self.get("open") > 0):
                    self.next_share(a, end - start)
            self.put("rounds", rounds + 1)

    def finish(self, condition: Term, x: Term, f: Term) -> None:
        """Ends the search at x, where the quantity is f, if the condition holds."""
        with self.writer.when(condition):
            self.put("open", 0)
            self.put("root", x)
            self.points[0][1].put(self.writer.compute("abs", f))

    def next_share(self, a: Term, width: Term) -> None:
        """Chandrupatla's choice between inverse quadratic interpolation and bisection, or the end of the search.

        The search ends at a point beyond the crossing, so that a motion that continues there does not cross again. While the best
        point is before the crossing, the search continues to the last digit.
        """
        w = self.writer
        (x1, f1), (x2, f2), (x3, f3) = ((x.get(), f.get()) for x, f in self.points)
        first = w.compute("abs", f1) < w.compute("abs", f2)
        best, least = w.select(first, x1, x2), w.select(first, f1, f2)
        beyond = crossed(a, least)
        near = width * w.select(beyond, SAME_TIME, 4 * EPS)
        share = (near + 2 * EPS * w.compute("abs", best)) / w.compute("abs", x2 - x1)
        over = (share > 0.5) | ~(w.compute("abs", least) > 0.0)
        xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
        bent = (phi * phi < xi) & ((1.0 - phi) * (1.0 - phi) < 1.0 - xi)
        wished = f1 / (f2 - f1) * (f3 / (f2 - f3)) + (x3 - x1) / (x2 - x1) * (f1 / (f3 - f1)) * (f2 / (f3 - f2))
        inner = w.compute("max", w.compute("min", wished, 1.0 - share), share)
        self.part.put(w.select(bent, inner, 0.5))
        other, there = w.select(first, x2, x1), w.select(first, f2, f1)
        self.finish(over, w.select(beyond, best, other), w.select(beyond, least, there))

    def median(self, first: Term, others: Term) -> None:
        """Sets `usual` to the median of the nonzero absolute values that a quantity has at the nine places."""
        w, zoom = self.writer, self.zoom
        zoom[0] = first
        zoom.store(1, others)
        count, rank, total = (w.variable(f"median{k}_{len(w.cells)}") for k in range(3))
        count.put(0.0)
        total.put(0.0)
        with w.few(PARTS + 1) as i:
            count.put(count.get() + w.select(w.compute("abs", zoom[i]) > 0.0, 1.0, 0.0))
        with w.few(PARTS + 1) as i:
            mine = w.compute("abs", zoom[i])
            rank.put(0.0)
            with w.few(PARTS + 1) as j:
                other = w.compute("abs", zoom[j])
                smaller = (other < mine) | ((other <= mine) & (j < i))
                rank.put(rank.get() + w.select((other > 0.0) & smaller, 1.0, 0.0))
            middle = w.compute("abs", rank.get() * 2.0 - (count.get() - 1.0)) <= 1.0
            both = w.compute("abs", rank.get() * 2.0 - (count.get() - 1.0)) > 0.5
            total.put(total.get() + w.select((mine > 0.0) & middle, w.select(both, mine * 0.5, mine), 0.0))
        self.put("usual", total.get())

    def refuse_pole(self, e: Term) -> None:
        """Sets `root` to −1 if a quantity changes sign through infinity: it grows towards that point, beyond its usual size."""
        w, root = self.writer, self.get("root")
        sides, grows, near = (w.variable(f"pole{k}_{len(w.cells)}") for k in range(3))
        sides.put(0.0)
        grows.put(1.0)
        rounded = 4 * EPS
        with w.few(4) as k:
            # close to the root on the left, farther to the left, and the same on the right
            left, closer = k < 2, (k < 1) | ((k > 1) & (k < 3))
            apart = w.select(closer, _BESIDE[0] + rounded, _BESIDE[1] + rounded)
            far = _BESIDE[1] + rounded
            within = w.select(left, root - far, 1.0 - (root + far)) >= 0.0
            with w.when(within):
                size = w.compute("abs", self.gap(e, w.select(left, root - apart, root + apart)))
                with w.when(closer):
                    near.put(w.select(size <= _HUGE, size, _HUGE))
                    sides.put(sides.get() + 1.0)
                    with w.when(~(near.get() > self.get("usual"))):
                        grows.put(0.0)
                with w.otherwise(), w.when(~(near.get() > _GROWN * size)):
                    grows.put(0.0)
        with w.when((sides.get() > 0.0) & (grows.get() > 0.0)):
            self.put("root", -1.0)

    # ------------------------------------------------------------------------------------------------------ sorting

    def sort(self, near: Term) -> None:
        """Sorts crossings by time, simultaneous ones by event, up to the first that ends the motion or changes the state.

        Those within `near` after it belong to the same instant; `broken` is its share of the step, 2 if there is none.
        """
        w, met = self.writer, self.met
        place = w.variable("at_place", INT)
        with w.few(self.get("found"), 1) as i:
            share, which = met[i * 2], met[i * 2 + 1]
            place.put(i)
            with w.repeat(
                lambda: (
                    (place.get() > 0) & (met[w.select(place.get() > 0, place.get() * 2 + (-2), place.get())] > share)
                )
            ):
                at = place.get() * 2
                met[at] = met[at + (-2)]
                met[at + 1] = met[at + (-1)]
                place.put(place.get() + (-1))
            met[place.get() * 2] = share
            met[place.get() * 2 + 1] = which
        with w.few(self.get("found")) as i:
            breaks = self.kind(w.compute("int", met[i * 2 + 1])) >= float(EventKind.ENDS)
            with w.when(breaks & (met[i * 2] < self.get("broken"))):
                self.put("broken", met[i * 2])
        place.put(0)
        with w.few(self.get("found")) as i:
            place.put(place.get() + w.select(met[i * 2] <= self.get("broken") + near, w.integer(1), w.integer(0)))
        self.put("found", place.get())


def inspection_kernel() -> Kernel:
    """A kernel that writes all crossings in a step of another solver to `met`, and returns their number, −1 if there are too many.

    `values` has nine per quantity, from the beginning of the step to its end; `told` the number of steps of the motion and the share
    of a step that is one instant; `rests` becomes 1 for a quantity that stays at its threshold, whose crossings are dropped.
    """
    w = Writer("inspection")
    count, glance = w.number("events"), w.callee("glance", *RATE)
    values, least, told, rests = map(w.array, ("values", "least", "told", "rests"))

    def ask(share: Term, array: Array, place: Term) -> None:
        unused = [what.at(0) for what in (values, least, told, rests)]
        glance(share, *unused, array.at(place))

    c, back, before = Crossings(w, count, ask), w.variable("back", INT), w.variable("before", INT)
    c.clear()
    c.begin_search()
    with w.few(count) as e:
        before.put(c.get("found"))
        c.search(e, (values[e * (PARTS + 1)], values.lanes(e * (PARTS + 1) + 1, PARTS)), least[e], told[0])
        with w.when(c.get("asked") > 0):
            c.put("asked", 0)
            c.put("found", before.get())
            rests[e] = 1.0
    c.sort(told[1])
    back.put(w.select(c.get("full") > 0, w.integer(-1), c.get("found")))
    return w.finished(back)


def crossed(a: Term, b: Term) -> Term:
    """Whether the sign changes from a to b; a crossing at a zero belongs to the interval that ends there."""
    return ((a > 0.0) & (b <= 0.0)) | ((a < 0.0) & (b >= 0.0))


def bounds(w: Writer, first: Term, others: Term) -> tuple[Term, Term, Term]:
    """The Bernstein coefficients of a quantity at nine places but the first, a bound on the interpolation error, and its size."""
    each = [w.compute("splat8", x) for x in (first, *(w.compute("lane", others, lane=k) for k in range(PARTS)))]
    columns = [tuple(map(float, column)) for column in TO_BERNSTEIN[1:].T]
    coefficients = w.sum([x * column for x, column in zip(each, columns, strict=True)])
    last = [
        w.compute("abs", first * float(row[0]) + w.compute("sum", others * tuple(map(float, row[1:]))))
        for row in TO_LAST
    ]
    size = w.compute("max", w.compute("abs", first), w.compute("largest", w.compute("abs", others)))
    return coefficients, LEFT * w.compute("max", *last), size


def dips(w: Writer, array: Array, at: int, threshold: Term) -> Term:
    """Whether a corner may cross the threshold between two neighbours of nine values of one sign, stored in an array from `at` on.

    Overwrites the two entries before and after these.
    """
    end, level = at + PARTS, w.compute("splat8", threshold)
    for k in (1, 2):
        array[at - k] = array[at]
        array[end + k] = array[end]
    places = [array.lanes(k, PARTS) - level for k in range(at - 2, at + 4)]
    first, last = places[2:4]
    onward, backward = (
        w.sum([x * tuple(map(float, weights)) for x, weights in zip(side, table, strict=True)])
        for side, table in ((places[2::-1], TO_NEXT), (places[3:], TO_NEXT[:, ::-1]))
    )
    led = w.compute("min", onward * first, backward * last)
    return w.compute("largest", w.compute("min", first * last, -led)) > 0.0
