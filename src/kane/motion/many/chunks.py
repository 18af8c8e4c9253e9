# SPDX-License-Identifier: BSD-3-Clause
"""Chunks: consecutive instances whose results are computed, kept or sent, and written together.

The division of a chunk into tiles depends on its length alone, so that results depend neither on threads nor on the process.
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
"""Largest size of a result in memory (bytes)."""
_BYTES = 2**26
"""Largest size of a chunk (bytes)."""
_LEAST, _LARGE, _CHUNKS = 64, 4096, 32
"""Default sizes: about `_CHUNKS` chunks, of `_LEAST` to `_LARGE` instances each."""
_OTHER = 256
"""Approximate size of the status, cause and final state of an instance (bytes)."""


@dataclass(frozen=True, eq=False)
class Job:
    """Many motions: the ensemble, the quantities recorded at the times t, and the attributes of the resulting Dataset."""

    family: Ensemble
    kept: Sequence[RecordedQuantity]
    t: Array
    facts: Mapping[str, Any]

    def __reduce__(self) -> tuple[Any, ...]:
        return Job, (self.family, self.kept, self.t, self.facts)

    @property
    def count(self) -> int:
        """The number of motions."""
        return self.family.instances.count

    @cached_property
    def pool(self) -> Pool | ContactPool | None:
        """The compiled kernels, made once in each process."""
        return prepared(self.family)

    def results(self, tiles: Sequence[range], threads: int, told: Callable[[int], Any] = lambda done: None) -> Results:
        """Results of consecutive tiles; `told` is called after each with the number of instances completed."""
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
        """Approximate size of the results of an instance (bytes)."""
        kept = [1 if one.reduce else prod(one.shape(self.family.eom, len(self.t))) for one in self.kept]
        return 8 * sum(kept) + _OTHER

    def chunk_size(self) -> int:
        """Default number of instances in a chunk."""
        size = min(_LARGE, max(_LEAST, -(-self.count // _CHUNKS)))
        return max(1, min(size + -size % _LEAST, _BYTES // self.bytes_of_one()))

    def check_size(self) -> None:
        """Raises SimulationError if the results are too large for memory."""
        size = self.count * self.bytes_of_one()
        if size > LARGEST:
            raise SimulationError(
                f"Expected results of at most {LARGEST / 2**30:g} GiB in memory, got {size / 2**30:.3g} GiB of {self.count} instances "
                f'at {len(self.t)} times. Write them to a store, store="runs.zarr", or keep less: samples=, outputs=, reduce=.'
            )
