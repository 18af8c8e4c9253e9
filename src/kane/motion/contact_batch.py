# SPDX-License-Identifier: BSD-3-Clause
"""Batches of motions with contacts, each by one call of the automaton's kernel: one at a time, or collected and checked as a table.

A motion that the kernel does not complete, or whose energy balance is not certain to hold, is left to a separate simulation, which
also prepares the kernels of modes that later motions need.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from kane.analysis.state_checks import start_state
from kane.equations.equations import Equations
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import time
from kane.model.beams.beam import Beam
from kane.motion.contact_runner import (
    ContactRunner,
    ModeKernel,
    ModeRows,
    room_for,
    runner,
    same_in_all,
    stops_of,
    timed_laws,
)
from kane.motion.course import Method
from kane.motion.hybrid.contact_automaton import Back, Record
from kane.motion.hybrid.contact_tables import numbers_of
from kane.motion.inputs.expressions import Formula, gains_of
from kane.motion.loop import admitted_start
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import switches, timed
from kane.motion.runner import Judge, check_values
from kane.motion.solution.checks import surely_keeps
from kane.motion.solution.phases import Indices, Phase, leaps
from kane.motion.solution.resumed import Begin
from kane.motion.solution.solution import Solution
from kane.motion.steppers.context import Slot
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array, Mask
from kane.numeric.scale import SURELY_REGULAR
from kane.program.native.machine import Settings
from kane.progress import is_noted

_ROOM = 2**21
"""Approximate size, in doubles, of records and samples collected in one table."""


def leads_contacts(eom: Equations, drives: Mapping[Expr, Any], method: Method) -> bool:
    """Whether motions can run in a batch: only modes of contacts change the equations, and inputs are numbers or expressions."""
    system = eom.system
    return (
        bool(system.contacts)
        and system.modes_change
        and all(event.then is None for event in system.events)
        and not switches(eom)
        and eom.solved.twin is None
        and not any(isinstance(b, Beam) for b in system.bodies)
        and all(same_in_all(f) is not None for f in drives.values())
        and method.max_seconds == np.inf
    )


class Led(NamedTuple):
    """Completed motions: their indices `which` and numbers of steps, and a table of samples (t, states), mode by mode.

    For each row of the table, `piece` is the row of `records` and `motion` the index in `which`; `records` refer to modes in `made`.
    """

    which: Indices
    steps: Array
    records: Array
    made: Sequence[ModeKernel]
    t: Array
    states: Array
    piece: Indices
    motion: Indices

    def spans(self, motions: Indices) -> list[tuple[int, int]]:
        """The ranges (begin, end) of rows of motions in the table."""
        sides = (np.searchsorted(self.motion, motions, side=side).tolist() for side in ("left", "right"))
        return list(zip(*sides, strict=True))


class ContactBatch:
    """Motions of equations over one span, with the same inputs."""

    def __init__(
        self,
        eom: Equations,
        method: Method,
        span: tuple[float, float],
        drives: Mapping[Expr, Any],
        times: Array,
        options: Mapping[str, Any],
    ) -> None:
        self.eom, self.method, self.span = eom, method, span
        self.drives, self.times, self.options = drives, times, options
        self.settings: Settings | None = options["settings"]
        inside = times[(times > span[0]) & (times < span[1])]
        self.t = np.concatenate([span[:1], inside, span[1:]])
        self.judge = Judge(eom, self.settings, [drives[s] for s in eom.inputs])
        self.parameters = self.judge.parameters
        varied = [f.expr for f in self.judge.drives if isinstance(f, Formula) and f.values]
        self.timed = time in free_symbols(varied) or any(any(eom.numeric().value(f)) for f in (timed, timed_laws))
        self.held = is_constrained(eom)

    def single(self) -> "ContactCalls":
        """The object that runs one motion at a time."""
        return ContactCalls(self)

    def taken(self, p: Array) -> tuple[ContactRunner, list[ContactRunner]]:
        """A runner that no other motion uses, and the list to which it must be returned after use."""
        return runner(self.eom, self.method, self.span, self.given(p), self.settings, self.times)

    def given(self, p: Array) -> tuple[dict[Expr, float], dict[Expr, Any]]:
        """Parameters, and inputs with their values, from a row p of both."""
        known: dict[Expr, float] = dict(zip(self.parameters, p.tolist(), strict=True))
        phase = Phase(dict.fromkeys(self.eom.parameters, 0.0), self.drives).at(known)
        return {**phase.parameters}, {**phase.inputs}

    def _goes_on(self, own: ContactRunner, p: Array) -> bool:
        """Sets a runner's breakpoints for a motion with other parameters; False if it has no room for them."""
        if self.timed:
            breakpoints = stops_of(self.eom, self.method, self.span, self.given(p))
            if room_for(breakpoints) != own.stops["breakpoints"]:
                return False
            own.stop_at(breakpoints)
        return True

    def run(
        self,
        x: Array,
        p: Array,
        alone: Callable[[int, Solution | None], None],
        stops: Callable[[], bool] = lambda: False,
    ) -> Iterator[Led]:
        """The motions from rows (q, u, a) of x with rows p of parameters, in groups.

        `alone(row, motion)` is called for a motion that an event ends, or with None for one to be simulated separately.
        """
        begin = 0
        while begin < len(x) and not stops():
            led, begin = self._led(x, p, begin, alone, stops)
            yield led

    def _led(
        self, x: Array, p: Array, begin: int, alone: Callable[[int, Solution | None], None], stops: Callable[[], bool]
    ) -> tuple[Led, int]:
        """The motions from the row `begin` on, as many as fit in one table, and the row after them."""
        which, steps, every = list[int](), list[float](), list[ModeKernel]()
        records, samples = list[Array](), list[Array]()
        own, free = self.taken(p[begin])
        n, room = begin, _ROOM
        while n < len(x) and room > 0 and not stops():
            if not self._goes_on(own, p[n]):
                every += own.made
                free.append(own)
                own, free = self.taken(p[n])
            own.renew(p[n])
            back = own.leads(x[n])
            if back is Back.END:
                which.append(n)
                steps.append(float(own.s[Slot.STEPS]))
                records.append(own.completed().copy())
                records[-1][:, Record.MODE] += len(every)
                samples.append(own.rows.copy())
                room -= records[-1].size + samples[-1].size
            elif back is Back.EVENT:
                motion, kept = self.motion(own, p[n])
                alone(n, motion if kept else None)
            else:
                every += own.made
                free.append(own)
                alone(n, None)
                own, free = self.taken(p[n])
            n += 1
        every += own.made
        free.append(own)
        owner = np.repeat(np.arange(len(which)), [len(rows) for rows in records])
        table = np.concatenate([np.zeros((0, own.width)), *records])
        t, states, piece = own.laid_out(ModeRows(table, owner, np.array([*samples, own.rows])))
        numbers = np.array(which, dtype=np.int64), np.array(steps)
        return Led(*numbers, table, every, t, states, piece, owner[piece]), n

    def judged(self, led: Led, p: Array) -> Mask:
        """Whether equations are certainly regular at the start, and the energy balance, except for impacts, holds (motions)."""
        found = self.judge(led.t, led.states, p[led.which][led.motion])
        result = np.zeros(len(led.which), dtype=bool)
        for k, (begin, end) in enumerate(led.spans(np.arange(len(led.which)))):
            at = slice(begin, end)
            kept = self.is_kept(led.t[at], found[at], led.states[at, -1], led.piece[at])
            result[k] = kept and found[begin, 2] > SURELY_REGULAR
        return result

    def motion(self, own: ContactRunner, p: Array) -> tuple[Solution | None, bool]:
        """The motion that a runner has led, and whether its energy balance certainly holds; None if equations may be singular."""
        motion = own.motion()
        found = self.judge(motion.t, np.column_stack([motion.states, motion.work]), p[None])
        regular = found[0, 2] > SURELY_REGULAR
        return motion if regular else None, regular and self.is_kept(motion.t, found, motion.work, motion.phase)

    def is_kept(self, t: Array, found: Array, work: Array, piece: Indices) -> bool:
        """Whether the energy balance of a motion certainly holds, by the results of the judge, the work, and the mode of each row."""
        kinetic, total, _ = found.T
        work = work + leaps(total, np.flatnonzero(np.diff(piece)) + 1)
        return surely_keeps(t, kinetic, total, work, self.method.rtol, True)

    def table(self, led: Led, chosen: Mask, constants: Callable[[int], dict[Expr, float]], modes: bool) -> Solution:
        """The chosen motions at the sample times, one after the other; with `modes`, each sample has the equations of its mode."""
        spans = led.spans(np.flatnonzero(chosen))
        rows = np.concatenate([a + np.searchsorted(led.t[a:b], self.t, side="right") - 1 for a, b in spans])
        eom, own = self.eom, led.which[chosen]
        phases: tuple[Phase, ...] = (Phase(constants(int(own[0])), self.drives),)
        phase, samples = np.zeros(len(rows), dtype=np.int64), tuple[Equations, ...]()
        if modes:
            pieces, phase = np.unique(led.piece[rows], return_inverse=True)
            whose = led.which[led.motion[np.searchsorted(led.piece, pieces)]]
            numbers = numbers_of(eom, led.records[pieces])
            phases = tuple(
                Phase({**constants(int(n)), **more}, self.drives) for n, more in zip(whose, numbers, strict=True)
            )
            modes_of = [led.made[int(m)].equations for m in led.records[:, Record.MODE]]
            samples = tuple(modes_of[k] for k in led.piece[rows])
        states = led.states[rows]
        return Solution(
            eom, led.t[rows], states[:, :-1], states[:, -1], phases[0].parameters, self.drives, "finished",
            f"reached t = {self.span[1]:g}", None, (), 0, 0, (), samples, self.method.rtol, self.method.atol, self.method.name,
            phases, phase,
        )  # fmt: skip


class ContactCalls:
    """Runs the motions of a batch one at a time, with the interface of `kane.motion.runner.Runner`."""

    def __init__(self, batch: ContactBatch) -> None:
        self.batch, self.options = batch, batch.options
        self.usual: dict[Expr, float] = {}

    def take(self, eom: Equations, constants: Mapping[Expr, float]) -> None:
        """Sets the parameter values of the next motions, after checks."""
        usual = gains_of(self.batch.judge.drives)
        self.p = np.array([constants.get(s, usual.get(s)) for s in self.batch.parameters])
        check_values(eom, self.p[: len(eom.parameters)], self.batch.span)

    def begin(self, eom: Equations, at: tuple[Any, Any, Any], constants: Mapping[Expr, float]) -> Array | None:
        """(q, u, a) from start values, on the constraints."""
        batch = self.batch
        if not batch.held:
            return start_state(eom, *at)
        parameters, drives = batch.given(self.p)
        stepper = Stepper(eom, self.p[: len(eom.parameters)].copy(), tuple(drives.values()), batch.settings)
        return admitted_start(stepper, Begin(at[0], at[1], None, at[2]), parameters, batch.span[0])[:-1]

    def run(
        self, eom: Equations, x: Array, constants: dict[Expr, float], again: Callable[..., Any]
    ) -> tuple[Solution | None, bool]:
        """The motion, and whether its energy balance certainly holds; None if the kernel does not complete it."""
        batch = self.batch
        own, free = batch.taken(self.p)
        try:
            led = not is_noted() and own.leads(x) is not None
            motion, kept = batch.motion(own, self.p) if led else (None, False)
        finally:
            free.append(own)
        if motion is None:
            return None, False
        return replace(motion, parameters=constants, _again=again, _options=self.options), kept
