# SPDX-License-Identifier: BSD-3-Clause
"""Continuation of the root x of a square system f(x, d) = 0 along rows of data d, on the branch of the first root.

Roots are extrapolated and corrected by Newton's method, whose contraction decides whether they are on the branch (Deuflhard 2011,
Newton Methods for Nonlinear Problems, sec. 5.1). If not, d is varied along the line from the last row in steps, which are halved
until Newton's method contracts. det ∂f/∂x has a constant sign along a branch without singular points, which separates it from the
one that it meets at a fold. The branch ends where steps become too small. All of this is one kernel, which calls f as machine code.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Literal, NamedTuple

import numpy as np

from kane.numeric.arrays import Array
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.rows import LANES, Rows
from kane.program.kernel.writer import Term, Writer
from kane.program.native.compiled_routine import CompiledRoutine
from kane.program.native.entry import CompiledKernel, entry, hoist_entry
from kane.program.native.machine import Settings

_EXTRAPOLATED = {2: (2.0, -1.0), 3: (3.0, -3.0, 1.0), 4: (4.0, -6.0, 4.0, -1.0)}
"""Coefficients of extrapolation from 2, 3 or 4 last roots, the latest first."""
_FAR, _CONTRACTS = 0.5, 0.25
"""Largest first Newton step relative to the sizes of x, and largest ratio of successive steps."""
_ENOUGH = 1e-9
"""Newton steps below this converge, as their squares are below rounding; for unmeasured x, relative to their own sizes."""
_FINITE = 1e300
_STEPS = 12
_PARTS, _LEAST = 400, 2.0**-20
"""Largest number of steps between two rows, and shortest step as a fraction of the distance."""
_ROWS = 10_000
"""Number of rows in one call; keyboard interrupts are handled between calls."""
_OLD = 4
"""Number of roots kept for extrapolation."""
_LAST, _RUN, _NEGATIVE = range(3)
"""Indices in `s`: the row of the last root, the number of consecutive roots up to it, whether det ∂f/∂x is negative there."""
_FOUND, _ENDED = 1.0, 2.0


class BranchEnd(NamedTuple):
    """The end of a branch between the row `last` and another: after a `share` of the distance, at `x`."""

    last: int
    share: float
    x: Array


class Followed(NamedTuple):
    """The roots x (k × n), NaN for rows that were not reached, and the branch end for each of these."""

    x: Array
    ends: Mapping[int, BranchEnd]


class SquareEquations(NamedTuple):
    """f (n) and ∂f/∂x (n × n)."""

    f: Array
    gradient: Array


class Unknowns(NamedTuple):
    """The indices of x among the values of the ports after t, the sizes of x and of f, and the number of `measured` x.

    The first `measured` x determine the length of a step. f is linear in the others, which converge when steps no longer change them;
    where the equations are singular within rounding, steps always do.
    """

    places: Sequence[int]
    sizes: Array
    rows: Array
    measured: int


def follow(routine: CompiledRoutine, data: Array, x: Array, unknowns: Unknowns) -> Followed:
    """The roots at rows of `data` (k × d), given the root x (n) at the first row; a row contains t and the values of the other ports.

    `routine`, with arguments t, a state, parameters and others, returns f, then ∂f/∂x row by row. A row that is not reached is
    skipped, and the next ones are tried from the last root before it.
    """
    n, ports = len(x), [len(port.symbols) for port in routine.program.ports[1:]]
    places = np.cumsum([1, *ports]).tolist()
    found, ends = np.full((len(data), n), np.nan), np.zeros((len(data), 3))
    roots = np.zeros(_OLD * n + 1)
    roots[:n] = x
    square = -(-n // LANES)
    given = {
        "width": data.shape[1],
        "n": n,
        "measured": unknowns.measured,
        "start": 0,
        "stop": 0,
        **{f"port{k}": place for k, place in enumerate(places[:-1])},
        "data": np.array(data, dtype=float, order="C"),
        "at": np.zeros(data.shape[1] + 1),
        "places": np.append(1.0 + np.array(unknowns.places, dtype=float), 0.0),
        "sizes": np.append(unknowns.sizes, 0.0),
        "rows": np.append(unknowns.rows, 0.0),
        "square": square,
        "room": np.zeros(n * LANES * (square + 1) + n + 1),
        "out": np.zeros(n * n + n + 1),
        "h": np.zeros(max(1, len(routine.program.kept))),
        "roots": roots,
        "s": np.zeros(3),
        "ends": ends,
        "found": found,
        "hoist": hoist_entry(routine),
        "function": entry(routine),
    }
    bound = _compiled(len(ports), routine.settings).bound(given)
    for start in range(0, len(data), _ROWS):
        bound(start=start, stop=min(start + _ROWS, len(data)))
    ended = np.flatnonzero(ends[:, 0] == _ENDED)
    told = {int(k): BranchEnd(int(ends[k, 1]), float(ends[k, 2]), found[k].copy()) for k in ended}
    found[ended] = np.nan
    return Followed(found, told)


@cache
def _compiled(ports: int, settings: Settings) -> CompiledKernel:
    return CompiledKernel(_Following(ports).kernel(), settings)


class _Following:
    """The kernel in construction, for rows from `start` to `stop`; row 0 has the given root."""

    def __init__(self, ports: int) -> None:
        self.writer = w = Writer(f"follow{ports}")
        self.width, self.n, self.measured, self.start, self.stop = map(
            w.number, ("width", "n", "measured", "start", "stop")
        )
        self.ports = [w.number(f"port{k}") for k in range(ports)]
        square = w.number("square")
        self.data, self.at, self.places, self.sizes, self.rows = map(w.array, ("data", "at", "places", "sizes", "rows"))
        self.room, self.out, self.h, self.roots = map(w.array, ("room", "out", "h", "roots"))
        self.s, self.ends, self.found = map(w.array, ("s", "ends", "found"))
        self.hoist = w.callee("hoist", "array", "array")
        arrays: list[Literal["float", "array"]] = ["array"] * (ports + 2)
        self.function = w.callee("function", "float", *arrays)
        self.going, self.steps, self.led, self.parts, self.settled = (
            w.variable(name, INT) for name in ("going", "steps", "led", "parts", "settled")
        )
        self.moved, self.most, self.done, self.part, self.to, self.odd = (
            w.variable(name) for name in ("moved", "most", "done", "part", "to", "odd")
        )
        self.system = Rows(self.room, w.integer(0), self.n, square, square + 1)
        self.right, self.x = square * LANES, self.n * self.system.width

    def kernel(self) -> Kernel:
        """The whole kernel."""
        w = self.writer
        with w.count(self.stop, self.start) as k:
            first = k < 1
            self.led.put(w.select(self.s[_RUN] > 1.0, 0, w.integer(1)))
            self.parts.put(0)
            self.done.put(0.0)
            self.part.put(1.0)
            self.going.put(1)
            with w.few(self.n) as i:  # the point reached so far between rows
                self.found[k * self.n + i] = self.roots[i]
            with w.repeat(lambda: self.going.get() > 0):
                with w.when(self.led.get() < 1):
                    self._extrapolate()
                with w.otherwise():
                    self._set_out(k)
                self._mix(k)
                self._correct()
                alone = self.measured < 1  # linear equations have one branch only
                kept_sign = self.odd.get().equals(self.s[_NEGATIVE]) | alone
                right = (self.going.get() > -1) & (kept_sign | first)
                self.going.put(1)
                self._judge(k, right, first)
            self._keep(k)
        result = w.variable("result", INT)
        result.put(0)
        return w.finished(result)

    def _extrapolate(self) -> None:
        """Extrapolate x from the last roots; if this moves x too far, no Newton step is accepted."""
        w, run = self.writer, self.s[_RUN]
        self.to.put(1.0)
        self.moved.put(0.0)
        with w.few(self.n) as i:
            old = [self.roots[i + self.n * j] for j in range(_OLD)]
            guesses = {
                count: w.sum([x * c for x, c in zip(old, weights, strict=False)])
                for count, weights in _EXTRAPOLATED.items()
            }
            guess = w.select(run > 3.0, guesses[4], w.select(run > 2.0, guesses[3], guesses[2]))
            self.room[self.x + i] = guess
            with w.when(i < self.measured):
                self.moved.put(w.compute("max", self.moved.get(), w.compute("abs", guess - old[0]) / self.sizes[i]))
        moved = self.moved.get()
        self.most.put(w.select(moved <= _FAR, w.compute("max", moved * _CONTRACTS, _ENOUGH), w.constant(-1.0)))

    def _set_out(self, k: Term) -> None:
        """Take x from the part of the distance that is already covered."""
        w = self.writer
        self.to.put(w.compute("min", self.done.get() + self.part.get(), 1.0))
        self.most.put(_FAR)
        with w.few(self.n) as i:
            self.room[self.x + i] = self.found[k * self.n + i]

    def _mix(self, k: Term) -> None:
        """Interpolate the data between the row of the last root and row k."""
        w, to = self.writer, self.to.get()
        last = w.compute("int", self.s[_LAST])
        with w.count(self.width) as i:
            begin, end = self.data[last * self.width + i], self.data[k * self.width + i]
            self.at[i] = w.select(to < 1.0, begin + to * (end - begin), end)

    def _correct(self) -> None:
        """Newton's method from x, with a first step of at most `most`; `going` becomes 0 on convergence, −1 on failure."""
        w, room, n = self.writer, self.room, self.n
        self.steps.put(0)
        with w.repeat(lambda: self.going.get() > 0):
            with w.few(n) as i:
                self.at[w.compute("int", self.places[i])] = room[self.x + i]
            self._evaluate()
            with w.few(n) as i:
                row = 1.0 / self.rows[i]
                room[self.system.row(i) + self.right] = -self.out[i] * row
                with w.few(n) as j:
                    room[self.system.row(i) + j] = self.out[n + i * n + j] * self.sizes[j] * row
            self.odd.put(0.0)
            self.system.solve(self.odd)
            self.moved.put(0.0)
            with w.few(self.measured) as i:
                self.moved.put(w.compute("max", self.moved.get(), w.compute("abs", self._change(i))))
            moved = self.moved.get()
            self.settled.put(1)
            with w.when(moved <= self.most.get()):
                with w.few(n) as i:
                    step, at = self._change(i) * self.sizes[i], self.x + i
                    room[at] = room[at] + step
                    size = w.compute("max", self.sizes[i], w.compute("abs", room[at]))
                    with w.when(~(w.compute("abs", step) <= size * _ENOUGH) & ~(i < self.measured)):
                        self.settled.put(0)
                    with w.when(~(w.compute("abs", room[at]) < _FINITE)):
                        self.settled.put(0)
                        self.steps.put(_STEPS)
                self.most.put(w.compute("max", moved * _CONTRACTS, _ENOUGH))
                self.steps.put(self.steps.get() + 1)
                there = (moved <= _ENOUGH) & (self.settled.get() > 0)
                self.going.put(w.select(there, 0, w.select(self.steps.get() < _STEPS, 1, w.integer(-1))))
            with w.otherwise():
                self.going.put(-1)

    def _evaluate(self) -> None:
        """Evaluate f and ∂f/∂x at the current values."""
        ports = [self.at.at(place) for place in self.ports]
        self.hoist(ports[1], self.h.at(0))
        self.function(self.at[0], *ports, self.h.at(0), self.out.at(0))

    def _change(self, i: Term) -> Term:
        """Newton step of x relative to its size; `odd` is 1 if the determinant is negative."""
        return self.room[self.system.row(i) + self.right]

    def _judge(self, k: Term, right: Term, first: Term) -> None:
        """Accept a root that is `right`, or shorten the step; `going` becomes 0 when the row is finished."""
        w = self.writer
        with w.when(right):
            with w.few(self.n) as i:
                self.found[k * self.n + i] = self.room[self.x + i]
            self.done.put(self.to.get())
            self.part.put(self.part.get() * 2.0)
            self.going.put(w.select(self.done.get() < 1.0, 1, w.integer(0)))
        with w.otherwise():
            with w.when(first):  # the first root is accepted as given
                self.done.put(1.0)
                self.going.put(0)
            with w.otherwise(), w.when(self.led.get() > 0):
                self.going.put(w.select(self.part.get() < _LEAST, 0, w.integer(1)))
                self.part.put(w.compute("min", self.part.get(), 1.0 - self.done.get()) * 0.5)
        self.led.put(1)
        self.parts.put(self.parts.get() + 1)
        with w.when(self.parts.get() > _PARTS):
            self.going.put(0)

    def _keep(self, k: Term) -> None:
        """Store the root of the row as the last one, or record the end of the branch."""
        w, n = self.writer, self.n
        self.ends[k * 3 + 1], self.ends[k * 3 + 2] = self.s[_LAST], self.done.get()
        with w.when(self.done.get() < 1.0):
            self.ends[k * 3] = _ENDED
            self.s[_RUN] = 0.0
        with w.otherwise():
            self.ends[k * 3] = _FOUND
            for j in range(_OLD - 1, 0, -1):
                with w.few(n) as i:
                    self.roots[i + n * j] = self.roots[i + n * (j - 1)]
            with w.few(n) as i:
                self.roots[i] = self.found[k * n + i]
            self.s[_LAST] = w.compute("float", k)
            self.s[_NEGATIVE] = self.odd.get()
            self.s[_RUN] = w.compute("min", self.s[_RUN] + 1.0, float(_OLD))
