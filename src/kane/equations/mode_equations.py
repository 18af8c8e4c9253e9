# SPDX-License-Identifier: BSD-3-Clause
"""The equations of the modes of a system's contacts, derived when first needed, and the matrices by which modes are chosen.

With the rows J w + … of all contacts, in the speeds w = (u, u_a), which include the auxiliary speeds of normal reactions,

    M ẇ = f + Jᵀ λ + Pᵀ μ,    P ẇ + ṗ = 0            P the constraints that always hold
    a = W λ + b               W = J H Jᵀ,  H = M⁻¹ − M⁻¹Pᵀ (P M⁻¹ Pᵀ)⁺ P M⁻¹

which `kane.contacts` solves for the modes. A contact whose normal force is not the multiplier of a row of J has N = size, μ = 1. If
the size depends on the N of another contact, the problems are solved repeatedly until they agree.
"""

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from kane.contacts import ContactProblem, ContactStatus, ModeChoice, choose, contact_problem
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived, derived
from kane.dynamics.forcing import mass_rows
from kane.equations.compiled import ports
from kane.equations.equations import Equations, derive, repartition
from kane.errors import KaneWarning, ModelError, SimulationError
from kane.expr.build import mul
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr, constant
from kane.expr.regular import Sizes, largest, size
from kane.model.contacts import ContactLaw, ContactMode, Modes
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.numeric.scale import GIVEN, MOTION_RANK, ROUNDED, ROUNDED_SUM, ROUNDED_TERMS
from kane.program.from_expressions import Bundle

_ROUNDS = 100
"""Choices of modes until normal forces and the couples that follow from them agree."""


class ContactNumbers(NamedTuple):
    """Gaps and the sizes of their terms (k); M, f and its terms; rows of all constraints in w, and the rest of their derivatives.

    `laws` are μ_s, μ_k and e of each contact (k × 3), `viscous` c (k).
    """

    gaps: Array
    gap_terms: Array
    mass: Array
    forcing: Array
    forcing_terms: Array
    rows: Array
    rest: Array
    drift: Array
    drift_terms: Array
    laws: Array
    viscous: Array


def in_touch(system: System) -> System:
    """The system with the rows of all contacts as constraints; it is derived but not solved."""
    gaps = [c.gap for c in system.contacts if c.gap is not None]
    slips = [v for c in system.contacts for v in c.slips]
    pressing = [
        n for c in system.contacts if c.gap is None and c.pressed_by is None and (n := c.normal_force) is not None
    ]
    return system.quietly(
        events=(),
        holonomic=(*system.holonomic, *gaps),
        nonholonomic=(*system.nonholonomic, *slips),
        reactions=tuple(dict.fromkeys((*system.reactions, *pressing))),
    )


def touching(eom: Equations) -> Derived:
    """The derived system with the rows of all contacts."""
    d = derived(in_touch(eom.system), eom.derived.near)
    if any(x is not ZERO for x in d.blocks.coupling.entries):
        raise ModelError(
            "Expected loads without reactions in a system with contacts, whose modes depend on the reactions, got one that contains a "
            "reaction. Declare friction as a contact: kn.contact(…), kn.joints.stiction(…)."
        )
    return d


def contact_numbers(eom: Equations) -> Bundle[ContactNumbers]:
    """The bundle of expressions whose values the choice of modes needs."""
    d, contacts, memo = eom.numeric().value(touching), eom.system.contacts, Sizes()
    blocks, rows = d.blocks, d.constraints
    gaps = [ZERO if c.gap is None else c.gap.expr for c in contacts]
    laws = [eom.in_speeds(x) for c in contacts for x in c.numbers]
    forcing = [*blocks.forcing, *blocks.forcing_a]
    groups = {
        "gaps": gaps,
        "gap_terms": [_gap_size(x, memo) for x in gaps],
        "mass": Matrix(mass_rows(d.bodies, d.all_speeds, ())),
        "forcing": forcing,
        "forcing_terms": [size(x, memo) for x in forcing],
        "rows": Matrix([[*a, *b] for a, b in zip(rows.a.rows, rows.a_auxiliary.rows, strict=True)]),
        "rest": list(rows.b),
        "drift": list(rows.drift),
        "drift_terms": [size(x, memo) for x in rows.drift],
        "laws": Matrix([laws[i : i + 3] for i in range(0, len(laws), 3)]),
        "viscous": [eom.in_speeds(c.viscous) for c in contacts],
    }
    return Bundle("contacts", ports(eom.derived), ContactNumbers, groups)


def _gap_size(gap: Expr, memo: Sizes) -> Expr:
    """The size of a gap; what rounding of the time leaves of it counts once, not as that of its terms, which add up."""
    own, late = size(gap, memo), size(gap, {}, late=True)
    return own if late is own else largest([own, mul(constant(ROUNDED_TERMS / ROUNDED), late)])


@dataclass(frozen=True, slots=True, eq=False)
class ContactRows:
    """The layout of contact rows: `d` rows per contact, its normal first, each a constraint row or −1 − (auxiliary speed).

    `places` (k × d) is None for rows that a contact does not have; `always` are the constraint rows that hold in every mode.
    `pressed_by` is the contact whose normal force stands in the place of the contact's own, or None.
    """

    contacts: tuple[ContactLaw, ...]
    d: int
    places: tuple[tuple[int | None, ...], ...]
    always: tuple[int, ...]
    pressed_by: tuple[int | None, ...]

    def together(self, closed: Iterable[int]) -> set[int]:
        """The closed contacts, with those that are pressed by them."""
        own = {i for i in closed if self.pressed_by[i] is None}
        return own | {i for i, m in enumerate(self.pressed_by) if m in own}


def layout(eom: Equations) -> ContactRows:
    """The layout of the contacts of equations."""
    derived_ = eom.numeric().value(touching)
    row = {c: i for i, c in enumerate(derived_.constraints.constraints)}
    auxiliary = {r: -1 - k for k, r in enumerate(derived_.reactions)}
    contacts = eom.system.contacts
    d = 1 + max(1, *(len(c.slips) for c in contacts))
    places = []
    for c in contacts:
        given = c.normal_force is None or c.pressed_by is not None
        normal = row[c.gap] if c.gap is not None else None if given else auxiliary[c.normal_force]
        slips = [row[v] for v in c.slips]
        places.append((normal, *slips, *[None] * (d - 1 - len(slips))))
    taken = {p for own in places for p in own}
    every = (*range(len(row)), *auxiliary.values())
    pressed = tuple(None if c.pressed_by is None else contacts.index(c.pressed_by) for c in contacts)
    return ContactRows(contacts, d, tuple(places), tuple(p for p in every if p not in taken), pressed)


class ContactsAtState:
    """The contacts at an instant: W, b and v of all contact rows (kd), and the changes H Jᵀ p of speeds by impulses p."""

    def __init__(self, where: ContactRows, numbers: ContactNumbers, u: Array) -> None:
        self.layout, self.numbers, self.width = where, numbers, len(u)
        k, d, width = len(where.contacts), where.d, len(numbers.forcing)
        self.rows = np.zeros((k * d, width))
        velocity, velocity_terms = np.zeros(k * d), np.zeros(k * d)
        drift, drift_terms = np.zeros(k * d), np.zeros(k * d)
        w = np.append(u, np.zeros(width - len(u)))
        for i, place in enumerate(p for own in where.places for p in own):
            if place is None:
                continue
            self.rows[i] = self._row(place, width)
            velocity[i], velocity_terms[i] = self.rows[i] @ w, np.abs(self.rows[i]) @ np.abs(w)
            if place >= 0:
                velocity[i] += numbers.rest[place]
                velocity_terms[i] += abs(numbers.rest[place])
                drift[i], drift_terms[i] = numbers.drift[place], numbers.drift_terms[place]
        always = [self._row(place, width) for place in where.always]
        p = np.array(always).reshape(len(always), width)
        of_p = np.array([numbers.drift[place] if place >= 0 else 0.0 for place in where.always])
        inverse = np.linalg.inv(numbers.mass)
        self.spread, free = inverse @ self.rows.T, inverse @ numbers.forcing
        if len(p):
            moved = inverse @ p.T
            back = moved @ np.linalg.pinv(p @ moved, rcond=ROUNDED_SUM, hermitian=True)
            self.spread = self.spread - back @ (p @ self.spread)
            free = free - back @ (p @ free + of_p)
        self.mobility = self.rows @ self.spread
        self.mobility_terms = (np.abs(self.rows) @ np.abs(inverse) * np.abs(self.rows)).sum(axis=1)
        self.bias = self.rows @ free + drift
        self.bias_terms = np.abs(self.rows) @ (np.abs(inverse) @ numbers.forcing_terms) + drift_terms
        self.bias_terms = np.maximum(self.bias_terms, np.abs(self.bias))
        sizes = np.maximum(velocity_terms, np.abs(velocity)).reshape(k, d)
        sizes[:, 0] = sizes.max(axis=1)  # what rounding leaves of rows of gaps multiplies speeds, too
        self.velocity, self.velocity_terms = velocity, sizes.reshape(-1)
        self.drag = -np.repeat(numbers.viscous, d) * velocity
        self.drag[::d] = 0.0

    def _row(self, place: int, width: int) -> Array:
        if place >= 0:
            return np.asarray(self.numbers.rows[place])
        row = np.zeros(width)
        row[self.width + (-1 - place)] = 1.0
        return row

    @property
    def gap_rates(self) -> Array:
        """The velocities of all gaps (k)."""
        return self.velocity[:: self.layout.d]

    @property
    def slips(self) -> Array:
        """The velocities of slip (k × d − 1)."""
        return self.velocity.reshape(-1, self.layout.d)[:, 1:]

    @property
    def slip_terms(self) -> Array:
        """The sizes of the terms of slips (k × d − 1)."""
        return self.velocity_terms.reshape(-1, self.layout.d)[:, 1:]

    @property
    def slip_sums(self) -> Array:
        """How far slips change by a change of each speed by one, at most (k × d − 1)."""
        sums = np.abs(self.rows[:, : self.width]).sum(axis=1)
        return np.asarray(sums.reshape(-1, self.layout.d)[:, 1:])

    def problem(
        self,
        closed: Sequence[int],
        sliding: Array,
        friction: Array,
        velocities: bool = False,
        pressing: Mapping[int, float] = MappingProxyType({}),
    ) -> ContactProblem:
        """The contact problem of closed contacts; `sliding` (k × d − 1) are unit directions of slip, zero without slip.

        `friction` is μ_s of each contact (k), `pressing` the N of contacts that press others. With `velocities` v replaces b, for the
        problem of impulses.
        """
        d, laws, places = self.layout.d, self.numbers.laws, self.places(closed)
        self._check_normals(closed)
        w = self.mobility[np.ix_(places, places)]
        given, terms = (self.velocity, self.velocity_terms) if velocities else self.unforced(closed)
        b, size_ = given[places], terms[places]
        kinetic, slides = laws[list(closed), 1].copy(), np.any(sliding[list(closed)], axis=1)
        static = np.maximum(friction[list(closed)], np.where(slides, kinetic, 0.0))
        for n, i in enumerate(closed):
            usual = max(w[d * n + j, d * n + j] for j in range(d))
            for j, place in enumerate(self.layout.places[i]):
                if place is None:
                    w[d * n + j, d * n + j] = usual or 1.0
            if self.layout.places[i][0] is None:  # friction of a given size
                most = max(laws[i, 0], kinetic[n])
                b[d * n] = 0.0 if velocities else -(usual or 1.0) * most * pressing.get(i, 1.0)
                size_[d * n] = abs(b[d * n])
                static[n], kinetic[n] = (static[n] / most, kinetic[n] / most) if most > 0 else (0.0, 0.0)
        kinetic = np.minimum(kinetic, static)
        names = [self.layout.contacts[i].name for i in closed]
        return contact_problem(w, b, static, kinetic=kinetic, sliding=sliding[list(closed)], terms=size_, names=names)

    def _check_normals(self, closed: Sequence[int]) -> None:
        """Raises a SimulationError for contacts whose gaps no force can move, as constraints fix their bodies and N is arbitrary."""
        d = self.layout.d
        for i in closed:
            own = slice(d * i, d * i + d)
            w, terms = self.mobility[d * i, d * i], self.mobility_terms[own]
            if self.layout.places[i][0] is not None and w <= max(ROUNDED_SUM * terms[0], ROUNDED * terms.max()):
                raise SimulationError(
                    f"Expected a contact whose normal force accelerates its bodies, got {self.layout.contacts[i].name!r}, whose gap "
                    f"cannot change here to first order (W_nn = {w:.3g} beside terms of {terms.max():.3g}): other constraints fix it, "
                    "or the configuration is a dead centre. Leave the contact out, give its normal another direction, or start "
                    "elsewhere."
                )

    def choose(
        self, closed: Sequence[int], sliding: Array, friction: Array, before: Sequence[ContactStatus] | None = None
    ) -> ModeChoice:
        """The modes of closed contacts, `before` the present ones, with pressing forces that agree with the solution."""
        d, place = self.layout.d, {i: n for n, i in enumerate(closed)}
        by = {i: place[m] for i, m in enumerate(self.layout.pressed_by) if m in place and i in place}
        alone = [i for i in closed if i not in by]
        if not by:
            return choose(self.problem(closed, sliding, friction), before)
        known = before and [before[place[i]] for i in alone]
        first = choose(self.problem(alone, sliding, friction), known)
        pressing = {i: float(first.forces[d * alone.index(closed[m])]) for i, m in by.items()}
        for _ in range(_ROUNDS):
            choice = choose(self.problem(closed, sliding, friction, pressing=pressing), before)
            found = {i: max(float(choice.forces[d * m]), 0.0) for i, m in by.items()}
            if all(abs(n - pressing[i]) <= ROUNDED * n for i, n in found.items()):
                return choice
            pressing = found
        names = ", ".join(self.layout.contacts[i].name for i in by)
        raise SimulationError(
            f"Expected resisting couples of {names} consistent with the normal forces, which they affect, got none in "
            f"{_ROUNDS} iterations."
        )

    def held(self, closed: Sequence[int], stuck: Sequence[int], slips: Array | None = None) -> Array:
        """The least Δu for zero gap rates of closed contacts, and slips of stuck ones that are zero or `slips` (k × d − 1)."""
        d = self.layout.d
        rows = [d * i for i in closed] + [d * i + j for i in stuck for j in range(1, d)]
        w, missing = self.mobility[np.ix_(rows, rows)], -self.velocity[rows]
        if slips is not None:
            missing[len(closed) :] += slips[list(stuck)].ravel()
        return self.change(rows, np.linalg.pinv(w, rcond=ROUNDED_SUM, hermitian=True) @ missing)

    def change(self, rows: Sequence[int], impulses: Array) -> Array:
        """Δu due to impulses along contact rows."""
        return np.asarray(self.spread[: self.width, rows] @ impulses)

    def after(self, u: Array, rows: Sequence[int], impulses: Array) -> Array:
        """The speeds u after impulses along contact rows; speeds that become zero up to rounding are exactly zero."""
        after = u + self.change(rows, impulses)
        terms = np.abs(u) + np.abs(self.spread[: self.width, rows]) @ np.abs(impulses)
        return np.where(np.abs(after) > ROUNDED_TERMS * terms, after, 0.0)

    def places(self, closed: Sequence[int]) -> list[int]:
        """The numbers of the rows of closed contacts."""
        return [self.layout.d * i + j for i in closed for j in range(self.layout.d)]

    def accelerations(self, closed: Sequence[int], forces: Array) -> tuple[Array, Array]:
        """a = W λ + b of all rows with forces of the closed contacts, and the sizes of its terms."""
        w, (bias, terms) = self.mobility[:, self.places(closed)], self.unforced(closed)
        return w @ forces + bias, np.abs(w) @ np.abs(forces) + terms

    def unforced(self, closed: Sequence[int]) -> tuple[Array, Array]:
        """b of all rows and the sizes of its terms, with the viscous friction of closed contacts."""
        places = self.places(closed)
        w, drag = self.mobility[:, places], self.drag[places]
        return self.bias + w @ drag, self.bias_terms + np.abs(w) @ np.abs(drag)


def held_together(touch: ContactsAtState, modes: Sequence[ContactMode], directions: Array) -> tuple[Modes, Array]:
    """The modes by the rows that hold what is closed and sticks; directions (k × d − 1) of slips, and of what others hold of one.

    Raises
    ------
    SimulationError
        if rows of contacts depend on each other otherwise than those of a body on a plane: rigid bodies do not tell their forces
    """
    d, found, ways, contacts = touch.layout.d, list(modes), directions.copy(), touch.layout.contacts
    closed = [i for i, m in enumerate(modes) if m is not ContactMode.SEPARATED]
    sticking = [i for i in closed if modes[i] is ContactMode.STICK and contacts[i].slips]
    scale = np.sqrt(np.maximum(np.diag(touch.mobility), 0.0))
    kept, weak = list[int](), list[int]()
    for i in (*sticking, *(i for i in closed if i not in sticking)):
        if touch.layout.places[i][0] is None:
            continue
        if _followed(touch, kept, [d * i], scale, MOTION_RANK):
            weak.append(i)  # last: a row that others almost hold holds these poorly
        else:
            kept.append(d * i)
    for i in weak:
        following = _followed(touch, kept, [d * i], scale)
        if following:
            _check_stands(touch, i, following)
            found[i] = modes[i].with_others()
        else:
            kept.append(d * i)
    leader = -1
    for i in sticking:
        own = [d * i + 1 + k for k in range(len(contacts[i].slips))]
        following = _followed(touch, kept, own, scale)
        if not following and not found[i].carried:
            kept += own
            leader = i
        elif len(following) < len(own):
            if found[i].carried:
                raise undetermined(contacts[i])
            _check_stands(touch, i, following)
            found[i], ways[i] = ContactMode.ACROSS, following[0].along
            kept.append(own[int(np.argmax(np.abs(ways[i][::-1])))])  # the row across is −d₂ v₁ + d₁ v₂
        elif not found[i].carried:
            rubs = leader < 0 or touch.numbers.laws[i, 0] > 0
            if rubs and not _by_one_row(following, [d * leader + 1 + k for k in range(len(own))]):
                _check_stands(touch, i, following)
            found[i] = ContactMode.HELD
    return tuple(found), ways


class _Follows(NamedTuple):
    """A slip velocity or gap rate that is a combination of other rows, with their coefficients."""

    along: Array
    shares: dict[int, float]


def _followed(
    touch: ContactsAtState, kept: Sequence[int], rows: Sequence[int], scale: Array, share: float = ROUNDED_SUM
) -> list[_Follows]:
    """The combinations of kept rows that a gap's rate or a contact's slips follow from but for a share; empty if independent."""
    if not kept or not scale[list(rows)].all():
        return []
    w = touch.mobility / np.where(scale > 0, scale, 1.0) / np.where(scale > 0, scale, 1.0)[:, None]
    by = np.linalg.solve(w[np.ix_(kept, kept)], w[np.ix_(kept, rows)])
    left, ways = np.linalg.eigh(w[np.ix_(rows, rows)] - w[np.ix_(rows, kept)] @ by)
    few = ways.T[left <= share]
    each = np.eye(len(rows)) if len(few) == len(rows) else few / scale[list(rows)]
    result = []
    for e in each / np.linalg.norm(each, axis=1, keepdims=True):
        real = by @ (e * scale[list(rows)]) / scale[list(kept)]
        result.append(_Follows(e, {k: float(x) for k, x in zip(kept, real, strict=True) if abs(x) > GIVEN}))
    return result


def _by_one_row(following: Sequence[_Follows], first: Sequence[int]) -> bool:
    """Whether slips are those of one preceding contact, whatever gaps do: else normal forces depend on what friction each has."""
    return all(
        set(shares) == {row} and abs(shares[row] - 1) <= GIVEN
        for (_, shares), row in zip(following, first, strict=True)
    )


def _check_stands(touch: ContactsAtState, i: int, following: Sequence[_Follows]) -> None:
    """Raises a SimulationError if rows depend on others otherwise than those of one body on one plane."""
    d, contacts = touch.layout.d, touch.layout.contacts
    others = {place // d for _, shares in following for place in shares} - {i}
    c = contacts[i]
    if not others:
        raise SimulationError(
            f"Expected a contact with uniquely determined normal force and friction, got {c.name!r}, which cannot slip without "
            "opening: friction may jam it, with forces that depend on compliance. Model that by a stiffness, or give the contact mu=0"
        )
    if c.between is None or any(contacts[n].between != c.between for n in others):
        raise undetermined(c, *(contacts[n] for n in sorted(others)))


def undetermined(*contacts: ContactLaw) -> SimulationError:
    """The error for contacts whose forces rigid bodies leave undetermined."""
    names = ", ".join(repr(c.name) for c in contacts)
    return SimulationError(
        f"Expected contacts with uniquely determined forces between rigid bodies, got {names}, whose conditions follow from those "
        "of other contacts. Leave one out, or model the compliance by a stiffness"
    )


class ContactModes:
    """The equations of the modes of a system's contacts, each derived when it is first needed."""

    def __init__(self, eom: Equations) -> None:
        self._system, self._near = eom.system, eom.derived.near
        self._made: dict[Modes, Equations] = {}

    def equations(self, modes: Modes, near: Mapping[Expr, float] | None = None) -> Equations:
        """The equations of a mode, with dependent speeds chosen at the values `near`."""
        if modes not in self._made:
            with warnings.catch_warnings():  # a motion is there, whatever defaults of parameters say
                warnings.filterwarnings("ignore", "Expected configuration constraints that some", KaneWarning)
                self._made[modes] = derive(
                    self._system.in_modes(modes), near={**(self._near or {}), **(near or {})} or None
                )
        return self._made[modes]


def equations_in(first: Equations, modes: Modes, partition: Partition | None) -> Equations:
    """The equations in given modes of the contacts of `first`, with the dependent speeds of a partition; without modes `first`'s."""
    eom = first.numeric().value(ContactModes).equations(modes) if modes else first
    present = eom.embedding and eom.embedding.partition
    return eom if partition in (None, present) else repartition(eom, partition)
