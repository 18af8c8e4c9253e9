# SPDX-License-Identifier: BSD-3-Clause
"""Motions with contacts in kernels, without Python: kernels of modes, and the kernel of the hybrid automaton that calls them.

The kernel of a mode is prepared when a motion first reaches it. Python runs a mode if loads are discontinuous, events have actions, or
its kernel would need Python; where inputs are Python functions, the kernels call these.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from kane.equations.compiled import Kept
from kane.equations.equations import Equations
from kane.equations.mode_equations import ContactModes, contact_numbers
from kane.errors import KaneError
from kane.expr.node import Expr
from kane.model.contacts import ContactMode, Modes
from kane.model.declarations import Event
from kane.motion.arguments import Arguments, Hooks
from kane.motion.constraint_kernels import KernelConstraints
from kane.motion.course import Method
from kane.motion.hybrid.automaton import End, ended_by, glance
from kane.motion.hybrid.contact_automaton import Back, Record, automaton_kernel
from kane.motion.hybrid.contact_tables import (
    KNOWN,
    LIMIT,
    MODES,
    code_of,
    numbers_of,
    of_modes,
    put_mode,
    reach_of,
    row_of,
    structure,
    symbols,
)
from kane.motion.inputs.breakpoints import Clock, clock, stretch
from kane.motion.inputs.expressions import Formula, HeldInput, controllers, gains_of
from kane.motion.inputs.functions import constant
from kane.motion.loop import bounded, breakpoints_of, whole
from kane.motion.methods import chosen, kernel_of
from kane.motion.native import first_slots, pauses
from kane.motion.projection import is_constrained
from kane.motion.right_hand_side import Given, has_jumps, timed
from kane.motion.solution.phases import Indices, Phase
from kane.motion.solution.solution import Solution, SolutionSegment
from kane.motion.steppers.context import SIZE, ReturnCode, Slot
from kane.motion.steppers.held import CHANGES, POORER
from kane.motion.steppers.table import INTEGRATORS
from kane.motion.steppers.watched import rooms
from kane.motion.steps import Stepper, unheld
from kane.numeric.arrays import Array
from kane.program.native.entry import RESULT, CompiledKernel, Hoisting, KeptCalls, entry, hoists_of
from kane.program.native.machine import Settings
from kane.progress import Interrupted, far, is_noted


@dataclass(frozen=True, slots=True, eq=False)
class Went:
    """The result of a run of the automaton: the completed modes as a motion, if any, why it returned, and the last event.

    The other attributes are those at the last event, or of the mode that Python must run: the events `by` which it began, the
    quantities that leave thresholds upward, and the number `still` of modes of zero duration before.
    """

    motion: Solution | None
    back: Back
    event: Event | None
    t: float
    x: Array
    work: float
    modes: Modes
    directions: Array
    numbers: Mapping[Expr, float]
    by: tuple[Event, ...]
    leaves: Mapping[str, float]
    still: int


class ModeKernel(NamedTuple):
    """A mode, its equations, the name of its method, the arguments of its kernel, and the owners of arrays to which these point.

    `places` are the indices of its parameters among those of the motion, or the number of these for other parameters.
    """

    modes: Modes
    equations: Equations
    method: str
    given: Given
    owners: tuple[Arguments, KernelConstraints | None]
    places: Indices


class ModeRows(NamedTuple):
    """Motions of the automaton: rows of `records`, the motion `owner` (rows) of each, and samples (motions × times × y)."""

    records: Array
    owner: Indices
    samples: Array


_LOOKED_AT = 8
"""Number of modes after which the elapsed time is looked at, if it is limited."""


@cache
def _automaton(settings: Settings) -> CompiledKernel:
    return CompiledKernel(automaton_kernel(), settings, loops=False)


class ContactRunner:
    """The kernels of the automaton and of its modes, with their arrays."""

    def __init__(
        self,
        eom: Equations,
        method: Method,
        span: tuple[float, float],
        given: tuple[Mapping[Expr, float], Mapping[Expr, Any]],
        settings: Settings | None,
        times: Array,
        breakpoints: tuple[float, ...],
    ) -> None:
        self.eom, self.method, self.span, self.settings = eom, method, span, settings
        self.parameters, self.inputs = given
        self.gains = tuple(gains_of(self.inputs.values()))
        self.contacts, n = eom.system.contacts, len(eom.state) + 1
        later = times[times > span[0]]
        self.s, self.y = np.zeros(SIZE), np.zeros(n)
        self.times, self.rows = np.append(later, np.inf), np.zeros((len(later) + 1, n))
        self.controllers = controllers(tuple(self.inputs.values()))
        most = room_for(breakpoints)
        self.stops: Given = {"breakpoints": most, "pauses": np.append(np.full(3 * most, -np.inf), 0.0)}
        self.breakpoints: tuple[float, ...] = ()
        self.stop_at(breakpoints)
        self.hooks = Hooks(self.s, self.y)
        self.control = self.hooks.add(self._control)
        self.raised: BaseException | None = None
        self.made: list[ModeKernel] = []
        self.turning = list[int]()  # modes with discontinuities at given times
        self.admitted = b""  # the parameters for which these are admitted
        self.named = dict[str, Method]()
        self.left: set[Modes] = set()
        self.poor, self.steps = (-1, 0.0), 0
        self.late: Callable[[], object] = lambda: False
        told = structure(eom)
        self.at_once = _LOOKED_AT if method.max_seconds < np.inf else told["room_for"]
        if self.controllers:  # modes that Python repeats begin with the values held there
            self.at_once = 1
        self.k, self.d, self.lag, count = told["contacts"], told["dimension"], told["lag"], told["event_count"]
        self.counts = {name: told[name] for name in ("event_count", "p_count")}
        self.width = row_of(self.k, self.d, n)
        lengths = rooms(count, count, 0, n)
        self.shared: Given = {name: np.zeros(lengths[name] + 2 * count) for name in ("log", "jumps")}
        self.marks, self.held_log = np.zeros(len(later) + 1), np.zeros(2 * CHANGES + 3)
        self.calls = KeptCalls(MODES, settings or Settings())
        self.codes = np.full(MODES, -1.0)
        self.arrays: dict[str, Array] = {
            **of_modes(told, MODES),
            **{name: told[name] for name in (*KNOWN, "modes", "leaving", "records", "noted", "kept", "next_modes")},
            "directions": told["directions"].reshape(self.k, self.d - 1),
            "extra": told["extra"].reshape(self.k, self.d + 1),
        }
        self.given = self._bound(told)
        self.kernel = _automaton(settings or Settings()).bound(self.given)
        self.symbols = symbols(eom)
        self.flat = [s for own in self.symbols for s in own]

    def stop_at(self, breakpoints: tuple[float, ...]) -> None:
        """Sets the breakpoints of the next motions, with the same `room_for` them; the table of pauses ends with theirs."""
        if breakpoints == self.breakpoints:
            return
        self.breakpoints = breakpoints
        own, table = self.stops["pauses"][:-1], pauses(breakpoints, self.span, self.controllers)
        own[:] = -np.inf
        own[len(own) - len(table) :] = table

    def take(self, given: tuple[Mapping[Expr, float], Mapping[Expr, Any]]) -> None:
        """Prepares the next motion, with these parameters and with inputs of the same values."""
        self.parameters, self.inputs = given
        self.late = lambda: False
        own = gains_of(self.inputs.values())
        self.renew(np.array([*(self.parameters[s] for s in self.eom.parameters), *own.values()]))

    def renew(self, p: Array) -> None:
        """Resets contacts and constraint solvers, so that results do not depend on motions before, and sets the parameters.

        p are those of the equations, then those of inputs alone.
        """
        self._forget()
        self.steps = 0
        own = p[self.own_places]
        if (own != self.given["p"][:-1]).any():
            self.given["p"][:-1] = own
            at = self.span[0], np.zeros(len(self.eom.state)), own, self.given["r"][:-1]
            self.given["h"][:] = self.hoists(*at)
        padded = np.append(p, 0.0)
        for m, one in enumerate(self.made):
            self.arrays["ps"][m, : len(one.places)] = padded[one.places]
            holding = one.owners[1]
            if holding is not None:
                holding.begin(self.s)
                one.given["held_quiet"][0] = 0.0
        if p.tobytes() != self.admitted:
            self.admitted = p.tobytes()
            for m in self.turning:
                self._admit(m, dict(zip(self.eom.parameters, p.tolist(), strict=False)))

    def _forget(self) -> None:
        """Resets the data of contacts."""
        for name in (*KNOWN, "kept"):
            self.arrays[name][:] = 0.0

    def _control(self, t: float, x: int, out: int) -> None:
        """Evaluates the sampled controllers that are due; after an exception the kernel returns."""
        self.s[Slot.STOPPED] = 1.0
        for one in self.controllers:
            one.due(t, self.y[:-1])
        self._hold()
        self.s[Slot.STOPPED] = float(is_noted() or bool(self.late()))

    def _hold(self) -> None:
        """Writes the latest values of sampled controllers to the inputs of the automaton and of all modes."""
        for m in self.made if self.controllers else ():
            m.owners[0].hold()
        for k, held in self.held:
            self.given["r"][k] = held.now

    def _ends_here(self) -> bool:
        """Whether the mode that the kernel has left within its time has any steps; then they are a completed mode."""
        s, count, noted = self.s, *map(int, self.arrays["records"][:2])
        row = self._rows()[count]
        if s[Slot.TIME] <= row[Record.BEGIN]:
            return False
        logged = int(s[Slot.LOGGED])
        self.arrays["noted"][2 * noted : 2 * (noted + logged)] = self.shared["log"][: 2 * logged]
        row[[Record.END, Record.EVENT, Record.SAMPLE, Record.OVER]] = s[Slot.TIME], -1.0, s[Slot.SAMPLE], 0.0
        row[Record.NOTED] = noted + logged
        row[-len(self.y) :] = self.y
        self.arrays["records"][:2] = count + 1, noted + logged
        return True

    def check(self) -> None:
        """Raises the exception that occurred in an input, if any."""
        error, self.raised = self.raised, None
        if error is not None:
            raise error

    def _places(self, symbols: Iterable[Expr]) -> Indices:
        """The indices of symbols among the parameters of the motion and its inputs; the number of these for other symbols."""
        at: dict[Expr, int] = {s: k for k, s in enumerate((*self.eom.parameters, *self.gains))}
        return np.array([at.get(s, len(at)) for s in symbols], dtype=np.int64)

    def _bound(self, told: Given) -> Given:
        """The arguments of the automaton's kernel."""
        eom = self.eom
        routine = self.routine = eom.numeric(self.settings).routine(contact_numbers).flat
        self.hoists, ports = Hoisting(routine), routine.program.ports
        self.own_places = self._places(ports[2].symbols)
        p = np.array([self.parameters[s] for s in ports[2].symbols] + [0.0])
        drives = [self.inputs[s] for s in ports[3].symbols]
        self.held = [(k, f) for k, f in enumerate(drives) if isinstance(f, HeldInput)]
        r = np.array([*(constant(f) or 0.0 for f in drives), 0.0], dtype=float)
        return {
            **told,
            "known": 0,
            "most": self.method.max_steps,
            "enter": 1,
            "alone": 0,
            "at_once": self.at_once,
            **{name: array.reshape(-1) for name, array in self.arrays.items()},
            "touch": entry(routine),
            "h": self.hoists(self.span[0], np.zeros(len(eom.state)), p[:-1], r[:-1]),
            "p": p,
            "r": r,
            "numbers": np.zeros(len(routine.routine.results) + 1),
            "s": self.s,
            "y": self.y,
            "log": self.shared["log"],
            "held_log": self.held_log,
            "calls": self.calls.table,
            "codes": self.codes,
            "tolerances": np.array([self.method.atol, self.method.rtol, 0.0]),
            "make": self.calls.make,
            "hoist": self.calls.hoist,
            "look": self.calls.look,
            "drive": self.calls.drive,
            "driven": int(any(constant(f) is None and not isinstance(f, HeldInput) for f in self.inputs.values())),
        }

    # Modes ------------------------------------------------------------------------------------------------------------------

    def place(self, modes: Modes, mode: Equations) -> int | None:
        """The index of a mode among those prepared, after preparation if needed; None if Python must run it."""
        for m, one in enumerate(self.made):
            if one.modes == modes:
                return m if self.codes[m] >= 0 else None
        if modes in self.left or len(self.made) == MODES or max(modes) >= ContactMode.ACROSS:
            return None
        if not self._make(modes, mode):
            self.left.add(modes)
            return None
        return self.place(modes, mode)

    def _make(self, modes: Modes, mode: Equations) -> bool:
        """Prepares the kernel of a mode; False if Python must run it."""
        m, numbers = len(self.made), dict(self.parameters)
        numbers |= {s: 0.0 for s in self.flat if s is not None}
        p, drives = np.array([numbers[s] for s in mode.parameters]), tuple(self.inputs[s] for s in mode.inputs)
        stepper = Stepper(mode, p, drives, self.settings)
        name = chosen(self.method.name, stepper, stepper.now.drives, self.method.rtol, self.method.max_step)
        if not _fits(stepper, name) or [*map(id, mode.inputs)] != [*map(id, self.eom.inputs)]:
            return False
        arguments = Arguments(name, stepper.now, self.span[0], self.s, self.y, hooks=self.hooks)
        samples = {"times": self.times, "rows": self.rows, "samples": len(self.times) - 1}
        given = arguments.given | samples | self.stops | {"limit": LIMIT}
        if self.controllers:
            given["control"] = self.control
        holding: KernelConstraints | None = None
        if is_constrained(mode):
            stepper.reach = reach_of(mode)
            holding = KernelConstraints(stepper, arguments, self.span[0], self.y)
            holding.begin(self.s)
            given |= holding.given | {"held_marks": self.marks, "held_log": self.held_log}
        if len(mode.events) >= self.counts["event_count"] or len(given["p"]) > self.counts["p_count"]:
            return False
        arrays = self.arrays
        for name_ in ("p", "seen", "largest", "least", "leaves"):
            view = arrays["ps" if name_ == "p" else name_][m, : len(given[name_])]
            view[:] = given[name_][: len(view)]
            given[name_] = view
        put_mode(arrays, m, self.eom, mode)
        given |= self.shared | {"lag": self.lag}
        looked = arguments.now.routine(glance, *arguments.now.turning).flat
        kernel = kernel_of(name, arguments.now, is_constrained(mode))
        own_given = {a.name: given[a.name] for a in kernel.kernel.arguments}
        drive = given["single_drive"], given["hd"]
        self.calls.put(m, (kernel, own_given), hoists_of(given), ((entry(looked), given["hg"]), drive), given["p"])
        self.named[name] = replace(bounded(self.method, self.inputs.values(), self.span), name=name, first=None)
        self.made.append(
            ModeKernel(modes, mode, name, given, (arguments, holding), self._places((*mode.parameters, *self.gains)))
        )
        if any(mode.numeric().value(timed)):
            self.turning.append(m)
            self.admitted = b""
        self._admit(m, self.parameters)
        return True

    def _admit(self, m: int, parameters: Mapping[Expr, float]) -> None:
        """Lets the automaton enter a mode, unless that has discontinuities at other times than the breakpoints."""
        one = self.made[m]
        own = one.equations.numeric().value(timed).breakpoints(parameters, self.span) if m in self.turning else ()
        self.codes[m] = code_of(one.modes) if {*own} <= {*self.breakpoints} else -1.0

    # The motion -------------------------------------------------------------------------------------------------------------

    def go(
        self,
        m: int,
        at: tuple[float, Array, float],
        directions: Array,
        numbers: Mapping[Expr, float],
        leaves: Sequence[int],
        by: Any,
        before: tuple[int, int],
    ) -> Went | None:
        """Runs from mode m on, from t, x and the work done; quantities of the contacts `leaves` leave their thresholds upward.

        None if an input raises an exception in that mode; see `check`.
        `before` are the number of preceding modes of zero duration and the number of steps so far.
        """
        arrays, self.steps = self.arrays, before[1]
        self._sets_out(at, self.made[m].method)
        self.calls.table[0] = m
        arrays["modes"][:] = self.made[m].modes
        arrays["directions"][:] = directions
        arrays["extra"][:] = [[0.0 if s is None else numbers.get(s, 0.0) for s in row] for row in self.symbols]
        arrays["leaving"][:] = 0.0
        arrays["leaving"][list(leaves)] = 1.0
        arrays["kept"][-1] = before[0]
        back, motion, by = self._led(by)
        return None if back is Back.DECIDE and motion is None else self._went(back, motion, by)

    def start(self, at: tuple[float, Array, float], first: Callable[[], tuple[Modes, Equations]]) -> Went | None:
        """Runs from the start of a motion, t, x and the work done; None if Python must decide the mode in which it begins.

        If no mode is prepared, the `first` mode of the motion is, as the kernel evaluates inputs by the routines of a mode.
        """
        if not self.made:
            self.place(*first())
            self._forget()
        if not self.made:
            return None
        self._sets_out(at, self.made[0].method)
        back, motion, by = self._led((), enter=2)
        return None if back is Back.DECIDE and motion is None else self._went(back, motion, by)

    def leads(self, x: Array) -> Back | None:
        """END or EVENT if the kernel alone runs from the start x to the end of the span, or to a terminal event; else None.

        `records` and `rows` then contain the motion.
        """
        if not self.made:
            return None
        self._sets_out((self.span[0], x, 0.0), self.made[0].method)
        back = Back(self.kernel(known=len(self.made), enter=2, most=self.method.max_steps))
        return back if back in (Back.END, Back.EVENT) else None

    def _sets_out(self, at: tuple[float, Array, float], name: str) -> None:
        """Sets the kernel's arguments for a run from t, x and the work done, with the method `name`."""
        t, x, work = at
        method, s = self.named[name], self.s
        first, end = stretch(self.breakpoints, t, self.span[1])
        s[: int(Slot.FRESH) + 1] = first_slots(method, self.span, first, end)
        s[Slot.BREAKPOINT] = np.searchsorted(self.stops["pauses"][:-1:3], first, side="right")
        s[Slot.SPAN] = self.span[1] - self.span[0]
        s[Slot.SAMPLE] = np.searchsorted(self.times[:-1], t, side="right")
        s[[Slot.STEPS, Slot.RATES]] = 0.0
        self.y[:] = np.append(x, work)
        self.held_log[0] = 0.0
        self.given["tolerances"][2] = (self.method.first or 0.0) if t == self.span[0] and not self.steps else 0.0

    def _led(self, by: tuple[Event, ...], enter: int = 1) -> tuple[Back, Solution | None, tuple[Event, ...]]:
        """Runs the kernel: its return code, the completed modes, and the events that ended the last one; `enter` is 2 at a start.

        It is FULL or UNKNOWN if the motion is `late`.
        """
        pieces = list[Solution]()
        while True:
            # after an interrupt the kernel returns at its next mode, which Python ends at once
            self._hold()
            for one in self.controllers:
                one.keep()
            most = -1 if is_noted() else self.method.max_steps - self.steps
            back = Back(self.kernel(known=len(self.made), enter=enter, most=most))
            self.given["tolerances"][2] = 0.0
            self.raised, late = self.hooks.left(), bool(self.late())
            interrupted = is_noted() or (isinstance(self.raised, Interrupted) and not late)
            if back is Back.TAKE and (interrupted or late) and self._ends_here():
                back = Back.DECIDE if interrupted else Back.FULL
                self.raised = Interrupted() if interrupted else None
            elif (
                self.raised is not None
            ):  # `check` raises it after the last completed mode, before Python decides anything
                back = Back.TAKE if pieces and not len(self.completed()) else Back.DECIDE
            for one in self.controllers:
                one.done(repeats=not len(self.completed()))
            if back is Back.TAKE:  # Python repeats the mode: its steps do not count
                self.s[[Slot.STEPS, Slot.RATES]] = self._rows()[len(self.completed()), [Record.STEPS, Record.RATES]]
            far(lambda: f"t = {self.s[Slot.TIME]:.4g} of {self.span[1]:.4g} s")
            piece, by = self._collect(by)
            pieces += piece
            asked = self.calls.table[RESULT] == ReturnCode.LOOK and self.s[Slot.HELD] == POORER
            self.poor = (int(self.calls.table[0]), 1.25 * self.s[Slot.SHARE]) if asked else (-1, 0.0)
            if back is Back.UNKNOWN and not self._completed():
                back = Back.DECIDE
            if back not in (Back.FULL, Back.UNKNOWN) or self.late():
                return back, whole(pieces) if pieces else None, by
            enter = 1

    def _completed(self) -> bool:
        """Whether the mode that the kernel has decided on, but had no kernel for, could be prepared; then it begins.

        Else the data of contacts are restored to those before the decision, which is left to Python.
        """
        arrays, modes = self.arrays, tuple(ContactMode(int(m)) for m in self.arrays["next_modes"])
        m = None
        with suppress(KaneError):
            m = self.place(modes, self.eom.numeric().value(ContactModes).equations(modes))
        if m is None:
            for name, values in zip(KNOWN, arrays["kept"][:-1].reshape(len(KNOWN), -1), strict=True):
                arrays[name][:] = values
            return False
        self.calls.table[0] = m
        arrays["modes"][:] = modes
        arrays["directions"].flat[:] = self.given["next_ways"]
        return True

    def admit(self) -> None:
        """Suppresses further requests for better dependent speeds up to the quality at which Python has found none."""
        m, share = self.poor
        if m >= 0:
            self.made[m].given["held_quiet"][0] = share

    def _rows(self) -> Array:
        """The array `records`, by rows."""
        return self.arrays["records"][2:].reshape(-1, self.width)

    def motion(self) -> Solution:
        """The completed modes as one motion, to the end of the span or to the event that ended the last one."""
        ((motion,), by), (t, end) = self._collect(()), (self.s[Slot.TIME], self.span[1])
        over = (
            ended_by(by, [(event, float(t)) for event in by], acted=True)
            if self.completed()[-1, Record.EVENT] >= 0
            else None
        )
        over = over or End("finished", f"reached t = {end:g}")
        return replace(motion, status=over.status, message=over.message, event=over.event)

    def completed(self) -> Array:
        """The rows of `records` of completed modes."""
        return self._rows()[: int(self.arrays["records"][0])]

    def _went(self, back: Back, motion: Solution | None, by: tuple[Event, ...]) -> Went:
        count, n = int(self.arrays["records"][0]), len(self.y)
        taken = back is Back.TAKE
        row = self._rows()[count if taken else count - 1]
        modes, mode, *_ = self.made[int(row[Record.MODE])]
        (numbers,) = numbers_of(self.eom, row[None])
        more = int(Record.MORE) + self.k * (self.d + 1)
        states = row[more : more + 2 * n].reshape(2, n)
        y = states[0 if taken else 1]
        ways = row[int(Record.MORE) : more].reshape(self.k, self.d + 1)[:, : self.d - 1].copy()
        event = None if taken or row[Record.EVENT] < 0 else mode.events[int(row[Record.EVENT])]
        t = float(row[Record.BEGIN if taken else Record.END])
        pairs = zip(self.contacts, modes, self.arrays["leaving"], strict=True)
        leaves = {f"{c.name} {'sticks' if m else 'closes'}": 1.0 for c, m, up in pairs if up}
        still = int(self.arrays["kept"][-1])
        return Went(motion, back, event, t, y[:-1].copy(), float(y[-1]), modes, ways, numbers, by, leaves, still)

    def _collect(self, by: tuple[Event, ...]) -> tuple[list[Solution], tuple[Event, ...]]:
        """The completed modes as one motion, if any, and the events that began the next mode."""
        rows = self.completed()
        if not len(rows):
            return [], by
        one = ModeRows(rows, np.zeros(len(rows), dtype=np.int64), self.rows[None])
        t, states, piece = self.laid_out(one)
        modes = [self.made[int(m)] for m in rows[:, Record.MODE]]
        phases, segments, events, by = self._parts(rows, modes, by)
        names = dict.fromkeys(one.method for one in modes)
        steps, rates = int(self.s[Slot.STEPS]), int(self.s[Slot.RATES])
        self.steps += steps
        self.s[[Slot.STEPS, Slot.RATES]] = 0.0
        made = Solution(
            self.eom,
            t,
            states[:, :-1],
            states[:, -1],
            phases[0].parameters,
            self.inputs,
            "event",
            "",
            None,
            tuple(events),
            steps,
            rates,
            tuple(segments),
            tuple(modes[k].equations for k in piece.tolist()),
            rtol=self.method.rtol,
            atol=self.method.atol,
            method=", ".join(names),
            phases=tuple(phases),
            phase=piece,
        )
        return [made], by

    def laid_out(self, motions: ModeRows) -> tuple[Array, Array, Indices]:
        """Times, y and row of `records` of samples: the beginning, the samples within and the end of each completed mode."""
        rows, owner, samples = motions
        n, more = len(self.y), int(Record.MORE) + self.k * (self.d + 1)
        begins, ends, mode = rows[:, Record.BEGIN], rows[:, Record.END], np.arange(len(rows))
        first, last = (rows[:, at].astype(int) for at in (Record.FIRST_SAMPLE, Record.SAMPLE))
        whose = np.repeat(mode, last - first)
        which = np.arange(len(whose)) - np.repeat(np.cumsum(last - first) - last, last - first)
        inside = (self.times[which] > begins[whose]) & (self.times[which] < ends[whose])
        whose, which = whose[inside], which[inside]
        order = np.argsort(np.concatenate([3 * mode, 3 * whose + 1, 3 * mode + 2]), kind="stable")
        t = np.concatenate([begins, self.times[which], ends])[order]
        inner = samples[owner[whose], which]
        states = np.concatenate([rows[:, more : more + n], inner, rows[:, more + n : more + 2 * n]])[order]
        return t, states, np.concatenate([mode, whose, mode])[order]

    def _parts(
        self, rows: Array, modes: Sequence[ModeKernel], by: tuple[Event, ...]
    ) -> tuple[list[Phase], list[SolutionSegment], list[tuple[Event, float]], tuple[Event, ...]]:
        """The phases, segments and events of completed modes, and the events that ended the last one."""
        phases, segments, events, done = list[Phase](), list[SolutionSegment](), list[tuple[Event, float]](), 0
        met = self.arrays["noted"][: 2 * int(rows[-1, Record.NOTED])].reshape(-1, 2).tolist()
        for row, numbers, one in zip(
            rows[:, : int(Record.MORE)].tolist(), numbers_of(self.eom, rows), modes, strict=True
        ):
            mode = one.equations
            phases.append(Phase({**self.parameters, **numbers}, self.inputs, by))
            segments.append(SolutionSegment(row[Record.BEGIN], mode))
            for at, k in met[done : int(row[Record.NOTED])]:
                events.append((mode.events[int(k)], at))
            done = int(row[Record.NOTED])
            if row[Record.EVENT] >= 0:
                by = (mode.events[int(row[Record.EVENT])],)
            if row[Record.END] < row[Record.OVER] <= self.span[1]:
                events.append((rests(by[0]), row[Record.OVER]))
        return phases, segments, events, by


def runner(
    eom: Equations,
    method: Method,
    span: tuple[float, float],
    given: tuple[Mapping[Expr, float], Mapping[Expr, Any]],
    settings: Settings | None,
    times: Array,
) -> tuple[ContactRunner, list[ContactRunner]]:
    """A runner that no other motion uses, and the list to which it must be returned after use."""
    inputs, breakpoints = tuple(map(same_in_all, given[1].values())), stops_of(eom, method, span, given)
    kept, key = eom.numeric(settings).value(_runners), (method, span, times.tobytes(), inputs, room_for(breakpoints))
    free = kept.get(key)
    if any(x is None for x in inputs):  # these belong to one motion
        free = []
    elif free is None:
        kept.put(key, free := [])
    try:
        found = free.pop()
    except IndexError:
        found = ContactRunner(eom, method, span, given, settings, times, breakpoints)
    found.stop_at(breakpoints)
    found.take(given)
    return found, free


def room_for(breakpoints: tuple[float, ...]) -> int:
    """The number of breakpoints for which a runner made for these has room."""
    return (1 << len(breakpoints).bit_length()) - 1


def stops_of(
    eom: Equations, method: Method, span: tuple[float, float], given: tuple[Mapping[Expr, float], Mapping[Expr, Any]]
) -> tuple[float, ...]:
    """The breakpoints of a motion with given parameters and inputs."""
    laws = eom.numeric().value(timed_laws).breakpoints(given[0], span)
    return tuple(sorted({*breakpoints_of(eom, Phase(*given), span, method.breakpoints), *laws}))


def same_in_all(f: Any) -> float | Expr | None:
    """The number or expression of an input, which is the same in all motions but for parameters; None for functions."""
    return f.expr if isinstance(f, Formula) else constant(f)


def timed_laws(eom: Equations) -> Clock:
    """The parts of friction and restitution that switch at given times, or may be pulses."""
    return clock(eom.in_speeds(x) for c in eom.system.contacts for x in c.numbers)


def _runners(eom: Equations) -> Kept[list[ContactRunner]]:
    return Kept()


def _fits(stepper: Stepper, name: str) -> bool:
    """Whether a kernel can run a mode up to an event of its contacts without Python."""
    eom = stepper.eom
    return (
        name in INTEGRATORS
        and not unheld(stepper)
        and not (is_constrained(eom) and INTEGRATORS[name].implicit)
        and not has_jumps(eom, stepper.now.laws)
        and all(event.then is None for event in eom.events)
    )


def rests(closes: Event) -> Event:
    """The event that is noted when the rebounds that begin with the event `closes` have ended."""
    return Event(f"{closes.name.removesuffix(' closes')} rests", closes.quantity, terminal=False)
