# SPDX-License-Identifier: BSD-3-Clause
"""The motions of a tile in one call of machine code: a kernel loops over instances, calls the stepping kernel, and stores samples.

It runs motions that only their final time ends: without constraints, events and switching surfaces, and with the same inputs. Lanes
also run motions with constraints and events (`lanes.py`). Motions with another return code are run again individually.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from kane.motion.constraint_kernels import choices, stepping
from kane.motion.many.lanes import Ends, run_in_lanes, runs_in_lanes
from kane.motion.methods import kernel_of
from kane.motion.native import LOOKS
from kane.motion.right_hand_side import Routines
from kane.motion.runner import Judge, Noted, Runner
from kane.motion.solution.checks import FEW, energy_check, keeps_sharply, opened
from kane.motion.steppers.context import SIZE, ReturnCode, Slot
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array, Mask
from kane.numeric.scale import SURELY_REGULAR
from kane.program.kernel.language import INT, Kernel
from kane.program.kernel.writer import Writer
from kane.program.native.entry import RESULT, CompiledKernel, KeptCalls, hoists_of
from kane.program.native.machine import Settings


def tile_kernel() -> Kernel:
    """A loop over `count` motions from rows of `starts` and `ps`; writes a row of `out`, `ends` and `told` (slots) for each."""
    w = Writer("tile")
    count, n, size, p_count, rows_count = map(w.number, ("count", "n", "size", "p_count", "rows_count"))
    s, y, lag, p, rows, calls = (w.array(name) for name in ("s", "y", "lag", "p", "rows", "calls"))
    slots, starts, ps, out, ends, told, codes = map(w.array, ("slots", "starts", "ps", "out", "ends", "told", "codes"))
    make, hoist = (w.callee(name, "array") for name in ("make", "hoist"))
    done = w.variable("done", INT)
    with w.count(count) as i:
        with w.count(size) as j:
            s[j] = slots[j]
        with w.few(n) as j:
            y[j] = starts[i * n + j]
            lag[j] = 0.0
        with w.few(p_count) as j:
            p[j] = ps[i * p_count + j]
        hoist(calls.at(0))
        make(calls.at(0))
        codes[i] = calls[RESULT]
        with w.count(size) as j:
            told[i * size + j] = s[j]
        with w.few(n) as j:
            ends[i * n + j] = y[j]
        with w.count(rows_count * n) as j:
            out[i * rows_count * n + j] = rows[j]
    done.put(count)
    return w.finished(done)


@cache
def _compiled(settings: Settings) -> CompiledKernel:
    return CompiledKernel(tile_kernel(), settings)


def _stepper(runner: Runner) -> Stepper:
    now = runner.plain
    return Stepper(now.eom, now.p[: len(now.eom.parameters)].copy(), now.drives, now.settings)


def goes_in_lanes(runner: Runner) -> bool:
    """Whether lanes can run the motions of a runner: no time limit; with constraints, an end that is a sample, which is projected."""
    ends = runner.holding is None or len(runner.t) == len(runner.rows) + 1
    return ends and runner.method.max_seconds == np.inf and runs_in_lanes(_stepper(runner), runner.method)


def fits(runner: Runner) -> bool:
    """Whether the tile kernel can run the motions of a runner: an explicit method, no constraints, events or switching surfaces."""
    now = runner.now
    plain = runner.holding is None and now.events is None and not now.quantities
    return plain and not INTEGRATORS[runner.method.name].implicit


class Ran(NamedTuple):
    """Motions of a batch: samples (… × t × y), final slots of the kernel, masks of complete ones and of those that conserve energy.

    `met` are the records of events and actions of each, if any; `changes` the (time, choice) of each change of dependent speeds.
    """

    states: Array
    told: Array
    done: Mask
    kept: Mask
    met: tuple[Noted, ...] = ()
    changes: tuple[list[tuple[float, int]], ...] = ()


class Batch:
    """The kernel of a runner, called for many motions at once: in lanes, or sequentially."""

    def __init__(self, runner: Runner, lanes: bool = False) -> None:
        self.runner, now = runner, runner.now
        self.breakpoints = runner.method.breakpoints
        self.lanes = _stepper(runner) if lanes else None
        if not lanes:
            self._bind()
        self.judge = Judge(now.eom, now.settings, now.drives)
        self._choices: dict[int, Routines] = {}

    def changes(self, ran: Ran, n: int) -> list[tuple[float, Routines]]:
        """The times at which the nth motion changed its dependent speeds, and the routines for the new ones."""
        own = ran.changes[n] if ran.changes else []
        for k in {k for _, k in own} - set(self._choices):
            assert self.lanes is not None
            self._choices[k] = stepping(self.lanes, choices(self.lanes.eom)[k])
        return [(t, self._choices[k]) for t, k in own]

    def _bind(self) -> None:
        """Compiles the tile kernel and binds the routines that it calls."""
        runner, given, now = self.runner, self.runner.given, self.runner.now
        settings = now.settings or Settings()
        kernel = kernel_of(runner.method.name, now)
        own = given | {"limit": int(min(LOOKS, runner.method.max_steps)), "breakpoints": runner.breakpoints}
        drive = own["single_drive"], own["hd"]
        self.calls = KeptCalls(1, settings)
        named = {a.name: own[a.name] for a in kernel.kernel.arguments}
        self.calls.put(0, (kernel, named), hoists_of(own), (drive, drive), own["p"])
        self.kernel = _compiled(settings)

    def run(self, x: Array, p: Array, reach: Array | None = None) -> Ran:
        """The motions from initial (q, u, a), rows of x; `reach`: magnitudes of the entries of A so far.

        Rows of p are the parameters of the equations, then those of inputs alone.
        Changes the parameters of the runner.
        """
        self.runner.stop_at(self.breakpoints)
        n, samples = len(self.runner.y), len(self.runner.rows)
        states = np.zeros((len(x), len(self.runner.t), n))
        states[:, 0, :-1] = x
        ends = self._one_by_one(states, p) if self.lanes is None else self._in_lanes(states, p, reach)
        rows, last, codes = ends.samples, ends.states, ends.back
        met = tuple(zip(ends.events, ends.jumps, strict=True))
        states[:, 1 : samples + 1] = rows
        states[:, samples + 1 :] = last[:, None]
        regular, kept = self._judged(states, p)
        plain = np.array([not len(jumps) for _, jumps in met], dtype=bool) if met else True
        held = self.runner.holding is not None
        done = (codes == ReturnCode.END) | ((codes == ReturnCode.EVENT) & (not held))
        kept &= (codes == ReturnCode.END) & plain & (not self.runner.bends)
        return Ran(states, ends.told, done & regular, kept, met, ends.changes)

    def _in_lanes(self, states: Array, p: Array, reach: Array | None) -> Ends:
        assert self.lanes is not None
        runner, count = self.runner, len(states)
        inputs = np.tile(runner.given["single_r"][:-1], (count, 1)).reshape(count, -1)
        spans, times = np.tile(runner.span, (count, 1)), np.tile(runner.times[:-1], (count, 1))
        return run_in_lanes(self.lanes, runner.method, states[:, 0, :-1], p, inputs, spans, times, reach)

    def _one_by_one(self, states: Array, p: Array) -> Ends:
        runner, given, count = self.runner, self.runner.given, len(states)
        n, samples = len(runner.y), len(runner.rows)
        starts, told, out = states[:, 0].copy(), np.zeros((count, SIZE)), np.zeros((count, samples, n))
        ends, codes = np.zeros((count, n)), np.zeros(count)
        runner.told = b""
        self.kernel(
            {
                "count": count, "n": n, "size": SIZE, "p_count": p.shape[1], "rows_count": samples,
                "s": runner.s, "y": runner.y, "lag": given["lag"], "p": given["p"], "rows": given["rows"],
                "calls": self.calls.table, "slots": runner.slots, "starts": starts.ravel(), "ps": np.append(p, 0.0),
                "out": np.append(out, 0.0) if not samples else out.ravel(), "ends": ends.ravel(), "told": told.ravel(),
                "codes": codes, "make": self.calls.make, "hoist": self.calls.hoist,
            }
        )  # fmt: skip
        return Ends(
            out, ends, told[:, Slot.TIME], codes.astype(np.int64), told[:, Slot.STEPS].astype(np.int64), told=told
        )

    def _judged(self, states: Array, p: Array) -> tuple[Mask, Mask]:
        """Masks: regular equations at the start (pivot above `SURELY_REGULAR`); energy balance well within tolerance."""
        runner, few = self.runner, self.runner.few
        rtol, whole = runner.method.rtol, len(few) == len(runner.t)
        some, t = states if whole else np.ascontiguousarray(states[:, few]), runner.t[few]
        k, e, pivot = self._read(np.broadcast_to(t, some.shape[:2]), some, p)
        with np.errstate(invalid="ignore"):
            kept = keeps_sharply(k, e, some[:, :, -1], rtol, whole)
        for i in np.flatnonzero(~kept):
            if not np.isfinite(some[i]).all():
                continue
            check = energy_check(t, k[i], e[i], some[i, :, -1], self._open(some[i], p[i]) / rtol)
            kept[i] = check.surely_within(rtol, whole)
        return pivot[:, 0] > SURELY_REGULAR, kept

    def _open(self, some: Array, p: Array) -> Array:
        """The uncertainty of the energy due to atol, if `some` (m × n) are all samples of a motion and at most `FEW`; else zeros."""
        m, n = some.shape
        if m < len(self.runner.t) or m > FEW:
            return np.zeros(m)
        shifts = self.runner.method.atol * np.concatenate([np.zeros((1, n)), np.eye(n)[:-1], -np.eye(n)[:-1]])
        rows = some[None] + shifts[:, None]
        _, e, _ = self._read(np.broadcast_to(self.runner.t, rows.shape[:2]), rows, np.tile(p, (len(rows), 1)))
        return opened(e)

    def _read(self, t: Array, states: Array, p: Array) -> Array:
        """K, E and the pivot (3 × k × m) at times t (k × m) and states (k × m × n), with parameters for each of k motions."""
        count, m, n = states.shape
        found = self.judge(t.reshape(-1), states.reshape(-1, n), np.repeat(p, m, axis=0))
        return np.moveaxis(found.reshape(count, m, 3), -1, 0)
