# SPDX-License-Identifier: BSD-3-Clause
"""Where, along a branch of steady motions, an eigenvalue crosses the imaginary axis: Re λ = 0, by bisection on the branch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from kane.simulate.point import OperatingPoint

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]
Middle = Callable[[Array, Array], Array | None]
Spectrum = Callable[[Array], Complex]

GROWS = 1e-7
"""Real part, over the largest eigenvalue, above which a mode grows: below it is what rounding leaves of zero."""
_BISECTIONS, _CLOSE = 60, 1e-13


@dataclass(frozen=True, slots=True, eq=False)
class Crossing:
    """An eigenvalue on the imaginary axis: i ω of a pair where swinging sets in, 0 where the motion begins to fall over.

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
    from scipy.optimize import linear_sum_assignment

    found = [np.asarray(rows[0])]
    for row in rows[1:]:
        guess = 2 * found[-1] - found[-2] if len(found) > 1 else found[-1]
        cost = np.abs(guess[:, None] - row[None, :])
        found.append(row[linear_sum_assignment(cost)[1]])
    return np.array(found)


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
    least = GROWS * max(size, 1.0)
    found = []
    for k, (first, last) in enumerate(pairwise(roots)):
        before, after = tracked([first, last])
        for start, end in zip(before.tolist(), after.tolist(), strict=True):
            grows = end.real > least
            # of a conjugate pair one is enough
            if (start.real > least) != grows and (start + end).imag >= 0:
                y, root = _bisected((path[k], start), (path[k + 1], end), least, middle, spectrum)
                found.append(Change(k, y, root, grows))
    return found


def _bisected(
    a: tuple[Array, complex], b: tuple[Array, complex], least: float, middle: Middle, spectrum: Spectrum
) -> tuple[Array, complex]:
    """Y and λ where Re λ passes zero; where one end lies on the axis but for rounding, where it leaves it."""
    level = 0.0 if min(abs(a[1].real), abs(b[1].real)) > least else least
    for _ in range(_BISECTIONS):
        y = middle(a[0], b[0]) if np.linalg.norm(b[0] - a[0]) > _CLOSE else None
        if y is None:
            break
        roots = spectrum(y)
        root = complex(roots[np.argmin(np.abs(roots - (a[1] + b[1]) / 2))])
        if (root.real > level) == (b[1].real > level):
            b = y, root
        else:
            a = y, root
    y, root = min(a, b, key=lambda end: abs(end[1].real))
    return y, complex(0.0, root.imag)
