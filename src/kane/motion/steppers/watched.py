# SPDX-License-Identifier: BSD-3-Clause
"""Events along a step: whether there may be one, from eight places of the step, of collocation in one call.

What it finds is only that it may: Python then looks at the step with the tests that say so for all methods (`hybrid.events`). So
the places are the same, and a quantity that passes zero between two of them, or comes near it where it must not, is never left out.
"""

from collections.abc import Callable

from kane.motion.steppers.context import RATE, WIDE, Slot, StepperContext
from kane.numeric.sign_changes import CLOSE, LEFT, SHARES, SMALL, TO_BERNSTEIN, TO_LAST
from kane.numeric.sign_changes import DEGREE as PARTS
from kane.program.kernel.language import INT
from kane.program.kernel.writer import Term

PLACES = SHARES[1:]
"""Shares of a step at which events are looked at, but for its beginning."""
ROOM = 2 * PARTS
"""Where the quantities begin in `values`."""


class Watched:
    """The arguments that tell of events, and the look at a step.

    `seen` holds the events' quantities at the beginning of the step, `largest` the sizes that they have had; `least` and `shares` of
    that are their thresholds. `pivots` are 1 for those that must not come near zero. `values` is room for 9 of each and 24 more.
    Where it is `wide`, their routine takes the eight places at once, else one state.
    """

    def __init__(self, context: StepperContext, wide: bool) -> None:
        self.context = context
        self.writer = w = context.writer
        self.call = w.callee("watch", *(WIDE if wide else RATE))
        self.count = w.number("events")
        names = ("hw", "seen", "largest", "least", "shares", "pivots", "values")
        self.h, self.seen, self.largest, self.least, self.shares, self.pivots, self.values = map(w.array, names)
        self.doubtful = w.variable("doubtful", INT)

    def look(self, clock: Term, states: Term) -> None:
        """Sets `doubtful` where there may be an event; `work` holds the states at the places at `states`, their times at `clock`."""
        o = self.context
        o.follow(o.work.at(clock), o.work.at(states))
        self.call(*(o.work.at(x) for x in (clock, states)), o.p.at(0), o.r.at(0), self.h.at(0), self.values.at(ROOM))
        self.compare()

    def look_along(self, t: Term, h: Term, state: Callable[[Term, Term], None], place: Term) -> None:
        """The same where one state is looked at at a time: `state(k, θ)` writes it into `work` at a place, the kth one at a share."""
        w, o = self.writer, self.context
        one = (self.count + 2) * PARTS
        shares = one + self.count
        self.values.store(shares, w.lanes(*PLACES))
        with w.few(PARTS) as k:
            share = self.values[shares + k]
            state(k, share)
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
            new = self.at_places(e)
            # one place on, behind what was seen at the beginning: what there was a place before
            self.values[PARTS - 1] = self.seen[e]
            self.values.store(PARTS, new)
            old = self.values.lanes(PARTS - 1, PARTS)
            size = w.compute("max", w.compute("largest", w.compute("abs", new)), w.compute("abs", self.seen[e]))
            largest = w.select(size > self.largest[e], size, self.largest[e])
            least = self.least[e] + self.shares[e] * largest
            sure = self.sure(self.seen[e] - least, new - w.compute("splat8", least))
            closest = -w.compute("largest", -w.compute("min", w.compute("abs", old), w.compute("abs", new)))
            near = (self.pivots[e] > 0.0) & (closest < SMALL * largest)
            with w.when(~sure | near):
                self.doubtful.put(1)

    def sure(self, first: Term, others: Term) -> Term:
        """Whether a quantity has one sign along the step, whatever its values at the places leave open: see `numeric.sign_changes`."""
        w, count = self.writer, range(PARTS)
        each = [w.compute("splat8", x) for x in (first, *(w.compute("lane", others, lane=k) for k in count))]
        # the coefficients but for the first one, which is the first value
        columns = [tuple(map(float, column)) for column in TO_BERNSTEIN[1:].T]
        coefficients = w.sum([x * column for x, column in zip(each, columns, strict=True)])
        last = [
            w.compute("abs", first * float(row[0]) + w.compute("sum", others * tuple(map(float, row[1:]))))
            for row in TO_LAST
        ]
        slack = LEFT * w.compute("max", *last)
        lowest = w.compute("min", first, -w.compute("largest", -coefficients))
        highest = w.compute("max", first, w.compute("largest", coefficients))
        size = w.compute("max", w.compute("abs", first), w.compute("largest", w.compute("abs", others)))
        return (slack <= CLOSE * size) & ((lowest > slack) | (highest < -slack))

    def at_places(self, e: Term) -> Term:
        """The quantity of an event at the eight places."""
        return self.values.lanes(e * PARTS + ROOM, PARTS)

    def keep(self) -> None:
        """What was seen at the end of the step is what there is at the beginning of the next one."""
        w, o = self.writer, self.context
        with w.count(self.count) as e:
            sizes = w.compute("abs", self.at_places(e))
            size = w.compute("largest", sizes)
            self.largest[e] = w.select(size > self.largest[e], size, self.largest[e])
            self.seen[e] = self.values[e * PARTS + (ROOM + PARTS - 1)]
        o.put(Slot.LOOKED, 0.0)
