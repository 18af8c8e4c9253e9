# SPDX-License-Identifier: BSD-3-Clause
"""Whether constraints all but depend on each other everywhere, or lose rank here.

A singular value of A that is small here and ten times as large where A has changed by a tenth of its size vanishes nearby:
the motion comes through a position at which rank drops. One that is as small there belongs to constraints that are nearly the same by
nature, such as those of a reducer of 10,000 : 1; what it holds must be held.
"""

from collections.abc import Callable

import numpy as np

from kane.motion.projection import Manifold, Mixes, Numbers
from kane.numeric.arrays import Array, Mask
from kane.numeric.rank import Mixed, balance, combinations, mixed, singular
from kane.numeric.scale import DERIVE_RANK, MOTION_RANK

_NEARBY = (0.03, 0.3)
"""Share of its size by which A must have changed at a place that tells what is small here alone."""
_FACTOR = 4.0
_TRIES = 60
_GROWS = 10.0
"""By how much a singular value that vanishes nearby must have grown there."""

Place = Callable[[Array], Numbers]


def mixes(manifold: Manifold, t: float, x: Array, given: tuple[Array, Array], numbers: Numbers, reach: Array) -> Mixes:
    """What counts in the places of the rows of A, of the configuration constraints and of all, at a state x of values p and r `given`.

    None for rows that count as they are: no singular value is small, or what is small vanishes here.
    """
    nq = manifold.coordinates

    def beside(change: Array) -> Numbers:
        return manifold.project(t, np.append(x[:nq] + change, x[nq:]), *given, reach)[1]

    def mix(count: int) -> Mixed | None:
        a = numbers.a[:count]
        values = combinations(a, reach[:count])[1] if count else np.zeros(0)
        weak = (values > DERIVE_RANK * values[:1]) & (values <= MOTION_RANK * values[:1])
        return mixed(a, reach[:count]) if weak.any() and not _vanishes(numbers, reach, beside, count, weak) else None

    return mix(len(numbers.f)), mix(len(numbers.a))


def _vanishes(numbers: Numbers, reach: Array, beside: Place, count: int, weak: Mask) -> bool:
    """Whether a singular value of the first `count` rows, of those that are `weak`, is much larger at some place beside."""
    size = balance(numbers.a[:count], reach[:count], order=(1, 0))
    sizes = size.rows * size.columns
    here = singular(numbers.a[:count] / sizes)
    sure = int(np.flatnonzero(weak)[0])
    for direction in here.right[sure:] / size.columns[0]:
        change = numbers.w[:, : len(direction)] @ direction
        for sign in (1.0, -1.0):
            a = _nearby(beside, sign * change, numbers.a[:count], sizes)
            if a is not None and np.any(singular(a / sizes).values[weak] > _GROWS * here.values[weak]):
                return True
    return False


def _nearby(beside: Place, along: Array, a: Array, sizes: Array) -> Array | None:
    """A where it has changed by a share of its size on the way `along`, None where it does not change."""
    step, factor = 1.0, 0.0
    for _ in range(_TRIES):
        numbers = beside(step * along)
        change = np.abs((numbers.a[: len(a)] - a) / sizes).max() if numbers.finite else np.inf
        if _NEARBY[0] <= change <= _NEARBY[1]:
            return numbers.a[: len(a)]
        wanted = _FACTOR if change < _NEARBY[0] else 1 / _FACTOR
        # between two steps of which one is too short and one too long the halves are tried
        step *= wanted if factor in (0.0, wanted) else wanted**0.5
        factor = wanted
    return None
