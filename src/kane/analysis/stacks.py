# SPDX-License-Identifier: BSD-3-Clause
"""Linear equations A x = b at many states, with a certificate of regularity of each A.

A and b are picked from rows of numbers, as routines return them. Elimination skips zeros, as the equations of mechanisms are sparse.
The inverse A⁻¹ from the same factors bounds the least singular value of A, balanced as in `numeric.rank.balance`: σ_min/σ_max ≥
1/(‖A‖ ‖A⁻¹‖) in the Frobenius norm. For a wide A, A Aᵀ takes the place of A. All of this is one kernel, vectorized along
the rows.
"""

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from kane.numeric.arrays import Array, Indices, Mask
from kane.numeric.rank import balanced, surely_regular
from kane.numeric.scale import ROUNDED
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.rows import LANES, VECTOR, Rows, vectors
from kane.program.kernel.writer import Term, Writer
from kane.program.native.entry import CompiledKernel
from kane.program.native.machine import Settings

_STATES = 10_000
"""Number of states in one call; keyboard interrupts are handled between calls."""


class MatrixEntries(NamedTuple):
    """Matrices (k × m × n), given by the `places` of their entries (m × n) in `rows` of numbers (k × …)."""

    rows: Array
    places: Indices

    def of(self, states: Mask | int) -> Array:
        """The matrices at some states."""
        return np.asarray(self.rows[states][..., self.places])


class Stack(NamedTuple):
    """x (k × n × c) and A⁻¹ (k × n × n), undefined where A is singular; `share` is the lower bound of σ_min/σ_max.

    A negative share is no bound: balancing dropped entries as rounding that the inverse contains.
    """

    a: MatrixEntries
    x: Array
    inverse: Array
    share: Array

    def regular(self, threshold: float) -> Mask:
        """Where the least singular value of A, balanced, is certainly above the threshold."""
        sure, lost = np.asarray(self.share > max(threshold, ROUNDED)), self.share < 0
        if lost.any():
            sure[lost] = surely_regular(balanced(self.a.of(lost)), threshold)
        return sure


def solve_each(
    a: MatrixEntries,
    b: MatrixEntries,
    settings: Settings,
    *,
    inverse: bool = False,
    order: Sequence[int] = (0, 1, 0, 1),
    rounding: float = ROUNDED,
) -> Stack:
    """x of A x = b at each state; `order` and `rounding` as in `balance`. For a wide A, the share is that of A Aᵀ, and x is undefined.

    The inverse is returned only if `inverse` is true.
    """
    count, m, sides = len(a.rows), len(a.places), b.places.shape[1]
    result = Stack(a, np.empty((count, m, sides)), np.empty((count, m, m) if inverse else 0), np.empty(count))
    _run(_compiled(settings), b, result, order, rounding)
    return result


def surely_independent(a: MatrixEntries, threshold: float, settings: Settings) -> Mask:
    """Where σ_m/σ_1 of A (m × n, m ≤ n), balanced, is certainly above the threshold."""
    m, n = a.places.shape
    found = solve_each(a, MatrixEntries(a.rows, a.places[:, :0]), settings)
    power = 1 if m == n else 2
    return np.asarray(np.abs(found.share) > max(threshold**power, ROUNDED)) if m < n else found.regular(threshold)


def _run(kernel: CompiledKernel, b: MatrixEntries, found: Stack, order: Sequence[int], rounding: float) -> None:
    a = found.a
    (m, n), sides = a.places.shape, b.places.shape[1]
    wide, tall, across = (-(-size // LANES) for size in (n, m, sides))
    given = {
        "m": m,
        "n": n,
        "sides": sides,
        "wide": wide,
        "tall": tall,
        "across": across,
        "passes": len(order),
        "begin": order[0],
        "wanted": min(1, found.inverse.size),
        "step_a": a.rows.shape[1],
        "step_b": b.rows.shape[1],
        "start": 0,
        "stop": 0,
        "a": np.require(a.rows, float, ["C", "W"]),
        "b": np.require(b.rows, float, ["C", "W"]),
        "of_a": np.append(a.places.astype(float), 0.0),
        "of_b": np.append(b.places.astype(float), 0.0),
        "limit": np.array([rounding]),
        "room": np.zeros(LANES * ((m + 1) * wide + tall + m * (2 * tall + across))),
        "x": found.x,
        "inverse": found.inverse,
        "share": found.share,
    }
    bound = kernel.bound(given)
    for start in range(0, len(found.share), _STATES):
        bound(start=start, stop=min(start + _STATES, len(found.share)))


@cache
def _compiled(settings: Settings) -> CompiledKernel:
    return CompiledKernel(_Eliminating().kernel(), settings)


class _Eliminating:
    """The kernel in construction, for states from `start` to `stop`.

    The array `room` contains S (m × wide), the balanced A, the sizes of its columns and rows, then the rows to be eliminated: A or
    A Aᵀ (tall), b (across) and the unit matrix (tall). All begin at multiples of the vector length, padded with zeros.
    """

    def __init__(self) -> None:
        self.writer = w = Writer("solve_each")
        self.m, self.n, self.sides = map(w.number, ("m", "n", "sides"))
        self.v_wide, self.v_tall, across = (w.number(name) for name in ("wide", "tall", "across"))
        self.wide, self.tall = self.v_wide * LANES, self.v_tall * LANES
        self.passes, self.begin, self.wanted = map(w.number, ("passes", "begin", "wanted"))
        self.step_a, self.step_b = map(w.number, ("step_a", "step_b"))
        self.start, self.stop = map(w.number, ("start", "stop"))
        self.a, self.b, self.of_a, self.of_b, self.limit = map(w.array, ("a", "b", "of_a", "of_b", "limit"))
        self.room, self.x, self.inverse, self.share = map(w.array, ("room", "x", "inverse", "share"))
        self.columns = self.m * self.wide
        self.sizes = self.columns + self.wide
        self.work = self.sizes + self.tall
        self.unit = self.tall + across * LANES
        self.rows = Rows(self.room, self.work, self.m, self.v_tall, self.v_tall * 2 + across)
        self.width, self.v_width = self.rows.width, self.rows.whole
        self.zeros, self.ones = (w.lanes(*[x] * LANES) for x in (0.0, 1.0))
        self.lost, self.norm = map(w.variable, ("lost", "norm"))
        self.axis = w.variable("axis", INT)
        self.most = w.variable("most", VECTOR)

    def kernel(self) -> Kernel:
        """The whole kernel."""
        w = self.writer
        with w.count(self.stop, self.start) as k:
            self._pick(k)
            self._balance()
            with w.when(self.m < self.n):
                self._multiply()
                self.norm.put(self._squares(self.work, self.width, self.v_tall))
            with w.otherwise():
                self.norm.put(self._squares(w.integer(0), self.wide, self.v_wide))
            self.rows.solve()
            self._answer(k)
            with w.when(~(self.m < self.n)):
                self._scale()
            inverted = self._squares(self.work + self.unit, self.width, self.v_tall)
            share = 1.0 / w.compute("sqrt", self.norm.get() * inverted)
            self.share[k] = w.select(self.lost.get() > 0.0, -share, share)
        result = w.variable("result", INT)
        result.put(0)
        return w.finished(result)

    def _pick(self, k: Term) -> None:
        """Load S and the rows to be eliminated, b and the unit matrix."""
        w, room = self.writer, self.room
        with w.few(self.m) as i:
            row = self.work + i * self.width
            with vectors(w, self.v_wide) as j:
                room.store(i * self.wide + j, self.zeros)
            with vectors(w, self.v_width) as j:
                room.store(row + j, self.zeros)
            with w.few(self.n) as j:
                entry = self.a[k * self.step_a + w.compute("int", self.of_a[i * self.n + j])]
                room[i * self.wide + j] = entry
                with w.when(~(self.m < self.n)):
                    room[row + j] = entry
            with w.few(self.sides) as j:
                entry = self.b[k * self.step_b + w.compute("int", self.of_b[i * self.sides + j])]
                room[row + self.tall + j] = entry
            room[row + self.unit + i] = 1.0

    def _balance(self) -> None:
        """Drop rounding residues in S, and divide its columns and rows by their sizes in turn."""
        w, room = self.writer, self.room
        self.most.put(self.zeros)
        with vectors(w, self.m * self.v_wide) as j:
            self.most.put(w.compute("max", self.most.get(), self._size(j)))
        least = w.compute("splat8", self.limit[0] * w.compute("largest", self.most.get()))
        self.lost.put(0.0)
        with vectors(w, self.m * self.v_wide) as j:
            small = self._size(j) <= least
            with w.when(w.compute("any", small & ~room.lanes(j, LANES).equals(self.zeros))):
                self.lost.put(1.0)
            room.store(j, w.select(small, self.zeros, room.lanes(j, LANES)))
        with vectors(w, self.v_wide + self.v_tall) as j:
            room.store(self.columns + j, self.ones)
        self.axis.put(self.begin)
        with w.few(self.passes):
            with w.when(self.axis.get() > 0):
                self._divide_rows()
            with w.otherwise():
                self._divide_columns()
            self.axis.put(1 - self.axis.get())

    def _size(self, place: Term) -> Term:
        return self.writer.compute("abs", self.room.lanes(place, LANES))

    def _divide_rows(self) -> None:
        w, room = self.writer, self.room
        with w.few(self.m) as i:
            row = i * self.wide
            self.most.put(self.zeros)
            with vectors(w, self.v_wide) as j:
                self.most.put(w.compute("max", self.most.get(), self._size(row + j)))
            size = w.compute("largest", self.most.get())
            size = w.select(size.equals(0.0), 1.0, size)
            room[self.sizes + i] = room[self.sizes + i] * size
            share = w.compute("splat8", 1.0 / size)
            with vectors(w, self.v_wide) as j:
                room.store(row + j, room.lanes(row + j, LANES) * share)

    def _divide_columns(self) -> None:
        w, room = self.writer, self.room
        with vectors(w, self.v_wide) as j:
            self.most.put(self.zeros)
            with w.few(self.m) as i:
                self.most.put(w.compute("max", self.most.get(), self._size(i * self.wide + j)))
            size = w.select(self.most.get().equals(self.zeros), self.ones, self.most.get())
            room.store(self.columns + j, room.lanes(self.columns + j, LANES) * size)
            share = 1.0 / size
            with w.few(self.m) as i:
                room.store(i * self.wide + j, room.lanes(i * self.wide + j, LANES) * share)

    def _multiply(self) -> None:
        """Form S Sᵀ, which is eliminated for a wide A."""
        w, room = self.writer, self.room
        with w.few(self.m) as i, w.few(i + 1) as j:
            self.most.put(self.zeros)
            with vectors(w, self.v_wide) as c:
                product = room.lanes(i * self.wide + c, LANES) * room.lanes(j * self.wide + c, LANES)
                self.most.put(self.most.get() + product)
            entry = w.compute("sum", self.most.get())
            room[self.work + i * self.width + j] = entry
            room[self.work + j * self.width + i] = entry

    def _squares(self, begin: Term, step: Term, length: Term) -> Term:
        """The sum of squares of rows that are `step` apart and `length` vectors long."""
        w, room = self.writer, self.room
        self.most.put(self.zeros)
        with w.few(self.m) as i, vectors(w, length) as j:
            entry = room.lanes(begin + i * step + j, LANES)
            self.most.put(self.most.get() + entry * entry)
        return w.compute("sum", self.most.get())

    def _answer(self, k: Term) -> None:
        w, room = self.writer, self.room
        with w.few(self.m) as i:
            row = self.work + i * self.width
            with w.few(self.sides) as j:
                self.x[(k * self.m + i) * self.sides + j] = room[row + self.tall + j]
            with w.when(self.wanted > 0), w.few(self.m) as j:
                self.inverse[(k * self.m + i) * self.m + j] = room[row + self.unit + j]

    def _scale(self) -> None:
        """Turn the inverse into that of S."""
        w, room = self.writer, self.room
        with w.few(self.m) as i:
            own = w.compute("splat8", room[self.columns + i])
            with vectors(w, self.v_tall) as j:
                place = self.work + i * self.width + self.unit + j
                room.store(place, room.lanes(place, LANES) * own * room.lanes(self.sizes + j, LANES))
