# SPDX-License-Identifier: BSD-3-Clause
"""f(x) = 0 by Gauss–Newton steps of least size in a trust region, halved until they help, from one start or from several."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from kane.numeric.arrays import Array
from kane.numeric.projection import least_squares
from kane.numeric.scale import CLOSED, CLOSED_FULLY, FIXED_SHARE

T = TypeVar("T")
Residual = Callable[[Array], tuple[Array, Array]]
"""f (m) and ∂f/∂x (m × n) at x (n)."""

_HALVINGS = 30
_STRAIGHT, _GROWTH = 0.1, 4.0
"""Where f differs from its tangent by no more than this share of a step's change, the trust region grows by this factor."""


@dataclass(frozen=True, slots=True)
class Closed:
    """Where the steps ended, `x` (n), what is left of f there (m), and how many steps it took."""

    x: Array
    residual: Array
    steps: int

    @property
    def size(self) -> float:
        """The largest residual."""
        return float(np.abs(self.residual).max(initial=0))


def close(
    function: Residual,
    x: Array,
    free: Sequence[int],
    limit: float = CLOSED_FULLY,
    steps: int = 60,
    sizes: tuple[Array | float, Array | float] = (1.0, 1.0),
) -> Closed:
    """Steps from x until the residual is below `limit` or falls no more; those of x that are `free` move.

    `sizes` of f (m) and x (n) are what these are measured by. A step moves x by at most the radius of a trust region, which is 1 at
    first and grows where f follows its tangent: what is linear is solved whatever the sizes of x are.
    """
    columns, (rows, wide) = list(free), sizes
    scale = np.broadcast_to(wide, x.shape)[columns]
    f, g = function(x)
    length = np.linalg.norm(f / rows)
    best, radius = Closed(x, f, 0), 1.0
    for step in range(1, steps + 1):
        if not math.isfinite(length) or np.abs(best.residual / rows).max(initial=0) <= limit or not columns:
            break
        slopes = g[:, columns] * scale / np.reshape(rows, (-1, 1))
        change = least_squares(slopes, -f / rows, FIXED_SHARE)
        within = share = radius / max(radius, np.abs(change).max(initial=0))
        before = length
        for _ in range(_HALVINGS):
            x = best.x.copy()
            x[columns] += share * change * scale
            f, g = function(x)
            length = np.linalg.norm(f / rows)
            if length < before:
                break
            share /= 2
        else:
            break
        predicted = share * (slopes @ change)
        curved = np.linalg.norm((f - best.residual) / rows - predicted)
        if within < 1 and curved <= _STRAIGHT * np.linalg.norm(predicted):
            radius *= _GROWTH
        best = Closed(x, f, step)
        if length > (1 - 1e-3 * within) * before:
            break
    return best


def closest(
    function: Residual,
    starts: Iterable[Array],
    free: Sequence[int],
    enough: float = CLOSED,
    limit: float = CLOSED_FULLY,
    astray: Callable[[Array], Array] | None = None,
) -> Closed:
    """From the first start that leaves no more than `enough`, and does not go `astray`; where none does, the one that came nearest."""
    best: Closed | None = None
    for x in starts:
        last = close(function, x, free, limit)
        if last.size <= enough and not (astray is not None and astray(last.x).any()):
            return last
        if best is None or last.size < best.size:
            best = last
    assert best is not None
    return best


def starts(x: Array, free: Sequence[int], seed: int, spreads: Iterable[float]) -> Iterator[Array]:
    """x, then x with those that are `free` displaced at random, by about each of `spreads` in turn."""
    yield x
    generator = np.random.default_rng(seed)
    for spread in spreads:
        other = x.copy()
        other[list(free)] += spread * generator.normal(size=len(free))
        yield other


def improved(at: T, size: Callable[[T], float], change: Callable[[T], T], limit: float, rounds: int) -> T:
    """`at` changed again and again while that makes its size fall, down to `limit`, at most `rounds` times."""
    for _ in range(rounds):
        if not size(at) > limit:
            break
        trial = change(at)
        if not size(trial) < size(at):
            break
        at = trial
    return at
