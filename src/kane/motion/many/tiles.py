# SPDX-License-Identifier: BSD-3-Clause
"""Tiles: some instances one after the other on one thread, each one call of machine code that holds no lock of the interpreter.

What a kernel cannot judge, or what needs Python on its way, is left open: it is simulated afterwards, one instance after the other.
So `run_tile` is all that a thread does.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from threading import Event as Flag
from typing import Any, NamedTuple

from kane.equations.equations import Equations
from kane.errors import cut, listed_warnings
from kane.motion.many.instances import Instances
from kane.motion.runner import Plan, Runner, Runners
from kane.motion.simulate import by_runner, check_kept, runner_of, simulate
from kane.motion.solution.solution import Solution
from kane.program.native.machine import Settings
from kane.progress import check_whole

_PARTS = 8
"""So many tiles a thread at least, so that none waits long for the last one."""
_MOST = 64
"""Instances of a tile at most: their samples are in memory twice."""


@dataclass(frozen=True, slots=True, eq=False)
class Family:
    """Motions that differ in their instances alone: equations, plan, how to compile, what is checked along each."""

    eom: Equations
    plan: Plan
    settings: Settings | None
    check: Sequence[Any]
    instances: Instances

    def runner(self, k: int = 0) -> Runner | None:
        """A runner with the inputs of the kth instance; None where Python is asked between two steps."""
        at = self.instances.at(k)
        return runner_of(self.eom, self.plan, at["inputs"], self.settings, at["parameters"] or {})


class Outcome(NamedTuple):
    """What became of an instance: its motion, or what was raised in its place, and what was warned of."""

    motion: Solution | None
    error: str = ""
    told: Sequence[str] = ()

    @property
    def is_open(self) -> bool:
        """Whether there is neither."""
        return self.motion is None and not self.error


def run_tile(family: Family, runners: Runners, tile: range, stop: Flag) -> list[Outcome]:
    """What became of a tile of instances; those that no kernel can judge are open, with neither a motion nor an error."""
    runner = None if family.instances.vary_inputs else runners.take(family.runner)
    try:
        return [decided(_by_kernel, family, runner, k) for k in tile if not stop.is_set()]
    finally:
        if runner is not None:
            runners.give_back(runner)


def decided(motion_of: Callable[..., Solution | None], *arguments: Any) -> Outcome:
    """What becomes of an instance, whatever that raises or warns of."""
    with listed_warnings() as told:
        try:
            return Outcome(motion_of(*arguments), "", told)
        except Exception as error:
            return Outcome(None, _words(error), told)


def _by_kernel(family: Family, runner: Runner | None, k: int) -> Solution | None:
    """The motion of the kth instance by a runner, which is its own where there is none for all; None where that cannot judge it."""
    at = family.instances.at(k)
    runner = runner or family.runner(k)
    if runner is None or at["q"] is None or at["u"] is None:
        return None
    start = at["q"], at["u"], at["states"], at["parameters"]
    motion, kept = by_runner(runner, family.eom, family.plan, start, at["inputs"])
    if motion is not None and (not kept or family.check):
        check_kept(motion, family.check)
    return motion


def _words(error: Exception) -> str:
    """What was raised, in words: messages of the library stand by themselves."""
    own = type(error).__module__.startswith("kane.")
    return str(error) if own else f"{type(error).__name__}: {cut(str(error), 500)}"


def outcomes(family: Family, threads: int) -> Iterator[tuple[range, list[Outcome]]]:
    """What became of the instances, tile by tile as they are done; the first one that can start says whether a kernel runs them."""
    first, tiles = _first(family), _tiles(family.instances.count, threads)
    runners, stop = Runners(), Flag()
    if first is None:
        yield from ((tile, [decided(_simulated, family, k) for k in tile]) for tile in tiles)
        return
    runners.give_back(first)
    if threads == 1 or len(tiles) == 1:
        yield from ((tile, _closed(family, tile, run_tile(family, runners, tile, stop))) for tile in tiles)
        return
    with ThreadPoolExecutor(threads, thread_name_prefix="kane") as pool:
        try:
            work = {pool.submit(run_tile, family, runners, tile, stop): tile for tile in tiles}
            for done in as_completed(work):
                tile = work.pop(done)
                yield tile, _closed(family, tile, done.result())
        finally:  # Ctrl-C, or nobody asks any more
            stop.set()
            pool.shutdown(cancel_futures=True)


def _first(family: Family) -> Runner | None:
    """A runner for the first instance; what is wrong with that one is said where it is run."""
    for k in range(family.instances.count):
        try:
            return family.runner(k)
        except Exception:
            continue
    return None


def _tiles(count: int, threads: int) -> list[range]:
    size = max(1, min(_MOST, count // (_PARTS * threads)))
    return [range(k, min(k + size, count)) for k in range(0, count, size)]


def _closed(family: Family, tile: range, found: Sequence[Outcome]) -> list[Outcome]:
    """Instances that are open are simulated."""
    return [decided(_simulated, family, k) if one.is_open else one for k, one in zip(tile, found, strict=True)]


def _simulated(family: Family, k: int) -> Solution:
    options = family.plan._asdict() | {"settings": family.settings, "check": family.check}
    motion: Solution = check_whole(simulate(family.eom, **family.instances.at(k), **options))
    return motion


def cores() -> int:
    """The processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
