# SPDX-License-Identifier: BSD-3-Clause
"""Gaussian elimination with partial pivoting in kernels, on rows of vectors; zero entries below and above a pivot are skipped."""

from collections.abc import Iterator
from contextlib import contextmanager

from kane.program.kernel.language import INT, Type
from kane.program.kernel.writer import Array, Given, Term, Variable, Writer, largest_below

LANES = 8
VECTOR = Type("float", LANES)


@contextmanager
def vectors(w: Writer, stop: Given, start: Given = 0) -> Iterator[Term]:
    """A loop over the vectors from number `start` to before `stop` of a row; yields the index of their first element."""
    with w.few(stop, start) as j:
        yield j * LANES


class Rows:
    """The `count` rows of an array from index `at`: `square` vectors with A, then the right-hand sides, up to `whole` vectors.

    Padding after the last column of A is ignored.
    """

    def __init__(self, a: Array, at: Term, count: Term, square: Term, whole: Term) -> None:
        self.a, self.at, self.count, self.square, self.whole = a, at, count, square, whole
        self.width = whole * LANES

    def row(self, i: Term) -> Term:
        """The index of the first element of row i."""
        return self.at + i * self.width

    def solve(self, odd: Variable | None = None) -> None:
        """Replaces the right-hand sides by the solutions x of A x = b; destroys A. `odd`, 0 or 1, is flipped if det A is negative."""
        self._eliminate(odd)
        self._return()

    def _eliminate(self, odd: Variable | None) -> None:
        """Forward elimination with partial pivoting; vectors before that of the pivot are zero and skipped."""
        a, w = self.a, self.a.writer
        largest = w.variable(f"largest{len(w.cells)}")
        place, begun = (w.variable(f"{name}{len(w.cells)}", INT) for name in ("place", "begun"))
        begun.put(0)
        with w.few(self.count) as k:
            with w.when((begun.get() + 1) * LANES <= k):
                begun.put(begun.get() + 1)
            largest.put(-1.0)
            place.put(k)
            largest_below(a, self.row, self.count, k, largest, place)
            row, other = self.row(k), self.row(place.get())
            swapped = k < place.get()
            with w.when(swapped), vectors(w, self.whole, begun.get()) as j:
                mine, theirs = a.lanes(row + j, LANES), a.lanes(other + j, LANES)
                a.store(other + j, mine)
                a.store(row + j, theirs)
            if odd is not None:
                for negative in (swapped, a[row + k] < 0.0):
                    odd.put(w.select(negative, 1.0 - odd.get(), odd.get()))
            pivot = 1.0 / a[row + k]
            with w.few(self.count, k + 1) as i:
                self._subtract(self.row(i), row, k, pivot, begun.get())

    def _return(self) -> None:
        """Back substitution."""
        a, w = self.a, self.a.writer
        with w.few(self.count) as done:
            k = self.count - 1 - done
            row = self.row(k)
            pivot = w.compute("splat8", 1.0 / a[row + k])
            with vectors(w, self.whole, self.square) as j:
                a.store(row + j, a.lanes(row + j, LANES) * pivot)
            with w.few(k) as i:
                self._subtract(self.row(i), row, k, 1.0, self.square)

    def _subtract(self, row: Term, other: Term, k: Term, pivot: Given, start: Term) -> None:
        """Subtracts a multiple of row `other` from a row, from a vector on, so that its kth entry vanishes."""
        a, w = self.a, self.a.writer
        entry = a[row + k]
        with w.when(~entry.equals(0.0)):  # true for NaN
            share = w.compute("splat8", entry * pivot)
            with vectors(w, self.whole, start) as j:
                a.store(row + j, a.lanes(row + j, LANES) - share * a.lanes(other + j, LANES))
