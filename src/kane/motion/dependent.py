# SPDX-License-Identifier: BSD-3-Clause
"""Which speeds are dependent at a state of a motion: judged by the numbers there and the sizes that entries of A have had."""

import numpy as np

from kane.dynamics.constraints.partition import POOR, Partition, choose, quality
from kane.equations.derive import repartition
from kane.equations.equations import Equations
from kane.equations.numeric import Numeric
from kane.errors import ReactionError
from kane.motion.projection import Numbers
from kane.numeric.arrays import Array
from kane.numeric.projection import mobility, sizes
from kane.numeric.rank import combinations, sure_rows

_BETTER = 4.0
"""By how much the quality of other dependent speeds must be better for a change."""
_SHORT = 1e-3
"""Quality below which a sample between two steps is read off with other dependent speeds than it was stepped with."""


def better(a: Array, present: Partition, reach: Array, may_grow: bool) -> Partition | None:
    """Other dependent speeds where the present ones are poorly determined by A (m × n), and those much better.

    Those of more rows than the present ones come in question where the rank `may_grow`: at the start.
    """
    now = quality(a, present, reach)
    if now >= POOR:
        return None
    other = choose(a, reach=reach)
    more = len(other.rows) - len(present.rows)
    allowed = more == 0 or (more > 0 and may_grow)
    return other if allowed and quality(a, other, reach) > _BETTER * now else None


def determined(first: Numeric[Equations], present: Equations, numbers: Numbers, reach: Array) -> Equations:
    """Equations whose dependent speeds are determined at a state: the present ones, or others made of the `first`.

    Where rank is lost, dependent speeds are as many as are determined: the accelerations are then those of least size.
    """
    assert present.embedding is not None
    partition = present.embedding.partition
    rank = len(sure_rows(numbers.a, reach))
    reach = np.maximum(reach, sizes(numbers.a, mobility(numbers.m, reach)))
    if rank >= len(partition.rows) and quality(numbers.a, partition, reach) >= _SHORT:
        return present
    try:
        return first.value(repartition, choose(numbers.a, reach=reach).first(min(rank, len(partition.rows))))
    except ReactionError:
        return present


def share_of_rank(a: Array, rank: int, reach: Array) -> float:
    """The singular value of A (m × n) that makes its rank, over the largest; NaN where A is zero."""
    values = combinations(a, reach)[1]
    with np.errstate(invalid="ignore"):
        return float(values[rank - 1] / values[0])
