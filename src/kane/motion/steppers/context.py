# SPDX-License-Identifier: BSD-3-Clause
"""What the kernels of all steppers share: their arguments, the numbers that pass between calls, the samples that a step holds.

A kernel goes on from t by at most `limit` steps and returns why it came back (`ReturnCode`). Time is the sum of two numbers, t and
what rounding left of it, and so is every component of y.
"""

from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import Literal

from kane.numeric.scale import EPS
from kane.program.kernel.language import INT, Address, Argument, ArrayOf, Immediate, Kernel, Put
from kane.program.kernel.writer import Array, Term, Variable, Writer


class ReturnCode(IntEnum):
    """Why a kernel returns: at the end; after as many steps as it may take; as no step is short enough, or a number is not finite.

    LOOK means that the next step may hold an event: it was not gone on from, and is taken again. EVENT means that an event ended the
    motion, FULL that what was noted of events is to be collected. STANDS means that no side of a switch leads on, RESTS that its
    quantity stays at zero. With AGAIN it does not return, but takes the step once more.
    """

    ON = 0
    END = 1
    LIMIT = 2
    UNDERFLOW = 3
    NOT_FINITE = 4
    LOOK = 5
    EVENT = 6
    FULL = 7
    STANDS = 8
    RESTS = 9
    AGAIN = 10


class Slot(IntEnum):
    """Places in the array `s`: what the kernel is told, up to FRESH, and what it leaves for the next call and for Python.

    STEP is the next step; where it is 0 a kernel that is FRESH chooses one, if its steps are not of one length. Where FRESH is 2 the
    state is moved onto the constraints, and the kernel comes back before the first step.
    BREAKPOINT counts breakpoints that are behind, SMOOTH steps along which the solution hardly bends, LIMITED those that nothing but
    stability or convergence made short. LOOKED is 1 where Python has looked at the constraints of the step, 2 at its events too. SPAN
    is the length of the motion, PHASE when an action was last taken, SINCE how long after the one before; LOGGED events
    and JUMPS are noted; `control` may have it STOPPED. SIDED is 0 where the sides of switches are not known, 2 where some turn. Where
    END is a place at which a switch turns, TURNING is 1 and BEYOND the end behind it. CHOICE is which dependent speeds are stepped,
    MEASURED whether the sizes of constraints are those of this step. BACK is why the instance of a queue has ended. PACE is one
    over the length that the error of the last step allowed, 0 where there is none.
    """

    TIME = 0
    TIME_LAG = 1
    STEP = 2
    END = 3
    LONGEST = 4
    RTOL = 5
    ATOL = 6
    SHORTEST = 7
    FRESH = 8
    STEPS = 9
    RATES = 10
    SAMPLE = 11
    WORST = 12
    REJECTED = 13
    LAST_STEP = 14
    LOOKED = 15
    HELD = 16
    SHARE = 17
    QUIET = 18
    SMOOTH = 19
    LIMITED = 20
    BREAKPOINT = 21
    SPAN = 22
    PHASE = 23
    LOGGED = 24
    JUMPS = 25
    STOPPED = 26
    SINCE = 27
    SIDED = 28
    TURNING = 29
    BEYOND = 30
    CHOICE = 31
    MEASURED = 32
    BACK = 33
    PACE = 34


SIZE = len(Slot)
RATE: tuple[Literal["float", "array"], ...] = ("float", "array", "array", "array", "array", "array")
"""What the routine of (q̇, u̇, P) takes: t, (q, u), p, r, h, and what it writes to."""
WIDE: tuple[Literal["float", "array"], ...] = ("array", *RATE[1:])
"""What it takes on lanes."""
QUEUE = ("queue", "instances", "results")
"""The arrays of a queue of instances, see `queue_kernel`."""
LOADED = ("s", "y", "p", "r", "times", "seen", "largest", "leaves", "held_reach")
SAVED = ("s", "y", "rows", "log", "jumps", "held_marks", "held_log")
CLEARED = ("lag", "held_log")
"""The arrays of which an instance has numbers in `instances`, and in `results`, and that begin with zeros, where a kernel has them."""


_STILL, _NEAR, _CONSTANT = 1e-5, 1e-6, 1e-15
"""Sizes over tolerances below which they do not tell a first step, the one tried then (s), and the change of rates that is none."""


class StepperContext:
    """The arguments of a stepper's kernel, its cell `back`, and `asks`: with what it comes back instead of going on from a step.

    `turned` tells whether a switch turns at the end of the step, `renewed` whether other equations hold there.
    """

    def __init__(self, name: str, queued: bool = False) -> None:
        self.writer = w = Writer(name)
        self.n, self.limit, self.samples = w.number("n"), w.number("limit"), w.number("samples")
        self.s, self.y, self.lag, self.work = w.array("s"), w.array("y"), w.array("lag"), w.array("work")
        self.p, self.r, self.h = w.array("p"), w.array("r"), w.hoisted("h")
        self.times, self.rows = w.array("times"), w.array("rows")
        self.driven, self.hd = w.number("driven"), w.hoisted("hd")
        self.breakpoints, self.pauses = w.number("breakpoints"), w.array("pauses")
        self.control = w.callee("control", *RATE)
        self.back = w.variable("back", INT)
        self.taken, self.arrived = w.variable("taken", INT), w.variable("arrived", INT)
        self.asks = w.variable("asks", INT)
        self.turned: Variable | None = None
        self.renewed, self.fixed = w.variable("renewed", INT), False
        self.cursor, self.prepared = w.variable("cursor", INT), w.variable("prepared", INT)
        self.queued = queued

    def steps(self, begin: Callable[[], None], step: Callable[[Term, Term], None], fixed: bool = False) -> Kernel:
        """The kernel: step(h, last) after step until there is a reason to come back, `begin()` before one that is FRESH.

        Steps that are `fixed` are of one length. Where instances are `queued`, the next one is taken up instead of coming back.
        """
        w, self.fixed = self.writer, fixed
        if self.queued:
            self.back.put(1)
        with w.repeat(self.goes_on):
            admitted = self.get(Slot.FRESH) > 1.0
            with w.when(self.get(Slot.FRESH) > 0.0):
                begin()
            with w.when(admitted):
                self.put(Slot.FRESH, 1.0)
                self.back.put(int(ReturnCode.LIMIT))
            with w.otherwise():
                step(*self.length())
                with w.when(self.arrived.get() > 0):
                    self.pass_breakpoint()
            if self.queued:
                with w.when(self.back.get() > 0):
                    self.forget()
        return w.finished(self.back)

    def goes_on(self) -> Term:
        """Whether there is a step to take; of a queue's instance that has ended why is noted, and the next one is taken up."""
        w = self.writer
        if self.queued:
            arrays = [*turned_over(w.arguments), *(w.array(name).argument.name for name in QUEUE)]
            take_next = w.callee("next", *(RATE[-1] for _ in arrays))
            with w.when(self.back.get() > 0):
                self.put(Slot.BACK, w.compute("float", self.back.get()))
                take_next(*(Address(name, Immediate(INT, 0)) for name in arrays))
                self.back.put(w.compute("int", self.get(Slot.BACK)))
                with w.when(self.back.get() < 1):
                    w.rehoist(self.p)
        return self.back.get() < 1

    def forget(self) -> None:
        """Nothing in cells is of the instance that has ended, but why it has."""
        for cell in self.writer.cells:
            if cell is not self.back.cell:
                self.writer.add(Put(cell, Immediate(cell.type, 0 if cell.type == INT else 0.0)))

    def begin_step_anew(self) -> None:
        """The next step begins from its rates, and chooses its length, if steps are not of one length."""
        self.put(Slot.FRESH, 1.0)
        if not self.fixed:
            self.put(Slot.STEP, 0.0)

    def pass_breakpoint(self) -> None:
        """From just before a breakpoint to just after it, where sampled controllers are asked.

        `pauses` has three numbers for each of the `breakpoints`: the time after it, the next end, and whether `control` writes r.
        """
        w = self.writer
        place = w.compute("int", self.get(Slot.BREAKPOINT)) * 3
        self.arrived.put(0)
        self.put(Slot.TIME, self.pauses[place])
        self.put(Slot.TIME_LAG, 0.0)
        self.put(Slot.END, self.pauses[place + 1])
        self.begin_step_anew()
        if self.turned is not None:
            self.put(Slot.SIDED, 0.0)
        self.more(Slot.BREAKPOINT, 1.0)
        with w.when(self.pauses[place + 2] > 0.0):
            self.control(self.get(Slot.TIME), self.y.at(0), self.p.at(0), self.r.at(0), self.h.at(0), self.r.at(0))
            with w.when(self.get(Slot.STOPPED) > 0.0):
                self.back.put(int(ReturnCode.LIMIT))

    def get(self, at: Slot) -> Term:
        """One of the numbers in s."""
        return self.s[int(at)]

    def put(self, at: Slot, value: Term | float) -> None:
        """One of the numbers in s becomes `value`."""
        self.s[int(at)] = value

    def more(self, at: Slot, by: Term | float) -> None:
        """One of the numbers in s grows."""
        self.put(at, self.get(at) + by)

    def row(self, k: int) -> Term:
        """Where row k of n doubles begins in `work`."""
        return self.n * k

    def rate(self, rhs: Callable[..., None], t: Term, x: Array, at: Term | int, row: Term | int) -> None:
        """A row of `work` becomes f(t, x) with the state at a place."""
        self.drive(t, x.at(at))
        rhs(t, x.at(at), self.p.at(0), self.r.at(0), self.h.at(0), self.work.at(row))
        self.more(Slot.RATES, 1.0)

    def drives(self, *takes: Literal["float", "array"], single: bool = False) -> None:
        """The argument that gives r at a time, which a motion has whose inputs are `driven`; it takes what the rates take.

        Another one gives `single_r` at a `single` state, where the rates take lanes.
        """
        w = self.writer
        self._drive, self.single_r = w.callee("drive", *takes), w.array("single_r") if single else self.r
        self._drive_single = w.callee("single_drive", *RATE) if single else self._drive

    def drive(self, t: Term | Address, x: Address, single: bool = False) -> None:
        """The inputs at a time; those of one state where it is `single`."""
        drive, r = (self._drive_single, self.single_r) if single else (self._drive, self.r)
        with self.writer.when(self.driven > 0):
            drive(t, x, self.p.at(0), r.at(0), self.hd.at(0), r.at(0))

    def follow(self, t: Term | Address, x: Address) -> None:
        """The inputs at states, where they follow from these."""
        with self.writer.when(self.driven > 1):
            self._drive(t, x, self.p.at(0), self.r.at(0), self.hd.at(0), self.r.at(0))

    def first_step(self, exponent: float, rhs: Callable[..., None], now: int | Term, state: Term, moved: Term) -> None:
        """`choose_step` where rates are those of one state: `now` is the row of f(t, y), `state` and `moved` are free rows."""

        def rates(t: Term, y: Callable[[Term], Term]) -> Callable[[Term], Term]:
            with self.writer.count(self.n) as i:
                self.work[state + i] = y(i)
            self.rate(rhs, t, self.work, state, moved)
            return lambda i: self.work[moved + i]

        self.choose_step(exponent, lambda i: self.work[now + i], rates)

    def choose_step(
        self,
        exponent: float,
        now: Callable[[Term], Term],
        rates: Callable[[Term, Callable[[Term], Term]], Callable[[Term], Term]],
    ) -> None:
        """Where no STEP is given, it becomes one over which an Euler step and the change of rates are small.

        `now(i)` is f_i(t, y), `rates(t', y')` gives f_i(t', y'), `exponent` is about 1/order. Source: Hairer, Nørsett & Wanner,
        *Solving Ordinary Differential Equations I*, 2nd ed. 1993, sec. II.4.
        """
        w = self.writer
        with w.when(~(self.get(Slot.STEP) > 0.0)):
            largest = {name: w.variable(name) for name in ("first_size", "first_rate", "first_change")}
            for cell in largest.values():
                cell.put(0.0)
            size, speed, change = largest.values()

            def raise_to(cell: Variable, value: Term, i: Term) -> None:
                allowed = self.get(Slot.ATOL) + self.get(Slot.RTOL) * w.compute("abs", self.y[i])
                cell.put(w.compute("max", cell.get(), w.compute("abs", value) / allowed))

            with w.count(self.n) as i:
                raise_to(size, self.y[i], i)
                raise_to(speed, now(i), i)
            left = (self.get(Slot.END) - self.get(Slot.TIME)) - self.get(Slot.TIME_LAG)
            tells = w.compute("min", size.get(), speed.get()) > _STILL
            euler = w.select(tells, 0.01 * size.get() / w.compute("max", speed.get(), _STILL), _NEAR)
            tried = w.compute("min", w.select(euler < _LARGE, euler, _NEAR), left)
            after = rates(self.get(Slot.TIME) + tried, lambda i: self.y[i] + tried * now(i))
            with w.count(self.n) as i:
                raise_to(change, after(i) - now(i), i)
            most = w.compute("max", speed.get(), change.get() / tried)
            bends = w.compute("max", w.select(most < _LARGE, most, 1.0), _CONSTANT)
            wished = w.select(
                most > _CONSTANT, dyadic_power(w, 0.01 / bends, exponent), w.compute("max", _NEAR, 1e-3 * tried)
            )
            best = w.compute("min", w.compute("min", 100.0 * tried, wished), left)
            since = self.get(Slot.SINCE)
            best = w.compute("min", best, w.select(since > 0.0, _INTERVALS * since, best))
            self.put(Slot.STEP, w.select(most < _LARGE, best, tried))

    def allowed(self, i: Term, end: Term) -> Term:
        """atol + rtol |y_i|, at the beginning or the end of the step."""
        w = self.writer
        size = w.compute("max", w.compute("abs", self.y[i]), w.compute("abs", end))
        return self.get(Slot.ATOL) + self.get(Slot.RTOL) * size

    def largest_error(self, largest: Variable, of: Callable[[Term], Term]) -> None:
        """`largest` becomes the largest of the errors of all components, NaN where one is; which component has it is noted."""
        w = self.writer
        largest.put(0.0)
        with w.count(self.n) as i:
            error, before = of(i), largest.get()
            with w.when(~(error <= before)):
                largest.put(w.compute("max", before, error))
                self.put(Slot.WORST, w.compute("float", i))

    def power(self, error: Term, exponent: float) -> tuple[Term, Term]:
        """Whether an error is finite, and the power of it by which steps are to be shorter."""
        w, finite = self.writer, error < _LARGE
        return finite, dyadic_power(w, w.compute("max", w.select(finite, error, 1.0), _SMALLEST), exponent)

    def length(self) -> tuple[Term, Term]:
        """The length of the next step, and whether it reaches the end."""
        w = self.writer
        left = (self.get(Slot.END) - self.get(Slot.TIME)) - self.get(Slot.TIME_LAG)
        wished = w.compute("min", w.compute("max", self.get(Slot.STEP), self.shortest()), self.get(Slot.LONGEST))
        last = wished >= left
        return w.select(last, left, wished), last

    def shortest(self) -> Term:
        """A step that rounding of the time leaves."""
        return self.get(Slot.SHORTEST) + _TEN_ROUNDINGS * self.writer.compute("abs", self.get(Slot.TIME))

    def sample(
        self, h: Term, prepare: Callable[[], None], write: Callable[[Term, Term], None], until: Term | None = None
    ) -> None:
        """Of each sample within a step `write(k, θ)` writes row k, after `prepare` where there are some; or those before a time."""
        w = self.writer
        cursor, prepared = self.cursor, self.prepared
        cursor.put(w.compute("int", self.get(Slot.SAMPLE)))
        prepared.put(0)

        def share() -> Term:
            return self.share_of(cursor.get(), h)

        def within() -> Term:
            # one more time stands behind the last one: after the end
            inside = share() <= 1.0 if until is None else self.times[cursor.get()] < until
            return (cursor.get() < self.samples) & inside

        with w.repeat(within):
            with w.when(prepared.get() < 1):
                prepare()
                prepared.put(1)
            write(cursor.get(), share())
            cursor.put(cursor.get() + 1)
        self.put(Slot.SAMPLE, w.compute("float", cursor.get()))

    def share_of(self, k: Term, h: Term) -> Term:
        """The share of a step at which a sample is."""
        return ((self.times[k] - self.get(Slot.TIME)) - self.get(Slot.TIME_LAG)) / h

    def has_sample(self, h: Term) -> Term:
        """Whether a step holds samples; one more time stands behind the last one."""
        k = self.writer.compute("int", self.get(Slot.SAMPLE))
        return (k < self.samples) & (self.share_of(k, h) <= 1.0)

    def advance(self, h: Term, last: Term) -> None:
        """t + h, or the end itself; the step is counted, and the kernel comes back where it is time."""
        w = self.writer
        t, more = self.get(Slot.TIME), h + self.get(Slot.TIME_LAG)
        sum_ = t + more
        self.put(Slot.TIME_LAG, w.select(last, 0.0, more - (sum_ - t)))
        self.put(Slot.TIME, w.select(last, self.get(Slot.END), sum_))
        self.put(Slot.LAST_STEP, h)
        self.put(Slot.LOOKED, 0.0)
        self.more(Slot.STEPS, 1.0)
        self.count_taken()
        with w.when(last):
            if self.turned is None:
                self.arrive()
            else:
                with w.when(self.get(Slot.TURNING) > 0.0):
                    self.put(Slot.END, self.get(Slot.BEYOND))
                    self.put(Slot.TURNING, 0.0)
                    self.turned.put(1)
                with w.otherwise():
                    self.arrive()

    def arrive(self) -> None:
        """At a breakpoint, or at the end, where the kernel comes back."""
        w = self.writer
        ahead = self.get(Slot.BREAKPOINT) < w.compute("float", self.breakpoints)
        self.arrived.put(w.select(ahead, w.integer(1), w.integer(0)))
        self.back.put(w.select(ahead, self.back.get(), w.integer(ReturnCode.END)))

    def count_taken(self) -> None:
        """One more step is taken; the kernel comes back after as many as it may take."""
        self.taken.put(self.taken.get() + 1)
        with self.writer.when(self.taken.get() >= self.limit):
            self.back.put(int(ReturnCode.LIMIT))

    def shorten(self, wished: Term, finite: Term) -> None:
        """A step is taken again, shorter, unless that is shorter than rounding."""
        w = self.writer
        self.put(Slot.STEP, wished)
        self.more(Slot.REJECTED, 1.0)
        with w.when(wished < self.shortest()):
            self.back.put(w.select(finite, w.integer(ReturnCode.UNDERFLOW), w.integer(ReturnCode.NOT_FINITE)))


def turned_over(arguments: Sequence[Argument]) -> list[str]:
    """The arrays that are an instance's own, in the order of the arguments."""
    own = {*LOADED, *SAVED, *CLEARED}
    return [a.name for a in arguments if isinstance(a, ArrayOf) and a.name in own]


_TEN_ROUNDINGS = 10 * EPS
_LARGE, _SMALLEST = 1e300, 2.0**-1000
_INTERVALS = 4.0
"""A first step after an action is no longer than so many times what lay between it and the one before: the next one may be as near."""


def dyadic_power(w: Writer, x: Term, exponent: float) -> Term:
    """x to a power between 0 and 1 that is a sum of halves, quarters, …: square roots alone are the same in every language."""
    factors, root, part = [], x, 1.0
    while exponent > 0:
        root, part = w.compute("sqrt", root), part / 2
        if exponent >= part:
            factors.append(root)
            exponent -= part
    result = factors[0]
    for f in factors[1:]:
        result = result * f
    return result


def add_exactly(y: Array, lag: Array, i: Term, change: Term) -> tuple[Term, Term]:
    """y_i + change, and what rounding leaves of it, with what it left before."""
    old = y[i]
    more = change + lag[i]
    new = old + more
    return new, more - (new - old)
