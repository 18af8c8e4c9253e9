# SPDX-License-Identifier: BSD-3-Clause
"""The interface that the kernels of all steppers share: arguments, the slots of `s`, sampling within steps, and the first step size.

A kernel advances the motion from t by at most `limit` steps and returns a `ReturnCode`. The time and each component of y are sums
of two doubles, the value and its rounding error (compensated summation).
"""

from collections.abc import Callable, Iterator, Sequence
from enum import IntEnum
from typing import Literal

from kane.numeric.scale import EPS
from kane.program.kernel.language import INT, Address, Argument, ArrayOf, Immediate, Kernel, Put
from kane.program.kernel.writer import Array, Term, Variable, Writer


class ReturnCode(IntEnum):
    """Why a kernel returns: END of the span, LIMIT of steps, UNDERFLOW of the step size, or a number that is NOT_FINITE.

    LOOK means that the last step needs an examination by Python, of its events or constraints; it was not accepted and is repeated.
    EVENT means that an event ended the motion, FULL that a log must be emptied, STANDS that a motion continues on neither side of a
    switch, RESTS that the quantity of a switch stays zero. ON and AGAIN are not returned: with AGAIN the kernel repeats the step.
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
    """Indices of the array `s`: the inputs of a kernel, up to FRESH, and the values that it leaves for its next call and for Python.

    STEP is the next step size; if it is 0, a kernel that is FRESH chooses it, unless steps are fixed. If FRESH is 2, it projects the
    state onto the constraints and returns before a step. SAMPLE is the next sample, WORST the component with the largest error.
    BREAKPOINT counts breakpoints passed, SMOOTH steps along which the solution hardly bends, LIMITED those whose size only stability
    or convergence restricts. LOOKED is 1 after Python has examined the constraints of the step, 2 after its events as well. SPAN is
    the length of the time span, PHASE the time of the last action, SINCE the interval between it and the previous one; LOGGED and
    JUMPS are the numbers of logged events and jumps; `control` may set STOPPED. SIDED is 0 while the sides of switches are unknown, 2
    if some are to change. While END is a switching time, TURNING is 1 and BEYOND is the end after it. CHOICE is the index of the
    dependent speeds in use, MEASURED 1 if the scales of the constraints were updated at this step; HELD, SHARE and QUIET: see
    `held.py`. BACK is the return code of a queued instance. PACE is one over the step size that the last error allowed, 0 if unknown.
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
"""Types of the arguments of the routine for (q̇, u̇, P): t, (q, u), p, r, h, and the result."""
WIDE: tuple[Literal["float", "array"], ...] = ("array", *RATE[1:])
"""The same for a routine that evaluates one state in each vector lane."""
QUEUE = ("queue", "instances", "results")
"""The arrays of a queue of instances, see `queue_kernel`."""
LOADED = ("s", "y", "p", "r", "times", "seen", "largest", "leaves", "held_reach")
SAVED = ("s", "y", "rows", "log", "jumps", "held_marks", "held_log")
CLEARED = ("lag", "held_log")
"""The arrays of an instance that are loaded from `instances`, stored in `results`, and set to zero, if a kernel has them."""


_STILL, _NEAR, _CONSTANT = 1e-5, 1e-6, 1e-15
"""Scaled sizes below which y and f do not determine a first step, the trial step then (s), and the scaled rate that counts as zero."""


class StepperContext:
    """The arguments of a stepper's kernel, its return code `back`, 0 while it continues, and `asks`, set if a step is not accepted.

    `turned` is 1 if a switch changes sides at the end of the step, `renewed` is 1 if the dependent speeds change there.
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
        """The kernel: calls step(h, last) until there is a reason to return, and `begin()` before a step that is FRESH.

        Steps that are `fixed` have one size. If instances are `queued`, the next one is loaded instead of a return.
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
        """Whether there is a step to take; for a queued instance that has ended, stores its return code and loads the next one."""
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
        """Resets all variables but the return code after a queued instance has ended."""
        for cell in self.writer.cells:
            if cell is not self.back.cell:
                self.writer.add(Put(cell, Immediate(cell.type, 0 if cell.type == INT else 0.0)))

    def begin_step_anew(self) -> None:
        """Restarts: the next step evaluates its initial rates and, unless steps are fixed, chooses its size."""
        self.put(Slot.FRESH, 1.0)
        if not self.fixed:
            self.put(Slot.STEP, 0.0)

    def pass_breakpoint(self) -> None:
        """Moves from just before a breakpoint to just after it, where sampled controllers are evaluated.

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
        """The value of a slot."""
        return self.s[int(at)]

    def put(self, at: Slot, value: Term | float) -> None:
        """Assigns a slot."""
        self.s[int(at)] = value

    def more(self, at: Slot, by: Term | float) -> None:
        """Increments a slot."""
        self.put(at, self.get(at) + by)

    def row(self, k: int) -> Term:
        """The index in `work` of row k of n doubles."""
        return self.n * k

    def rate(self, rhs: Callable[..., None], t: Term, x: Array, at: Term | int, row: Term | int) -> None:
        """Writes f(t, x) to a row of `work`; the state begins at an index of x."""
        self.drive(t, x.at(at))
        rhs(t, x.at(at), self.p.at(0), self.r.at(0), self.h.at(0), self.work.at(row))
        self.more(Slot.RATES, 1.0)

    def drives(self, *takes: Literal["float", "array"], single: bool = False) -> None:
        """Declares the routine, with arguments of types `takes`, that writes the inputs r at a time and state if they are `driven`.

        With `single`, a second routine writes `single_r` for one state, beside the first one, which works on lanes.
        """
        w = self.writer
        self._drive, self.single_r = w.callee("drive", *takes), w.array("single_r") if single else self.r
        self._drive_single = w.callee("single_drive", *RATE) if single else self._drive

    def drive(self, t: Term | Address, x: Address, single: bool = False) -> None:
        """Evaluates the inputs at a time and state; those for one state if `single`."""
        drive, r = (self._drive_single, self.single_r) if single else (self._drive, self.r)
        with self.writer.when(self.driven > 0):
            drive(t, x, self.p.at(0), r.at(0), self.hd.at(0), r.at(0))

    def follow(self, t: Term | Address, x: Address) -> None:
        """Evaluates the inputs again at changed states, if they depend on these."""
        with self.writer.when(self.driven > 1):
            self._drive(t, x, self.p.at(0), self.r.at(0), self.hd.at(0), self.r.at(0))

    def first_step(self, exponent: float, rhs: Callable[..., None], now: int | Term, state: Term, moved: Term) -> None:
        """`choose_step` with rates of one state: `now` is the row of f(t, y), `state` and `moved` are free rows."""

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
        """If STEP is zero, chooses a step over which an Euler step and the change of the rates are small.

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
        """The tolerance of component i, atol + rtol |y_i|, with the larger of its values at both ends of the step."""
        w = self.writer
        size = w.compute("max", w.compute("abs", self.y[i]), w.compute("abs", end))
        return self.get(Slot.ATOL) + self.get(Slot.RTOL) * size

    def largest_error(self, largest: Variable, of: Callable[[Term], Term]) -> None:
        """Sets `largest` to the largest error of a component, NaN if one is NaN, and WORST to the index of that component."""
        w = self.writer
        largest.put(0.0)
        with w.count(self.n) as i:
            error, before = of(i), largest.get()
            with w.when(~(error <= before)):
                largest.put(w.compute("max", before, error))
                self.put(Slot.WORST, w.compute("float", i))

    def power(self, error: Term, exponent: float) -> tuple[Term, Term]:
        """Whether an error is finite, and error**exponent, by which step sizes are divided."""
        w, finite = self.writer, error < _LARGE
        return finite, dyadic_power(w, w.compute("max", w.select(finite, error, 1.0), _SMALLEST), exponent)

    def length(self) -> tuple[Term, Term]:
        """The size of the next step, and whether it reaches the end."""
        w = self.writer
        left = (self.get(Slot.END) - self.get(Slot.TIME)) - self.get(Slot.TIME_LAG)
        wished = w.compute("min", w.compute("max", self.get(Slot.STEP), self.shortest()), self.get(Slot.LONGEST))
        last = wished >= left
        return w.select(last, left, wished), last

    def shortest(self) -> Term:
        """The smallest step size, above the rounding of the time."""
        return self.get(Slot.SHORTEST) + _TEN_ROUNDINGS * self.writer.compute("abs", self.get(Slot.TIME))

    def sample(
        self, h: Term, prepare: Callable[[], None], write: Callable[[Term, Term], None], until: Term | None = None
    ) -> None:
        """Calls `write(k, θ)` for each sample in a step, or before the time `until`, and `prepare()` before the first of them."""
        w = self.writer
        cursor, prepared = self.cursor, self.prepared
        cursor.put(w.compute("int", self.get(Slot.SAMPLE)))
        prepared.put(0)

        def share() -> Term:
            return self.share_of(cursor.get(), h)

        def within() -> Term:
            # `times` has one entry after the samples, beyond the end
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
        """The share θ of a step at which sample k lies."""
        return ((self.times[k] - self.get(Slot.TIME)) - self.get(Slot.TIME_LAG)) / h

    def has_sample(self, h: Term) -> Term:
        """Whether a step contains samples; `times` has one entry after these, beyond the end."""
        k = self.writer.compute("int", self.get(Slot.SAMPLE))
        return (k < self.samples) & (self.share_of(k, h) <= 1.0)

    def advance(self, h: Term, last: Term) -> None:
        """Sets the time to t + h, or to the end itself; counts the step, and sets the return code if it is time to return."""
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
        """Marks the arrival at a breakpoint, or sets the return code END."""
        w = self.writer
        ahead = self.get(Slot.BREAKPOINT) < w.compute("float", self.breakpoints)
        self.arrived.put(w.select(ahead, w.integer(1), w.integer(0)))
        self.back.put(w.select(ahead, self.back.get(), w.integer(ReturnCode.END)))

    def count_taken(self) -> None:
        """Counts an accepted step; sets the return code LIMIT after as many as allowed."""
        self.taken.put(self.taken.get() + 1)
        with self.writer.when(self.taken.get() >= self.limit):
            self.back.put(int(ReturnCode.LIMIT))

    def shorten(self, wished: Term, finite: Term) -> None:
        """Rejects a step: it is repeated with the size `wished`, unless that is below the rounding of the time."""
        w = self.writer
        self.put(Slot.STEP, wished)
        self.more(Slot.REJECTED, 1.0)
        with w.when(wished < self.shortest()):
            self.back.put(w.select(finite, w.integer(ReturnCode.UNDERFLOW), w.integer(ReturnCode.NOT_FINITE)))


def turned_over(arguments: Sequence[Argument]) -> list[str]:
    """The arrays that belong to one instance of a queue, in the order of the arguments."""
    own = {*LOADED, *SAVED, *CLEARED}
    return [a.name for a in arguments if isinstance(a, ArrayOf) and a.name in own]


_TEN_ROUNDINGS = 10 * EPS
_LARGE, _SMALLEST = 1e300, 2.0**-1000
_INTERVALS = 4.0
"""Largest first step after an action, in intervals between the last two actions: the next one may follow as soon."""


def dyadic_power(w: Writer, x: Term, exponent: float) -> Term:
    """x**exponent for a sum below 1 of halves, quarters, …, by square roots: these are correctly rounded in every language."""
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
    """y_i + change by compensated summation: the rounded sum and its rounding error."""
    old = y[i]
    more = change + lag[i]
    new = old + more
    return new, more - (new - old)


def of_others(differences: Sequence[Term], first: Term, one: Term) -> Iterator[Term]:
    """For each difference, `first` times the product of the others, as in Lagrange polynomials."""
    below, above = [first], [one]
    for d in differences[:-1]:
        below.append(below[-1] * d)
    for d in reversed(differences[1:]):
        above.append(above[-1] * d)
    return (a * b for a, b in zip(below, reversed(above), strict=True))
