# SPDX-License-Identifier: BSD-3-Clause
"""Linear equations in kernels by rows of vectors: what is zero below a pivot, and above it on the way back, costs nothing."""

from collections.abc import Iterator
from contextlib import contextmanager

from kane.program.kernel.language import INT, Type
from kane.program.kernel.writer import Array, Given, Term, Variable, Writer

LANES = 8
VECTOR = Type("float", LANES)


@contextmanager
def vectors(w: Writer, stop: Given, start: Given = 0) -> Iterator[Term]:
    """Where the vectors of a row begin, from one to before another."""
    with w.few(stop, start) as j:
        yield j * LANES


class Rows:
    """The `count` rows of an array from `at` on: the entries of A in `square` vectors, right sides in the others up to `whole`.

    The places between, behind the last of A, mean nothing.
    """

    def __init__(self, a: Array, at: Term, count: Term, square: Term, whole: Term) -> None:
        self.a, self.at, self.count, self.square, self.whole = a, at, count, square, whole
        self.width = whole * LANES

    def row(self, i: Term) -> Term:
        """Where a row begins."""
        return self.at + i * self.width

    def solve(self, odd: Variable | None = None) -> None:
        """The right sides become x of A x = b; A is lost. `odd` changes between zero and one with the sign of det A."""
        self._eliminate(odd)
        self._return()

    def _eliminate(self, odd: Variable | None) -> None:
        """Rows from above, the largest entry of a column first; vectors before the pivot's are done with."""
        a, w = self.a, self.a.writer
        largest = w.variable(f"largest{len(w.cells)}")
        place, begun = (w.variable(f"{name}{len(w.cells)}", INT) for name in ("place", "begun"))
        begun.put(0)
        with w.few(self.count) as k:
            with w.when((begun.get() + 1) * LANES <= k):
                begun.put(begun.get() + 1)
            largest.put(-1.0)
            place.put(k)
            with w.few(self.count, k) as i:
                tall = w.compute("abs", a[self.row(i) + k])
                with w.when(tall > largest.get()):
                    largest.put(tall)
                    place.put(i)
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
        """Rows from below."""
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
        """A row without what makes its kth entry vanish, a share of another row, from a vector on."""
        a, w = self.a, self.a.writer
        entry = a[row + k]
        with w.when(~entry.equals(0.0)):  # of NaN, too
            share = w.compute("splat8", entry * pivot)
            with vectors(w, self.whole, start) as j:
                a.store(row + j, a.lanes(row + j, LANES) - share * a.lanes(other + j, LANES))
