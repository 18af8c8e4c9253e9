# SPDX-License-Identifier: BSD-3-Clause
"""Which places of its vectors a piece of a long function is given pointers to, so that its code is short.

An instruction that reads memory holds the offset from a pointer: in one byte where that is less than 16 doubles, else in four. Of long
code the processor waits for the bytes of its instructions, and half of them read or write memory. So a piece has several pointers into
the vectors that it uses most: of each place one is the nearest, and no two pointers of one vector are for the same place.
"""

import itertools
from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from kane.program.kernel.language import Read, Statement, Write

REACH = 16
"""Doubles before a pointer, and from it on, that an offset of one byte reaches."""
_MOST = 8
"""Pointers of a piece: few more are in registers than those in which arguments are passed."""
_WORTH = 6
"""Reads and writes for which another pointer is worth being computed and passed."""


@dataclass(frozen=True, slots=True)
class Near:
    """The places of a vector to which there are pointers, ascending, and the last place for which each but the last is the nearest."""

    places: tuple[int, ...]
    last: tuple[int, ...]

    def nearest(self, place: int) -> tuple[int, int]:
        """Which pointer is the nearest to a place, and the offset from it."""
        k = bisect_left(self.last, place)
        return k, place - self.places[k]


def pointed(body: Iterable[Statement]) -> dict[str, Near]:
    """Of each vector that statements read or write, the places to which pointers save the most."""
    used: dict[str, Counter[int]] = {}
    for s in body:
        if isinstance(s, Read | Write) and isinstance(s.offset, int):
            used.setdefault(s.base, Counter())[s.offset] += 1
    chosen: dict[str, list[int]] = {base: [] for base in used}
    best = {base: _window(count) for base, count in used.items()}
    while best:
        # the first one of each vector is wanted whatever it saves
        base = max(best, key=lambda b: (not chosen[b], best[b][1]))
        start, saved = best[base]
        if chosen[base] and (saved < _WORTH or sum(map(len, chosen.values())) >= _MOST):
            break
        chosen[base].append(start + REACH)
        for place in range(start, start + 2 * REACH):
            used[base].pop(place, None)
        if used[base]:
            best[base] = _window(used[base])
        else:
            del best[base]
    return {base: _near(sorted(places)) for base, places in chosen.items()}


def _near(places: Sequence[int]) -> Near:
    return Near(tuple(places), tuple((a + b) // 2 for a, b in itertools.pairwise(places)))


def _window(count: Counter[int]) -> tuple[int, int]:
    """The first of as many places in a row as one pointer reaches, and how often those are used, for the most of them."""
    places: Sequence[int] = sorted(count)
    total = [0]
    for place in places:
        total.append(total[-1] + count[place])
    ends = [bisect_right(places, place + 2 * REACH - 1) for place in places]
    saved, k = max((total[end] - total[k], -k) for k, end in enumerate(ends))
    return places[-k], saved
