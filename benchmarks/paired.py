# SPDX-License-Identifier: BSD-3-Clause
"""Paired timing: two callables in turn, A B A B …, so that a drift of the machine's speed meets both."""

import gc
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Pairs:
    """Times of both sides in seconds, pair by pair."""

    a: tuple[float, ...]
    b: tuple[float, ...]

    @property
    def ratio(self) -> float:
        """Median of b/a, pair by pair."""
        return statistics.median(y / x for x, y in zip(self.a, self.b, strict=True))

    def line(self, name: str, peer: str) -> str:
        """One line: medians, ranges, ratio."""
        a, b = self.a, self.b
        return (
            f"{name} {statistics.median(a) * 1e3:.2f} ms ({min(a) * 1e3:.2f} … {max(a) * 1e3:.2f}), "
            f"{peer} {statistics.median(b) * 1e3:.1f} ms ({min(b) * 1e3:.1f} … {max(b) * 1e3:.1f}), "
            f"ratio {self.ratio:.2f} over {len(a)} pairs"
        )


def paired(
    a: Callable[[], object],
    b: Callable[[], object],
    pairs: int = 15,
    before: tuple[Callable[[], object], Callable[[], object]] = (gc.collect, gc.collect),
    clock: Callable[[], float] = time.perf_counter,
) -> Pairs:
    """Time both in turn; one uncounted run of each first; `before` runs before each run, garbage is collected, neither timed."""
    a()
    b()
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(pairs):
        for f, prepare, record in zip((a, b), before, times, strict=True):
            prepare()
            gc.collect()
            start = clock()
            f()
            record.append(clock() - start)
    return Pairs(tuple(times[0]), tuple(times[1]))
