# SPDX-License-Identifier: BSD-3-Clause
"""Chunks: consecutive instances whose results are made, kept or sent, and written together.

How a chunk is cut into tiles follows from its length alone, so that its numbers depend neither on threads nor on the process.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import Any

from kane.errors import SimulationError
from kane.motion.many.results import RecordedQuantity, Results
from kane.motion.many.tiles import MOST, ContactPool, Ensemble, Pool, cut_into, outcomes, prepared
from kane.numeric.arrays import Array

LARGEST = 2**31
"""Bytes of a result that is kept in memory."""
_BYTES = 2**26
"""Bytes of a chunk at most."""
_LEAST, _LARGE, _CHUNKS = 64, 4096, 32
"""Instances of a chunk unless told: `_CHUNKS` chunks of so many at least and at most."""
_OTHER = 256
"""Bytes of an instance's status, cause and last state, about."""


@dataclass(frozen=True, eq=False)
class Job:
    """Many motions: the family, what is kept of each at the times t, and what is told of all in attributes."""

    family: Ensemble
    kept: Sequence[RecordedQuantity]
    t: Array
    facts: Mapping[str, Any]

    def __reduce__(self) -> tuple[Any, ...]:
        return Job, (self.family, self.kept, self.t, self.facts)

    @property
    def count(self) -> int:
        """How many motions there are."""
        return self.family.instances.count

    @cached_property
    def pool(self) -> Pool | ContactPool | None:
        """Kernels, made once; another process makes its own."""
        return prepared(self.family)

    def results(self, tiles: Sequence[range], threads: int, told: Callable[[int], Any] = lambda done: None) -> Results:
        """Results of consecutive tiles; `told` hears after each how many instances are done."""
        rows = range(tiles[0].start, tiles[-1].stop)
        result = Results(self.family.eom, self.kept, self.t, self.family.instances, rows)
        for tile in outcomes(self.family, self.pool, tiles, threads):
            result.put(tile)
            told(result.done)
        return result

    def chunk(self, rows: range, threads: int, told: Callable[[int], Any] = lambda done: None) -> Results:
        """Results of a chunk."""
        return self.results(cut_into(rows, max(16, min(MOST, len(rows) // 16))), threads, told)

    def bytes_of_one(self) -> int:
        """Bytes that the results of an instance take, about."""
        kept = [1 if one.reduce else prod(one.shape(self.family.eom, len(self.t))) for one in self.kept]
        return 8 * sum(kept) + _OTHER

    def chunk_size(self) -> int:
        """Instances of a chunk unless told."""
        size = min(_LARGE, max(_LEAST, -(-self.count // _CHUNKS)))
        return max(1, min(size + -size % _LEAST, _BYTES // self.bytes_of_one()))

    def check_size(self) -> None:
        """A SimulationError where results are too large to be kept in memory."""
        size = self.count * self.bytes_of_one()
        if size > LARGEST:
            raise SimulationError(
                f"Expected results of at most {LARGEST / 2**30:g} GiB in memory, got {size / 2**30:.3g} GiB of {self.count} instances "
                f'at {len(self.t)} times. Write them to a store, store="runs.zarr", or keep less: samples=, outputs=, reduce=.'
            )
