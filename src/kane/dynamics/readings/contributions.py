# SPDX-License-Identifier: BSD-3-Clause
"""Where a generalized force comes from: each force with the partial velocity it meets, each body, and what contributes nothing.

    F_r = Σ v_r·F + Σ ω_r·T,   F*_r = Σ v_r·(−m a) + Σ ω_r·(−I·α − ω × I·ω),   M_rs = Σ m v_r·v_s + ω_r·I·ω_s

Forces that enter no F_r are the noncontributing ones (Kane & Levinson 1985, sec. 4.5), each with its reason; under motion constraints
generalized forces are the nonholonomic ones. With them the inertia force and torque of each body, R* = −m a, T* = −(I·α + ω × I·ω)
(sec. 4.11).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from kane.dynamics.assembly import Term, met_by
from kane.dynamics.derivation import Derived
from kane.dynamics.solved import Solved
from kane.errors import Attributes, SpeedsError, none_of
from kane.expr.build import add, mul, sum_of
from kane.expr.node import ZERO, Expr, postorder
from kane.expr.piecewise import Piecewise
from kane.expr.regular import Sizes, size
from kane.expr.symbols import Reaction
from kane.kinematics.matching import Sample
from kane.model.bodies import Body
from kane.model.force_systems import ForceSystem
from kane.model.loads import Load
from kane.model.reactions import Cut, constraint_of, cut_of
from kane.numeric.sampling import SEEDS
from kane.numeric.scale import ROUNDED_SUM
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector

Source = TypeVar("Source", Load, Body)

_SWITCHES = {"where", "less", "max", "min", "abs", "sign"}


@dataclass(frozen=True, slots=True, eq=False)
class Contribution:
    """One term of a generalized force: `partial`·`vector` = `term`.

    `source` is the load, reaction or body that `vector` comes from: a force at a point, or a torque on a frame; of a body
    −m a at its mass centre, or −I·α − ω × I·ω on its frame.
    """

    source: Load | Reaction | Body
    place: Point | Frame
    vector: Vector
    partial: Vector
    term: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Contributions:
    """The terms of F_r and of F*_r for one speed, and the loads and bodies that have none."""

    speed: Expr
    active: tuple[Contribution, ...]
    inertia: tuple[Contribution, ...]
    noncontributing_loads: tuple[Load, ...]
    noncontributing_bodies: tuple[Body, ...]


@dataclass(frozen=True, slots=True, eq=False)
class MassContribution:
    """What one body adds to M_rs: `translation` m v_r·v_s and `rotation` ω_r·I·ω_s."""

    body: Body
    translation: Expr
    rotation: Expr


def contributions(derived: Derived, speed: Expr | str) -> Contributions:
    """See Equations.contributions."""
    speed = _own(derived, speed)
    active, idle_loads = _contributing(derived, derived.active_terms, speed)
    pairs = [_of_pair(derived, speed, r) for r in derived.reactions if (speed, r) in derived.pairs]
    inertia, idle_bodies = _contributing(derived, derived.inertia_terms, speed)
    return Contributions(speed, (*active, *(p for p in pairs if p.term is not ZERO)), inertia, idle_loads, idle_bodies)


def mass_contributions(derived: Derived, r: Expr | str, s: Expr | str) -> tuple[MassContribution, ...]:
    """See Equations.mass_contributions."""
    r, s = _own(derived, r), _own(derived, s)
    shares = dict.fromkeys(derived.system.bodies, (ZERO, ZERO))
    for b in derived.bodies:
        body, center, rotation = b.body, b.center, b.rotation
        translated, rotated = shares[body]
        for motion, mass in b.momenta:
            if r in center.partials and s in motion.partials:
                translated = add(translated, mul(mass, center.partials[r].dot(motion.partials[s])))
        turns = {} if rotation is None else rotation.motion.partials
        if rotation is not None and r in turns and s in turns:
            rotated = add(rotated, turns[r].dot(rotation.inertia.times(turns[s])))
        shares[body] = translated, rotated
    return tuple(MassContribution(b, *share) for b, share in shares.items() if not vanish(share, derived))


def _own(derived: Derived, speed: Expr | str) -> Expr:
    """The speed of the system that a symbol or name means."""
    if speed not in derived.all_speeds:
        raise SpeedsError(f"Expected a speed of the system, one of {none_of(derived.all_speeds, speed)}")
    return derived.all_speeds[derived.all_speeds.index(speed)]


def _of_pair(derived: Derived, speed: Expr, reaction: Reaction) -> Contribution:
    """The pair ±R n: only its far side, which the auxiliary speed moves, has a partial velocity."""
    here, there, held = cut_of(speed), cut_of(reaction), constraint_of(reaction)
    term = derived.pairs[speed, reaction] * reaction
    if held is not None:  # its auxiliary speed lets the constraint give way, at a place if it has any
        places: tuple[tuple[Point | Frame, Vector], ...] = (*held.forces, *held.torques)
        place, direction = places[0] if places else (derived.system.inertial, Vector())
        return Contribution(reaction, place, direction * reaction, direction, term)
    assert isinstance(here, Cut)
    assert isinstance(there, Cut)
    return Contribution(reaction, there.at, there.along * reaction, here.along, term)


def _contributing(
    derived: Derived, table: Mapping[Source, Sequence[Term]], speed: Expr
) -> tuple[tuple[Contribution, ...], tuple[Source, ...]]:
    """The terms that do not vanish; the sources whose terms all vanish, one by one or together."""
    kept: list[Contribution] = []
    idle: list[Source] = []
    for source, terms in table.items():
        products = [Contribution(source, t.place, t.vector, v, v.dot(t.vector)) for t, v in met_by(terms, speed)]
        if vanish([sum_of(c.term for c in products)], derived):
            idle.append(source)
        else:
            kept += [c for c in products if not vanish([c.term], derived)]
    return tuple(kept), tuple(idle)


def vanish(exprs: Sequence[Expr], derived: Derived) -> bool:
    """Whether all are zero: as they stand, or beside their terms at states drawn at random unless they switch."""
    left = [e for e in exprs if e is not ZERO]
    if not left:
        return True
    if any(node.op.name in _SWITCHES or isinstance(node.op, Piecewise) for node in postorder(left)):
        return False
    memo = Sizes()
    both = [*left, *(size(e, memo) for e in left)]

    def zero(seed: int) -> bool:
        numbers = np.array(np.broadcast_arrays(*Sample(derived.kinematical, seed).numbers(both)), dtype=float)
        values, sizes = np.split(numbers, 2)
        return bool((np.abs(values) <= ROUNDED_SUM * np.abs(sizes)).all())  # NaN is not zero

    return all(map(zero, SEEDS))


@dataclass(frozen=True, slots=True, eq=False)
class Noncontributing(Attributes):
    """A load that is in no generalized active force, and why."""

    load: Load
    reason: str

    def __repr__(self) -> str:
        return f"{self.load.name}: {self.reason}"


def noncontributing(solved: Solved) -> tuple[Noncontributing, ...]:
    """See Equations.noncontributing."""
    derived, speeds = _in_independent_speeds(solved), solved.independent_speeds
    found = []
    for load, terms in derived.active_terms.items():
        reason = _reason(derived, terms, speeds)
        if reason:
            found.append(Noncontributing(load, reason))
    return tuple(found)


def _in_independent_speeds(solved: Solved) -> Derived:
    """The motions in the independent speeds, with all loads: also those along what constraints hold."""
    shown, e = solved.derived.as_declared, solved.embedding
    if e is None:
        return shown
    return replace(shown, kinematics=shown.kinematics.with_following(e.following(solved.derived.speeds), {}))


def _reason(derived: Derived, terms: Sequence[Term], speeds: Sequence[Expr]) -> str:
    """Why F_r is zero for every speed, "" where it is not."""
    shares = [[_share(term, u) for u in speeds] for term in terms]
    if not vanish([sum_of(column) for column in zip(*shares, strict=True)], derived):
        return ""
    places = ", ".join(dict.fromkeys(term.place.name for term in terms))
    moving = [term for term in terms if any(not v.is_zero for u, v in term.motion.partials.items() if u in set(speeds))]
    if not moving:
        return f"no speed moves {places}: all partial velocities there are zero"
    if vanish([x for row in shares for x in row], derived):
        return f"perpendicular to the partial velocities of {places}"
    return f"what is contributed at {places} adds up to zero: action and reaction, where nothing moves along them"


def _share(term: Term, speed: Expr) -> Expr:
    partial = term.motion.partials.get(speed)
    return ZERO if partial is None else partial.dot(term.vector)


def inertia_forces(derived: Derived, body: Body) -> ForceSystem:
    """See Equations.inertia_forces."""
    terms = derived.inertia_terms[body]
    return ForceSystem(
        tuple((t.place, t.vector) for t in terms if isinstance(t.place, Point)),
        tuple(t.vector for t in terms if isinstance(t.place, Frame)),
    )
