# SPDX-License-Identifier: BSD-3-Clause
"""Tiles: some instances one after the other on one thread, each one call of machine code that holds no lock of the interpreter.

What a kernel cannot judge, or what needs Python on its way, is left open: it is simulated afterwards, one instance after the other.
So `run_tile` is all that a thread does, and `batch.py` where a tile is one call.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from threading import Event as Flag
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from kane.analysis.state_checks import start_state
from kane.dynamics.readings.quantities import parameter_values
from kane.equations.equations import Equations
from kane.errors import cut, listed_warnings
from kane.expr.node import Expr
from kane.motion.many.batch import Batch, fits
from kane.motion.many.instances import Instances
from kane.motion.runner import Plan, Runner, check_values
from kane.motion.simulate import by_runner, check_kept, runner_of, simulate
from kane.motion.solution.phases import Phase
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.program.native.machine import Settings
from kane.progress import check_whole

T = TypeVar("T")

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


class Outcome(NamedTuple, Generic[T]):
    """What became of an instance: its motion, or what was raised in its place, and what was warned of."""

    found: T | None
    error: str = ""
    told: Sequence[str] = ()

    @property
    def is_open(self) -> bool:
        """Whether there is neither."""
        return self.found is None and not self.error


@dataclass(frozen=True, slots=True, eq=False)
class Bound:
    """What a thread runs tiles with: a runner, unless each instance has its own, and its batch, where it is run in one call."""

    runner: Runner | None
    batch: Batch | None = None


class Pool:
    """As many of a family's as have run tiles at the same time; `first` is one of them."""

    def __init__(self, family: Family, first: Runner) -> None:
        self.family = family
        self._free = [self._bound(first)]

    def _bound(self, runner: Runner | None) -> Bound:
        if runner is None or self.family.instances.vary_inputs:
            return Bound(None)
        return Bound(runner, Batch(runner) if fits(runner) else None)

    def take(self) -> Bound:
        """One that no other thread has."""
        try:
            return self._free.pop()
        except IndexError:
            return self._bound(self.family.runner())

    def give_back(self, bound: Bound) -> None:
        """It is free again."""
        self._free.append(bound)


def run_tile(family: Family, pool: Pool, tile: range, stop: Flag) -> list[Outcome[Solution]]:
    """What became of a tile of instances; those that no kernel can judge are open, with neither a motion nor an error."""
    if stop.is_set():
        return []
    bound = pool.take()
    try:
        if bound.batch is not None:
            return _in_one_call(family, bound.batch, tile)
        return [decided(_by_kernel, family, bound.runner, k) for k in tile if not stop.is_set()]
    finally:
        pool.give_back(bound)


def _in_one_call(family: Family, batch: Batch, tile: range) -> list[Outcome[Solution]]:
    """What became of a tile by one call; those that did not get to the end in it are run by themselves."""
    runner, parameters = batch.runner, family.eom.parameters
    starts = [decided(_start, family, runner, k) for k in tile]
    rows = [one.found for one in starts if one.found is not None]
    x = np.array([start.x for start in rows]).reshape(len(rows), len(family.eom.state))
    p = np.array([[start.constants[s] for s in parameters] for start in rows]).reshape(len(rows), len(parameters))
    results = batch.run(x, p)
    found: list[Outcome[Solution]] = []
    places = iter(range(len(rows)))
    for k, one in zip(tile, starts, strict=True):
        if one.found is None:
            found.append(Outcome(None, one.error, one.told))
        elif results.done[n := next(places)]:
            phase = Phase(one.found.constants, runner.drives)
            motion = runner.motion(family.eom, phase, results.states[n], results.told[n])
            sure = results.kept[n] and not family.check
            found.append(Outcome(motion) if sure else decided(_checked, family, motion))
        else:
            found.append(decided(_by_kernel, family, runner, k))
    return found


class Start(NamedTuple):
    """(q, u, a) of an instance, and its parameters."""

    x: Array
    constants: dict[Expr, float]


def _start(family: Family, runner: Runner, k: int) -> Start:
    at = family.instances.at(k)
    constants = parameter_values(family.eom.system, at["parameters"])
    check_values(family.eom, np.array([constants[s] for s in family.eom.parameters]), runner.span)
    return Start(start_state(family.eom, at["q"], at["u"], at["states"]), constants)


def _checked(family: Family, motion: Solution) -> Solution:
    check_kept(motion, family.check)
    return motion


def decided(found: Callable[..., T | None], *arguments: Any) -> Outcome[T]:
    """What becomes of an instance, whatever that raises or warns of."""
    with listed_warnings() as told:
        try:
            return Outcome(found(*arguments), "", told)
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
    return motion if motion is None or (kept and not family.check) else _checked(family, motion)


def _words(error: Exception) -> str:
    """What was raised, in words: messages of the library stand by themselves."""
    own = type(error).__module__.startswith("kane.")
    return str(error) if own else f"{type(error).__name__}: {cut(str(error), 500)}"


def outcomes(family: Family, threads: int) -> Iterator[tuple[range, list[Outcome[Solution]]]]:
    """What became of the instances, tile by tile as they are done; the first one that can start says whether a kernel runs them."""
    first, tiles = _first(family), _tiles(family.instances.count, threads)
    if first is None:
        yield from ((tile, [decided(_simulated, family, k) for k in tile]) for tile in tiles)
        return
    pool, stop = Pool(family, first), Flag()
    if threads == 1 or len(tiles) == 1:
        yield from ((tile, _closed(family, tile, run_tile(family, pool, tile, stop))) for tile in tiles)
        return
    with ThreadPoolExecutor(threads, thread_name_prefix="kane") as executor:
        try:
            work = {executor.submit(run_tile, family, pool, tile, stop): tile for tile in tiles}
            for done in as_completed(work):
                tile = work.pop(done)
                yield tile, _closed(family, tile, done.result())
        finally:  # Ctrl-C, or nobody asks any more
            stop.set()
            executor.shutdown(cancel_futures=True)


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


def _closed(family: Family, tile: range, found: Sequence[Outcome[Solution]]) -> list[Outcome[Solution]]:
    """Instances that are open are simulated."""
    return [decided(_simulated, family, k) if one.is_open else one for k, one in zip(tile, found, strict=True)]


def _simulated(family: Family, k: int) -> Solution:
    options = family.plan._asdict() | {"settings": family.settings, "check": family.check}
    motion: Solution = check_whole(simulate(family.eom, **family.instances.at(k), **options))
    return motion


def cores() -> int:
    """The processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
