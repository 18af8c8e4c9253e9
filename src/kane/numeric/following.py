# SPDX-License-Identifier: BSD-3-Clause
"""The root x of f(x, d) = 0, square, followed along rows of data d: each from those before it, on the branch of the first.

What is extrapolated from roots before is corrected by Newton's steps, whose contraction says whether they stay on the branch
(Deuflhard 2011, Newton Methods for Nonlinear Problems, sec. 5.1). Where they do not, the way from the last root is gone in parts, d
varied along a line, halved until they do. Along a branch without singular points det ∂f/∂x keeps its sign, which tells a branch from
the one that it meets at a fold. Where parts become too small the branch ends.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from kane.numeric.arrays import Array

Square = Callable[[Array, Array], tuple[Array, Array]]
"""f (n) and ∂f/∂x (n × n) at x (n) and data (d)."""

_EXTRAPOLATED = {2: (2.0, -1.0), 3: (3.0, -3.0, 1.0), 4: (4.0, -6.0, 4.0, -1.0)}
"""Weights of the last roots, the latest first, in what follows them."""
_FAR, _CONTRACTS = 0.5, 0.25
"""The longest step of x over its size, and the share of a step that the next one may have."""
_ENOUGH = 1e-9
"""A step after which nothing is left but the square of it, which is rounding."""
_STEPS = 12
_PARTS, _LEAST = 400, 2.0**-20
"""So many parts of a way are gone at most, and none is shorter than that share of it."""


class End(NamedTuple):
    """Where a branch ends on the way from the row `last` to another: after a `share` of it, at `x`."""

    last: int
    share: float
    x: Array


class Followed(NamedTuple):
    """The roots x (k × n), NaN where none was reached, and by row what ended the way there."""

    x: Array
    ends: Mapping[int, End]


class _Root(NamedTuple):
    """A root, and whether det ∂f/∂x is negative there."""

    x: Array
    negative: bool


def follow(function: Square, data: Array, x: Array, size: Array, start: int = 0) -> Followed:
    """The roots at the rows of data (k × d) from `start` on, where x (n) is one; `size` (n) measures x.

    A row that the branch does not lead to is left out, and the next ones are tried from the last root before it.
    """
    found, ends = np.full((len(data), len(x)), np.nan), dict[int, End]()
    first = _corrected(function, x, data[start], size)
    at = first or _Root(x, _negative(function(x, data[start])[1]))
    found[start], last, run = at.x, start, [at.x]
    for k in range(start + 1, len(data)):
        new = _extrapolated(function, data[k], size, at, run) if len(run) > 1 else None
        reached = new or _led(function, data[last], data[k], size, at, last)
        if isinstance(reached, End):
            ends[k], run = reached, []
            continue
        at, last = reached, k
        found[k] = at.x
        run = [at.x, *run[:3]]
    return Followed(found, ends)


def _extrapolated(function: Square, data: Array, size: Array, at: _Root, run: list[Array]) -> _Root | None:
    """The root from what the last ones lead to, where that is near; None where it is not."""
    guess = sum((w * x for w, x in zip(_EXTRAPOLATED[len(run)], run, strict=True)), np.zeros(len(at.x)))
    moved = np.abs((guess - at.x) / size).max()
    if not moved <= _FAR:
        return None
    found = _corrected(function, guess, data, size, max(_CONTRACTS * moved, _ENOUGH))
    return found if found is not None and found.negative == at.negative else None


def _led(function: Square, start: Array, end: Array, size: Array, at: _Root, last: int) -> _Root | End:
    """The root at the data `end`, from one at the data `start`, in as few parts as keep to the branch; or where that ends."""
    done, part = 0.0, 1.0
    for _ in range(_PARTS):
        to = min(done + part, 1.0)
        found = _corrected(function, at.x, start + to * (end - start), size)
        if found is not None and found.negative == at.negative:
            at, done, part = found, to, 2 * part
            if done == 1.0:
                return at
        elif part < _LEAST:
            break
        else:
            part = min(part, 1.0 - done) / 2
    return End(last, done, at.x)


def _corrected(function: Square, x: Array, data: Array, size: Array, most: float = _FAR) -> _Root | None:
    """Newton's steps from x, the first of which is no longer than `most`; None where they do not contract."""
    from scipy.linalg.lapack import dgesv

    negative = False
    for _ in range(_STEPS):
        f, g = function(x, data)
        lu, pivots, change, singular = dgesv(g, -f)
        moved = float(np.abs(change / size).max(initial=0)) if not singular else np.inf
        if not moved <= most:
            return None
        negative = _odd(lu, pivots)
        x = x + change
        if moved <= _ENOUGH:
            return _Root(x, negative)
        most = max(_CONTRACTS * moved, _ENOUGH)
    return None


def _odd(lu: Array, pivots: Array) -> bool:
    """Whether the determinant is negative."""
    swaps = np.count_nonzero(pivots != np.arange(len(pivots)))
    return bool((swaps + np.count_nonzero(lu.diagonal() < 0)) % 2)


def _negative(g: Array) -> bool:
    return bool(np.linalg.slogdet(g)[0] < 0)
