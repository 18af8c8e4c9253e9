# SPDX-License-Identifier: BSD-3-Clause
"""Small matrices in kernels: square, row after row in an array from a place on."""

from collections.abc import Callable

from kane.program.kernel.language import INT
from kane.program.kernel.write import Array, Given, Term, Writer


def total(w: Writer, count: Given, term: Callable[[Term], Term]) -> Term:
    """The sum of a term for each integer below `count`."""
    cell = w.variable(f"total{len(w.cells)}")
    cell.put(0.0)
    with w.few(count) as k:
        cell.put(cell.get() + term(k))
    return cell.get()


def factor(a: Array, at: Term, width: Term, count: Term) -> None:
    """The leading `count` rows, `width` long, become Cholesky's factor L of what they were; the lower half is read and written."""
    w = a.writer
    with w.few(count) as i, w.few(i + 1) as j:
        row, above = at + i * width, at + j * width
        rest = a[row + j] - total(w, j, lambda k: a[row + k] * a[above + k])
        with w.when(j < i):
            a[row + j] = rest / a[above + j]
        with w.otherwise():
            a[row + j] = w.compute("sqrt", rest)


def solve(a: Array, at: Term, width: Term, count: Term, x: Term) -> None:
    """The `count` doubles at `x` of the same array become the solution of L Lᵀ x = what they were."""
    w = a.writer
    with w.few(count) as i:
        row = at + i * width
        a[x + i] = (a[x + i] - total(w, i, lambda k: a[row + k] * a[x + k])) / a[row + i]
    with w.few(count) as done:
        i = count - done - 1
        below = total(w, done, lambda k: a[at + (i + k + 1) * width + i] * a[x + i + k + 1])
        a[x + i] = (a[x + i] - below) / a[at + i * width + i]


def invert(a: Array, at: Term, size: Term) -> None:
    """Of the rows [B | 1], 2 `size` long, the second half becomes B⁻¹: Gauss and Jordan's, with the largest pivot of each column."""
    w, width = a.writer, size * 2
    best, place = w.variable(f"best{len(w.cells)}"), w.variable(f"place{len(w.cells)}", INT)
    with w.few(size) as k:
        best.put(-1.0)
        with w.few(size, k) as i:
            tall = w.compute("abs", a[at + i * width + k])
            with w.when(tall > best.get()):
                best.put(tall)
                place.put(i)
        row, other = at + k * width, at + place.get() * width
        with w.few(width) as j:
            mine, theirs = a[row + j], a[other + j]
            a[other + j] = mine
            a[row + j] = theirs
        pivot = 1.0 / a[row + k]
        with w.few(width) as j:
            a[row + j] = a[row + j] * pivot
        with w.few(size) as i, w.when((i < k) | (k < i)):
            share = a[at + i * width + k]
            with w.few(width) as j:
                a[at + i * width + j] = a[at + i * width + j] - share * a[row + j]
