# SPDX-License-Identifier: BSD-3-Clause
"""Whether a state is on its constraints: no projection closes those that contradict each other, or that lost rank and hold again.

A residual counts where it is more than the tolerances leave open: those of coordinates and speeds, times the largest
slopes that the constraint has had, and their relative one of the terms that it is made of.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from kane.equations.equations import Equations
from kane.expr.build import mul
from kane.expr.evaluation import evaluate
from kane.expr.node import Expr
from kane.expr.size import Sizes, largest, size
from kane.motion.projection import Numbers
from kane.numeric.arrays import Array
from kane.numeric.scale import CLOSED

_SLACK = 10.0
"""Tolerances that a residual may measure: one step leaves about one."""
_TINY = np.finfo(float).tiny
_ANY = 1 / _TINY**0.5
"""A change of a speed that moves no coordinate, in any unit."""

Tolerances = tuple[float, float]
"""Relative and absolute."""


def missed(
    eom: Equations,
    numbers: Numbers,
    x: Array,
    reach: Array,
    tolerances: Tolerances,
    values: Callable[[], Mapping[Expr, Any]],
) -> str:
    """The constraint that is missed most at x = (q, u, a), and by how much, in words; "" where all hold.

    `reach` (m × n) holds the sizes that entries of A have had, `values` gives a number for every symbol.
    """
    with np.errstate(invalid="ignore"):  # of numbers that are not finite nothing is said here
        residual, slopes = _residuals(numbers, x, reach, tolerances)
    over = np.abs(residual) > slopes
    if not over.any():
        return ""
    terms = np.array(evaluate(_terms(eom, len(residual)), values()), dtype=float)
    limit = slopes + max(_SLACK * tolerances[0], CLOSED) * terms
    off = np.abs(residual) / np.maximum(limit, _TINY)
    worst = int(np.argmax(np.where(np.isfinite(off), off, 0.0)))
    if not off[worst] > 1:
        return ""
    return f"{eom.derived.constraints.constraints[worst].name!r} is missed by {abs(residual[worst]):.3g}"


def _residuals(numbers: Numbers, x: Array, reach: Array, tolerances: Tolerances) -> tuple[Array, Array]:
    """f of configuration constraints, A u + b of motion constraints, and what the tolerances of q and u make of them.

    Rates of configuration constraints are left out: near a position at which rank drops rounding makes much of them, and f tells soon.
    """
    rtol, atol = tolerances
    open_ = _SLACK * (atol + rtol * np.abs(x))
    c, n = len(numbers.f), len(numbers.m)
    nq = len(numbers.w)
    # the change in each speed's direction that leaves every coordinate within its tolerance
    pace, most = np.abs(numbers.w[:, :n]), open_[:nq, None]
    along = np.divide(most, pace, out=np.full(pace.shape, _ANY), where=pace > most / _ANY)
    slopes = reach[:c] @ along.min(axis=0, initial=_ANY)
    if len(numbers.speeds):
        return numbers.f, slopes
    rates = numbers.a[c:] @ x[nq : nq + n] + numbers.b[c:]
    return np.concatenate([numbers.f, rates]), np.concatenate([slopes, reach[c:] @ open_[nq : nq + n]])


def _terms(eom: Equations, count: int) -> list[Expr]:
    """The sizes of the terms of f, and of those of A u + b of motion constraints, sines and cosines taken as 1."""
    rows, memo = eom.derived.constraints, Sizes()
    sizes = [size(k.expr, memo) for k in eom.system.holonomic]
    for a, b in list(zip(rows.a, rows.b, strict=True))[len(sizes) :]:
        sizes.append(largest([*(mul(size(x, memo), u) for x, u in zip(a, eom.speeds, strict=True)), size(b, memo)]))
    return sizes[:count]
