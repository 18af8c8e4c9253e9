# SPDX-License-Identifier: BSD-3-Clause
"""A motion with contacts as a hybrid automaton: one mode after the other, each with its own derived equations.

A mode ends at one of its events (`kane.model.contacts`). The state there alone determines what follows: an impact where a gap closes,
then the modes whose accelerations and forces satisfy the laws (`kane.contacts`). Events determine which contacts are closed and which
slip; numerical values decide this only at the start of a motion.

A Zeno sequence of impacts is replaced by its limit: the n-th impact follows v_n (1 + e)/a after the one before, with v_n ∝ eⁿ, so that
a contact that rebounds with v is at rest after 2 v/(a (1 − e)). It comes to rest if the height v²/2a of its rebound is below a
fraction of the tolerance of the gap, or of the highest rebound before.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kane.contacts import ContactStatus, Law, ModeChoice, Rule, SolutionCount, impacts
from kane.contacts.mode_solution import solve
from kane.equations.contact_shares import rows_of, shares
from kane.equations.equations import Equations
from kane.equations.mode_equations import (
    ContactModes,
    ContactRows,
    ContactsAtState,
    contact_numbers,
    held_together,
    layout,
)
from kane.errors import KaneError, KaneWarning, SimulationError, warn
from kane.expr.node import ZERO, Expr
from kane.model.contact_modes import groups, stands
from kane.model.contacts import ContactMode, Modes, check_numbers, law_of
from kane.model.declarations import Event
from kane.motion.contact_runner import ContactRunner, Went, rests, runner
from kane.motion.course import Pace
from kane.motion.hybrid.automaton import End, ended_by
from kane.motion.hybrid.contact_automaton import AT_ONCE, Back
from kane.motion.hybrid.contact_events import ENDS, FLAT, LOW, NOTHING, STARTS
from kane.motion.hybrid.contact_tables import KNOWN, end_of
from kane.motion.hybrid.events import ThresholdReturn
from kane.motion.inputs.expressions import value
from kane.motion.inputs.functions import warn_of_jumps
from kane.motion.loop import admitted_start, run, solver, whole
from kane.motion.solution.resumed import Begin
from kane.motion.solution.solution import Solution, SolutionSegment
from kane.motion.steps import Stepper
from kane.numeric.arrays import Array
from kane.numeric.scale import EQUAL, GIVEN, ROUNDED, ROUNDED_TERMS, SAME_TIME, SIX_DIGITS
from kane.progress import Interrupted, collecting_seldom, in_time, is_noted

_MODES = 10_000_000
_LAWS: dict[str, dict[str, Any]] = {
    "stronge": {"law": Law.STRONGE},
    "poisson": {"law": Law.POISSON},
    "newton": {"law": Law.NEWTON},
    "moreau": {"rule": Rule.SIMULTANEOUS},
}


@dataclass(frozen=True, slots=True, eq=False)
class Decided:
    """The modes of contacts from an instant on, and directions of slip (k × d − 1).

    `choice` is that of the contacts `closed`; `hits` had impacts before; `stiff` if slip begins whose direction changes at once.
    """

    modes: Modes
    directions: Array
    closed: Sequence[int] = ()
    choice: ModeChoice | None = None
    hits: frozenset[int] = frozenset()
    stiff: bool = False

    @property
    def forces(self) -> Array:
        """N and F of the contacts `closed`; empty without a choice."""
        return np.zeros(0) if self.choice is None else self.choice.forces


class ContactMotion:
    """The contacts of a motion; arrays (k): `highest` rebound, `fastest` slip, its last `slip_rate`, last `rebound` speed, `slack`."""

    def __init__(self, eom: Equations, span: tuple[float, float], given: Any, options: Mapping[str, Any]) -> None:
        self.eom, self.span = eom, span
        self.atol, self.rtol = (float(options[name]) for name in ("atol", "rtol"))
        self.parameters, self.inputs = given
        self.modes_of = eom.numeric().value(ContactModes)
        self.numbers = eom.numeric(options["settings"]).routine(contact_numbers)
        self.layout: ContactRows = eom.numeric().value(layout)
        self.contacts = eom.system.contacts
        self.p = np.array([given[0][s] for s in self.numbers.bundle.ports[2].symbols])
        self.q = len(eom.coordinates)
        self.none = np.zeros((len(self.contacts), self.layout.d - 1))  # no slip of any contact
        self.highest, self.fastest, self.rebound, self.slack, self.slip_rate = np.zeros((5, len(self.contacts)))
        self.brief = False  # the mode that has ended lasted no time

    def touch(self, t: float, x: Array) -> ContactsAtState:
        """The contacts at time t and state x = (q, u, a)."""
        r = np.array([value(self.inputs[s], t, x) for s in self.numbers.bundle.ports[3].symbols])
        numbers = self.numbers(t, x, self.p, r)
        return ContactsAtState(self.layout, numbers, x[self.q : self.q + len(self.eom.speeds)])

    # Numbers of an instant ---------------------------------------------------------------------------------------------------

    def _still(self, touch: ContactsAtState, closed: set[int], sliding: Array) -> Array:
        """Directions of slip (k × d − 1) of the contacts `closed`, zero where slip is zero up to rounding."""
        result = np.zeros_like(sliding)
        for i in closed:
            v, size = touch.slips[i], float(np.linalg.norm(touch.slips[i]))
            if size > NOTHING * max(touch.slip_terms[i].max(), self.fastest[i]):
                result[i] = v / size
        return result

    def decide(self, t: float, x: Array, closed: set[int], sliding: Array, friction: Array, before: Modes) -> Decided:
        """The modes from time t on; `sliding` (k × d − 1) are directions of present slip, `friction` (k) the μ_s to be used."""
        modes = [ContactMode.SEPARATED] * len(self.contacts)
        directions = self.none.copy()
        closed = self.layout.together(closed)
        if not closed:
            return Decided(tuple(modes), directions)
        order = sorted(closed)
        touch = self.touch(t, x)
        choice = touch.choose(order, sliding, friction, [_mode(before[i], sliding[i]) for i in order])
        if choice.count is SolutionCount.SEVERAL:
            warn(
                f"Expected one mode of the contacts at t = {t:.6g}, got {1 + len(choice.others)} that satisfy the laws of "
                f"friction. The motion continues with {_modes_text(self.contacts, order, choice.modes)}: modes without "
                "wedging are preferred, then the previous mode, then the smallest forces. For rigid bodies the mode is not "
                "unique. Give compliant parts a stiffness, or reduce the friction."
            )
        for n, i in enumerate(order):
            mode, c, by = choice.modes[n], self.contacts[i], self.layout.pressed_by[i]
            if by is not None and choice.modes[order.index(by)] is ContactStatus.OPEN:
                continue
            if mode is ContactStatus.OPEN:
                if c.gap is None:
                    raise SimulationError(
                        f"{c.name} opens, but no coordinate describes its gap: continue with a model that has one"
                    )
                continue
            if mode is ContactStatus.STICK or not c.slips:
                modes[i] = ContactMode.STICK
                continue
            directions[i] = choice.directions[n]
            straight = len(c.slips) == 1 or self._slow(t, touch, i, self._slip_rate(choice, n))
            modes[i] = ContactMode.STRAIGHT if straight else ContactMode.SLIP
        return Decided(*held_together(touch, modes, directions), order, choice)

    def hit(self, t: float, x: Array, closed: set[int]) -> tuple[Array, set[int], float]:
        """The state after impacts of contacts, those that stay closed, and the time at which the last omitted rebound ends."""
        order, touch = sorted(closed), self.touch(t, x)
        laws = touch.numbers.laws
        problem = touch.problem(order, self.none, laws[:, 1], velocities=True)
        done = impacts(
            problem.mobility,
            problem.bias,
            problem.static,
            laws[order, 2],
            terms=problem.terms,
            names=problem.names,
            **_LAWS[law_of(self.contacts)],
        )
        after = x.copy()
        speeds = slice(self.q, self.q + touch.width)
        after[speeds] = touch.after(x[speeds], touch.places(order), done.impulse)
        scale = np.sqrt(np.diag(problem.mobility))
        size = problem.terms + scale * (scale @ np.abs(done.impulse))  # the scale of rounding errors of W
        self.fastest[order] = np.maximum(self.fastest[order], problem.tangents(size).max(axis=1))
        leaves = problem.normals(done.velocity) > NOTHING * problem.normals(size)
        stays = {i for i, off in zip(order, leaves, strict=True) if not off}
        off = [i for i in order if i not in stays]
        rebound = self.rebound.copy()
        flat, over = self._flat(t, after, stays, off, rebound)
        while flat:
            touch = self.touch(t, after)
            sliding = self._still(touch, stays, self.none)
            stuck = [i for i in stays if not sliding[i].any()]
            while flat:  # and contacts that these push down
                stays |= set(flat)
                change = touch.held(sorted(stays), stuck)
                rates = touch.velocity + touch.rows[:, : touch.width] @ change
                down = (rates < -NOTHING * touch.velocity_terms)[:: self.layout.d]
                flat = [i for i in off if i not in stays and down[i]]
            after[self.q : self.q + touch.width] += change
            off = [i for i in off if i not in stays]
            flat, later = self._flat(t, after, stays, off, rebound)  # others fall faster beside these
            over = max(over, later)
        return after, self.layout.together(stays), over

    def _flat(
        self, t: float, x: Array, closed: set[int], off: Sequence[int], rebound: Array
    ) -> tuple[list[int], float]:
        """The contacts whose further rebounds are below tolerances or rounding, and the time at which these would end.

        If restitution is zero, the ratio to the previous rebound speeds, `rebound` (k), replaces it.
        """
        touch, order, forces = self.touch(t, x), sorted(self.layout.together(closed)), np.zeros(0)
        if order:
            sliding = self._still(touch, set(order), self.none)
            forces = touch.choose(order, sliding, touch.numbers.laws[:, 0]).forces
        a = touch.accelerations(order, forces)[0][:: self.layout.d]
        flat, over = [], t
        for i in off:
            v = touch.gap_rates[i]
            e = touch.numbers.laws[i, 2] or (v / rebound[i] if rebound[i] > v else 0.0)
            self.rebound[i] = v
            height = -v * v / (2 * a[i]) if a[i] < 0 else np.inf
            open_ = self.atol + self.rtol * touch.numbers.gap_terms[i]
            if height < np.inf:
                self.highest[i] = max(self.highest[i], height)
            left = max(ROUNDED * touch.numbers.gap_terms[i], self._shifted(touch, order, i))
            if height <= max(FLAT * open_, LOW * self.highest[i], left):
                flat.append(i)
                over = max(over, t - 2 * v / (a[i] * (1 - e))) if e < 1 else over
        return flat, over

    def _shifted(self, touch: ContactsAtState, closed: Sequence[int], i: int) -> float:
        """How far at most a gap is shifted when the gaps of `closed` contacts, zero up to the resolution of times, are made zero."""
        d, w = self.layout.d, touch.mobility
        gaps = [n for n in closed if self.contacts[n].gap is not None]
        return float(2 * sum(abs(touch.numbers.gaps[n] * w[d * i, d * n] / w[d * n, d * n]) for n in gaps))

    # From mode to mode -------------------------------------------------------------------------------------------------------

    def start(self, t: float, x: Array) -> tuple[Array, set[int]]:
        """The state at the start, after impacts of contacts that close there, and the closed contacts.

        Raises
        ------
        SimulationError
            if bodies penetrate
        """
        touch, closed = self.touch(t, x), set[int]()
        for i, c in enumerate(self.contacts):
            static, kinetic, e = touch.numbers.laws[i]
            slides = c.kinetic_at(ZERO) is not c.kinetic and self._still(touch, {i}, self.none)[i].any()
            check_numbers(c.name, static, min(static, kinetic) if slides else kinetic, e, sized=c.sized)
            g, size = touch.numbers.gaps[i], touch.numbers.gap_terms[i]
            near, far = GIVEN * size, abs(touch.gap_rates[i]) * max(self.span[1] - self.span[0], abs(t))
            if c.gap is not None and g < -max(
                near, SAME_TIME * far
            ):  # a motion may have ended within rounding of its time
                raise SimulationError(
                    f"Expected a gap of the contact {c.name!r} at or above zero at the start, got {g:.6g}: the bodies "
                    "overlap. Move one of them."
                )
            if c.gap is None or (g <= near and touch.gap_rates[i] <= GIVEN * touch.velocity_terms[i * self.layout.d]):
                closed.add(i)
        closed = self.layout.together(closed)
        hits = [i for i in closed if touch.gap_rates[i] < -GIVEN * touch.velocity_terms[i * self.layout.d]]
        if hits:
            x, closed, _ = self.hit(t, x, closed)
        return x, closed

    def constants(self, now: Decided, t: float, x: Array) -> dict[Expr, float]:
        """The parameters of a mode: those of the motion, and those that contacts set, such as directions of slip."""
        found: dict[Expr, float] = dict(self.parameters)
        found |= {c.slack: float(g) for c, g in zip(self.contacts, self.slack, strict=True)}
        touch: ContactsAtState | None = None
        for i, c in enumerate(self.contacts):
            if now.modes[i] is ContactMode.ACROSS:
                found |= dict(zip(c.direction, now.directions[i].tolist(), strict=True))
            if not now.modes[i].slips:
                continue
            touch = touch or self.touch(t, x)
            d = now.directions[i][: len(c.slips)]
            found |= dict(zip(c.direction, d.tolist(), strict=True))
            v = float(np.linalg.norm(touch.slips[i]))
            gained = 0.0
            if now.choice is not None and i in now.closed:
                self.slip_rate[i] = self._slip_rate(now.choice, now.closed.index(i))
                gained = self._gained(self.slip_rate[i])
            self.fastest[i] = max(self.fastest[i], v, touch.slip_terms[i].max(), gained)
            level = self._slowest(t, touch, i, self.fastest[i], self.slip_rate[i])
            found[c.slowest] = max(2 * level, gained, v * (1 + ENDS)) if now.modes[i].straight else level
        return found | self._shares(now, t, x)[0]

    def mode(self, modes: Modes, numbers: Mapping[Expr, float], x: Array) -> Equations:
        """The equations of modes; for stands, dependent speeds are chosen at x and the present directions of slip."""
        if not stands(self.contacts, modes):
            return self.modes_of.equations(modes)
        return self.modes_of.equations(modes, {**dict(zip(self.eom.coordinates, x.tolist(), strict=False)), **numbers})

    def _shares(self, now: Decided, t: float, x: Array) -> tuple[dict[Expr, float], dict[int, float]]:
        """The weights of multipliers in the forces of stands, by symbol, and the margins of these forces, by contact."""
        found, margins, every = dict[Expr, float](), dict[int, float](), stands(self.contacts, now.modes)
        if not every:
            return found, margins
        touch = self.touch(t, x)
        ways = _slip_directions(touch, now)
        forces = self._forces(touch, now, ways)
        for stand in every:
            rows = rows_of(touch, stand, now.modes, ways)
            own = shares(touch, stand, now.modes, rows, forces)
            margins |= dict.fromkeys(stand.members, own.margin)
            along = own.along.reshape(len(rows.sticks), self.layout.d - 1, len(stand.along))
            for i, row in zip(stand.members, own.normal, strict=True):
                c = self.contacts[i]
                found |= dict(zip(c.shares[0], row.tolist(), strict=False))
                for w, more in zip(c.shares[1:], along[rows.sticks.index(i)] if i in rows.sticks else (), strict=False):
                    found |= dict(zip(w, more.tolist(), strict=False))
        return found, margins

    def _forces(self, touch: ContactsAtState, now: Decided, ways: Array) -> Array:
        """Contact forces (kd) that satisfy the equations of a mode, with the directions of slip `ways`; not unique for stands."""
        modes = now.modes
        order = [i for i, m in enumerate(modes) if m is not ContactMode.SEPARATED and self.layout.pressed_by[i] is None]
        forces = np.zeros(len(touch.mobility))
        if order:
            sliding = np.where([[m.slips] for m in modes], ways, 0.0)
            problem = touch.problem(order, sliding, touch.numbers.laws[:, 0])
            solution = solve(problem, [_mode(modes[i], sliding[i]) for i in order], problem.directions)
            forces[touch.places(order)] = solution.forces
        return forces

    def flight(self, now: Decided, t: float, x: Array, leaves: Mapping[str, float]) -> float | None:
        """Four times the least time until a gap that leaves its threshold is back, so that a first step shows its rise; else None."""
        off = [i for i, c in enumerate(self.contacts) if f"{c.name} closes" in leaves]
        if not off:
            return None
        touch = self.touch(t, x)
        forces = self._forces(touch, now, now.directions)
        a, v = touch.accelerations(range(len(self.contacts)), forces)[0][:: self.layout.d], touch.gap_rates
        return min((float(-8 * v[i] / a[i]) for i in off if a[i] < 0 < v[i]), default=None)

    def balanced(self, now: Decided, numbers: Mapping[Expr, float], t: float, x: Array) -> None:
        """SimulationError if contacts of a stand have moved relative to each other: shares are valid for one configuration."""
        every = stands(self.contacts, now.modes)
        if not every:
            return
        touch = self.touch(t, x)
        for stand in every:
            rows = rows_of(touch, stand, now.modes, now.directions)
            own = [self.contacts[i].shares[0][: len(stand.normals)] for i in stand.members]
            along = [w[: len(stand.along)] for i in rows.sticks for w in self.contacts[i].shares[1:]]
            for g, w in ((rows.normal, own), (rows.along, along)):
                sums = g.T @ np.array([[numbers[s] for s in row] for row in w]).reshape(g.shape)
                if np.abs(sums - np.eye(len(sums))).max(initial=0) > EQUAL:
                    names = ", ".join(self.contacts[i].name for i in stand.members)
                    raise SimulationError(
                        f"Expected contacts that keep their positions relative to each other, got {names}, which have moved "
                        "and whose forces are not unique for rigid bodies. Leave one out, or give compliant parts a stiffness"
                    )

    def _slip_rate(self, choice: ModeChoice, n: int) -> float:
        """The magnitude of the slip acceleration of the n-th chosen contact."""
        return float(np.linalg.norm(choice.accelerations.reshape(-1, self.layout.d)[n, 1:]))

    def _gained(self, rate: float) -> float:
        """The slip speed up to which slip has a fixed direction after it begins at this rate: see `STARTS`."""
        return STARTS * (self.span[1] - self.span[0]) * rate

    def _slow(self, t: float, touch: ContactsAtState, i: int, rate: float) -> bool:
        """Whether a contact slips so slowly that its direction is taken as fixed: see `ENDS`."""
        fastest = max(self.fastest[i], touch.slip_terms[i].max(), self._gained(rate))
        return bool(np.linalg.norm(touch.slips[i]) <= self._slowest(t, touch, i, fastest, rate))

    def _slowest(self, t: float, touch: ContactsAtState, i: int, fastest: float, rate: float) -> float:
        """The slip speed below which contact i, by its `fastest` one and its `rate`, slips in a fixed direction: see `ENDS`."""
        left = self.rtol * fastest + self.atol * touch.slip_sums[i].max()
        return float(max(ENDS * fastest, left, ROUNDED_TERMS * abs(t) * rate))

    def begin(self, t: float, x: Array) -> tuple[Array, Decided]:
        """The state and the modes at the start of a motion."""
        x, closed = self.start(t, x)
        touch = self.touch(t, x)
        sliding = self._still(touch, closed, self.none)
        before = tuple(ContactMode.STICK if i in closed else ContactMode.SEPARATED for i in range(len(self.contacts)))
        return x, self.decide(t, x, closed, sliding, touch.numbers.laws[:, 0], before)

    def leaves(self, now: Decided, before: Modes, t: float, x: Array, by: tuple[Event, ...]) -> dict[str, float]:
        """Events, by name, whose quantities leave thresholds upward as a mode begins: gaps that open or rebound, slips, N at zero."""
        found: dict[str, float] = {}
        decided = all(own is None or own[1] not in ("turns", "slows") for own in map(self.ends, by))
        touch: ContactsAtState | None = None
        for i, (c, mode) in enumerate(zip(self.contacts, now.modes, strict=True)):
            if (
                mode is ContactMode.SEPARATED
                and c.gap is not None
                and (i in now.hits or before[i] is not ContactMode.SEPARATED)
            ):
                found[f"{c.name} closes"] = 1.0
            elif mode.straight and decided:
                touch = touch or self.touch(t, x)
                if not self._still(touch, {i}, now.directions)[i].any():
                    found[f"{c.name} sticks"] = 1.0
        return found | {f"{self.contacts[i].name} opens": 1.0 for i in self._hardly_pressed(now)}

    def _hardly_pressed(self, now: Decided) -> list[int]:
        """Closed contacts with N = 0 up to rounding, which open at once if N decreases."""
        if now.choice is None:
            return []
        found, d = now.choice.solution, self.layout.d
        pairs = zip(now.closed, found.forces[::d], found.force_errors[::d], strict=True)
        return [i for i, n, error in pairs if now.modes[i] is not ContactMode.SEPARATED and n <= error]

    def goes_on(self, piece: Solution) -> None:
        """Takes over the parameters and inputs after a piece of the motion, which events may have changed."""
        last = piece.phases[-1]
        self.parameters = {s: last.parameters[s] for s in self.parameters}
        self.inputs = {**self.inputs, **last.inputs}
        self.p = np.array([self.parameters[s] for s in self.numbers.bundle.ports[2].symbols])

    def after(self, t: float, x: Array, now: Decided, event: Event) -> tuple[Array, Decided, float]:
        """The state after an event that ends a mode, the modes from then on, and the time at which omitted rebounds end."""
        k = len(self.contacts)
        closed = {i for i in range(k) if now.modes[i] is not ContactMode.SEPARATED}
        slides = {i for i in closed if now.modes[i].slips}
        (i, kind), begins, thrown = self.ends(event) or (-1, ""), t, set[int]()
        if kind == "turns":
            modes = tuple(m.slipping(straight=False) if n == i else m for n, m in enumerate(now.modes))
            return x, replace(now, modes=modes, hits=frozenset(), stiff=False), t
        if kind == "slows":
            touch, directions = self.touch(t, x), now.directions.copy()
            directions[i] = touch.slips[i] / np.linalg.norm(touch.slips[i])
            modes = tuple(m.slipping(straight=True) if n == i else m for n, m in enumerate(now.modes))
            return x, Decided(modes, directions), t
        touch = self.touch(t, x)
        hits = {n for n in set(range(k)) - closed if (n == i and kind == "closes") or self._closes(touch, n)}
        if hits:
            # an impact of another contact may make them rebound
            hits |= {n for n in set(range(k)) - closed if self._touches(touch, n)}
            for n in hits:  # those that leave have rebounded at this instant
                self.slack[n] = max(-touch.numbers.gaps[n], 0.0) if touch.gap_rates[n] > 0 else 0.0
            x, closed, begins = self.hit(t, x, thrown := closed | hits)
            touch = self.touch(t, x)
            x, touch, sliding = self._consistent(t, x, touch, closed, self._still(touch, closed, self.none))
        else:
            sliding = self._still(touch, slides, now.directions)
            if kind == "sticks":
                sliding[i] = 0.0
        friction = touch.numbers.laws[:, 0].copy()
        stand = next((s.members for s in stands(self.contacts, now.modes) if i in s.members), ())
        if stand and kind in ("opens", "slips") and not hits:
            same = replace(now, closed=(), choice=None, hits=frozenset(), stiff=False)
            if self._shares(same, t, x)[1][i] > GIVEN:  # large enough to locate an event
                return x, same, t
        if kind == "opens" and not hits:
            share = self._turned(touch, sliding)
            for off in (self._unpressed(touch, closed, sliding, friction, share) | {i}, {i}):
                apart = self.decide(t, x, closed - off, sliding, friction, now.modes)
                # a mode that lasted no time began with N > 0, and N has fallen through zero since
                if all((self.brief and n == i) or self._parts(touch, n, apart, share) for n in off):
                    self._opens(touch, closed, set(), apart.modes)
                    return x, apart, t
        slips = kind == "slips" and not hits
        begun = self._begins_to_slip(now, i, t, x, friction, sliding) if slips else []
        decided = self.decide(t, x, closed, sliding, friction, now.modes)
        if begun and not stand and (under_way := self._under_way(t, touch, x, decided, begun)):
            return *under_way, t
        if kind == "sticks" and not hits and not decided.modes[i].slips and sliding.any():
            x, touch, sliding = self._consistent(t, x, touch, closed, sliding)
            decided = self.decide(t, x, closed, sliding, friction, now.modes)
        back = set[int]() if hits else self._falls_back(touch, now, decided)
        # a slip that has turned before its end continues: from rest, along its acceleration
        turned = kind == "sticks" and not hits and decided.modes[i].slips and len(self.contacts[i].slips) > 1
        if back or turned:
            x, touch, sliding = self._brought_to_rest(t, x, touch, closed, back, sliding)
            closed = self.layout.together(closed | back)
            decided = self.decide(t, x, closed, sliding, friction, now.modes)
        self._opens(touch, closed, thrown, decided.modes)
        return x, replace(decided, hits=frozenset(hits)), begins

    def _consistent(
        self, t: float, x: Array, touch: ContactsAtState, closed: set[int], sliding: Array
    ) -> tuple[Array, ContactsAtState, Array]:
        """The state without any slip of contacts that are not `sliding`, its contacts, and the directions of slip of the others there.

        Residual slip of other contacts would change the direction of a slip that is barely above rounding.
        """
        for _ in closed:
            slides = set(np.flatnonzero(sliding.any(axis=1)).tolist())
            stuck = [i for i in closed - slides if self.contacts[i].slips]
            if not stuck or not slides:
                break
            x = x.copy()
            x[self.q : self.q + touch.width] += touch.held(sorted(closed), stuck)
            touch = self.touch(t, x)
            sliding = self._still(touch, slides, self.none)
        return x, touch, sliding

    def _brought_to_rest(
        self, t: float, x: Array, touch: ContactsAtState, closed: set[int], back: set[int], sliding: Array
    ) -> tuple[Array, ContactsAtState, Array]:
        """The state at zero gap rates of `closed` and `back` and zero slips not `sliding`, with its contacts and directions of slip.

        The directions are the previous ones, or those of `back`, unless a slip is reversed: friction would push along it.
        """
        after, stuck = x.copy(), [n for n in closed if not sliding[n].any()]
        after[self.q : self.q + touch.width] += touch.held(sorted(self.layout.together(closed | back)), stuck)
        there, still = self.touch(t, after), self._still(touch, back, self.none)
        directions = np.where(still.any(axis=1, keepdims=True), still, sliding)
        turned = np.flatnonzero((directions * there.slips).sum(axis=1) < 0)
        directions[turned] = self._still(there, set(turned.tolist()), self.none)[turned]
        return after, there, directions

    def _falls_back(self, touch: ContactsAtState, now: Decided, decided: Decided) -> set[int]:
        """Contacts that open and fall again before their gaps exceed rounding: they count as closed throughout."""
        a, v, d = touch.accelerations(decided.closed, decided.forces)[0], touch.gap_rates, self.layout.d
        result = set()
        for n, (c, before, mode) in enumerate(zip(self.contacts, now.modes, decided.modes, strict=True)):
            falls = c.gap is not None and before is mode is ContactMode.SEPARATED and a[d * n] < 0
            if falls and touch.numbers.gaps[n] - v[n] ** 2 / (2 * a[d * n]) <= ROUNDED * touch.numbers.gap_terms[n]:
                result.add(n)
        return result

    def _opens(self, touch: ContactsAtState, closed: set[int], thrown: set[int], modes: Modes) -> None:
        """Sets the `slack` of gaps that open although they are not positive: at rest, or `thrown`, after impacts, by what they are.

        Raises
        ------
        SimulationError
            if a contact has opened and fallen so often, with a doubled slack each time, that the slack exceeds what counts as closed
        """
        for n in closed | thrown:
            gap, mode = float(touch.numbers.gaps[n]), modes[n]
            if mode is ContactMode.SEPARATED and n in closed:  # with zero gap rate
                # the terms of a gap that is a single coordinate vanish when it is closed
                least, far = FLAT * self.atol, touch.velocity_terms[n * self.layout.d] * (self.span[1] - self.span[0])
                self.slack[n] = max(ROUNDED * touch.numbers.gap_terms[n], least) + 2 * abs(gap)
                if self.slack[n] > EQUAL * (touch.numbers.gap_terms[n] + far) + least:
                    raise SimulationError(
                        f"Expected a contact that stays closed or opens, got {self.contacts[n].name!r}, which opens and "
                        "closes without end. Give compliant parts a stiffness, or reduce the friction"
                    )
            # what event times leave counts as zero, or levels sink with each rebound
            elif mode is ContactMode.SEPARATED and -gap > self._resolution(touch, n):
                self.slack[n] = -gap

    def _closes(self, touch: ContactsAtState, n: int) -> bool:
        """Whether an open gap closes at the same instant."""
        approaches = touch.gap_rates[n] < -NOTHING * touch.velocity_terms[n * self.layout.d]
        return bool(approaches and self._touches(touch, n))

    def _touches(self, touch: ContactsAtState, n: int) -> bool:
        """Whether an open gap is zero up to the resolution of event times."""
        return bool(touch.numbers.gaps[n] + self.slack[n] <= self._resolution(touch, n))

    def _resolution(self, touch: ContactsAtState, n: int) -> float:
        """The gap of contact n that the resolution of event times leaves."""
        far = abs(touch.gap_rates[n]) * (self.span[1] - self.span[0])
        return float(SAME_TIME * (touch.numbers.gap_terms[n] + far))

    def _turned(self, touch: ContactsAtState, sliding: Array) -> float:
        """Fraction of its terms up to which a force counts as zero: rounding changes directions of slow slips, and so forces."""
        slow = [
            ROUNDED_TERMS * touch.slip_terms[n].max() / np.linalg.norm(touch.slips[n])
            for n in np.flatnonzero(sliding.any(axis=1))
        ]
        return float(max([NOTHING, *slow]))

    def _unpressed(
        self, touch: ContactsAtState, closed: set[int], sliding: Array, friction: Array, share: float
    ) -> set[int]:
        """Contacts with N = 0 up to a `share` of its terms: the normal forces of a body that lies flat vanish together."""
        order, d = sorted(closed), self.layout.d
        pressed = dict(zip(order, touch.choose(order, sliding, friction).forces[::d], strict=True))
        rows = {n: d * n for n in order if not self.contacts[n].sized and self.contacts[n].pressed_by is None}
        size = {n: touch.bias_terms[k] / touch.mobility[k, k] for n, k in rows.items()}
        return {n for n, most in size.items() if pressed[n] <= share * most}

    def _parts(self, touch: ContactsAtState, i: int, apart: Decided, share: float) -> bool:
        """Whether a gap does not close again if its contact is assumed open, up to a `share`: at N = 0 both modes agree."""
        if self.contacts[i].gap is None:
            return False
        a, terms = touch.accelerations(apart.closed, apart.forces)
        return bool(a[self.layout.d * i] >= -share * terms[self.layout.d * i])

    def _forces_at_most(self, now: Decided, t: float, x: Array) -> Array:
        """N and F of all contacts (k × d) where friction has reached its limit at some, which it may exceed by rounding."""
        closed = [n for n, m in enumerate(now.modes) if m is not ContactMode.SEPARATED]
        touch, d = self.touch(t, x), self.layout.d
        slides = {n for n in closed if now.modes[n].slips}
        sliding = self._still(touch, slides, now.directions)
        result = np.zeros((len(self.contacts), d))
        result[closed] = touch.choose(closed, sliding, touch.numbers.laws[:, 0] * (1 + SIX_DIGITS)).forces.reshape(
            -1, d
        )
        return result

    def _under_way(
        self, t: float, touch: ContactsAtState, x: Array, decided: Decided, begun: Sequence[int]
    ) -> tuple[Array, Decided] | None:
        """The state with the least slip of contacts that begin to slip at unchanged friction, μ_k = μ_s, and the modes with it.

        From zero the slip grows as t², as its initial acceleration is zero, and turns with the friction before, A (F − F₀) = s': it
        opposes F to first order in t, whatever A is. With a fixed direction, and so a fixed F, it might reverse. None if there is no
        such slip, because other contacts that stick prevent it.
        """
        begun = [n for n in begun if decided.modes[n].straight and len(self.contacts[n].slips) > 1]
        if not begun or stands(self.contacts, decided.modes):
            return None
        slips, modes = self.none.copy(), list(decided.modes)
        # magnitudes of the terms of accelerations, which are zero up to rounding
        pushed = touch.accelerations(decided.closed, decided.forces)[1].reshape(-1, self.layout.d)[:, 1:]
        for n in begun:
            rate = float(np.linalg.norm(pushed[n]))
            fastest = max(self.fastest[n], touch.slip_terms[n].max(), self._gained(rate))
            slips[n] = 2 * self._slowest(t, touch, n, fastest, rate) * decided.directions[n]
            modes[n] = modes[n].slipping(straight=False)
        closed = [n for n, m in enumerate(modes) if m is not ContactMode.SEPARATED]
        stuck = [n for n in closed if n in begun or not modes[n].slips]
        change = touch.held(closed, stuck, slips)
        came = (touch.velocity + touch.rows[:, : touch.width] @ change).reshape(-1, self.layout.d)[:, 1:]
        if np.abs(came - slips)[stuck].max() > SIX_DIGITS * np.abs(slips).max():
            return None
        after = x.copy()
        after[self.q : self.q + touch.width] += change
        return after, replace(decided, modes=tuple(modes), stiff=True)

    def _begins_to_slip(self, now: Decided, i: int, t: float, x: Array, friction: Array, sliding: Array) -> list[int]:
        """Sets `friction` and `sliding` of contact i, which begins to slip at its limit of friction, and of those that slip with it.

        In a stand these are the others at their limits, too: the body may turn about the rest. Returns the contacts whose friction
        does not drop, μ_k = μ_s.
        """
        forces, kinetic = self._forces_at_most(now, t, x), self.touch(t, x).numbers.laws[:, 1]
        stand = next((s.members for s in stands(self.contacts, now.modes) if i in s.members), ())
        left = friction * forces[:, 0] * (1 - SIX_DIGITS) - np.linalg.norm(forces[:, 1:], axis=1)
        together = [i, *(n for n in stand if n != i and not now.modes[n].slips and left[n] <= 0)]
        if not stand:
            together = [self.contacts.index(c) for c in groups(self.contacts, now.modes)[i]]
        static, friction[together] = friction[together], kinetic[together]
        if friction[i] >= static[0] * (1 - ENDS):
            also = [n for n, most in zip(together, static, strict=True) if friction[n] >= most * (1 - ENDS)]
            sliding[also] = _against(forces[also, 1:])
            return also
        return []

    def ends(self, event: Event) -> tuple[int, str] | None:
        """The contact whose mode an event ends, and the kind of the event; None for other events."""
        return end_of(self.contacts, event)


def _slip_directions(touch: ContactsAtState, now: Decided) -> Array:
    """Directions of slip at an instant (k × d − 1): of v, or the fixed directions of straight slip."""
    sizes = np.linalg.norm(touch.slips, axis=1, keepdims=True)
    turns = np.array([[m.slips and not m.straight] for m in now.modes]) & (sizes > 0)
    return np.where(turns, touch.slips / np.where(sizes > 0, sizes, 1.0), now.directions)


def _against(forces: Array) -> Array:
    """Unit vectors (k × d − 1) opposite to forces; arbitrary for zero forces."""
    sizes, any_ = np.linalg.norm(forces, axis=1, keepdims=True), np.eye(forces.shape[1])[0]
    return np.asarray(np.where(sizes > 0, -forces / np.where(sizes > 0, sizes, 1.0), any_))


def _mode(mode: ContactMode, slides: Array) -> ContactStatus:
    if mode is ContactMode.SEPARATED:
        return ContactStatus.OPEN
    return ContactStatus.SLIP if np.any(slides) else ContactStatus.STICK


def _modes_text(contacts: Sequence[Any], order: Sequence[int], modes: Sequence[ContactStatus]) -> str:
    words = {
        ContactStatus.OPEN: "separates",
        ContactStatus.STICK: "sticks",
        ContactStatus.FRESH_SLIP: "slips",
        ContactStatus.SLIP: "slips",
    }
    return ", ".join(f"{contacts[i].name} {words[m]}" for i, m in zip(order, modes, strict=True))


def run_over_time(eom: Equations) -> Callable[..., Solution]:
    """The function that runs motions of the equations: `run_with_contacts` if the modes of contacts change, else `run`."""
    return run_with_contacts if eom.system.modes_change else run


def run_with_contacts(
    eom: Equations,
    span: tuple[float, float],
    begin: Begin,
    given: tuple[Mapping[Expr, float], Mapping[Expr, Any]],
    options: Mapping[str, Any],
    bounds: Mapping[str, Any],
    times: Array,
) -> Solution:
    """A motion with contacts, mode by mode, with parameters and inputs `given`; see `kane.motion.loop.run`."""
    at = ContactMotion(eom, span, given, options)
    p = np.array([given[0][s] for s in eom.parameters])
    stepper = Stepper(eom, p, tuple(given[1].values()), options["settings"])
    x = admitted_start(stepper, begin, given[0], span[0])[:-1]
    way = _ContactCourse(at, span, (options, bounds, times), (span[0], x, begin.work), begin.fresh)
    try:
        with collecting_seldom(), in_time(way.late):  # each mode keeps a few objects
            return _to_its_end(way, eom, given)
    finally:
        way.ends()


def _to_its_end(
    way: _ContactCourse, eom: Equations, given: tuple[Mapping[Expr, float], Mapping[Expr, Any]]
) -> Solution:
    """The motion to its end; "stopped" if an error or an interrupt occurs after its first piece."""
    at, end = way.at, way.span[1]
    way.begins()

    def ended(**told: Any) -> Solution:
        return replace(whole(way.pieces), equations=eom, parameters=given[0], inputs=given[1], **told)

    while True:
        try:
            event = way.goes()
            if event is None or at.ends(event) is None:
                return ended()
            way.follows(event)
        except KaneError as error:
            if not way.pieces:
                raise
            by = next((e for e in (way.pieces[-1].event, *way.by) if e is not None), None)
            last = f" after {by.name!r}" if by else ""
            told = f"the motion cannot continue{last} at t = {float(way.pieces[-1].t[-1]):.9g}: {error}"
            return ended(status="stopped", event=None, message=told)
        except Interrupted:  # before the first step of a mode
            if not way.pieces:
                raise
            return ended(status="stopped", event=None, message=way.pace.why(float(way.pieces[-1].t[-1])))
        if way.t >= end:
            return ended(status="finished", event=None, message=f"reached t = {end:g}")
        if late := way.late():
            return ended(status="stopped", event=None, message=late)


class _ContactCourse:
    """A motion in progress: completed `pieces`, t, x and work, the events `by` which its mode began, and the automaton's kernel."""

    def __init__(
        self,
        at: ContactMotion,
        span: tuple[float, float],
        solver_: tuple[Mapping[str, Any], Mapping[str, Any], Array],
        start: tuple[float, Array, float],
        fresh: Mapping[str, float],
    ) -> None:
        self.at, self.span, self.fresh = at, span, fresh
        self.options, self.bounds, self.times = solver_
        self.t, self.x, self.work = start
        self.pieces, self.by, self.still, self.count, self.steps = list[Solution](), tuple[Event, ...](), 0, 0, 0
        self.method = solver(self.options, self.bounds)
        self.pace = Pace(span, self.method.max_seconds, self.method.bounded)
        self.free = list[ContactRunner]()
        self.runner = self._runner()
        self.went: Went | None = None

    def _runner(self) -> ContactRunner:
        """The kernel of the automaton.

        `ContactRunner.place` leaves single modes to Python, `unsure` of `kane.motion.hybrid.contact_decisions` single decisions.
        """
        at = self.at
        warn_of_jumps(at.inputs.values(), self.span, self.method.breakpoints)
        given = dict(at.parameters), at.inputs
        result, self.free = runner(at.eom, self.method, self.span, given, self.options["settings"], self.times)
        for name in KNOWN:  # shared with the kernel from now on
            own = result.arrays[name]
            own[:] = getattr(at, name)
            setattr(at, name, own)
        result.late = self.late
        return result

    def begins(self) -> None:
        """Decides the modes at the start, in the kernel if it can."""
        at, start = self.at, (self.t, self.x, self.work)
        try:
            self.went = None if self.fresh else self.runner.start(start, self._first)
            if self.went is None:
                self.runner.check()
        except Interrupted:  # before the first step; of a limit of time Python makes a motion that ends at its start
            if is_noted() or not self.late():
                raise
        if self.went is None:
            self.x, self.now = at.begin(self.t, self.x)
            self.before = self.now.modes

    def _first(self) -> tuple[Modes, Equations]:
        """The modes in which the motion begins, and their equations."""
        x, now = self.at.begin(self.t, self.x)
        return now.modes, self.at.mode(now.modes, self.at.constants(now, self.t, x), x)

    def late(self) -> str:
        """A message if the limit of elapsed time is exceeded, else ""."""
        return self.pace.late(self.t)

    def ends(self) -> None:
        """Releases the kernel for other motions."""
        self.free.append(self.runner)

    def goes(self) -> Event | None:
        """Runs to the next event that the kernel does not decide; None at the end of the motion."""
        went, self.went = self.went, None
        if went is not None:
            return self._led(went)
        at = self.at
        numbers: Mapping[Expr, float] = at.constants(self.now, self.t, self.x)
        mode = at.mode(self.now.modes, numbers, self.x)
        first, self.fresh = self.fresh, {}
        leaves = {**first, **at.leaves(self.now, self.before, self.t, self.x, self.by)}
        opens = any(own and own[1] == "opens" for own in map(at.ends, [e for e in mode.events if e.name in leaves]))
        led = not (first or opens or self.now.stiff or self.late())
        if led and self.runner.parameters == at.parameters:
            m = self.runner.place(self.now.modes, mode)
            if m is not None:
                upward = {own[0] for own in map(at.ends, [e for e in mode.events if e.name in leaves]) if own}
                went = self.runner.go(
                    m,
                    (self.t, self.x, self.work),
                    self.now.directions,
                    numbers,
                    sorted(upward),
                    self.by,
                    (self.still, self.steps),
                )
                if went is not None:
                    return self._led(went)
        return self._by_python(mode, numbers, leaves)

    def _by_python(self, mode: Equations, numbers: Mapping[Expr, float], leaves: dict[str, float]) -> Event | None:
        """Runs one mode in Python; the event that ends it, if any."""
        self.runner.check()
        at = self.at
        q, u, a = np.split(self.x, np.cumsum([at.q, len(at.eom.speeds)]))
        drives: dict[Expr, Any] = {s: at.inputs[s] for s in mode.inputs}
        bounds = {**self.bounds, "begun": self.pace.begun}
        if self.pieces:
            bounds["first_step"] = at.flight(self.now, self.t, self.x, leaves)
        start = Begin(q, u, None, a, self.work, leaves, True, True, rounded=ROUNDED_TERMS, steps=self.steps)
        with warnings.catch_warnings():  # due to forces that are zero throughout, which are treated here
            warnings.filterwarnings("ignore", "Expected a start beside the threshold", KaneWarning)
            warnings.filterwarnings("ignore", "Expected a quantity of the event '.* opens' that crosses", KaneWarning)
            try:
                piece = run(mode, (self.t, self.span[1]), start, (numbers, drives), self.options, bounds, self.times)
            except ThresholdReturn as back:
                if not self._never_begun(back.event):
                    raise
                return self._sticks_on()
        at.balanced(self.now, numbers, float(piece.t[-1]), piece.states[-1])
        self._take(_of_mode(piece, mode, self.t, self.by))
        if len(piece.segments) < 2:
            self.runner.admit()
        if piece.event is not None:
            at.goes_on(piece)
            t = float(piece.t[-1])
            self._arrives(t, piece.states[-1], float(piece.work[-1]), self.still + 1 if t <= self.t else 0)
        return piece.event

    def _never_begun(self, event: Event) -> bool:
        """Whether an event ends a slip in the plane that returns to zero at once, as friction barely reached its limit."""
        ended, began = self.at.ends(event), {own[1] for own in map(self.at.ends, self.by) if own}
        if ended is None or ended[1] != "sticks" or "slips" not in began:
            return False
        return len(self.at.contacts[ended[0]].slips) == 1 and not self._mode_before().system.modes[ended[0]].slips

    def _mode_before(self) -> Equations:
        """The equations of the previous mode."""
        return self.pieces[-1].segments[-1].equations

    def _sticks_on(self) -> Event | None:
        """Runs on in the mode before a slip that did not begin: friction is beyond its limit and is expected to return below it."""
        before = self._mode_before()
        self.now = Decided(before.system.modes, self.now.directions)
        numbers = self.at.constants(self.now, self.t, self.x)
        return self._by_python(before, numbers, dict.fromkeys((e.name for e in self.by), 0.0))

    def _take(self, piece: Solution) -> None:
        self.pieces.append(piece)
        self.count += len(piece.phases)
        self.steps += piece.steps

    def _arrives(self, t: float, x: Array, work: float, still: int) -> None:
        self.t, self.x, self.work, self.still = t, x, work, still
        self.at.brief = still > 0

    def _led(self, went: Went) -> Event | None:
        """The event at which the kernel returned and Python decides, or the one that ends the mode left to Python."""
        at = self.at
        if went.motion is not None:
            self._take(went.motion)
        self.now = Decided(went.modes, went.directions)
        if went.back is Back.TAKE and went.t < self.span[1]:
            self.t, self.x, self.work, self.by, self.still = went.t, went.x, went.work, went.by, went.still
            return self._by_python(
                at.modes_of.equations(went.modes), {**at.parameters, **went.numbers}, dict(went.leaves)
            )
        self._arrives(went.t, went.x, went.work, went.still)
        if late := went.back in (Back.FULL, Back.UNKNOWN) and self.pace.late(went.t):
            self.pieces[-1] = replace(self.pieces[-1], status="stopped", event=None, message=late)
            return None
        met = [] if went.event is None else [(went.event, went.t)]
        end = ended_by([e for e, _ in met], met, acted=True) or End("finished", f"reached t = {self.span[1]:g}")
        self.pieces[-1] = replace(self.pieces[-1], status=end.status, event=end.event, message=end.message)
        if went.event is None:
            self.runner.check()
        return went.event

    def follows(self, event: Event) -> None:
        """Sets the state and the modes after an event; SimulationError if too many modes follow at one instant."""
        self.runner.check()
        at, t = self.at, self.t
        if self.still > AT_ONCE or self.count > _MODES:
            raise SimulationError(
                f"Expected a mode of the contacts that lasts, got {self.still or self.count} changes up to t = {t:.9g}, the "
                f"last by the event {event.name!r}. Give a restitution below 1, or end the motion earlier."
            )
        self.before = self.now.modes
        self.x, self.now, over = at.after(t, self.x, self.now, event)
        if t < over <= self.span[1]:
            self.pieces[-1] = replace(self.pieces[-1], events=(*self.pieces[-1].events, (rests(event), over)))
        self.by = (event,)


def _of_mode(piece: Solution, mode: Equations, t: float, by: tuple[Event, ...]) -> Solution:
    """A piece of a motion with its equations and the events that began it."""
    first = replace(piece.phases[0], by=by or piece.phases[0].by)
    return replace(
        piece,
        segments=piece.segments or (SolutionSegment(t, mode),),
        samples=piece.samples or (mode,) * len(piece.t),
        phases=(first, *piece.phases[1:]),
    )
