# SPDX-License-Identifier: BSD-3-Clause
"""Repeated motions in one call of machine code: a kernel bound once to its arrays, as `simulate` and `prepare` keep it.

Such motions need no Python between two steps: a kernel decides their constraints, events and switches, and inputs are numbers or
expressions. Start, parameters and energy are checked by sufficient conditions in compiled code; if these do not
hold, the general loop integrates the motion from its beginning (`loop.py`) and decides.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import reduce
from operator import itemgetter
from time import monotonic
from typing import Any, NamedTuple

import numpy as np

from kane.analysis.state_checks import start_state
from kane.dynamics.formulation.recursive import WAYS
from kane.dynamics.readings.quantities import without_unknowns
from kane.equations.compiled import Kept, ports
from kane.equations.equations import Equations
from kane.expr.build import NODE_BUILDERS, div, mul, sub
from kane.expr.evaluation import free_symbols
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.node import constant as constant_node
from kane.expr.symbols import time
from kane.model.beams.beam import Beam
from kane.motion.arguments import Arguments
from kane.motion.constraint_kernels import KernelConstraints
from kane.motion.course import HELD, MANY_STEPS, RECENT, Method
from kane.motion.hybrid.automaton import (
    asks,
    asks_for,
    check_witnesses,
    ended_by_last,
    leapt_over,
    on_their_sides,
    phase_after,
    stands_beside,
)
from kane.motion.inputs.breakpoints import stretch
from kane.motion.inputs.expressions import Formula, gains_of, values, with_value
from kane.motion.inputs.functions import constant
from kane.motion.inputs.smooth import check_prescribed, pieces_prescribed
from kane.motion.integrators import spelled
from kane.motion.loop import admitted_start, breakpoints_of, continued
from kane.motion.methods import kernel_of
from kane.motion.native import LOOKS, Stiffness, first_slots, pauses
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import Routines, has_jumps, only, switches, timed, unfit
from kane.motion.solution.checks import keeps_sharply
from kane.motion.solution.phases import Phase
from kane.motion.solution.resumed import Begin
from kane.motion.solution.solution import Solution, SolutionSegment, some_of
from kane.motion.start import check_masses, moving, surely_have_mass
from kane.motion.steppers.context import SIZE, ReturnCode, Slot
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.steps import Stepper, unheld
from kane.numeric.arrays import Array, Mask
from kane.numeric.sampling import SEED, sample
from kane.numeric.scale import SURELY_REGULAR
from kane.program.from_expressions import Bundle
from kane.program.native.entry import hoisting, hoists_of
from kane.program.native.machine import Settings
from kane.progress import is_noted, noted, working

_PATIENCE = 0.05
"""Elapsed seconds after which the general loop, which checks time limits and signals, continues a motion."""


_REACHED = (ReturnCode.END, ReturnCode.LIMIT, ReturnCode.EVENT)
"""Return codes of a kernel that need no decision by the general loop."""


def judged(eom: Equations) -> Bundle[Array]:
    """K, E = K + V, and the least relative pivot: of M to its diagonal, of W and of trees to the sizes at a random configuration."""
    rows = [] if eom.solved.route in WAYS else [list(row) for row in eom.mass_matrix]
    own = moving(eom)
    sizes = dict(zip(own, (constant_node(abs(x) or 1.0) for x in sample(own, SEED)), strict=True))
    sizes |= eom.solved.free_pivots if eom.solved.route in WAYS else {}
    shares = [div(NODE_BUILDERS["abs"](p), usual) for p, usual in sizes.items()]
    roots = without_unknowns(eom.solved, [eom.kinetic_energy, eom.energy, _least_pivot(rows, shares)])
    return Bundle("judged", ports(eom.derived), only, {"judged": roots}, ["K", "E", "pivot"])


def _least_pivot(m: list[list[Expr]], others: Sequence[Expr]) -> Expr:
    """min d_i / M_ii of M = L D Lᵀ (m is overwritten), and of `others`; 1 if there are none, 0 if a pivot is identically zero."""
    least, diagonal = reduce(NODE_BUILDERS["min"], others, ONE), [row[i] for i, row in enumerate(m)]
    for k, row in enumerate(m):
        if row[k] is ZERO:
            return ZERO
        least = NODE_BUILDERS["min"](least, div(row[k], diagonal[k]))
        for i in range(k + 1, len(m)):
            share = div(m[i][k], row[k])
            for j in range(i, len(m)):
                m[i][j] = m[j][i] = sub(m[i][j], mul(share, m[j][k]))
    return least


Noted = tuple[Array, Array]
"""Logged events, rows (t, index), and rows of `jumps` (see `Course.noted`)."""
_ROOM = 64
"""Numbers for further breakpoints, three each, of motions whose inputs break at other times."""
_STARTS = 64
"""Number of stored starts of constrained motions, which are found by iteration."""


def _key(at: tuple[Any, Any, Any]) -> Any:
    """A hashable key of start values; None if they have none."""
    result = tuple(
        tuple(x.items()) if isinstance(x, Mapping) else tuple(x) if hasattr(x, "__iter__") else x for x in at
    )
    try:
        hash(result)
    except TypeError:
        return None
    return result


class Plan(NamedTuple):
    """The arguments of a motion that are the same in each call, as the user gave them; a key for what is derived from them."""

    span: Any
    method: Any = None
    rtol: Any = None
    atol: Any = None
    samples: Any = 501
    max_steps: Any = None
    max_step: Any = None
    first_step: Any = None
    breakpoints: Any = None
    max_seconds: Any = None

    def spelled(self) -> "Plan":
        """The plan with a record of options as `method` replaced by a name and options."""
        return self if self.method is None or isinstance(self.method, str) else Plan(**spelled(self._asdict()))


def check_values(eom: Equations, p: Array, span: tuple[float, float]) -> None:
    """Check masses, moments of inertia, events and prescribed motions at values p of the parameters.

    Equal values are checked once. A SimulationError names what is not admissible.
    """
    admitted, key = eom.numeric().value(_admitted), (p.tobytes(), span)
    if admitted.get(key):
        return
    constants: dict[Expr, float] = dict(zip(eom.parameters, p.tolist(), strict=True))
    check_masses(eom, constants)
    check_witnesses(eom, constants)
    check_prescribed(eom, constants, span)
    admitted.put(key, True)


def surely_admitted(eom: Equations, p: Array) -> Mask:
    """For which of k rows p (k × parameters) `check_values` certainly raises no error (k)."""
    if pieces_prescribed(eom):
        return np.zeros(len(p), dtype=bool)
    watched = ~(p == 0).any(axis=1) if eom.system.events else True
    return surely_have_mass(eom, dict(zip(eom.parameters, p.T, strict=True)), len(p)) & watched


def _admitted(eom: Equations) -> Kept[bool]:
    return Kept()


def _reads_inputs(eom: Equations, drives: Iterable[Any]) -> bool:
    """Whether the quantities of `judged` depend on inputs that are not constant."""
    read = free_symbols(eom.numeric().value(judged).groups["judged"].roots)
    return any(constant(f) is None for f in drives) and not set(eom.inputs).isdisjoint(read)


class Judge:
    """The routine of `judged` for motions with the same inputs, at many times and states."""

    def __init__(self, eom: Equations, settings: Settings | None, drives: Sequence[Any]) -> None:
        self.routine, self.drives = eom.numeric(settings).routine(judged).flat, drives
        self.parameters, self.reads = (*eom.parameters, *gains_of(drives)), _reads_inputs(eom, drives)
        self.r = np.array([*(constant(f) or 0.0 for f in drives), 0.0], dtype=float)

    def __call__(self, t: Array, y: Array, p: Array) -> Array:
        """K, E and the least pivot (rows × 3) at times and y, with parameters, those of inputs alone last, for each row or for all."""
        rows, y, found = np.append(p, np.zeros((len(p), 1)), axis=1), np.ascontiguousarray(y), np.zeros((len(t), 3))
        r, width = self.r, rows.shape[1] if len(p) > 1 else 0
        if self.reads:
            known: dict[Expr, Any] = dict(zip(self.parameters, p.T if len(p) != 1 else p[0], strict=True))
            inputs = values([with_value(f, known) for f in self.drives], t, y[:, :-1])
            r = np.column_stack([inputs, np.zeros(len(t))])
        places = (t.copy(), 1), (y, y.shape[1]), (rows, width), (r, len(self.r) * self.reads)
        self.routine.on_rows(*places, out=found)()
        return found


def is_plain(stepper: Stepper, method: Method) -> bool:
    """Whether a kernel can integrate the motion without Python, both before it and between two steps."""
    eom = stepper.eom
    return (
        method.name in INTEGRATORS
        and not eom.system.modes_change
        and not unheld(stepper)
        and not (is_constrained(eom) and INTEGRATORS[method.name].implicit)
        and not (bool(eom.events) and (eom.numeric().value(asks) or asks_for(stepper.now)))
        and (not switches(eom) or (has_jumps(eom) and not unfit(eom)))
        and not any(eom.numeric().value(timed))
        and all(constant(f) is not None or isinstance(f, Formula) for f in stepper.now.drives)
    )


class Runner:
    """A kernel with its arrays, which integrates one motion at a time: `take` parameters, `begin` at a start, `run`."""

    def __init__(
        self,
        stepper: Stepper,
        method: Method,
        span: tuple[float, float],
        times: Array,
        drives: Mapping[Expr, Any],
        options: Mapping[str, Any],
    ) -> None:
        self.method, self.span, self.drives, self.options = method, span, drives, options
        self.usual: dict[Expr, float] = {}
        self.told = b""
        varied = [f for f in drives.values() if isinstance(f, Formula) and f.values]
        self.varied, self.timed = bool(varied), time in free_symbols([f.expr for f in varied])
        self.reads = _reads_inputs(stepper.eom, drives.values())
        self.starts: dict[Any, tuple[Array, Array]] = {}
        self.holding: KernelConstraints | None = None
        self.marks = np.zeros(len(times) + 1)
        self.noted: list[Noted] = []
        self.changed: list[tuple[float, Routines]] = []
        self.bends = any(isinstance(b, Beam) for b in stepper.first.system.bodies)
        later = times[times > span[0]]
        ends = [] if later.size and later[-1] == span[1] else [span[1]]
        self.t = np.concatenate([span[:1], later, ends])
        n = len(stepper.eom.state) + 1
        self.s, self.y, self.states = np.zeros(SIZE), np.zeros(n), np.zeros((len(self.t), n))
        self.rows = self.states[1 : len(later) + 1]
        self.slots = np.zeros(SIZE)
        self.slots[Slot.SPAN], self.slots[Slot.PHASE] = span[1] - span[0], span[0]
        self.parameters, self.stops = (*stepper.eom.parameters, *gains_of(drives.values())), method.breakpoints
        breakpoints = self.breakpoints_for(stepper.eom, drives)
        self.pauses = np.zeros(len(pauses(breakpoints, span, ())) + _ROOM)
        self.stop_at(breakpoints)
        self.times = np.append(later, np.inf)
        self.few = some_of(len(self.t))
        self.some = self.states if len(self.few) == len(self.t) else np.zeros((len(self.few), n))
        self.verdict = np.zeros((len(self.few), 3))
        self.inputs = np.zeros((len(self.few), len(stepper.eom.inputs) + 1))
        self.plain = stepper.now
        self._bind(stepper.now, stepper)

    def _bind(self, now: Routines, stepper: Stepper) -> None:
        """Binds the kernel to the parameters of `now`."""
        name, now = self.method.name, on_their_sides(now)
        arguments = Arguments(name, now, self.span[0], self.s, self.y)
        self.now = arguments.now
        more = {"times": self.times, "rows": self.rows, "samples": len(self.rows)}
        self.given = arguments.given | more | {"breakpoints": self.breakpoints, "pauses": self.pauses}
        if is_constrained(stepper.eom):
            self.holding = KernelConstraints(stepper, arguments, self.span[0], self.y)
            self.given |= self.holding.given | {"held_marks": self.marks}
        self.hoist = hoisting(hoists_of(self.given))
        r = (self.inputs, self.inputs.shape[1]) if self.reads else (self.given["single_r"], 0)
        places = (self.t[self.few], 1), (self.some, len(self.y)), (self.given["p"], 0), r
        self.judge = now.eom.numeric(now.settings).routine(judged).flat.on_rows(*places, out=self.verdict)
        self.kernel = kernel_of(name, now, self.holding is not None).bound(self.given | {"limit": 0})

    def breakpoints_for(self, eom: Equations, drives: Mapping[Expr, Any]) -> tuple[float, ...]:
        """The breakpoints of a motion with these inputs; rates have none of their own."""
        return breakpoints_of(eom, Phase({}, drives), self.span, self.stops)

    def stop_at(self, breakpoints: tuple[float, ...]) -> None:
        """Sets the breakpoints of the next motions; there may be too many."""
        self.method, table = replace(self.method, breakpoints=breakpoints), pauses(breakpoints, self.span, ())
        self.slots[: Slot.FRESH + 1] = first_slots(self.method, self.span, *stretch(breakpoints, *self.span))
        self.breakpoints, self.covers = len(table) // 3, len(table) < len(self.pauses)
        if self.covers:
            self.pauses[: len(table)] = table

    def take(self, eom: Equations, constants: Mapping[Expr, float]) -> None:
        """Sets the values of the parameters, those of inputs included, for the next motions, after checking them.

        Raises
        ------
        SimulationError
            if a value is not admissible
        """
        p = np.array([constants[s] for s in eom.parameters])
        drives: dict[Expr, Any] = {
            s: with_value(f, constants) for s, f in zip(eom.inputs, self.plain.drives, strict=True)
        }
        gains = gains_of(drives.values())
        told = np.append(p, [*gains.values()]).tobytes()
        if told == self.told:
            return
        check_values(eom, p, self.span)
        if self.varied:
            self.drives = drives
            if self.timed:
                self.stop_at(self.breakpoints_for(eom, drives))
            self.now = self.now.driven({**constants, **gains})  # one left out has its default again
        own = self.given["p"]
        own[: len(p)], own[len(self.now.p) : len(self.now.p) + len(gains)] = p, [*gains.values()]
        self.hoist(own)
        self.told = told

    def begin(self, eom: Equations, at: tuple[Any, Any, Any], constants: Mapping[Expr, float]) -> Array | None:
        """(q, u, a) from start values; None if a motion from there needs the general loop.

        Raises
        ------
        ValueMissingError
            if a value is missing or unknown
        SimulationError
            if the start is not admissible
        """
        if not self.covers:
            return None
        if self.holding is None:
            return start_state(eom, *at)
        p, key = self.now.p[: len(eom.parameters)], _key(at)
        known = self.starts.get((key, self.told)) if key else None
        stepper = Stepper(eom, p.copy(), self.now.drives, self.now.settings)
        if known is None:
            y = admitted_start(stepper, Begin(at[0], at[1], None, at[2]), constants, self.span[0])
            if unheld(stepper) or stepper.eom is not self.plain.eom or stepper.changes:
                return None
            if len(self.starts) >= _STARTS:
                self.starts.clear()
            known = self.starts[key, self.told] = y, stepper.reach
        stepper.reach = known[1].copy()
        self.holding.restart(stepper)
        return known[0][:-1]

    def run(
        self, eom: Equations, x: Array, constants: dict[Expr, float], again: Callable[..., Any]
    ) -> tuple[Solution | None, bool]:
        """The motion from (q, u, a), and whether its energy balance certainly holds; None if it needs the general loop.

        `constants` are the values of the parameters; `again` repeats the motion.
        """
        begun = monotonic()
        self.s[:], self.y[:-1], self.y[-1], self.marks[:] = self.slots, x, 0.0, 0.0
        if self.holding is not None:
            self.holding.begin(self.s)
        self.states[0] = self.y
        self.given["lag"][:] = 0.0
        self.noted.clear()
        self.changed.clear()
        if self.now.events is not None and not stands_beside(self.now, self.given, self.span[0], self.y):
            return None, False
        p = self.given["p"].copy()
        back, stiffness = self._steps(begun)
        if (p != self.given["p"]).any():  # by actions: hoisted values are evaluated anew for the next motion
            self.told = b""
            self.given["p"][:] = self.given["p"] if back is ReturnCode.LIMIT else p
        if self.holding is not None and (
            back is not ReturnCode.END or self.marks.any() or len(self.t) > len(self.rows) + 1
        ):
            return None, False
        if back in _REACHED and not is_noted() and not (self.noted and back is ReturnCode.LIMIT):
            self.states[len(self.rows) + 1 :] = self.y  # the end, if it is not a sample
            if self.some is not self.states:
                np.take(self.states, self.few, axis=0, out=self.some)
            if self.reads:
                self.inputs[:, :-1] = self.now.inputs(self.t[self.few], self.some)
            self.judge()
            if self.verdict[0, 2] > SURELY_REGULAR:
                phase = Phase(constants, self.drives)
                if back is ReturnCode.LIMIT:
                    return replace(
                        self._continued(eom, x, phase, begun, stiffness), _again=again, _options=self.options
                    ), False
                if self.now.events is not None:
                    if back is ReturnCode.END and self._leapt(eom):
                        return None, False
                    self._logged_events()
                k, e, _ = self.verdict.T
                kept = not self._jumps(back) and bool(keeps_sharply(k, e, self.some[:, -1], self.method.rtol))
                return self._ended(eom, phase, back, again), kept and not self.bends
        return None, False

    def _leapt(self, eom: Equations) -> bool:
        """Whether the quantity of an event crosses its threshold between the last step and the end, by rounding alone."""
        own = len(eom.events)
        return bool(leapt_over(eom.events, self.given["seen"][:own], self.now.watch(self.span[1], self.y)[:own]))

    def _ended(
        self, eom: Equations, phase: Phase, back: ReturnCode, again: Callable[..., Any] | None = None
    ) -> Solution:
        """The solution of a motion that has ended, from the arrays."""
        if self._jumps(back):
            return self._with_stepped_speeds(self._with_jumps(eom, phase, again, back))
        return self._with_stepped_speeds(self.motion(eom, phase, self.states.copy(), self.s, again))

    def _jumps(self, back: ReturnCode) -> bool:
        """Whether an event has ended the motion, or changed its state."""
        return back is ReturnCode.EVENT or any(len(jumps) for _, jumps in self.noted)

    def ended(
        self,
        eom: Equations,
        phase: Phase,
        stepper: Stepper | None,
        states: Array,
        s: Array,
        met: Noted | None,
        changed: Sequence[tuple[float, Routines]] = (),
    ) -> Solution:
        """The solution of a motion that other code has integrated: samples, slots, logged events, changes of dependent speeds."""
        self.states[:], self.y[:], self.s[:] = states, states[-1], s
        self.noted[:], self.changed[:] = [] if met is None else [met], changed
        if self.holding is not None and stepper is not None:
            self.holding.restart(stepper)
        return self._ended(eom, phase, ReturnCode(int(s[Slot.BACK])))

    def _steps(self, begun: float) -> tuple[ReturnCode, Stiffness]:
        """Calls the kernel up to the end or until the general loop is needed: its last return code, the stiffness detection before."""
        stiffness, most = Stiffness(False), self.method.max_steps
        limit = RECENT if self.now.quantities else LOOKS
        while True:
            t = self.s[Slot.TIME]
            back = ReturnCode(
                self.kernel(limit=min(limit, most - int(self.s[Slot.STEPS])), breakpoints=self.breakpoints)
            )
            if self.now.quantities and back is ReturnCode.LIMIT and self.s[Slot.TIME] - t < HELD * self.s[Slot.SPAN]:
                return ReturnCode.STANDS, stiffness
            before = copy(stiffness)
            if back is ReturnCode.FULL:
                self._logged_events()
                continue
            if self.holding is not None and self.holding.completes(back, self.s):
                continue
            late = monotonic() - begun > _PATIENCE or self.method.max_seconds < np.inf
            if back is not ReturnCode.LIMIT or late or self.s[Slot.STEPS] >= min(most, MANY_STEPS):
                return back, before
            if self.method.free and stiffness.sets_in(self.s):
                return back, before

    def _continued(self, eom: Equations, x: Array, phase: Phase, begun: float, stiffness: Stiffness) -> Solution:
        """The solution of a motion of many steps, continued by the general loop."""
        with working("Simulating"), noted():
            p = self.now.p[: len(eom.parameters)]
            stepper = Stepper(eom, p, self.now.drives, self.now.settings)
            way = self.span, np.append(x, 0.0), self.times[:-1]
            given = self.given | {"pauses": self.pauses[: 3 * self.breakpoints + 1]}
            return continued(stepper, self.method, way, phase, (given, stiffness), begun)

    def _logged_events(self) -> list[Noted]:
        """Collects from the kernel logged events, one pair of tables for each call, and changes of dependent speeds."""
        s, width = self.s, 2 * len(self.y) + 2
        self.changed += self.holding.changes() if self.holding is not None else ()
        if s[Slot.LOGGED]:
            log = self.given["log"][: 2 * int(s[Slot.LOGGED])].reshape(-1, 2).copy()
            self.noted.append((log, self.given["jumps"][: width * int(s[Slot.JUMPS])].reshape(-1, width).copy()))
            s[Slot.LOGGED] = s[Slot.JUMPS] = 0.0
        return self.noted

    def _with_jumps(self, eom: Equations, phase: Phase, again: Callable[..., Any] | None, back: ReturnCode) -> Solution:
        """The solution with two samples, before and after, where an event changes the state."""
        n, count, events = len(self.y), int(self.s[Slot.SAMPLE]), eom.events
        met = [(events[int(k)], t) for log, _ in self.noted for t, k in log.tolist()]
        later, instants = self.times[:count], np.concatenate([jumps[:, 0] for _, jumps in self.noted])
        kept = np.flatnonzero(~np.isin(later, instants))
        ends = [self.span[1]] if back is ReturnCode.END and not (count and later[-1] == self.span[1]) else []
        t = np.concatenate([self.t[:1], later[kept], ends])
        states = np.concatenate([self.states[:1], self.rows[kept], *([self.y[None]] if ends else [])])
        places, times, rows, begins = list[int](), list[float](), list[Array](), list[int]()
        phases = [phase]
        done = first = 0
        for log, jumps in self.noted:
            for row in jumps:
                acting = tuple(e for e, _ in met[done : first + int(row[1])] if e.then is not None)
                done, at = first + int(row[1]), int(np.searchsorted(t, row[0]))
                for x in row[2:].reshape(2, n)[: 1 + bool(acting)]:
                    places.append(at)
                    times.append(float(row[0]))
                    rows.append(x)
                if acting:
                    begins.append(at + len(places) - 1)
                    phases.append(phase_after(self.now, phases[-1], float(row[0]), row[2 : n + 2], acting))
            done = first = first + len(log)
        number = np.zeros(len(t) + len(places), dtype=np.int64)
        number[begins] = 1
        states = np.insert(states, places, rows, axis=0)
        ended = ended_by_last(met) if back is ReturnCode.EVENT else None
        return replace(
            self.motion(eom, phase, self.states.copy(), self.s, again),
            t=np.insert(t, places, times),
            states=states[:, :-1],
            work=states[:, -1],
            status="event" if ended else "finished",
            message=ended.message if ended else f"reached t = {self.span[1]:g}",
            event=ended and ended.event,
            phases=tuple(phases),
            phase=np.cumsum(number),
        )

    def _with_stepped_speeds(self, motion: Solution) -> Solution:
        """The solution with the segments and samples of the dependent speeds that were used."""
        if self.holding is None:
            return motion
        stepper = self.holding.stepper
        changed = (*self.changed, *self.holding.changes())
        for t, now in changed:
            stepper.go_over(now, t)
        segments = (
            (SolutionSegment(self.span[0], motion.equations), *stepper.segments) if motion.equations.embedding else ()
        )
        samples = tuple(stepped_along(motion.equations, changed, motion.t)) if segments else ()
        events = tuple(sorted([*motion.events, *stepper.changes], key=itemgetter(1)))
        return replace(motion, segments=segments, samples=samples, events=events)

    def motion(
        self, eom: Equations, phase: Phase, states: Array, s: Array, again: Callable[..., Any] | None = None
    ) -> Solution:
        """The solution of a motion that reached the end of the span, from its samples and the final slots s."""
        return Solution(
            eom,
            self.t.copy(),
            states[:, :-1],
            states[:, -1],
            phase.parameters,
            phase.inputs,
            "finished",
            f"reached t = {self.span[1]:g}",
            None,
            tuple((eom.events[int(k)], t) for log, _ in self.noted for t, k in log.tolist()),
            int(s[Slot.STEPS]),
            int(s[Slot.RATES]),
            rtol=self.method.rtol,
            atol=self.method.atol,
            method=self.method.name,
            phases=(phase,),
            phase=np.zeros(len(self.t), dtype=np.int64),
            _again=again,
            _options=self.options,
        )


def stepped_along(eom: Equations, changed: Sequence[tuple[float, Routines]], t: Array) -> list[Equations]:
    """The equations in use at times t, given the changes of dependent speeds."""
    every = [eom, *(now.eom for _, now in changed)]
    counts = np.diff(np.searchsorted(t, [at for at, _ in changed]), prepend=0, append=len(t))
    return [one for one, count in zip(every, counts.tolist(), strict=True) for _ in range(count)]
