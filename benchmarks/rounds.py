# SPDX-License-Identifier: BSD-3-Clause
"""Contenders sampled in turn, A B C A B C …, so that a drift of the machine's speed meets all of them."""

import gc
import statistics
import time
import timeit
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypedDict

Loop = Callable[[int], float]


class Summary(TypedDict):
    """Median and range."""

    median: float
    min: float
    max: float


def summary(values: Sequence[float], unit: float = 1.0) -> Summary:
    """Median and range in a unit."""
    scaled = [v / unit for v in values]
    return Summary(median=statistics.median(scaled), min=min(scaled), max=max(scaled))


def in_turn(loops: Mapping[str, Loop], rounds: int = 15, seconds: float = 0.02) -> dict[str, list[float]]:
    """Seconds a call of each contender, round by round; `loop(n)` gives the seconds of n calls, a sample takes `seconds`."""
    calls = {name: _calls(loop, seconds) for name, loop in loops.items()}
    found: dict[str, list[float]] = {name: [] for name in loops}
    gc.collect()
    for _ in range(rounds):
        for name, loop in loops.items():
            found[name].append(loop(calls[name]) / calls[name])
    return found


def _calls(loop: Loop, seconds: float) -> int:
    n = 1
    while (taken := loop(n)) < seconds / 4:
        n *= 4
    return max(1, round(n * seconds / taken))


def python_loop(function: Callable[..., Any], *arguments: Any) -> Loop:
    """Calls from Python with positional arguments, in processor time."""
    names = {f"a{i}": value for i, value in enumerate(arguments)}
    call = f"f({', '.join(names)})"
    return timeit.Timer(call, timer=time.process_time, globals={"f": function, **names}).timeit
