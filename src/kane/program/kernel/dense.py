# SPDX-License-Identifier: BSD-3-Clause
"""Small matrices in kernels: square, row after row in an array from a place on."""

from collections.abc import Callable

from kane.program.kernel.language import INT
from kane.program.kernel.writer import Array, Given, Term, Writer


def total(w: Writer, count: Given, term: Callable[[Term], Term]) -> Term:
    """The sum of a term for each integer below `count`."""
    cell = w.variable(f"total{len(w.cells)}")
    cell.put(0.0)
    with w.few(count) as k:
        cell.put(cell.get() + term(k))
    return cell.get()


def unit(i: Term, j: Term) -> Term:
    """An entry of the unit matrix."""
    return i.writer.select(i.equals(j), 1.0, 0.0)


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


def decompose(a: Array, at: Term, size: Term, swaps: Term) -> None:
    """The square matrix at `at` becomes L and R of it with rows swapped; with which, stands at `swaps` in the same array."""
    w = a.writer
    best, place = w.variable(f"best{len(w.cells)}"), w.variable(f"place{len(w.cells)}", INT)
    with w.few(size) as k:
        best.put(-1.0)
        place.put(k)
        with w.few(size, k) as i:
            tall = w.compute("abs", a[at + i * size + k])
            with w.when(tall > best.get()):
                best.put(tall)
                place.put(i)
        row, other = at + k * size, at + place.get() * size
        a[swaps + k] = w.compute("float", place.get())
        with w.when(k < place.get()), w.count(size) as j:
            mine, theirs = a[row + j], a[other + j]
            a[other + j] = mine
            a[row + j] = theirs
        pivot = 1.0 / a[row + k]
        with w.few(size, k + 1) as i:
            below = at + i * size
            share = a[below + k] * pivot
            a[below + k] = share
            with w.count(size, k + 1) as j:
                a[below + j] = a[below + j] - share * a[row + j]


def substitute(a: Array, at: Term, size: Term, swaps: Term, x: Term) -> None:
    """The doubles at `x` of the same array become the solution for what they were, by what `decompose` has left."""
    w = a.writer
    with w.few(size) as k:
        other = w.compute("int", a[swaps + k])
        mine, theirs = a[x + k], a[x + other]
        a[x + other] = mine
        a[x + k] = theirs
    with w.few(size) as i:
        a[x + i] = a[x + i] - total(w, i, lambda k: a[at + i * size + k] * a[x + k])
    with w.few(size) as done:
        i = size - done - 1
        behind = total(w, done, lambda k: a[at + i * size + i + 1 + k] * a[x + i + 1 + k])
        a[x + i] = (a[x + i] - behind) / a[at + i * size + i]
