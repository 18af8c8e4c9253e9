# SPDX-License-Identifier: BSD-3-Clause
"""Where a generalized force comes from: each force with the partial velocity it meets, each body, and what contributes nothing.

    F_r = Σ v_r·F + Σ ω_r·T,   F*_r = Σ v_r·(−m a) + Σ ω_r·(−I·α − ω × I·ω),   M_rs = Σ m v_r·v_s + ω_r·I·ω_s

Forces that enter no F_r are the noncontributing ones (Kane & Levinson 1985, sec. 4.5); they are named, not listed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kane.dynamics.readings.forces import Term, active_terms, inertia_terms
from kane.errors import SpeedsError
from kane.expr.build import add, mul
from kane.expr.node import ZERO, Expr, postorder
from kane.expr.symbols import Reaction
from kane.kinematics.sample import Sample
from kane.model.bodies import Body
from kane.model.loads import Load
from kane.model.reactions import Cut, constraint_of, cut_of
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector

if TYPE_CHECKING:
    from kane.equations.equations import Equations

_SEED = 20045
_SLACK = 1e-11
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


def contributions(eom: Equations, speed: Expr) -> Contributions:
    """See Equations.contributions."""
    _check(eom, speed)
    active, idle_loads = _contributing(
        [(load, _of(load, active_terms(eom.kinematics, speed, load))) for load in eom.loads], eom
    )
    pairs = [_of_pair(eom, speed, r) for r in eom.reactions if (speed, r) in eom.pairs]
    inertia, idle_bodies = _contributing([(b.body, _of(b.body, inertia_terms(b, speed))) for b in eom.bodies], eom)
    return Contributions(
        speed,
        (*active, *(p for p in pairs if p.term is not ZERO)),
        inertia,
        tuple(x for x in idle_loads if isinstance(x, Load)),
        tuple(x for x in idle_bodies if not isinstance(x, Load | Reaction)),
    )


def mass_contributions(eom: Equations, r: Expr, s: Expr) -> tuple[MassContribution, ...]:
    """See Equations.mass_contributions."""
    _check(eom, r)
    _check(eom, s)
    found = []
    for b in eom.bodies:
        translation, rotation = ZERO, ZERO
        if r in b.center.partials and s in b.center.partials:
            translation = mul(b.body.mass, b.center.partials[r].dot(b.center.partials[s]))
        if b.rotation is not None and b.inertia is not None:
            turns = b.rotation.partials
            if r in turns and s in turns:
                rotation = turns[r].dot(b.inertia.times(turns[s]))
        if not _vanish([translation, rotation], eom):
            found.append(MassContribution(b.body, translation, rotation))
    return tuple(found)


def _check(eom: Equations, speed: Expr) -> None:
    if speed not in set(eom.all_speeds):
        known = ", ".join(map(str, eom.all_speeds))
        raise SpeedsError(f"Expected one of the speeds of the system ({known}), got {speed!r:.60}.")


def _of_pair(eom: Equations, speed: Expr, reaction: Reaction) -> Contribution:
    """The pair ±R n: only its far side, which the auxiliary speed moves, has a partial velocity."""
    here, there, held = cut_of(speed), cut_of(reaction), constraint_of(reaction)
    if held is not None:  # its auxiliary speed lets the constraint give way, at a place if it has any
        places: tuple[tuple[Point | Frame, Vector], ...] = (*held.forces, *held.torques)
        place, direction = places[0] if places else (eom.system.inertial, Vector())
        return Contribution(reaction, place, direction * reaction, direction, eom.pairs[speed, reaction] * reaction)
    assert isinstance(here, Cut)
    assert isinstance(there, Cut)
    return Contribution(reaction, there.at, there.along * reaction, here.along, eom.pairs[speed, reaction] * reaction)


def _of(source: Load | Body, terms: Iterable[Term]) -> list[Contribution]:
    return [Contribution(source, place, x, partial, partial.dot(x)) for place, x, partial in terms]


def _contributing(
    groups: Iterable[tuple[Load | Body, Sequence[Contribution]]], eom: Equations
) -> tuple[tuple[Contribution, ...], list[Load | Body]]:
    """The terms that do not vanish; the sources whose terms all vanish, one by one or together."""
    kept: list[Contribution] = []
    idle: list[Load | Body] = []
    for source, terms in groups:
        total = ZERO
        for c in terms:
            total = add(total, c.term)
        if _vanish([total], eom):
            idle.append(source)
        else:
            kept += [c for c in terms if not _vanish([c.term], eom)]
    return tuple(kept), idle


def _vanish(exprs: Sequence[Expr], eom: Equations) -> bool:
    """Whether all are zero: as they stand, or at a state drawn at random unless they switch from branch to branch."""
    left = [e for e in exprs if e is not ZERO]
    if not left:
        return True
    if any(node.op.name in _SWITCHES for node in postorder(left)):
        return False
    sample = Sample(eom.kinematical, _SEED)
    return bool(np.abs(np.array(sample.numbers(left), dtype=float)).max() < _SLACK)  # NaN is not zero
