# SPDX-License-Identifier: BSD-3-Clause
"""Tiles: groups of instances that one thread runs, each by one call of machine code that releases the interpreter's lock.

Instances that a kernel cannot complete, or that need Python during the motion, stay open and are simulated afterwards, one by one.
`run_tile` is the work of a thread; `batch.py` runs a tile by a single call.
"""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import dataclass, replace
from threading import Event as Flag
from threading import RLock
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

import numpy as np

from kane.analysis.many.poses import Poses, in_numbers
from kane.analysis.nearest_states import NearestStates
from kane.analysis.state_checks import start_state
from kane.dynamics.readings.quantities import parameter_values
from kane.equations.equations import Equations
from kane.equations.instances import Instances
from kane.errors import KaneError, cut, listed_warnings
from kane.expr.node import Expr
from kane.expr.symbols import time
from kane.motion.inputs.breakpoints import clock, may_have_bumps
from kane.motion.inputs.expressions import Formula, along, gains_of, given_parameters, with_value
from kane.motion.many.batch import Batch, Ran, fits, goes_in_lanes
from kane.motion.methods import has_lanes, side_by_side
from kane.motion.runner import Plan, Runner, check_values, stepped_along, surely_admitted
from kane.motion.simulate import are_fixed, by_runner, check_conserved, contacts_of, runner_of, simulate
from kane.motion.solution.phases import Indices, Phase
from kane.motion.solution.solution import Solution
from kane.motion.steppers.context import Slot
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array, Mask
from kane.program.native.machine import Settings
from kane.progress import check_whole

if TYPE_CHECKING:
    from kane.motion.contact_batch import ContactBatch  # a slow import

T = TypeVar("T")

_PARTS = 8
"""Least number of tiles per thread, for balanced loads at the end."""
MOST = 2048
"""Largest number of instances in a tile."""
_BYTES = 2**24
"""Approximate largest size of the samples of a tile (bytes), which are in memory twice."""
_ALONE = RLock()
"""Serializes motions that need Python, also where several threads of a worker run chunks."""
FEW = 64
"""Least number of instances for lanes: compilation takes 0.1 s, or seconds if a stepper is compiled for the first time."""

_TRIED = 3
"""Number of instances that are tried for the assembly on which the starts of all are based."""


@dataclass(frozen=True, slots=True, eq=False)
class Ensemble:
    """Motions that differ only by instance: equations, simulation plan, compiler settings, and functions checked along each motion."""

    eom: Equations
    plan: Plan
    settings: Settings | None
    check: Sequence[Any]
    instances: Instances
    lanes: bool | None = None
    states_alone: bool = False
    """Whether only coordinates, speeds and further states are recorded."""

    @property
    def alike(self) -> bool:
        """Whether one runner can run all instances: inputs are the same, or expressions that differ by parameters."""
        own = self.instances
        given = {*own.columns["parameters"], *(own.common["parameters"] or {})}
        return not own.vary_laws or are_fixed(self.eom, own.common["inputs"], given)

    def parameters(self, p: Array, places: Sequence[int], drives: Mapping[Expr, Any]) -> Array:
        """Rows of parameters for instances: rows p of those of the equations, then those of inputs alone."""
        own = gains_of(drives.values())
        known = {**own, **(self.instances.common["parameters"] or {}), **self.instances.columns["parameters"]}
        columns = [np.broadcast_to(known[s], self.instances.count)[list(places)] for s in own]
        return np.column_stack([p, *columns])

    def runner(self, k: int = 0) -> Runner | None:
        """A runner with the inputs of the kth instance; None if Python is called between steps."""
        at = self.instances.at(k)
        return runner_of(self.eom, self.plan, at["inputs"], self.settings, at["parameters"] or {})


class Outcome(NamedTuple, Generic[T]):
    """The outcome of an instance: its motion or the error raised instead, and warnings."""

    found: T | None
    error: str = ""
    told: Sequence[str] = ()

    @property
    def is_open(self) -> bool:
        """Whether there is neither a motion nor an error."""
        return self.found is None and not self.error


class Finished(NamedTuple):
    """Complete motions that conserve energy: their instances, numbers of steps, and all motions as one table."""

    instances: list[int]
    steps: Array
    table: Solution


class Tile(NamedTuple):
    """The outcomes of the instances of a tile: individual ones, and groups of complete motions."""

    outcomes: dict[int, Outcome[Solution]]
    finished: Sequence[Finished] = ()


@dataclass(frozen=True, slots=True, eq=False)
class TileRunner:
    """The resources with which a thread runs tiles: a runner, unless each instance has its own, and a batch for single-call tiles."""

    runner: Runner | None
    batch: Batch | None = None


class Pool:
    """The tile runners of an ensemble, one for each concurrent thread; `first` is the runner of the first."""

    def __init__(self, family: Ensemble, first: Runner) -> None:
        self.family = family
        self.alike = family.alike
        self.lanes = _in_lanes(family, first) if self.alike else None
        # the deflection of a beam must be checked at each start against the range of its equations
        held = self.lanes is not None and first.holding is not None and not first.bends
        self.nearest = _nearest(family, first) if held else None
        self._free = [self._bound(first)]

    def _bound(self, runner: Runner | None) -> TileRunner:
        if runner is None or not self.alike:
            return TileRunner(None)
        if self.lanes is not None:
            own = self.lanes.runner()
            return TileRunner(runner, None if own is None else Batch(own, lanes=True))
        return TileRunner(runner, Batch(runner) if fits(runner) else None)

    def take(self) -> TileRunner:
        """A tile runner that no other thread uses."""
        try:
            return self._free.pop()
        except IndexError:
            return self._bound(self.family.runner())

    def give_back(self, bound: TileRunner) -> None:
        """Returns a tile runner to the pool."""
        self._free.append(bound)


class ContactPool:
    """The runner of tiles with contacts; see `kane.motion.contact_batch`."""

    def __init__(self, family: Ensemble, batch: "ContactBatch") -> None:
        self.family, self.batch = family, batch
        self.nearest = _nearest(family, batch) if batch.held else None

    def run(self, tile: range, stop: Flag) -> Tile:
        """The outcomes of a tile; after `stop` no instance is simulated individually."""
        family, batch = self.family, self.batch
        begun, found = _held(family, batch, tile, self.nearest) if batch.held else _begun(family, batch.span, tile)
        if not begun.places:
            return Tile(found)

        def alone(n: int, motion: Solution | None = None) -> None:
            if motion is not None:
                found[begun.places[n]] = Outcome(
                    replace(motion, parameters=begun.constants(n, family.eom.parameters, begun.p[n]))
                )
            elif not stop.is_set():
                found[begun.places[n]] = decided(_simulated, family, begun.places[n])

        finished = list[Finished]()
        p = family.parameters(begun.p, begun.places, batch.drives)

        def known(n: int) -> dict[Expr, float]:
            return begun.constants(n, batch.parameters, p[n])

        for led in batch.run(begun.x, p, alone, stop.is_set):
            kept = batch.judged(led, p)
            for n in led.which[~kept].tolist():
                alone(n)
            if kept.any():
                table = batch.table(led, kept, known, not family.states_alone)
                finished.append(Finished([begun.places[n] for n in led.which[kept]], led.steps[kept], table))
        return Tile(found, finished)


def _contacts(family: Ensemble, k: int) -> ContactPool | None:
    """The runner of tiles with contacts, if their kernel can run the motions; the kth instance determines this."""
    if not family.eom.system.contacts or family.check or not family.alike:
        return None
    given = family.instances.at(k)
    batch = contacts_of(family.eom, family.plan, given["inputs"], family.settings, given["parameters"] or {})
    return None if batch is None else ContactPool(family, batch)


def _in_lanes(family: Ensemble, first: Runner) -> Ensemble | None:
    """The ensemble with the method that runs it in lanes; None if its motions run one by one.

    Lanes are used if the time saved exceeds that of compilation, hence not for few instances.
    """
    settings = family.settings or Settings()
    if family.lanes is False or (family.lanes is None and (family.instances.count < FEW or not has_lanes(settings))):
        return None
    method = side_by_side(first.method.name) if first.method.free else first.method.name
    own = replace(family, plan=family.plan._replace(method=method))
    runner = own.runner()
    return own if runner is not None and goes_in_lanes(runner) else None


def run_tile(family: Ensemble, pool: Pool | ContactPool, tile: range, stop: Flag) -> Tile:
    """The outcomes of a tile; those that no kernel can decide are open, with neither a motion nor an error."""
    if stop.is_set():
        return Tile({})
    if isinstance(pool, ContactPool):
        return pool.run(tile, stop)
    bound = pool.take()
    try:
        if bound.batch is not None:
            runner = bound.batch.runner
            return _in_one_call(family, bound, bound.batch, _starts(family, runner, tile, pool.nearest))
        return Tile({k: decided(_by_kernel, family, bound.runner, k) for k in tile if not stop.is_set()})
    finally:
        pool.give_back(bound)


def _in_one_call(
    family: Ensemble, bound: TileRunner, batch: Batch, starts: tuple["Starts", dict[int, Outcome[Solution]]]
) -> Tile:
    """The outcomes of a tile by one call; instances that it does not complete are run individually."""
    (begun, found), runner = starts, batch.runner
    if not begun.places:
        return Tile(_one_by_one(family, bound, found))
    p = family.parameters(begun.p, begun.places, runner.drives)
    if runner.timed:
        kept = _with_breakpoints(family, batch, begun, p)
        found |= {k: Outcome[Solution](None) for k, own in zip(begun.places, kept, strict=True) if not own}
        begun, p = begun.of(np.flatnonzero(kept)), p[kept]
        if not begun.places:
            return Tile(_one_by_one(family, bound, found))
    ran = batch.run(begun.x, p, begun.reach)
    together = ran.done & ran.kept & (not family.check)
    for n in map(int, np.flatnonzero(~together)):
        k = begun.places[n]
        found[k] = decided(_judged, family, batch, ran, n, begun, p) if ran.done[n] else Outcome(None)
    finished = [_together(family, batch, ran, np.flatnonzero(together), begun, p)] if together.any() else []
    return Tile(_one_by_one(family, bound, found), finished)


def _one_by_one(
    family: Ensemble, bound: TileRunner, found: dict[int, Outcome[Solution]]
) -> dict[int, Outcome[Solution]]:
    """The outcomes with open instances run individually."""
    return {k: decided(_by_kernel, family, bound.runner, k) if one.is_open else one for k, one in found.items()}


def _with_breakpoints(family: Ensemble, batch: Batch, begun: "Starts", p: Array) -> Mask:
    """Which motions, with rows p of parameters, have the breakpoints of the batch."""
    count, runner = len(p), batch.runner
    columns = dict[Expr, Any](zip(runner.parameters, p.T, strict=True))
    clocks = [clock([f.expr]) for f in runner.drives.values() if isinstance(f, Formula)]
    doubtful = np.full(count, bool(batch.breakpoints) or any(own.turning for own in clocks))
    for own in clocks:
        doubtful |= may_have_bumps(own.pulses, columns, count, runner.span)
    kept = np.ones(count, dtype=bool)
    for n in np.flatnonzero(doubtful).tolist():
        phase = _phase(family.eom, runner, begun, n, p)
        kept[n] = runner.breakpoints_for(family.eom, phase.inputs) == batch.breakpoints
    return kept


def _phase(eom: Equations, runner: Runner, begun: "Starts", n: int, p: Array) -> Phase:
    """The parameters and inputs of the nth of some motions with rows p of parameters."""
    known = dict[Expr, Any](zip(runner.parameters, p[n].tolist(), strict=True))
    return Phase(begun.constants(n, eom.parameters, begun.p[n]), runner.drives).at(known)


def _judged(family: Ensemble, batch: Batch, ran: Ran, n: int, begun: "Starts", p: Array) -> Solution:
    """The nth motion of a batch as a single solution."""
    runner, phase = batch.runner, _phase(family.eom, batch.runner, begun, n, p)
    if batch.lanes is None:
        motion = runner.motion(family.eom, phase, ran.states[n], ran.told[n])
    else:
        met, changed = ran.met[n] if ran.met else None, batch.changes(ran, n)
        stepper = None
        if runner.holding is not None:
            stepper = Stepper(family.eom, begun.p[n], (*phase.inputs.values(),), family.settings)
        motion = runner.ended(family.eom, phase, stepper, ran.states[n], ran.told[n], met, changed)
    return motion if ran.kept[n] and not family.check else _checked(family, motion)


def _together(family: Ensemble, batch: Batch, ran: Ran, which: Indices, begun: "Starts", p: Array) -> Finished:
    """Motions of a batch as one table; with a phase for each set of parameters if more than states is recorded."""
    runner, eom, (_, m, n) = batch.runner, family.eom, ran.states.shape
    own = which if family.instances.columns["parameters"] and not family.states_alone else which[:1]
    drives = dict(runner.drives)  # each phase has the values of the parameters in them
    phases = tuple(Phase(begun.constants(k, runner.parameters, p[k]), drives) for k in own)
    one = runner.motion(eom, phases[0], ran.states[which].reshape(-1, n), ran.told[which[0]])
    phase = np.repeat(np.arange(len(which)) % len(phases), m)
    every = [batch.changes(ran, k) for k in which] if any(ran.changes) and not family.states_alone else []
    samples = tuple(held for changed in every for held in stepped_along(eom, changed, runner.t))
    table = replace(one, t=np.tile(runner.t, len(which)), phases=phases, phase=phase, samples=samples)
    return Finished([begun.places[k] for k in which], ran.told[which, Slot.STEPS], table)


class Starts(NamedTuple):
    """Initial states of some instances as tables with a row each: (q, u, a), parameters, and magnitudes `reach` of the entries of A.

    `usual` are the parameters by symbol, for each or one for all; `places` the indices of the instances.
    """

    places: Sequence[int]
    x: Array
    p: Array
    reach: Array | None
    usual: Sequence[Mapping[Expr, float]]

    def constants(self, n: int, symbols: Sequence[Expr], p: Array) -> dict[Expr, float]:
        """The parameters of the nth instance by symbol, with the values p of `symbols`."""
        return {**self.usual[n % len(self.usual)], **dict(zip(symbols, p.tolist(), strict=True))}

    def of(self, rows: Indices) -> "Starts":
        """Some of them."""
        usual = self.usual if len(self.usual) < len(self.places) else [self.usual[n] for n in rows]
        reach = None if self.reach is None else self.reach[rows]
        return Starts([self.places[n] for n in rows], self.x[rows], self.p[rows], reach, usual)

    @staticmethod
    def together(several: Sequence["Starts"]) -> "Starts":
        """All of several, one after the other."""
        parts = [one for one in several if one.places] or [Starts([], np.zeros((0, 0)), np.zeros((0, 0)), None, [])]
        x, p = (np.concatenate(rows) for rows in zip(*((one.x, one.p) for one in parts), strict=True))
        reaches = [one.reach for one in parts if one.reach is not None]
        reach = np.concatenate(reaches) if len(reaches) == len(parts) else None
        usual = [one.usual[n % len(one.usual)] for one in parts for n in range(len(one.places))]
        return Starts([k for one in parts for k in one.places], x, p, reach, usual)


def _starts(
    family: Ensemble, runner: Runner, tile: range, nearest: NearestStates | None
) -> tuple[Starts, dict[int, Outcome[Solution]]]:
    """The initial states of a tile, and the outcomes of instances without one."""
    if runner.holding is not None:
        return _held(family, runner, tile, nearest)
    return _begun(family, runner.span, tile)


def _begun(family: Ensemble, span: tuple[float, float], tile: range) -> tuple[Starts, dict[int, Outcome[Solution]]]:
    """The initial states of a tile without constraints: that of the first instance, with the columns that differ inserted."""
    eom, many = family.eom, family.instances
    first = decided(_unchecked, family, tile[0])
    if first.found is None:
        return _one_after_another({k: decided(_checked_start, family, span, k) for k in tile})
    x, p = np.tile(first.found.x, (len(tile), 1)), np.tile(first.found.p, (len(tile), 1))
    places = {s: x[:, i] for i, s in enumerate(eom.state)} | {s: p[:, i] for i, s in enumerate(eom.parameters)}
    for _, s, column in many.varied:
        if s in places:
            places[s][:] = column[tile.start : tile.stop]
    own = p if many.columns["parameters"] else p[:1]
    right = surely_admitted(eom, own) if len(own) > 1 else np.zeros(1, dtype=bool)
    errors: dict[int, str] = {}
    for n in map(int, np.flatnonzero(~right)):
        errors[n] = decided(check_values, eom, own[n], span).error
        right[n] = not errors[n]
    right = np.resize(right, len(p))
    failed = {tile[n]: Outcome[Solution](None, errors[n % len(own)]) for n in map(int, np.flatnonzero(~right))}
    begun = np.flatnonzero(right)
    return Starts([tile[n] for n in begun], x[right], p[right], None, first.found.usual), failed


def _held(
    family: Ensemble, runner: "Runner | ContactBatch", tile: range, nearest: NearestStates | None
) -> tuple[Starts, dict[int, Outcome[Solution]]]:
    """The initial states of a tile on the constraint manifold: computed together, and one by one where in doubt."""
    sure = None if nearest is None else decided(_sure, family, runner, tile, nearest).found
    known = set() if sure is None else {*sure.places}
    others = {k: decided(_projected_start, family, runner, k) for k in tile if k not in known}
    own, failed = _one_after_another(others)
    return own if sure is None else Starts.together([sure, own]), failed


def _sure(family: Ensemble, runner: "Runner | ContactBatch", tile: range, nearest: NearestStates) -> "Starts":
    """The initial states of a tile that are not in doubt."""
    eom, poses = family.eom, _poses(family, runner, tile)
    found, p, given = nearest.at(poses), poses.numbers()[1], poses.given("states")
    further = [np.full(len(tile), given.get(a, a.default), dtype=float) for a in eom.states]
    x = np.column_stack([found.q, found.u, *further])
    sure = np.flatnonzero(~found.doubt & surely_admitted(eom, p) & np.isfinite(x).all(axis=1))
    usual = parameter_values(eom.system, family.instances.at(tile[0])["parameters"])
    return Starts([tile[n] for n in sure.tolist()], x[sure], p[sure], np.abs(found.a[sure]), [usual])


def _one_after_another(starts: Mapping[int, Outcome[Starts]]) -> tuple[Starts, dict[int, Outcome[Solution]]]:
    """Initial states that were computed one by one."""
    failed = {k: Outcome[Solution](None, one.error, one.told) for k, one in starts.items() if one.found is None}
    return Starts.together([one.found for one in starts.values() if one.found is not None]), failed


def _nearest(family: Ensemble, runner: "Runner | ContactBatch") -> NearestStates | None:
    """The states nearest to the first instance that can be assembled; None if none of a few can, or if q or u is missing."""
    known = all(family.instances.at(0)[kind] is not None for kind in ("q", "u"))
    for k in range(min(_TRIED, family.instances.count) if known else 0):
        with suppress(KaneError):
            return NearestStates(_poses(family, runner, range(k, k + 1)))
    return None


def _poses(family: Ensemble, runner: "Runner | ContactBatch", rows: range) -> Poses:
    """Some of the instances as states at the initial time."""
    own = family.instances.part(rows)
    known: dict[Expr, Any] = {**(own.common["parameters"] or {}), **own.columns["parameters"]}
    t, drives = np.full(own.count, runner.span[0]), [with_value(f, known) for f in runner.drives.values()]
    values = [np.zeros(own.count) if getattr(f, "of_state", False) else along(f, t, t[:, None]) for f in drives]
    common = {**own.common, "t": {time: runner.span[0]}, "inputs": None}
    columns = {**own.columns, "t": {}, "inputs": dict(zip(family.eom.inputs, values, strict=True))}
    return Poses(family.eom, in_numbers(replace(own, common=common, columns=columns)), {})


def _unchecked(family: Ensemble, k: int) -> Starts:
    """The initial state of the kth instance, before assembly."""
    at, eom = family.instances.at(k), family.eom
    constants = parameter_values(eom.system, at["parameters"])
    x = start_state(eom, at["q"], at["u"], at["states"])
    return Starts([k], x[None], np.array([[constants[s] for s in eom.parameters]]), None, [constants])


def _checked_start(family: Ensemble, span: tuple[float, float], k: int) -> Starts:
    """The initial state of the kth instance without constraints, with parameters checked."""
    start = _unchecked(family, k)
    check_values(family.eom, start.p[0], span)
    return start


def _projected_start(family: Ensemble, runner: "Runner | ContactBatch", k: int) -> Starts | None:
    """The initial state of the kth instance on its constraints; None if a kernel cannot decide it."""
    at, eom = family.instances.at(k), family.eom
    constants = parameter_values(eom.system, at["parameters"])
    one = runner if isinstance(runner, Runner) else runner.single()
    one.take(eom, given_parameters(at["parameters"]) | constants)
    x = None if at["q"] is None or at["u"] is None else one.begin(eom, (at["q"], at["u"], at["states"]), constants)
    if x is None:
        return None
    holding = runner.holding if isinstance(runner, Runner) else None
    reach = None if holding is None else holding.stepper.reach[None].copy()
    return Starts([k], x[None].copy(), np.array([[constants[s] for s in eom.parameters]]), reach, [constants])


def _checked(family: Ensemble, motion: Solution) -> Solution:
    check_conserved(motion, family.check)
    return motion


def decided(found: Callable[..., T | None], *arguments: Any) -> Outcome[T]:
    """The outcome of a call for an instance, with any exception or warnings."""
    with listed_warnings() as told:
        try:
            return Outcome(found(*arguments), "", told)
        except Exception as error:
            return Outcome(None, _words(error), told)


def _by_kernel(family: Ensemble, runner: Runner | None, k: int) -> Solution | None:
    """The motion of the kth instance by `runner`, or by its own runner if None; None if the runner cannot decide it."""
    at = family.instances.at(k)
    runner = runner or family.runner(k)
    if runner is None or at["q"] is None or at["u"] is None:
        return None
    start = at["q"], at["u"], at["states"], at["parameters"]
    motion, kept = by_runner(runner, family.eom, family.plan, start, at["inputs"])
    return motion if motion is None or (kept and not family.check) else _checked(family, motion)


def _words(error: Exception) -> str:
    """The message of an exception, with its type unless it is one of the library's."""
    own = type(error).__module__.startswith("kane.")
    return str(error) if own else f"{type(error).__name__}: {cut(str(error), 500)}"


def prepared(family: Ensemble) -> Pool | ContactPool | None:
    """The runner of tiles of an ensemble, by its first instance that can start; None if Python is called during motions.

    Errors of instances before that one are reported when they are run.
    """
    for k in range(family.instances.count):
        try:
            first = family.runner(k)
            return _contacts(family, k) if first is None else Pool(family, first)
        except Exception:
            continue
    return None


def outcomes(family: Ensemble, pool: Pool | ContactPool | None, tiles: Sequence[range], threads: int) -> Iterator[Tile]:
    """The outcomes of the instances, tile by tile in order of completion."""
    if pool is None:
        yield from (Tile({k: decided(_simulated, family, k) for k in tile}) for tile in tiles)
        return
    stop = Flag()
    if threads == 1 or len(tiles) == 1:
        yield from (_closed(family, run_tile(family, pool, tile, stop)) for tile in tiles)
        return
    with ThreadPoolExecutor(threads, thread_name_prefix="kane") as executor:
        try:
            work = {executor.submit(run_tile, family, pool, tile, stop) for tile in tiles}
            for done in as_completed(work):
                work.discard(done)
                yield _closed(family, done.result())
        finally:  # also on Ctrl-C, or if the iterator is closed
            stop.set()
            executor.shutdown(cancel_futures=True)


def tiles_of(rows: range, threads: int, doubles: int = 1) -> list[range]:
    """Instances, each with `doubles` numbers of samples, divided into tiles."""
    size = max(1, min(MOST, _BYTES // (8 * doubles), len(rows) // (_PARTS * threads)))
    return cut_into(rows, size)


def cut_into(rows: range, size: int) -> list[range]:
    """Consecutive ranges of equal size, the last one perhaps smaller."""
    return [rows[k : k + size] for k in range(0, len(rows), size)]


def _closed(family: Ensemble, found: Tile) -> Tile:
    """The tile with open instances simulated."""
    own = {k: decided(_simulated, family, k) if one.is_open else one for k, one in found.outcomes.items()}
    return found._replace(outcomes=own)


def _simulated(family: Ensemble, k: int) -> Solution:
    options = family.plan._asdict() | {"settings": family.settings, "check": family.check}
    with _ALONE:
        motion: Solution = check_whole(simulate(family.eom, **family.instances.at(k), **options))
    return motion


def cores() -> int:
    """The number of processors available to this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
