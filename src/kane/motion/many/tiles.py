# SPDX-License-Identifier: BSD-3-Clause
"""Tiles: some instances one after the other on one thread, each one call of machine code that holds no lock of the interpreter.

What a kernel cannot judge, or what needs Python on its way, is left: it is simulated afterwards, one instance after the other. What
warns does so there too, as warnings are the process's. So `run_tile` is all that a thread does, and where several instances would
step at once.
"""

import os
import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from threading import Event as Flag
from typing import Any, NamedTuple

from kane.equations.equations import Equations
from kane.errors import KaneWarning, cut
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
    told: tuple[str, ...] = ()


class Found(NamedTuple):
    """What a tile found of an instance: a motion, and whether it surely keeps its energy, or why there is none; neither is open."""

    motion: Solution | None = None
    kept: bool = False
    error: str = ""


def run_tile(family: Family, runners: Runners, tile: range, stop: Flag) -> list[Found]:
    """The motions of a tile of instances, so far as a kernel decides them."""
    found: list[Found] = []
    own = family.instances.vary_inputs
    runner = None if own else runners.take(family.runner)
    try:
        for k in tile:
            if stop.is_set():
                break
            try:
                found.append(_one(family, family.runner(k) if own else runner, k))
            except Exception as error:
                found.append(Found(error=_words(error)))
    finally:
        if runner is not None:
            runners.give_back(runner)
    return found


def _one(family: Family, runner: Runner | None, k: int) -> Found:
    at = family.instances.at(k)
    if runner is None or at["q"] is None or at["u"] is None:
        return Found()
    start = at["q"], at["u"], at["states"], at["parameters"]
    return Found(*by_runner(runner, family.eom, family.plan, start, at["inputs"]))


def _words(error: Exception) -> str:
    """What was raised, in words: messages of the library stand by themselves."""
    own = type(error).__module__.startswith("kane.")
    return str(error) if own else f"{type(error).__name__}: {cut(str(error), 500)}"


def outcomes(family: Family, threads: int) -> Iterator[tuple[range, list[Outcome]]]:
    """What became of the instances, tile by tile as they are done; the first instance says whether a kernel runs them."""
    first = _first(family)
    tiles = _tiles(family.instances.count, threads)
    if first is None:
        for tile in tiles:
            yield tile, [_whole(family, k, Found()) for k in tile]
        return
    runners, stop = Runners(), Flag()
    runners.give_back(first)
    if threads == 1 or len(tiles) == 1:
        for tile in tiles:
            yield tile, _wholes(family, tile, run_tile(family, runners, tile, stop))
        return
    with ThreadPoolExecutor(threads, thread_name_prefix="kane") as pool:
        try:
            work: dict[Future[list[Found]], range] = {
                pool.submit(run_tile, family, runners, tile, stop): tile for tile in tiles
            }
            for done in as_completed(work):
                tile = work.pop(done)
                yield tile, _wholes(family, tile, done.result())
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


def _wholes(family: Family, tile: range, found: list[Found]) -> list[Outcome]:
    return [_whole(family, k, one) for k, one in zip(tile, found, strict=True)]


def _whole(family: Family, k: int, found: Found) -> Outcome:
    """What became of the kth instance: what is open is simulated, what is doubtful is checked, and what either warns of is kept."""
    if found.error:
        return Outcome(None, found.error)
    if found.motion is not None and found.kept and not family.check:
        return Outcome(found.motion)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", KaneWarning)
        try:
            motion = found.motion
            if motion is None:
                motion = _simulated(family, k)
            else:
                check_kept(motion, family.check)
        except Exception as error:
            return Outcome(None, _words(error), _texts(told))
    return Outcome(motion, told=_texts(told))


def _texts(told: Sequence[warnings.WarningMessage]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(str(one.message) for one in told))


def _simulated(family: Family, k: int) -> Solution:
    options = family.plan._asdict() | {"settings": family.settings, "check": family.check}
    motion: Solution = check_whole(simulate(family.eom, **family.instances.at(k), **options))
    return motion


def cores() -> int:
    """The processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
