# SPDX-License-Identifier: BSD-3-Clause
"""Event detection along a step: possible crossings, from the values of the quantities at eight places; their times; actions.

A quantity that is proved to keep its sign is skipped. Crossings of the others are located (`crossings`) and recorded in `log`. The
first event that ends the motion or changes its state ends the step there: the states before it and after its actions are a row of
`jumps`. Python decides, with the tests of all methods (`hybrid.events`), what the kernel cannot: `EventKind.ASKED`, a quantity that
stays at its threshold, a side that no first derivative determines, a further event at the instant of an action.

The side of a switch is a parameter, −1 or 1; with a fixed side the rates are smooth across zero of its quantity. A step that would
cross zero is repeated up to there; then the switch changes sides. If its quantity returns at once, the switch changes back, and if
the motion does not continue on that side either, it continues on none.
"""

from collections.abc import Callable

from kane.motion.steppers.context import RATE, WIDE, ReturnCode, Slot, StepperContext
from kane.motion.steppers.crossings import KINDS, LEAVES, MET, Crossings, EventKind, bounds, dips
from kane.motion.steppers.held import ConstraintSolver
from kane.numeric.polynomials import CLOSE, SHARES, SMALL
from kane.numeric.polynomials import DEGREE as PARTS
from kane.numeric.scale import EPS, EQUAL, LATER, NEAR_TIME, ROUNDED, ROUNDED_TERMS, SAME_TIME, SOON, UNRELATED
from kane.program.kernel.language import INT
from kane.program.kernel.writer import Array, Term

PLACES = SHARES[1:]
"""Shares of a step at which event quantities are evaluated, without its beginning."""
ROOM = 3 * PARTS
"""Index of the quantities in `values`."""
LOOSE = 1e-2
"""A pivot of W counts as zero below this share of rtol, or below rounding, times the largest value that it has had."""
LOG, JUMPS = 1024, 64
"""Capacities of `log` and `jumps`, which Python empties."""
Dense = Callable[[Term, Array, Term], None]
"""Writes the state at a share of the step into an array, from an index on."""
_AIMED, _SHORTER, _BACK = 1, 2, 3
"""Why a step is repeated: it is to end at a switching time; it is too long to show to which side one leads; switches change back."""


class Watched:
    """The kernel's arguments for events, and the inspection of a step.

    `seen` contains the event quantities at the beginning of the step, `largest` their largest absolute values so far; thresholds are
    `least` plus `shares` of `largest`. `pivots` is 1 for those that must not come near zero. `values` has room for 9 of each and 32
    more. If `wide`, the routine of the quantities takes the eight places at once, else one state; `glance` takes one state and
    returns the quantities and the sizes of their terms, `tendency` the rates of the `own` ones along the motion, and `act` the values
    that actions assign: a row of `actions` has the event and the index of the value, in the state or, beyond it, in the parameters;
    −1 requires a positive value. With constraints, speeds that no action assigns are solved for. `dense` is the state along the step,
    `held` the constraint solver.

    If `sided`, the quantities after those of events belong to switches, whose sides are in p from `sides_at` on. `turns` contains for
    each whether it changes sides, whether it came back, and its last value.
    """

    def __init__(
        self, context: StepperContext, wide: bool, dense: Dense, held: ConstraintSolver | None, sided: bool
    ) -> None:
        self.context, self.dense, self.held = context, dense, held
        self.writer = w = context.writer
        self.call, self.h = w.callee("watch", *(WIDE if wide else RATE)), w.hoisted("hw")
        self.glance, self.tendency, self.act = (
            (w.callee(name, *RATE), w.hoisted(f"h{name[0]}")) for name in ("glance", "tendency", "act")
        )
        self.count, self.own, self.acts = map(w.number, ("events", "own", "acts"))
        names = ("seen", "largest", "least", "shares", "pivots", "values", "doubts", "probe")
        self.seen, self.largest, self.least, self.shares, self.pivots, self.values, self.doubts, self.probe = map(
            w.array, names
        )
        self.actions, self.log, self.jumps, self.instant = map(w.array, ("actions", "log", "jumps", "instant"))
        self.doubtful, self.rests = w.variable("doubtful", INT), w.variable("asked_before", INT)
        self.before = w.variable("found_before", INT)
        self.crossings = Crossings(w, self.count, self.ask)
        self.sided = sided
        if sided:
            context.turned = w.variable("turned", INT)
            self.turns, self.sides_at = w.array("turns"), w.number("sides_at")
            self.again, self.rounds, self.verdict = (
                w.variable(name, INT) for name in ("sides_again", "sides_round", "verdict")
            )
            self.first_turn = w.variable("first_turn")
        self.begin, self.length = w.variable("step_begin"), w.variable("step_length")
        # in `instant`: quantities and sizes after actions, rows of `leaves`, rates before and after, quantities before, values set
        self.rows = self.count * 2
        self.before_rates = self.rows + self.own * LEAVES
        self.after_rates = self.before_rates + self.own
        self.was = self.after_rates + self.own
        self.set_at = self.was + self.count * 2
        self.bound = self.set_at + self.acts  # per speed: 0 is solved for, 1 unchanged, 2 assigned
        self.kept_p = self.bound + context.n  # previous values of assigned parameters
        self.kept_sides = self.kept_p + self.acts
        self.renews = w.variable("renews", INT)

    # --------------------------------------------------------------------------------------------------- detection

    def look(self, clock: Term, states: Term) -> None:
        """Sets `doubtful` if there may be an event; in `work`, states at the eight places are at `states`, their times at `clock`."""
        o = self.context
        o.follow(o.work.at(clock), o.work.at(states))
        self.call(*(o.work.at(x) for x in (clock, states)), o.p.at(0), o.r.at(0), self.h.at(0), self.values.at(ROOM))
        self.compare()

    def look_along(self, t: Term, h: Term, place: Term, end: Term) -> None:
        """The same with one state at a time, written into `work` at an index; the last one is at `end`, where the motion continues."""
        w, o = self.writer, self.context
        one = (self.count + 3) * PARTS
        shares = one + self.count
        self.values.store(shares, w.lanes(*PLACES))
        with w.few(PARTS) as k:
            share = self.values[shares + k]
            self.dense(share, o.work, place)
            with w.when(k >= PARTS - 1), w.count(o.n) as i:
                o.work[place + i] = o.work[end + i]
            o.drive(t + share * h, o.work.at(place))
            self.call(t + share * h, o.work.at(place), o.p.at(0), o.r.at(0), self.h.at(0), self.values.at(one))
            with w.few(self.count) as e:
                self.values[e * PARTS + k + ROOM] = self.values[one + e]
        self.compare()

    def compare(self) -> None:
        """Marks in `doubts` the quantities that may cross their thresholds or, as pivots, vanish, by the values at the places."""
        w = self.writer
        self.doubtful.put(0)
        with w.count(self.count) as e:
            new = self.at_nodes(e)
            # shifted by one, after the value at the beginning: `old` is the value one place before
            self.values[PARTS - 1] = self.seen[e]
            self.values.store(PARTS, new)
            old = self.values.lanes(PARTS - 1, PARTS)
            least = self.threshold(e)
            coefficients, slack, size = bounds(w, self.seen[e] - least, new - w.compute("splat8", least))
            lowest = w.compute("min", self.seen[e] - least, -w.compute("largest", -coefficients))
            highest = w.compute("max", self.seen[e] - least, w.compute("largest", coefficients))
            corner = dips(w, self.values, PARTS - 1, least)
            sure = (slack <= CLOSE * size) & ~corner & ((lowest > slack) | (highest < -slack))
            closest = -w.compute("largest", -w.compute("min", w.compute("abs", old), w.compute("abs", new)))
            gone = w.compute("max", self.context.get(Slot.RTOL) * LOOSE, UNRELATED) * self.size(e)
            away = sure & (w.compute("max", lowest, -highest) - slack > gone)
            near = (self.pivots[e] > 0.0) & (closest < SMALL * self.size(e)) & ~away
            self.doubts[e] = w.select(~sure | near, 1.0, 0.0)
            with w.when(~sure | near):
                self.doubtful.put(1)

    def size(self, e: Term) -> Term:
        """The largest absolute value of a quantity so far, including the step."""
        w = self.writer
        size = w.compute(
            "max", w.compute("largest", w.compute("abs", self.at_nodes(e))), w.compute("abs", self.seen[e])
        )
        return w.select(size > self.largest[e], size, self.largest[e])

    def threshold(self, e: Term) -> Term:
        """The threshold of an event."""
        return self.least[e] + self.shares[e] * self.size(e)

    def at_nodes(self, e: Term) -> Term:
        """The quantity of an event at the eight places."""
        return self.values.lanes(e * PARTS + ROOM, PARTS)

    # ---------------------------------------------------------------------------------------------------- location

    def ask(self, share: Term, array: Array, place: Term) -> None:
        """Writes the quantities at a share of the step, then the sizes of their terms."""
        t = self.begin.get() + share * self.length.get()
        self.dense(share, self.probe, self.writer.integer(0))
        self.at_state(self.glance, t, (self.probe, self.writer.integer(0)), (array, place))

    def at_state(
        self, routine: tuple[Callable[..., None], Array], t: Term, state: tuple[Array, Term], to: tuple[Array, Term]
    ) -> None:
        """Calls a routine with one state, copied to `probe`: all lanes must pass routines the same index."""
        o, (call, h), (array, at), (out, place) = self.context, routine, state, to
        if array is not self.probe:
            with self.writer.count(o.n) as i:
                self.probe[i] = array[at + i]
        o.drive(t, self.probe.at(0), single=True)
        call(t, self.probe.at(0), o.p.at(0), o.single_r.at(0), h.at(0), out.at(place))

    def decide(self, t: Term, h: Term, last: Term) -> None:
        """Locates the crossings in a step of length h from t that was inspected; sets `asks` if the step is not accepted."""
        w, o, c = self.writer, self.context, self.crossings
        c.clear()
        if self.sided:
            self.verdict.put(0)
            with w.when(last & (o.get(Slot.TURNING) > 0.0)), w.few(self.own) as e, w.when(self.expected(e)):
                self.doubts[e] = 1.0
                self.doubtful.put(1)
        with w.when((self.doubtful.get() > 0) & (o.get(Slot.LOOKED) < 2.0)):
            self.begin.put(t + o.get(Slot.TIME_LAG))
            self.length.put(h)
            c.begin_search()
            with w.few(self.count) as e, w.when(self.doubts[e] > 0.0):
                with w.when(c.kind(e) >= float(EventKind.ASKED)):
                    c.put("asked", 1)
                with w.otherwise():
                    if self.sided:
                        with w.when(self.turning(e) & (c.leaf(e, 0) > 0.0)):
                            self.leave_zero(e, h)
                    self.rests.put(c.get("asked"))
                    self.before.put(c.get("found"))
                    c.put("asked", 0)
                    c.search(e, (self.seen[e], self.at_nodes(e)), self.threshold(e), self.steps_since(t, h))
                    if self.sided:
                        with w.when(e < self.own):
                            self.meet_expected(e, last)
                        with w.when(self.turning(e) & (c.get("asked") > 0)):
                            self.decided(int(ReturnCode.RESTS), e)
                            c.put("asked", 0)
                    with w.when(self.rests.get() > 0):
                        c.put("asked", 1)
            if self.sided:  # beyond a switching time other quantities are unknown
                self.turn(h)
            c.sort(2 * SAME_TIME + 4 * EPS * w.compute("abs", t) / h)
            full = o.get(Slot.LOGGED) + w.compute("float", c.get("found")) > float(LOG)
            with w.when(~(o.asks.get() > 0)):
                with w.when(full | (o.get(Slot.JUMPS) + 1.0 > float(JUMPS))):
                    o.asks.put(ReturnCode.FULL)
                with w.when((c.get("asked") > 0) | (c.get("full") > 0)):
                    o.asks.put(ReturnCode.LOOK)

    # -------------------------------------------------------------------------------------------------- switches

    def turning(self, e: Term) -> Term:
        """Whether a quantity is that of a switch."""
        kind = self.crossings.kind(e)
        return (kind >= float(EventKind.TURNS)) & (kind < float(EventKind.ENDS))

    def side_index(self, e: Term) -> Term:
        """The index in p of the side of a switch."""
        return self.sides_at + e - self.own

    def mark(self, row: int, e: Term) -> Term:
        """An index in `turns`. Rows for a switch: 0 whether it changes sides, 1 whether it came back, 2 its last value.

        For an event: 0 whether it occurs at a switching time, 1 whether it was recorded before it crosses, 2 its last distance.
        """
        return self.count * row + e

    def expected(self, e: Term) -> Term:
        """Whether an event was located at the switching time up to which the step is repeated."""
        return self.turns[self.mark(0, e)] > 0.0

    def meet_expected(self, e: Term, last: Term) -> None:
        """Records an expected event at the end of a step that does not quite reach its threshold; drops the crossing after that."""
        w, c, passed = self.writer, self.crossings, self.crossings.get("found") > self.before.get()
        early, none = self.turns[self.mark(1, e)] > 0.0, ~passed & ~(c.get("asked") > 0)
        with w.when(early & passed):
            c.drop(self.before.get())
        with w.when(~early & none & last & (self.context.get(Slot.TURNING) > 0.0) & self.expected(e)):
            c.meet(w.constant(1.0), e)

    def keep_early(self, e: Term, gap: Term) -> None:
        """An event that was recorded before its crossing still has to cross while its distance from the threshold decreases."""
        early, left, size = self.turns[self.mark(1, e)], self.mark(2, e), self.writer.compute("abs", gap)
        before = (gap * (self.seen[e] - self.threshold(e)) > 0.0) & ((early > 1.5) | (size <= self.turns[left]))
        self.turns[self.mark(1, e)] = self.writer.select((early > 0.0) & before, 1.0, 0.0)
        self.turns[left] = size

    def decided(self, verdict: int, e: Term) -> None:
        """Sets the verdict on the step, for a switch, unless a more important one is set."""
        with self.writer.when(self.verdict.get() < verdict):
            self.verdict.put(verdict)
            if verdict > _BACK:
                self.context.put(Slot.WORST, self.writer.compute("float", e))

    def leave_zero(self, e: Term, h: Term) -> None:
        """Tests whether a switch's quantity that is zero at the beginning of the step leaves to its side."""
        w, o, c = self.writer, self.context, self.crossings
        c.put("threshold", 0.0)
        side = -c.direction(e)
        largest = w.compute(
            "max", w.compute("abs", self.seen[e]), w.compute("largest", w.compute("abs", self.at_nodes(e)))
        )
        soon, later = side * c.gap(e, w.constant(LATER)), side * c.gap(e, w.constant(SOON))
        rests = ~(largest > 0.0) | (w.compute("abs", soon) <= ROUNDED * largest)
        with w.when(rests):
            self.decided(int(ReturnCode.RESTS), e)
        with w.otherwise(), w.when(soon < 0.0):
            with w.when((later > 0.0) & (h * LATER > 2.0 * o.shortest())):
                self.decided(_SHORTER, e)
            with w.otherwise():
                with w.when((later > 0.0) | (self.turns[self.mark(1, e)] > 0.0)):
                    self.decided(int(ReturnCode.STANDS), e)
                with w.otherwise():
                    self.turns[self.mark(0, e)] = 2.0
                    self.decided(_BACK, e)

    def turn(self, h: Term) -> None:
        """Decides on a step in which switches change sides."""
        w, o, c = self.writer, self.context, self.crossings
        self.first_turn.put(2.0)
        with w.few(c.get("found")) as k:
            turns = self.turning(w.compute("int", c.met[k * 2 + 1])) & (c.met[k * 2] < self.first_turn.get())
            self.first_turn.put(w.select(turns, c.met[k * 2], self.first_turn.get()))
        with w.when(self.first_turn.get() < 1.0 - self.near_time(h)):
            self.decided(_AIMED, w.integer(0))
        with w.when((self.verdict.get() > 0) & (self.verdict.get() <= _BACK)):
            self.take_again(h)
        with w.when(self.verdict.get() > _BACK):
            with w.when(self.verdict.get() > int(ReturnCode.STANDS)):
                o.asks.put(ReturnCode.RESTS)
            with w.otherwise():
                o.asks.put(ReturnCode.STANDS)

    def near_time(self, h: Term) -> Term:
        """The share of a step of length h within which switching times are one, at least the rounding of the time."""
        return NEAR_TIME + 4 * EPS * self.writer.compute("abs", self.begin.get()) / h

    def take_again(self, h: Term) -> None:
        """Repeats the step: shorter, on other sides, or up to a switching time."""
        w, o, c = self.writer, self.context, self.crossings
        o.asks.put(ReturnCode.AGAIN)
        back, aimed = self.verdict.get() >= _BACK, self.verdict.get() < _SHORTER
        with w.when(~aimed):
            self.no_end()
            # after a change back, fixed steps keep their size, and others choose one
            o.put(Slot.STEP, w.select(back, o.get(Slot.STEP) if o.fixed else 0.0, h * LATER))
        with w.few(self.count) as e:
            returned = back & (self.turns[self.mark(0, e)] > 1.5)
            self.turns[self.mark(0, e)] = w.select(returned, 1.0, 0.0)
            self.turns[self.mark(1, e)] = w.select(returned, 1.0, self.turns[self.mark(1, e)])
        with w.when(back):
            self.begin_on_other_sides()
            o.put(Slot.LOOKED, 0.0)
        with w.when(aimed):
            with w.few(c.get("found")) as k:
                at, near = c.met[k * 2] - self.first_turn.get(), self.near_time(h)
                which = w.compute("int", c.met[k * 2 + 1])
                with w.when((self.turning(which) | (at >= -near)) & (at <= near)):
                    self.turns[self.mark(0, which)] = 1.0
            with w.when(self.first_turn.get() * h <= o.shortest()):
                self.no_end()
                self.begin_on_other_sides()
            with w.otherwise():
                with w.when(o.get(Slot.TURNING) < 1.0):
                    o.put(Slot.BEYOND, o.get(Slot.END))
                    o.put(Slot.TURNING, 1.0)
                o.put(Slot.END, self.begin.get() + self.first_turn.get() * h)

    def begin_on_other_sides(self) -> None:
        """Restarts the step with the marked switches on their other sides."""
        self.context.put(Slot.SIDED, 2.0)
        self.context.begin_step_anew()

    def no_end(self) -> None:
        """Restores the end after one that was a switching time."""
        o = self.context
        with self.writer.when(o.get(Slot.TURNING) > 0.0):
            o.put(Slot.END, o.get(Slot.BEYOND))
            o.put(Slot.TURNING, 0.0)

    def settle(self) -> None:
        """Sets the sides of switches from the current state, or changes those marked, then those whose quantities jump across zero."""
        w, o, c = self.writer, self.context, self.crossings
        values, turned = self.was, o.get(Slot.SIDED) > 1.0
        known = (o.get(Slot.SIDED) > 0.0) & ~turned
        self.again.put(w.select(known, w.integer(0), w.integer(1)))
        self.rounds.put(0)
        with w.repeat(lambda: (self.again.get() > 0) & (self.rounds.get() < self.count + 2)):
            self.again.put(0)
            t = o.get(Slot.TIME)
            self.at_state(self.glance, t, (o.y, w.integer(0)), (self.instant, values))
            with w.few(self.count, self.own) as e:
                value, side, before = self.instant[values + e], -c.direction(e), self.turns[self.mark(2, e)]
                size = w.compute("max", w.compute("abs", value), w.compute("abs", before))
                leapt = (w.compute("abs", value - before) > EQUAL * size) & (value * side < 0.0)
                marked = self.turns[self.mark(0, e)] > 0.0
                turns = (
                    w.select(self.rounds.get() < 1, w.select(marked, 1.0, 0.0), w.select(~marked & leapt, 1.0, 0.0))
                    > 0.0
                )
                new = w.select(turned, w.select(turns, -side, side), w.select(value < 0.0, -1.0, 1.0))
                self.turns[self.mark(2, e)] = value
                with w.when((new * side < 0.0) | ((self.rounds.get() < 1) & ~turned)):
                    self.again.put(1)
                    self.p_side(e, new)
            with w.when(self.again.get() > 0):
                w.rehoist(o.p)
            self.rounds.put(self.rounds.get() + 1)
        # events keep `seen`: at a breakpoint they may cross between the end of one step and the beginning of the next
        with w.few(self.count, self.own) as e, w.when(~known):
            value = self.instant[values + e]
            fresh = w.select(turned, self.turns[self.mark(0, e)] > 0.0, w.compute("abs", value) <= 0.0)
            self.seen[e] = w.select(fresh, 0.0, value)
            leaves = (w.constant(1.0), -c.direction(e), w.constant(1.0), w.constant(0.0), w.constant(LATER))
            for k, x in enumerate(leaves):
                c.leaves[e * LEAVES + k] = w.select(fresh, x, 0.0)
            self.turns[self.mark(0, e)] = 0.0
            with w.when(~turned):
                self.turns[self.mark(1, e)] = 0.0
        with w.few(self.own) as e, w.when(~known):
            self.turns[self.mark(0, e)] = 0.0
            with w.when(~turned):
                self.turns[self.mark(1, e)] = 0.0
        o.put(Slot.SIDED, 1.0)

    def p_side(self, e: Term, side: Term) -> None:
        """Sets the side of a switch; its quantity crosses in the direction that leaves it."""
        self.context.p[self.side_index(e)] = side
        self.crossings.kinds[e * KINDS + 1] = -side

    def steps_since(self, t: Term, h: Term) -> Term:
        """The number of steps of this size since the start or the last action; beyond any bound for the shortest ones."""
        o = self.context
        return self.writer.select(h < o.get(Slot.SPAN) * NEAR_TIME, 2 / NEAR_TIME, (t - o.get(Slot.PHASE)) / h + 2.0)

    @property
    def breaks(self) -> Term:
        """Whether an event ends the step."""
        return self.crossings.get("broken") <= 1.0

    def note(self, ended: tuple[Term, Term] | None = None) -> None:
        """Logs the crossings, those at the share where the step has `ended` at its time; marks switches there to change sides."""
        w, o, c = self.writer, self.context, self.crossings
        with w.few(c.get("found")) as k:
            which = w.compute("int", c.met[k * 2 + 1])
            with w.when(which < self.own):
                at = w.compute("int", o.get(Slot.LOGGED)) * 2
                share, t = c.met[k * 2], self.begin.get() + c.met[k * 2] * self.length.get()
                t = w.compute("min", t, o.get(Slot.END))
                if ended is not None:
                    t = w.select((share >= ended[0]) & (share <= ended[0]), ended[1], t)
                self.log[at] = t
                self.log[at + 1] = c.met[k * 2 + 1]
                o.more(Slot.LOGGED, 1.0)
            if self.sided and o.turned is not None:
                with w.when(self.turning(which)):
                    self.turns[self.mark(0, which)] = 1.0
                    o.turned.put(1)

    def keep(self) -> None:
        """Takes the values at the end of the step as those at the beginning of the next one."""
        w, c = self.writer, self.crossings
        if self.sided:
            with w.few(c.get("found")) as k:
                which = w.compute("int", c.met[k * 2 + 1])
                with w.when((c.met[k * 2] >= 1.0) & (which < self.own)):
                    self.turns[self.mark(1, which)] = 2.0
        with w.count(self.count) as e:
            self.largest[e] = self.size(e)
            last = self.values[e * PARTS + (ROOM + PARTS - 1)]
            inside = w.compute("abs", last - self.threshold(e)) < c.leaf(e, 3)
            with w.when(~inside):
                for j in range(LEAVES):
                    c.leaves[e * LEAVES + j] = 0.0
            if self.sided:
                with w.when(e < self.own):
                    self.keep_early(e, last - self.threshold(e))
                with w.otherwise():
                    self.turns[self.mark(1, e)] = 0.0
            self.seen[e] = last
        self.note()

    def turned(self) -> None:
        """After an accepted step that ended at a switching time, restarts on the other sides."""
        o = self.context
        if self.sided and o.turned is not None:
            with self.writer.when(o.turned.get() > 0):
                o.turned.put(0)
                o.put(Slot.SINCE, 0.0)
                self.begin_on_other_sides()

    # ----------------------------------------------------------------------------------------------------- actions

    def jump(self, sampled: Callable[[Term, Term], None]) -> None:
        """Ends the step at the first event that ends the motion or changes its state, and continues from there."""
        w, o, c = self.writer, self.context, self.crossings
        share = c.get("broken")
        width = o.n * 2 + 2
        row = w.compute("int", o.get(Slot.JUMPS)) * width
        before, after = row + 2, row + o.n + 2
        t = w.compute("min", self.begin.get() + share * self.length.get(), o.get(Slot.END))
        self.dense(share, self.jumps, before)
        if self.held is not None:
            self.held.project(t, self.jumps, before)
        acting, ends = w.variable("acting", INT), w.variable("ends", INT)
        acting.put(0)
        ends.put(0)
        with w.few(c.get("found")) as k:
            kind = c.kind(w.compute("int", c.met[k * 2 + 1]))
            self.at_once(k, lambda: acting.put(1), kind >= float(EventKind.ACTS))
        with w.when(acting.get() > 0):
            self.take_actions(t, before, after)
        with w.otherwise(), w.count(o.n) as i:
            self.jumps[after + i] = self.jumps[before + i]
        with w.few(c.get("found")) as k:
            self.at_once(k, lambda: ends.put(1), c.kinds[w.compute("int", c.met[k * 2 + 1]) * KINDS + 3] > 0.0)
        with w.when(c.get("asked") > 0):
            o.back.put(int(ReturnCode.LOOK))
            with w.when((acting.get() > 0) & (self.renews.get() > 0)):
                with w.few(self.acts) as k, w.when(self.sets_parameter(k)):
                    o.p[self.place(k) - o.n] = self.instant[self.kept_p + k]
                if self.sided:
                    with w.few(self.count, self.own) as e:
                        self.p_side(e, self.instant[self.kept_sides + e - self.own])
                w.rehoist(o.p)
        with w.otherwise():
            o.sample(self.length.get(), lambda: None, sampled, t)
            self.jumps[row] = t
            self.note((share, t))
            self.jumps[row + 1] = o.get(Slot.LOGGED)
            o.more(Slot.JUMPS, 1.0)
            self.begin_anew(t, after)
            with w.when(acting.get() > 0), w.count(self.own) as e:
                self.seen[e] = self.instant[e]
                self.largest[e] = w.compute("abs", self.instant[e])
                for j in range(LEAVES):
                    c.leaves[e * LEAVES + j] = self.instant[self.rows + e * LEAVES + j]
            with w.when(ends.get() > 0):
                o.back.put(int(ReturnCode.EVENT))
            with w.otherwise(), w.when((acting.get() > 0) & self.is_late(t)):
                self.be_at_the_end()

    def is_late(self, t: Term) -> Term:
        """Whether a time is too close to the end for another step, and counts as the end."""
        o = self.context
        return o.get(Slot.END) - t <= 10.0 * o.shortest()

    def be_at_the_end(self) -> None:
        """Takes the current state as that of the end, and of the samples up to there."""
        w, o = self.writer, self.context
        o.put(Slot.TIME, o.get(Slot.END))
        with w.repeat(lambda: self.is_behind(o.get(Slot.END))):
            row = w.compute("int", o.get(Slot.SAMPLE)) * o.n
            with w.count(o.n) as i:
                o.rows[row + i] = o.y[i]
            o.more(Slot.SAMPLE, 1.0)
        o.arrive()

    def is_behind(self, t: Term) -> Term:
        """Whether the next sample is no later than a time."""
        w, o, at = self.writer, self.context, self.context.get(Slot.SAMPLE)
        return (at < w.compute("float", o.samples)) & (o.times[w.compute("int", at)] <= t)

    def at_once(self, k: Term, do: Callable[[], None], condition: Term) -> None:
        """Runs `do` if the kth crossing is of the instant of the first that breaks, and the condition holds."""
        c = self.crossings
        near = 2 * SAME_TIME + 4 * EPS * self.writer.compute("abs", self.begin.get()) / self.length.get()
        with self.writer.when((c.met[k * 2] >= c.get("broken") - near) & condition):
            do()

    def begin_anew(self, t: Term, after: Term) -> None:
        """Continues the motion from a time and a state."""
        w, o = self.writer, self.context
        o.put(Slot.TIME, t)
        o.put(Slot.TIME_LAG, 0.0)
        o.put(Slot.LAST_STEP, self.crossings.get("broken") * self.length.get())
        o.begin_step_anew()
        o.put(Slot.SINCE, t - o.get(Slot.PHASE))
        o.put(Slot.PHASE, t)
        o.put(Slot.LOOKED, 0.0)
        o.more(Slot.STEPS, 1.0)
        o.count_taken()
        with w.count(o.n) as i:
            o.y[i] = self.jumps[after + i]
            o.lag[i] = 0.0
        if self.held is not None:
            o.put(Slot.MEASURED, 0.0)
            o.put(Slot.HELD, 0.0)
        if self.sided and o.turned is not None:
            self.no_end()
            o.turned.put(0)
            o.put(Slot.SIDED, 0.0)
        with w.repeat(lambda: self.is_behind(t)):
            o.more(Slot.SAMPLE, 1.0)

    def take_actions(self, t: Term, before: Term, after: Term) -> None:
        """Computes the state after the actions, all evaluated before them; sets `asked` if the result is uncertain.

        `instant` receives the quantities before and after, with the sizes of their terms, and the new rows of `leaves`. A switch
        whose quantity is then zero is left to Python.
        """
        w, o, c = self.writer, self.context, self.crossings
        own = self.own
        self.at_state(self.tendency, t, (self.jumps, before), (self.instant, self.before_rates))
        self.at_state(self.glance, t, (self.jumps, before), (self.instant, self.was))
        with w.count(o.n) as i:
            self.jumps[after + i] = self.jumps[before + i]
        # from here on `doubts` marks the events of this instant: 2, and 3 if they act
        with w.few(own) as e:
            self.doubts[e] = 0.0
        with w.few(c.get("found")) as k:
            which = w.compute("int", c.met[k * 2 + 1])
            acts = w.select(c.kind(which) >= float(EventKind.ACTS), 3.0, 2.0)

            def mark(which: Term = which, acts: Term = acts) -> None:
                self.doubts[which] = acts

            self.at_once(k, mark, c.kind(which) < float(EventKind.ASKED))
        self.set_values(t, before, after)
        self.set_parameters()
        if self.held is not None:
            self.follow(t, after)
        if self.sided:
            self.turn_over(t, after)
        self.at_state(self.glance, t, (self.jumps, after), (self.instant, w.integer(0)))
        self.at_state(self.tendency, t, (self.jumps, after), (self.instant, self.after_rates))
        with w.few(own) as e:
            self.leave(e, self.instant[self.was + e] - self.least[e], t)
        if self.sided:
            with w.few(self.count, own) as e, w.when(self.instant[e] * c.direction(e) >= 0.0):
                c.put("asked", 1)
        short = t - o.get(Slot.PHASE) <= SAME_TIME * w.compute("max", w.compute("abs", t), o.get(Slot.SPAN))
        with w.when(short):
            c.put("asked", 1)
        if self.sided:
            with w.when((o.get(Slot.TURNING) > 0.0) & self.is_late(t)):
                c.put("asked", 1)

    def set_values(self, t: Term, before: Term, after: Term) -> None:
        """Assigns the values of the events of this instant; inadmissible ones, and two for one index, are left to Python."""
        w, c = self.writer, self.crossings
        place = self.set_at
        self.at_state(self.act, t, (self.jumps, before), (self.instant, place))
        with w.few(self.acts) as k:
            event, slot = (w.compute("int", self.actions[k * 2 + j]) for j in (0, 1))
            value = self.instant[place + k]
            with w.when(self.doubts[event] > 2.5):
                with w.when((slot >= 0) & (slot < self.context.n)):
                    self.jumps[after + slot] = value
                with w.when(~(value * 0.0 <= 0.0) | ((slot < 0) & ~(value > 0.0))):
                    c.put("asked", 1)
                with w.few(self.acts) as j:
                    other, same = (w.compute("int", self.actions[j * 2 + i]) for i in (0, 1))
                    apart = (value < self.instant[place + j]) | (value > self.instant[place + j])
                    with w.when((self.doubts[other] > 2.5) & same.equals(slot) & (slot >= 0) & apart):
                        c.put("asked", 1)

    def place(self, k: Term) -> Term:
        """The index of the kth value that actions assign."""
        return self.writer.compute("int", self.actions[k * 2 + 1])

    def acts_now(self, k: Term) -> Term:
        """Whether an event of this instant assigns the kth value."""
        return self.doubts[self.writer.compute("int", self.actions[k * 2])] > 2.5

    def sets_parameter(self, k: Term) -> Term:
        """Whether an event of this instant assigns the kth value, to a parameter."""
        return self.acts_now(k) & (self.place(k) >= self.context.n)

    def set_parameters(self) -> None:
        """Assigns parameters and updates the hoisted values; keeps the previous values."""
        w, o = self.writer, self.context
        self.renews.put(0)
        with w.few(self.acts) as k, w.when(self.sets_parameter(k)):
            self.instant[self.kept_p + k] = o.p[self.place(k) - o.n]
            self.renews.put(1)
        with w.when(self.renews.get() > 0):
            with w.few(self.acts) as k, w.when(self.sets_parameter(k)):
                o.p[self.place(k) - o.n] = self.instant[self.set_at + k]
            w.rehoist(o.p)

    def turn_over(self, t: Term, after: Term) -> None:
        """Sets the sides of switches from the state after the actions."""
        w, c = self.writer, self.crossings
        self.at_state(self.glance, t, (self.jumps, after), (self.instant, w.integer(0)))
        self.again.put(0)
        with w.few(self.count, self.own) as e:
            value, side = self.instant[e], -c.direction(e)
            self.instant[self.kept_sides + e - self.own] = side
            with w.when(~(w.compute("abs", value) > ROUNDED_TERMS * self.instant[self.count + e])):
                c.put("asked", 1)
            with w.when(value * side < 0.0):
                self.p_side(e, -side)
                self.again.put(1)
        with w.when(self.again.get() > 0):
            self.renews.put(1)
            w.rehoist(self.context.p)

    def follow(self, t: Term, after: Term) -> None:
        """Solves for the dependent speeds, or for all that are not assigned if as many are assigned as are independent."""
        w, held = self.writer, self.held
        assert held is not None
        free = w.variable("unset", INT)
        free.put(held.s - held.d)
        with w.few(held.s) as j:
            self.instant[self.bound + j] = 1.0
        with w.few(held.d) as j:
            self.instant[self.bound + held.index(held.dependent, j)] = 0.0
        with w.few(self.acts) as k:
            j = self.place(k) - held.coordinates
            with w.when(self.acts_now(k) & (j >= 0) & (j < held.s)):
                with w.when(self.instant[self.bound + j] < 1.5):
                    free.put(free.get() - 1)
                self.instant[self.bound + j] = 2.0
        with w.when(free.get() < 1), w.few(held.s) as j:
            now = self.instant[self.bound + j]
            self.instant[self.bound + j] = w.select(now > 1.5, now, 0.0)
        held.follow(t, (self.jumps, after), (self.instant, self.bound))
        with w.when(held.doubt.get() > 0):
            self.crossings.put("asked", 1)

    def leave(self, e: Term, a: Term, t: Term) -> None:
        """How a quantity, at a relative to its threshold before the actions, leaves it after them, or that it jumps across."""
        w, c = self.writer, self.crossings
        b, size = self.instant[e] - self.least[e], self.instant[self.count + e]
        old, new = self.instant[self.before_rates + e], self.instant[self.after_rates + e]
        way, row = c.direction(e), self.rows + e * LEAVES
        for k in range(LEAVES):
            self.instant[row + k] = 0.0
        mine = c.kinds[e * KINDS + 2] > 0.0
        there, finite = self.doubts[e] > 1.5, (b * 0.0 <= 0.0)
        side = w.variable(f"leaving{len(w.cells)}")
        came = w.select(way > 0.0, -1.0, w.select(way < 0.0, 1.0, w.select(old > 0.0, -1.0, 1.0)))
        side.put(w.select(new * came > -EQUAL * w.compute("abs", old), came, 0.0))
        moving = (w.compute("abs", old) > 0.0) & (w.compute("abs", new) > 0.0) & (old * came <= 0.0)
        falls, rises = (a > 0.0) & (b <= 0.0) & (way <= 0.0), (a < 0.0) & (b >= 0.0) & (way >= 0.0)
        leapt = ~there & (falls | rises)
        beside = ~there & (w.compute("abs", b) <= ROUNDED_TERMS * size)
        with w.when(mine & leapt):
            side.put(0.0)
            at = w.compute("int", w.compute("float", c.get("found")))
            c.met[at * 2] = c.get("broken")
            c.met[at * 2 + 1] = w.compute("float", e)
            c.put("found", at + 1)
        with w.when(mine & (there | leapt)):
            self.instant[row + 1] = side.get()
            # the error of the event's time bounds how far beyond its threshold the quantity may be
            apart = self.length.get() * SAME_TIME + w.compute("abs", t) * (8 * EPS)
            near = there & (side.get() * b < 0.0) & (w.compute("abs", b) <= 2.0 * w.compute("abs", a))
            near = near & (w.compute("abs", a) <= w.compute("abs", old) * apart)
            band = w.select(near, 2.0 * w.compute("abs", b), 0.0)
            for k, value in ((0, 1.0), (2, 1.0), (3, band), (4, LATER)):
                self.instant[row + k] = value
        goes_on = (c.kind(e) < float(EventKind.ENDS)) & ~(w.compute("abs", new) > 0.0)
        unsure = (there & ~moving) | (leapt & ((c.kind(e) >= float(EventKind.ACTS)) | goes_on)) | beside
        with w.when((mine & unsure) | ~finite):
            c.put("asked", 1)


def rooms(count: int, own: int, acts: int, n: int) -> dict[str, int]:
    """The lengths of the arrays of `Watched`, by the numbers of quantities, events, assigned values and components."""
    return {
        "values": count * (PARTS + 1) + 4 * PARTS,
        "doubts": count + 1,
        "probe": n,
        "met": 2 * (MET + own),
        "log": 2 * (LOG + own),
        "jumps": (2 * n + 2) * JUMPS,
        **({"turns": 3 * count} if count > own else {}),
        "instant": 7 * own + 4 * count + 2 * acts + n + count - own + 1,
    }
