# SPDX-License-Identifier: BSD-3-Clause
"""Events along a step: whether there may be one, from eight places of the step, of collocation in one call; where; what it does.

A quantity that surely keeps its sign is passed by. Passages of the others are located (`crossings`), noted in `log`, and the first
that ends the motion or changes its state ends the step there: the state before it, and after its actions, are a row of `jumps`. What
the kernel does not decide (`EventKind.ASKED`, what rests at its threshold, sides that no first derivative tells, one more event at the
instant of an action) is looked at by Python, with the tests that say so for all methods (`hybrid.events`).

The side of each switch is a number among the parameters, −1 or 1, on which its quantity is smooth across zero. A step that would pass
zero is taken again up to there; then the switch turns. What comes back at once turns back, and where it does not lead on there either
there is no side that does.
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
"""Shares of a step at which events are looked at, but for its beginning."""
ROOM = 3 * PARTS
"""Where the quantities begin in `values`."""
LOOSE = 1e-2
"""How many relative tolerances of the largest that a pivot of W has been it is where it vanishes, if they are more than rounding."""
LOG, JUMPS = 1024, 64
"""So many events, and actions, are noted until Python collects them."""
Dense = Callable[[Term, Array, Term], None]
"""Writes the state at a share of the step into an array from a place on."""
_AIMED, _SHORTER, _BACK = 1, 2, 3
"""Why a step is taken again: it is to end where a switch turns; it is too long to tell how one leads on; switches turn back."""


class Watched:
    """The arguments that tell of events, and the look at a step.

    `seen` holds the events' quantities at the beginning of the step, `largest` the sizes that they have had; `least` and `shares` of
    that are their thresholds. `pivots` are 1 for those that must not come near zero. `values` is room for 9 of each and 32 more.
    Where it is `wide`, their routine takes the eight places at once, else one state; `glance` takes one state and gives the quantities
    and the sizes of their terms, `tendency` the rates of the `own` ones along the motion, and `act` the values that actions set:
    of each, `actions` says by which event, and at which place: of the state, or behind its components of the parameters; at −1 a
    value is to be above zero. Under constraints the speeds that none is set of follow.
    `dense` is the state along the step, `held` what moves it onto constraints.

    Where it is `sided` the quantities behind those of events are of switches, whose sides stand in p from `sides_at` on. `turns` holds
    of each whether it turns, whether it came back, and what it was.
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
        # in `instant`: the quantities and sizes after actions, how they leave, rates before and after, all of it before, what is set
        self.rows = self.count * 2
        self.before_rates = self.rows + self.own * LEAVES
        self.after_rates = self.before_rates + self.own
        self.was = self.after_rates + self.own
        self.set_at = self.was + self.count * 2
        self.bound = self.set_at + self.acts  # of each speed whether it stays as it is
        self.kept_p = self.bound + context.n  # values of the parameters that are set, before
        self.kept_sides = self.kept_p + self.acts
        self.renews = w.variable("renews", INT)

    # ---------------------------------------------------------------------------------------------------- the look

    def look(self, clock: Term, states: Term) -> None:
        """Sets `doubtful` where there may be an event; `work` holds the states at the places at `states`, their times at `clock`."""
        o = self.context
        o.follow(o.work.at(clock), o.work.at(states))
        self.call(*(o.work.at(x) for x in (clock, states)), o.p.at(0), o.r.at(0), self.h.at(0), self.values.at(ROOM))
        self.compare()

    def look_along(self, t: Term, h: Term, place: Term, end: Term) -> None:
        """The same where one state is looked at at a time, written into `work` at a place; the last, at `end`, is gone on from."""
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
        """What the values at the places tell."""
        w = self.writer
        self.doubtful.put(0)
        with w.count(self.count) as e:
            new = self.at_nodes(e)
            # one place on, behind what was seen at the beginning: what there was a place before
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
        """The largest that a quantity has been, the step with it."""
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

    # ----------------------------------------------------------------------------------------------- what is there

    def ask(self, share: Term, array: Array, place: Term) -> None:
        """The quantities at a share of the step, and the sizes of their terms."""
        t = self.begin.get() + share * self.length.get()
        self.dense(share, self.probe, self.writer.integer(0))
        self.at_state(self.glance, t, (self.probe, self.writer.integer(0)), (array, place))

    def at_state(
        self, routine: tuple[Callable[..., None], Array], t: Term, state: tuple[Array, Term], to: tuple[Array, Term]
    ) -> None:
        """A routine of one state is called, which stands in `probe`: lanes give routines places that are the same in all."""
        o, (call, h), (array, at), (out, place) = self.context, routine, state, to
        if array is not self.probe:
            with self.writer.count(o.n) as i:
                self.probe[i] = array[at + i]
        o.drive(t, self.probe.at(0), single=True)
        call(t, self.probe.at(0), o.p.at(0), o.single_r.at(0), h.at(0), out.at(place))

    def decide(self, t: Term, h: Term, last: Term) -> None:
        """Of a step of length h from t that was looked at the passages; `asks` why it is not gone on from, if it is not."""
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
            if self.sided:  # beyond a switch nothing is known of other quantities
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
        """Where in p the side of a switch stands."""
        return self.sides_at + e - self.own

    def mark(self, row: int, e: Term) -> Term:
        """A place in `turns`: 0 whether a switch turns, 1 whether it came back, 2 what its quantity was.

        Of an event 0 whether it is met where a switch turns, 1 whether it was met before it passes, 2 how far from its threshold.
        """
        return self.count * row + e

    def expected(self, e: Term) -> Term:
        """Whether an event was seen where switches turn, up to which the step was taken again."""
        return self.turns[self.mark(0, e)] > 0.0

    def meet_expected(self, e: Term, last: Term) -> None:
        """One that the end of the step leaves before its threshold is met there; where it passes then it was met before."""
        w, c, passed = self.writer, self.crossings, self.crossings.get("found") > self.before.get()
        early, none = self.turns[self.mark(1, e)] > 0.0, ~passed & ~(c.get("asked") > 0)
        with w.when(early & passed):
            c.drop(self.before.get())
        with w.when(~early & none & last & (self.context.get(Slot.TURNING) > 0.0) & self.expected(e)):
            c.meet(w.constant(1.0), e)

    def keep_early(self, e: Term, gap: Term) -> None:
        """An event that was met before it passes, by what is left to its threshold after a step, still has to pass if that is less."""
        early, left, size = self.turns[self.mark(1, e)], self.mark(2, e), self.writer.compute("abs", gap)
        before = (gap * (self.seen[e] - self.threshold(e)) > 0.0) & ((early > 1.5) | (size <= self.turns[left]))
        self.turns[self.mark(1, e)] = self.writer.select((early > 0.0) & before, 1.0, 0.0)
        self.turns[left] = size

    def decided(self, verdict: int, e: Term) -> None:
        """A verdict on the step, for a switch, unless there is one that weighs more."""
        with self.writer.when(self.verdict.get() < verdict):
            self.verdict.put(verdict)
            if verdict > _BACK:
                self.context.put(Slot.WORST, self.writer.compute("float", e))

    def leave_zero(self, e: Term, h: Term) -> None:
        """Whether a quantity that is zero at the beginning of the step leaves it to its side."""
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
        """What becomes of a step in which switches turn."""
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
        """The share of a step of length h within which switches turn at one time: rounding of the time leaves it, or more."""
        return NEAR_TIME + 4 * EPS * self.writer.compute("abs", self.begin.get()) / h

    def take_again(self, h: Term) -> None:
        """The step is shortened, or begins on other sides, or is to end where switches turn."""
        w, o, c = self.writer, self.context, self.crossings
        o.asks.put(ReturnCode.AGAIN)
        back, aimed = self.verdict.get() >= _BACK, self.verdict.get() < _SHORTER
        with w.when(~aimed):
            self.no_end()
            # of a step that turns back, steps of one length keep theirs, and others choose one
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
        """A step begins anew in which the marked switches have turned."""
        self.context.put(Slot.SIDED, 2.0)
        self.context.begin_step_anew()

    def no_end(self) -> None:
        """The end is no place at which a switch turns."""
        o = self.context
        with self.writer.when(o.get(Slot.TURNING) > 0.0):
            o.put(Slot.END, o.get(Slot.BEYOND))
            o.put(Slot.TURNING, 0.0)

    def settle(self) -> None:
        """The switches have the sides of the state at hand, or turn where they are to, with those that leap across zero then."""
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
        # events keep what was seen of them: at a breakpoint they may pass between the end of one step and the beginning of the next
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
        """The side of a switch becomes this one: its quantity counts where it leaves it."""
        self.context.p[self.side_index(e)] = side
        self.crossings.kinds[e * KINDS + 1] = -side

    def steps_since(self, t: Term, h: Term) -> Term:
        """Of how many steps like this one the motion is since it began, or an action was taken; without end for the shortest ones."""
        o = self.context
        return self.writer.select(h < o.get(Slot.SPAN) * NEAR_TIME, 2 / NEAR_TIME, (t - o.get(Slot.PHASE)) / h + 2.0)

    @property
    def breaks(self) -> Term:
        """Whether an event ends the step."""
        return self.crossings.get("broken") <= 1.0

    def note(self, ended: tuple[Term, Term] | None = None) -> None:
        """The passages that were found are noted, where the step has `ended` at a share with its time t; switches at the end turn."""
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
        """What was seen at the end of the step is what there is at the beginning of the next one."""
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
        """After a step that was gone on from: where it ended at a place at which switches turn, a new one begins."""
        o = self.context
        if self.sided and o.turned is not None:
            with self.writer.when(o.turned.get() > 0):
                o.turned.put(0)
                o.put(Slot.SINCE, 0.0)
                self.begin_on_other_sides()

    # ------------------------------------------------------------------------------------------------ what it does

    def jump(self, sampled: Callable[[Term, Term], None]) -> None:
        """The step ends at the first event that ends the motion or changes its state, which goes on from there."""
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
        """Whether no step leads on from a time to the end, which is as good as there."""
        o = self.context
        return o.get(Slot.END) - t <= 10.0 * o.shortest()

    def be_at_the_end(self) -> None:
        """The state at hand is that of the end, and of the samples up to there."""
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
        """For the kth passage, if it is of the instant of the first that breaks, and the condition holds."""
        c = self.crossings
        near = 2 * SAME_TIME + 4 * EPS * self.writer.compute("abs", self.begin.get()) / self.length.get()
        with self.writer.when((c.met[k * 2] >= c.get("broken") - near) & condition):
            do()

    def begin_anew(self, t: Term, after: Term) -> None:
        """The motion goes on from a time and a state."""
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
        """The state after the actions, all from the state before; what is not sure is `asked`.

        `instant` takes the quantities before and after, with the sizes of their terms, and the rows of `leaves` from then on. Where a
        switch is left at zero it is asked about.
        """
        w, o, c = self.writer, self.context, self.crossings
        own = self.own
        self.at_state(self.tendency, t, (self.jumps, before), (self.instant, self.before_rates))
        self.at_state(self.glance, t, (self.jumps, before), (self.instant, self.was))
        with w.count(o.n) as i:
            self.jumps[after + i] = self.jumps[before + i]
        # by their doubts the events of this instant are told from now on: 2, and 3 where they act
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
        """The values that the events of this instant set; two for one place are asked about."""
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
        """Where the kth value that actions set stands."""
        return self.writer.compute("int", self.actions[k * 2 + 1])

    def acts_now(self, k: Term) -> Term:
        """Whether an event of this instant sets the kth value."""
        return self.doubts[self.writer.compute("int", self.actions[k * 2])] > 2.5

    def sets_parameter(self, k: Term) -> Term:
        """Whether an event of this instant sets the kth value, of a parameter."""
        return self.acts_now(k) & (self.place(k) >= self.context.n)

    def set_parameters(self) -> None:
        """Parameters become what events set them to, and what follows from them with them; what they were is kept."""
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
        """Switches have the sides of the state after the actions."""
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
        """Speeds that are not set follow on the constraints: the dependent ones, or all where as many are set as are independent."""
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
        """How a quantity, over its threshold a before the actions, leaves it after them, or that it is leapt across."""
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
            # the time of an event is known so exactly that the quantity may be beyond by as much, and by no more
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
    """How many doubles the arrays of `Watched` have for so many quantities, events, values that are set, and components."""
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
