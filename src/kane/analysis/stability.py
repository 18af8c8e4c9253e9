# SPDX-License-Identifier: BSD-3-Clause
"""Where, along a branch of steady motions, an eigenvalue crosses the imaginary axis: Re λ = 0, by bisection on the branch."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from kane.analysis.point import OperatingPoint
from kane.errors import Attributes
from kane.numeric.arrays import Array, Complex
from kane.numeric.scale import ROUNDED, ROUNDED_ROOT

Middle = Callable[[Array, Array], Array | None]
Spectrum = Callable[[Array], Complex]

_BISECTIONS = 60


@dataclass(frozen=True, slots=True, eq=False)
class Crossing(Attributes):
    """An eigenvalue on the imaginary axis: i ω of a pair where swinging sets in, 0 where the motion begins to fall over.

    Where a switch of the equations takes it across at once, `eigenvalue` is that on the side nearer to the axis, and has a real part.
    `value` is that of the symbol that changes, `point` the steady motion there, `between` the indices of the branch's points before
    and after it; `grows` says whether the mode grows after it, or no longer.
    """

    value: float
    eigenvalue: complex
    point: OperatingPoint
    between: tuple[int, int]
    grows: bool

    def __repr__(self) -> str:
        return f"Crossing({self.value:.9g}, λ = {self.eigenvalue:.6g}, {'grows' if self.grows else 'decays'} after it)"


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """The place Y in interval k of a path at which the eigenvalue `root` comes to grow, or to decay."""

    interval: int
    y: Array
    root: complex
    grows: bool


def tracked(rows: Sequence[Complex]) -> Complex:
    """Rows of numbers, each put in the order that is nearest to the row before."""
    ordered = [np.asarray(rows[0])]
    for row in rows[1:]:
        guess = 2 * ordered[-1] - ordered[-2] if len(ordered) > 1 else ordered[-1]
        ordered.append(_matched(row, np.abs(guess[:, None] - row)))
    return np.array(ordered)


def changes(path: Sequence[Array], roots: Sequence[Complex], middle: Middle, spectrum: Spectrum) -> list[Change]:
    """Where modes come to grow or to decay along a path.

    Parameters
    ----------
    path : points Y, near enough to each other that `middle` finds the branch between two of them
    roots : the eigenvalues at each
    middle : the point of the branch halfway between two, None where there is none
    spectrum : the eigenvalues at a point
    """
    size = max((float(np.abs(r).max(initial=0)) for r in roots), default=0.0)
    least = ROUNDED_ROOT * size
    crossings = []
    for k, (first, last) in enumerate(pairwise(roots)):
        before, after = tracked([first, last])
        met: list[Change] = []
        for j, (start, end) in enumerate(zip(before.tolist(), after.tolist(), strict=True)):
            grows = end.real > least
            if (start.real > least) == grows or (start.imag < 0 and end.imag < 0):
                continue
            y, root = _bisected((path[k], before), (path[k + 1], after), j, least, middle, spectrum)
            new = Change(k, y, root, grows)
            # of a conjugate pair one is enough; where a pair is real at one end only, both of it come here
            if (start.imag == 0 and end.imag == 0) or not any(_same(new, c, least) for c in met):
                met.append(new)
        crossings += met
    return crossings


def _same(one: Change, other: Change, least: float) -> bool:
    """Whether two changes are those of a pair."""
    apart = np.linalg.norm(one.y - other.y)
    return bool(one.grows == other.grows and apart < ROUNDED_ROOT and abs(one.root - other.root) <= 10 * least)


def _bisected(
    a: tuple[Array, Complex], b: tuple[Array, Complex], k: int, least: float, middle: Middle, spectrum: Spectrum
) -> tuple[Array, complex]:
    """Y and i |ω| where Re λ of mode k passes zero; where one end lies on the axis but for rounding, where it leaves it.

    Where Re λ jumps over zero, λ beside it.
    """
    level = 0.0 if min(abs(a[1][k].real), abs(b[1][k].real)) > least else least
    for _ in range(_BISECTIONS):
        y = middle(a[0], b[0]) if np.linalg.norm(b[0] - a[0]) > ROUNDED else None
        if y is None:
            break
        # in the order of those before and after: the modes together, so that none takes another's place
        roots = spectrum(y)
        roots = _matched(roots, np.abs(a[1][:, None] - roots) + np.abs(b[1][:, None] - roots))
        if (roots[k].real > level) == (b[1][k].real > level):
            b = y, roots
        else:
            a = y, roots
    y, roots = min(a, b, key=lambda end: abs(end[1][k].real))
    frequency = abs(roots[k].imag)
    if np.linalg.norm(b[0] - a[0]) <= 10 * ROUNDED and abs(b[1][k].real - a[1][k].real) > 100 * least:
        return y, complex(roots[k])  # a switch takes it across
    return y, complex(0.0, frequency if frequency > 10 * least else 0.0)


def _matched(row: Complex, distance: Array) -> Complex:
    """The row in the order in which all distances together are least; of several such, that in which more modes stay where they are.

    A mode on the axis that stays and one that passes it would otherwise be told apart by rounding.
    """
    from scipy.optimize import linear_sum_assignment

    least = ROUNDED_ROOT * np.abs(row).max(initial=0)
    return np.asarray(row[linear_sum_assignment(distance + least * (distance > least))[1]])
