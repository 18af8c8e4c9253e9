# SPDX-License-Identifier: BSD-3-Clause
"""Whether a step leads across a state at which constraints lose rank, or at which the dependent speeds that are stepped do not follow.

Its ends do not tell: a step may be turns long, and where two rows are lost at once their determinant keeps its sign. So A is looked at
between them, closer where it moves far or where its rank may vanish: the least singular value σ changes by no more than A does,

    σ = 0 between two states only if σ₁ + σ₂ ≤ ‖A₂ − A₁‖
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kane.dynamics.constraints.partition import Partition
from kane.numeric.arrays import Array, Mask
from kane.numeric.rank import Mixed, balance
from kane.numeric.scale import MOTION_RANK

Indices = npt.NDArray[np.intp]

_FIRST = 8
"""Parts in which a step is looked at first."""
_FAR = 0.25
"""Change of A from one state to the next, its entries being 1 at most, that is looked at closer."""
_CURVED = 1.5
"""What A moves on a curve, over the distance of its ends."""
_DEPTH = 40
_MOST = 4096
"""How often parts are halved, and how many states are looked at, at most."""
_CLEAR = 10 * MOTION_RANK
"""Share of rank above which a state is away from one at which rank is lost."""
_CLOSE = np.geomspace(1e-4, 0.1, 7)
"""Shares of a step after which it is away from such an end."""


@dataclass(frozen=True, slots=True)
class Along:
    """At several times: A over the sizes that it has had, and its singular value that makes the rank, over the largest too.

    `side` is the sign of the dependent block's determinant, 0 where there is none.
    """

    t: Array
    a: Array
    least: Array
    share: Array
    side: Array

    @property
    def lost(self) -> Mask:
        """Where rank is lost."""
        return np.asarray(self.share < MOTION_RANK)

    def only(self, kept: slice | Indices) -> Along:
        """Some of the times."""
        return Along(self.t[kept], self.a[kept], self.least[kept], self.share[kept], self.side[kept])

    def and_at(self, other: Along) -> Along:
        """These times and others, in order."""
        pairs = zip(
            (self.t, self.a, self.least, self.share, self.side),
            (other.t, other.a, other.least, other.share, other.side),
            strict=True,
        )
        together = Along(*(np.concatenate(pair) for pair in pairs))
        return together.only(np.argsort(together.t))


def looked_at(t: Array, a: Array, partition: Partition, reach: Array, mix: Mixed | None = None) -> Along:
    """A (k × m × n) at times t (k), with the dependent speeds that are stepped; `mix` stands in the places of the rows for rank."""
    finite = np.asarray(np.isfinite(a).all(axis=(1, 2)))
    a = np.where(finite[:, None, None], a, 0.0)
    plain = balance(a, reach, order=(1, 0)).matrix
    scaled = plain if mix is None else balance(mix.rows @ a, mix.reach, order=(1, 0)).matrix
    rank = len(partition.rows)
    values = np.linalg.svd(scaled, compute_uv=False)
    block = plain[:, list(partition.rows)][:, :, list(partition.dependent)]
    side = np.where(finite, np.linalg.slogdet(block)[0], 0.0)
    least = np.where(finite, values[:, rank - 1], np.inf)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = least / values[:, 0]
    return Along(t, scaled, least, np.where(share >= 0, share, np.inf), side)


def crosses(along: Callable[[Array], Along], start: float, end: float) -> bool:
    """Whether a step from `start` to `end` leads across such a state; one at which it begins or ends is none."""
    length = end - start
    at = along(np.linspace(start, end, _FIRST + 1))
    at = _away(along, at, start, length)
    for _ in range(_DEPTH):
        if len(at.t) < 2:
            return False
        if at.lost.any() or (at.side[1:] * at.side[:-1] < 0).any():
            return True
        moved = np.sqrt(((at.a[1:] - at.a[:-1]) ** 2).sum(axis=(1, 2)))
        closer = np.flatnonzero((moved > _FAR) | (at.least[1:] + at.least[:-1] <= _CURVED * moved))
        if not len(closer) or len(at.t) > _MOST:
            return False
        at = at.and_at(along((at.t[closer] + at.t[closer + 1]) / 2))
    return False


def _away(along: Callable[[Array], Along], at: Along, start: float, length: float) -> Along:
    """Without the surroundings of an end at which rank is lost."""
    first, last = (bool(at.share[k] < MOTION_RANK) for k in (0, -1))
    close = [*(start + length * _CLOSE if first else ()), *(start + length * (1 - _CLOSE) if last else ())]
    if not close:
        return at
    at = at.and_at(along(np.array(close)))
    clear = np.flatnonzero(at.share > _CLEAR)
    if not len(clear):
        return at.only(slice(0, 0))
    return at.only(slice(clear[0] if first else 0, clear[-1] + 1 if last else len(at.t)))
