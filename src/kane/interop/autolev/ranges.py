# SPDX-License-Identifier: BSD-3-Clause
"""Names with ranges: Q{3} for q1, q2, q3, P{2}o for p1o, p2o, in declarations and in lists of unknowns."""

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from typing import Any

from kane.interop.autolev.grammar import Line

MOST_NAMES = 2_000
Number = Callable[[Any, Line], int]
"""A function that reads an integer."""


def names_of(item: Sequence[Any], number: Number, line: Line) -> Iterator[tuple[str, int]]:
    """The names denoted by a name with ranges and primes, Q{3}' for q1, q2, q3, each with the number of primes."""
    name, ranges, primes = str(item[0]), item[1], item[2]
    *told, end = ranges.children if ranges is not None else (None,)
    whole = name + (end or "") + (primes or "")
    count = whole.count("'")
    base, tail = name.rstrip("'"), (end or "").rstrip("'")
    if not told:
        yield base, count
        return
    spans = [_span(x, number, line) for x in told]
    if len(spans) > 1 and all(x.children[1] is None for x in told):
        spans = [range(1, span[-1] + 1) for span in spans]
    total = 1
    for span in spans:
        total *= len(span)
    if total > MOST_NAMES:
        raise line.refuse(f"at most {MOST_NAMES} names of one declaration", total)
    for indices in product(*spans):
        yield base + "".join(map(str, indices)) + tail, count


def _span(tree: Any, number: Number, line: Line) -> range:
    first = number(tree.children[0], line)
    if tree.children[1] is None:
        return range(1, first + 1)
    last = number(tree.children[1], line)
    if not 0 <= last - first < MOST_NAMES:
        raise line.refuse(f"a range of at most {MOST_NAMES} that goes up", f"{first}:{last}")
    return range(first, last + 1)
