# SPDX-License-Identifier: BSD-3-Clause
"""The exact derivative of a hybrid motion: variational equations between events, saltation matrices at events.

Between events Ψ′ = J Ψ + ∂f/∂p along the motion, J = ∂f/∂x. An event at h(x, t) = 0, crossed at the rate ḣ = ∇h·f⁻ + ∂h/∂t, has its
time shifted by δτ = −(∇h·δx⁻ + ∂h/∂p δp)/ḣ. With the reset x⁺ = g(x⁻, t, p)

    δx⁺ = G (δx⁻ + f⁻ δτ) + ∂g/∂t δτ + ∂g/∂p δp − f⁺ δτ,      G = ∂g/∂x

which is S δx⁻ with the saltation matrix S = G + (f⁺ − G f⁻ − ∂g/∂t) ∇hᵀ/ḣ (Aizerman & Gantmakher 1958; Leine & Nijmeijer 2004, sec.
7.5). At an event that ends the motion the term f⁺ δτ is omitted, since the states compared are those at the event. Where rates jump
at a time that depends on parameters, δx jumps as well (`moved_breakpoints`).
"""

import math
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from itertools import islice, pairwise, takewhile
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from kane.equations.equations import Equations
from kane.errors import SimulationError
from kane.expr.node import Expr
from kane.expr.symbols import Parameter
from kane.model.declarations import Event
from kane.motion.contact_motion import ContactMotion
from kane.motion.derivatives.jumps import JumpSlopes, action, gradients, impact, parameters_of
from kane.motion.derivatives.moved_breakpoints import MovedBreakpoint, moved_breakpoints, own_jump
from kane.motion.derivatives.parameter_slopes import Slopes, forcing, input_slopes
from kane.motion.derivatives.tangent_space import Side, sizes_of
from kane.motion.derivatives.transition import Stretch, transition
from kane.motion.inputs.breakpoints import Span, next_end, on_from, up_to
from kane.motion.inputs.expressions import controllers, turning_laws
from kane.motion.inputs.functions import follows
from kane.motion.loop import breakpoints_of
from kane.motion.right_hand_side import Routines, rates_jump, routines
from kane.motion.solution.phases import Indices, Phase
from kane.motion.solution.solution import Solution
from kane.numeric.arrays import Array
from kane.numeric.scale import SAME_TIME, SIX_DIGITS
from kane.program.native.machine import Settings

_AGREES = 1e-9
"""Relative change of Ψ on halving the steps at which it has converged; the error is then about 2⁻¹⁶ of that change."""
_HALVINGS = 8
Again = Callable[[Array], Solution]


def states_of_phase(motion: Solution, phase: int, times: Array) -> Array:
    """States at sample times within a phase; at events there are further rows, before and after the reset."""
    rows = np.flatnonzero(motion.phase == phase)
    places = np.minimum(np.searchsorted(motion.t[rows], times), len(rows) - 1)
    return np.asarray(motion.states[rows[places]])


class Variation(NamedTuple):
    """δx = x δ(x₀, p) at the end of a motion (n × n + k), and δT = t δ(x₀, p) of the final time (n + k)."""

    x: Array
    t: Array


class Leap(NamedTuple):
    """The jump δx⁺ − δx⁻ by parameters (n × k) at a breakpoint that depends on them, its δτ (k), and the motion on both sides."""

    x: Array
    t: Array
    before: Side
    behind: Side


class Differential:
    """The derivative of motions of one system with respect to initial state and parameters."""

    def __init__(self, by: Sequence[Parameter], settings: Settings | None, options: Any) -> None:
        self.by, self.settings, self.options = tuple(by), settings, options
        self._known: dict[tuple[Any, bytes], tuple[Routines, Slopes, Slopes]] = {}
        self.scale, self.pace, self.length = np.ones(1), np.ones(1), 1.0
        self._ends: dict[int, Array] = {}
        self._watched: tuple[Expr, ...] = ()
        self._moved: list[MovedBreakpoint] = []

    def _routines(self, eom: Equations, phase: Phase) -> tuple[Routines, Slopes, Slopes]:
        p = np.array([phase.parameters[s] for s in eom.parameters])
        drives = tuple(phase.inputs[s] for s in eom.inputs)
        key = (eom, p.tobytes())
        if key not in self._known:
            now = routines(eom, p, drives, self.settings)
            _check(now)
            feedback = input_slopes(now, eom.state) if follows(now.drives) else None
            self._known[key] = now, forcing(now, self.by), feedback
        return self._known[key]

    def side(self, motion: Solution, row: int) -> Side:
        """The motion at a sample; at the first or last sample of a phase, on the side within it of breakpoints at that time."""
        number, t = int(motion.phase[row]), float(motion.t[row])
        now, *_ = self._routines(motion.samples[row] if motion.samples else motion.equations, motion.phases[number])
        near = [one.t for one in self._near(t)]
        if near and (row == 0 or motion.phase[row - 1] != number):
            t = max(t, on_from(max(near)))
        elif near and (row + 1 == len(motion) or motion.phase[row + 1] != number):
            t = min(t, up_to(min(near)))
        return Side(now, motion.phases[number], t, motion.states[row])

    def __call__(
        self, motion: Solution, again: Again, section: Event | None, period_slopes: Array | None = None
    ) -> Variation:
        """The derivative of the final state at the `section`, or at a final time with the derivatives `period_slopes` by parameters.

        `again` recomputes the motion at other sample times.

        Raises
        ------
        SimulationError
            if the motion is not differentiable: it grazes an event, or two events coincide
        """
        n, k = motion.states.shape[1], len(self.by)
        psi, dt, _ = self._walk(motion, again, section, np.eye(n, n + k), every=False)
        if section is None:
            dt = np.append(np.zeros(n), np.zeros(k) if period_slopes is None else period_slopes)
            return Variation(psi + np.outer(self.side(motion, len(motion) - 1).rate, dt), dt)
        if section.then is None:
            psi, dt = self._saltation(self.side(motion, len(motion) - 1), None, section, psi, None)
        return Variation(psi, dt)

    def along(self, motion: Solution, again: Again, start: Array) -> Array:
        """δx at every sample (samples × n × m + k), for the change `start` δ(ξ, p) of the initial state (n × m + k)."""
        return self._walk(motion, again, None, start, every=True)[2]

    def _walk(
        self, motion: Solution, again: Again, section: Event | None, psi: Array, *, every: bool
    ) -> tuple[Array, Array, Array]:
        """δx at the end, δτ of the last event, and δx at every sample if `every`."""
        n = motion.states.shape[1]
        k = psi.shape[1] - len(self.by)
        self.begin(motion)
        stretches = self.stretches(motion, np.arange(len(motion)) if every else ())
        flows, leaps = self.transitions(motion, stretches, again), self.leaps(motion, stretches, again)
        last, dt, found = int(motion.phase[-1]), np.zeros(psi.shape[1]), np.zeros((len(motion) * every, *psi.shape))
        for number in range(last + 1):
            if every:
                found[np.flatnonzero(motion.phase == number)[0]] = psi
            for i, (stretch, flow) in enumerate(zip(stretches, flows, strict=True)):
                if stretch.phase != number:
                    continue
                if i in leaps:
                    psi = psi + np.hstack([np.zeros((n, k)), leaps[i].x])
                at = flow[:, :, :n] @ psi
                at[:, :, k:] += flow[:, :, n:]
                if every:
                    found[list(stretch.rows)] = np.concatenate([psi[None], at])[list(stretch.places)]
                psi = at[-1]
            if number < last:
                row = int(np.flatnonzero(motion.phase == number)[-1])
                psi, dt = self.across(motion, row, psi, number + 1, section)
        return psi, dt, found

    def begin(self, motion: Solution, watched: Sequence[Expr] = ()) -> None:
        """Sets sizes and mean rates of the states from a motion, and `watched`, expressions whose breakpoints in time count too."""
        self._watched = tuple(watched)
        self._known, self._moved, self.length = {}, [], float(motion.t[-1] - motion.t[0])
        self.pace = np.ptp(motion.states, axis=0) / max(self.length, 1e-300)
        way = np.abs(self.side(motion, 0).rate) * self.length / (2 * np.pi)
        self.scale = sizes_of(motion.equations, np.maximum(np.abs(motion.states).max(axis=0), way), 1e-3)

    def _parts(self, motion: Solution, rows: Indices) -> Iterator[tuple[Equations, float, float]]:
        """The parts of a phase, given by its samples, each integrated with the same equations: these, its first and last time."""
        eom = motion.samples[rows[0]] if motion.samples else motion.equations
        first, last = float(motion.t[rows[0]]), float(motion.t[rows[-1]])
        for other, start in ((s.equations, s.start) for s in motion.segments if first <= s.start < last):
            if other.system is eom.system:
                yield eom, first, start
                eom, first = other, start
        yield eom, first, last

    def stretches(self, motion: Solution, wanted: Sequence[int] | Indices) -> list[Stretch]:
        """The stretches between changes of equations and breakpoints; the `wanted` samples are among their edges."""
        result, self._moved = list[Stretch](), list[MovedBreakpoint]()
        known_rows = np.asarray(wanted, dtype=np.int64)
        for number in range(int(motion.phase[-1]) + 1):
            phase, own_rows = motion.phases[number], np.flatnonzero(motion.phase == number)
            x: Array | None = motion.states[own_rows[0]]
            rows = known_rows[(known_rows > own_rows[0]) & (known_rows <= own_rows[-1])]
            for eom, t, stop in self._parts(motion, own_rows):
                known, breaks = self._routines(eom, phase), self._breaks(motion, eom, phase, (t, stop))
                while t < stop:
                    until = next_end(breaks, t, stop)
                    if until > t:
                        own, rows = np.split(rows, [np.searchsorted(motion.t[rows], until, side="right")])
                        edges = np.unique([t, *np.maximum(motion.t[own], t), until])
                        at = tuple(np.searchsorted(edges, motion.t[own]).tolist())
                        result.append(Stretch(*known, x, edges, number, tuple(own.tolist()), at))
                        x = None
                    t = on_from(until) if until < stop else stop
        self._moved.sort(key=attrgetter("t"))
        return result

    def _breaks(self, motion: Solution, eom: Equations, phase: Phase, part: Span) -> list[float]:
        """The breakpoints within a part of a motion; adds them with their slopes to `_moved`."""
        whole, (low, high) = (part[0], float(motion.t[-1])), part  # pulses are searched over the span of the motion
        room = SAME_TIME * self.length
        moved = moved_breakpoints(eom, phase, (whole[0] - room, whole[1] + room), self.by, self._watched)
        here = [one for one in moved if low - room <= one.t <= high + room]
        self._moved += here
        every = {*breakpoints_of(eom, phase, whole, self.options.get("breakpoints", ())), *(one.t for one in here)}
        return sorted(t for t in every if low < t < high)

    def leaps(self, motion: Solution, stretches: Sequence[Stretch], again: Again) -> dict[int, Leap]:
        """The jumps of δx at breakpoints that depend on parameters, by the index of the stretch that begins there.

        Raises
        ------
        SimulationError
            if rates jump where two breakpoints coincide whose times depend differently on the parameters
        """
        self._check_start(motion)
        middle = {i: (a.t1 + b.t0) / 2 for i, (a, b) in enumerate(pairwise(stretches), 1) if b.x is None}
        edges = {i: t for i, t in middle.items() if any(np.any(one.slopes) for one in self._near(t))}
        result, along = dict[int, Leap](), again(np.array([*edges.values()])) if edges else motion
        for i, t in edges.items():
            first, second = stretches[i - 1], stretches[i]
            (x,) = states_of_phase(along, second.phase, np.array([t]))
            phase = motion.phases[second.phase]
            before, behind = Side(second.now, phase, first.t1, x), Side(second.now, phase, second.t0, x)
            slopes = self._common(self._near(t), before, behind)
            if slopes is not None:
                result[i] = Leap(np.outer(before.rate - behind.rate, slopes), slopes, before, behind)
        return result

    def _near(self, t: float) -> list[MovedBreakpoint]:
        """The breakpoints at a time, up to rounding."""
        apart = max(32 * math.ulp(t), SAME_TIME * self.length)
        first = bisect_left(self._moved, t - apart, key=attrgetter("t"))
        return list(takewhile(lambda one: one.t <= t + apart, islice(self._moved, first, None)))

    def _check_start(self, motion: Solution) -> None:
        """Raises SimulationError if rates jump at the start at a time that depends on parameters: the motion has no side before it."""
        at = self.side(motion, 0)
        near = self._near(at.t)
        if any(np.any(one.slopes) for one in near):
            self._common(
                near, Side(at.now, at.phase, up_to(min(one.t for one in near)), at.x), at, [np.zeros(len(self.by))]
            )

    def _check_met(self, before: Side, after: Side, dt: Array) -> None:
        """Raises SimulationError if rates jump at the time of an event and at a breakpoint with another δτ."""
        start = np.zeros(len(dt) - len(self.by))
        near = [one._replace(slopes=np.append(start, one.slopes)) for one in self._near(before.t)]
        if near:
            self._common(near, before, after, [dt])

    def _common(
        self, near: Sequence[MovedBreakpoint], before: Side, behind: Side, others: Sequence[Array] = ()
    ) -> Array | None:
        """The common δτ/δp of coinciding breakpoints and of `others` at which something jumps; None if nothing jumps.

        Raises
        ------
        SimulationError
            if their slopes differ
        """
        apart = [one.slopes - near[0].slopes for one in near] + [row - near[0].slopes for row in others]
        size = max(float(np.abs(row).max(initial=0)) for row in (*(one.slopes for one in near), *others))
        if np.abs(apart).max(initial=0) <= SIX_DIGITS * size < np.inf:
            return near[0].slopes
        jumping = [one.slopes for one in near if self._jumps(one.quantity, before, behind)]
        if not jumping:
            return None
        every = np.array([*jumping, *others])
        if not np.ptp(every, axis=0).max(initial=0) <= SIX_DIGITS * np.abs(every).max(initial=0) < np.inf:
            raise SimulationError(
                f"Expected rates that jump at one time, got several jumps at t = {before.t:.9g} whose times change "
                "differently with parameters, or one whose time changes without bound: the derivative is not unique. Give "
                "values at which the jumps occur one after the other."
            )
        return jumping[0]

    def _jumps(self, quantity: Expr, before: Side, behind: Side) -> bool:
        """Whether rates or watched expressions jump where a quantity reaches its level, on either side of the other breakpoints there.

        With a mere kink, the difference at a small distance is far larger than that at the breakpoint.
        """
        for side, sign in ((before, -1), (behind, 1)):
            times = np.array([side.t, side.t + sign * SIX_DIGITS * self.length])
            at, away = own_jump(side.now, quantity, self._watched, (times, np.stack([side.x] * 2))).T
            least = np.append(SIX_DIGITS * self.scale / self.length, np.zeros(len(self._watched)))
            if not np.all((at <= least) | (at <= math.sqrt(SIX_DIGITS) * away)):
                return True
        return False

    @np.errstate(over="ignore", invalid="ignore")  # steps that are too long leave no finite numbers, and are halved
    def transitions(self, motion: Solution, stretches: list[Stretch], again: Again) -> list[Array]:
        """Φ of each stretch, with steps halved until it has converged."""
        whole = max(self.length, 1e-300)
        steps = [s.parts(max(2, math.ceil(motion.steps * (s.t1 - s.t0) / whole))) for s in stretches]
        size = np.divide.outer(self.scale, np.append(self.scale, np.ones(len(self.by))))
        found = self._with(stretches, [*range(len(stretches))], steps, again)
        open_, done = [*range(len(stretches))], dict(enumerate(found))
        for _ in range(_HALVINGS):
            steps = [2 * m for m in steps]
            finer = self._with(stretches, open_, steps, again)
            off = [
                float(np.max(np.abs(b - done[i]) / size) / np.max(np.abs(b) / size))
                for i, b in zip(open_, finer, strict=True)
            ]
            done |= dict(zip(open_, finer, strict=True))
            open_ = [i for i, e in zip(open_, off, strict=True) if not e <= _AGREES]
            if not open_:
                return [done[i] for i in range(len(stretches))]
        at = stretches[open_[0]]
        raise SimulationError(
            f"Expected variational equations that can be integrated, got no convergence from t = {at.t0:.6g} to {at.t1:.6g}: "
            f"their solutions still change at {steps[open_[0]].sum()} steps of order 16."
        )

    def _with(self, stretches: list[Stretch], which: list[int], steps: list[Indices], again: Again) -> list[Array]:
        """Φ of the stretches `which` with given numbers of steps."""
        times = {i: stretches[i].steps(steps[i]).times for i in which}
        resolved = [i for i in which if np.all(np.diff(times[i].reshape(-1)) > 0)]
        wanted = np.concatenate([times[i].reshape(-1) for i in resolved]) if resolved else np.zeros(0)
        motion = again(wanted) if len(wanted) else None
        result = []
        for i in which:
            at = stretches[i]
            x = self._ends[i - 1] if at.x is None else at.x
            guess = np.broadcast_to(x, (*times[i].shape, len(x)))
            if motion is not None and i in set(resolved):
                guess = states_of_phase(motion, at.phase, times[i])
            phi, self._ends[i] = transition(at, x, steps[i], guess, self.scale)
            result.append(phi)
        return result

    def across(self, motion: Solution, row: int, psi: Array, number: int, section: Event | None) -> tuple[Array, Array]:
        """Ψ after the event at which phase `number` begins, and δτ."""
        phase = motion.phases[number]
        before, after = self.side(motion, row), self.side(motion, row + 1)
        if len(phase.by) != 1:
            names = " and ".join(repr(e.name) for e in phase.by) or "none"
            raise SimulationError(
                f"Expected one event at an instant, got {names} at t = {before.t:.9g}: neighbouring motions meet them one "
                "after the other, and the derivative is not unique. Combine them into one event, or give values at which they "
                "occur one after the other."
            )
        (event,) = phase.by
        ends = section is not None and event.name == section.name and number == int(motion.phase[-1])
        return self._saltation(before, after, event, psi, None if ends else after)

    def _saltation(
        self, before: Side, after: Side | None, event: Event, psi: Array, onward: Side | None
    ) -> tuple[Array, Array]:
        """δx⁺ and δτ of an event; `onward` is the motion after it, None if the motion ends there."""
        k = psi.shape[1] - len(self.by)
        (h,) = gradients(before, [event.quantity], self.by)
        f = before.rate
        rate = float(h.x @ f + h.t)
        usual = np.abs(h.x) @ self.pace + abs(h.t)
        if not abs(rate) > SIX_DIGITS * usual:
            raise SimulationError(
                f"Expected a motion that crosses the event {event.name!r} with a nonzero rate, got one that grazes it at t = "
                f"{before.t:.9g}, where its quantity has the rate {rate:.3g}: a neighbouring motion may miss it, and there is "
                "no derivative."
            )
        dt = -(h.x @ psi) / rate
        dt[k:] -= h.p / rate
        own = self._jump(before, after or before, event)
        self._check_met(before, after or before, dt)
        moved = own.x @ (psi + np.outer(f, dt)) + np.outer(own.t, dt)
        moved[:, k:] += own.p
        if onward is not None:
            moved = moved - np.outer(onward.rate, dt)
        return moved, dt

    def _jump(self, before: Side, after: Side, event: Event) -> JumpSlopes:
        """The derivative of the reset at an event: an action, an impact of contacts, or the identity where a contact mode ends."""
        system = before.now.eom.system
        if system.modes:
            motion = ContactMotion(
                self.options["contacts"], (before.t, before.t + 1.0), _given(self, before), self.options
            )
            ending = motion.ends(event)
            if ending is not None:
                if ending[1] != "closes":
                    return JumpSlopes(
                        np.eye(len(before.x)), np.zeros(len(before.x)), np.zeros((len(before.x), len(self.by)))
                    )
                return impact(motion, before, ending[0], self.by)
        return action(before, after, event, self.by)


def _given(differential: Differential, side: Side) -> tuple[Any, Any]:
    """Parameters and inputs, including those that the mode before an impact does not contain."""
    eom, drives = differential.options["contacts"], differential.options["drives"](parameters_of(side.phase))
    return {s: side.phase.parameters[s] for s in eom.parameters}, {**drives, **side.phase.inputs}


def _check(now: Routines) -> None:
    """Raises SimulationError if rates are discontinuous in the state, or an input is a sampled controller."""
    met = {
        "loads, inputs or rates of states that jump with the state": rates_jump(now.eom, turning_laws(now.drives)),
        "a sampled controller": bool(controllers(now.drives)),
    }
    told = [text for text, holds in met.items() if holds]
    if told:
        raise SimulationError(
            f"Expected equations whose rates are smooth between events for the derivative of a motion, got {' and '.join(told)}. "
            "Declare dry friction by kn.contact or kn.joints.stiction, and other switches by events that set a further state."
        )
