# SPDX-License-Identifier: BSD-3-Clause
"""The terms of generalized forces: each force or torque with its partial velocity, each body, and noncontributing forces.

    F_r = Σ v_r·F + Σ ω_r·T,   F*_r = Σ v_r·(−m a) + Σ ω_r·(−I·α − ω × I·ω),   M_rs = Σ m v_r·v_s + ω_r·I·ω_s

Forces in no F_r are noncontributing (Kane & Levinson 1985, sec. 4.5), each for a reason that is given; under motion constraints the
generalized forces are the nonholonomic ones. Each body has the inertia force R* = −m a and torque T* = −(I·α + ω × I·ω) (sec. 4.11).

The module also has generalized forces of the rates, Q_s = Σ F·∂v/∂q̇_s + Σ T·∂ω/∂q̇_s, with F_r = Σ_s Q_s W_sr for any speeds, rows C
of the constraints C q̇ + c = 0, and sample states at which both are evaluated.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from kane.dynamics.derivation import Derived
from kane.dynamics.forcing import LoadTerm, acting, generalized, terms_moved_by
from kane.dynamics.in_rates import InRates
from kane.dynamics.solved import Solved
from kane.errors import Attributes, SpeedsError, none_of
from kane.expr.build import add, mul, sum_of
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import ZERO, Expr, Exprs, postorder
from kane.expr.piecewise import Piecewise
from kane.expr.regular import Sizes, size
from kane.expr.symbols import Coordinate, Parameter, QuasiRate, Rate, Reaction, Speed, Symbol
from kane.kinematics.speeds import Sample
from kane.model.bodies import Body
from kane.model.constraints import Cut, constraint_of, cut_of
from kane.model.force_systems import ForceSystem
from kane.model.loads import Load
from kane.numeric.arrays import Array, Mask
from kane.numeric.sampling import SEED, SEEDS, draw
from kane.numeric.scale import ROUNDED_SUM, UNRELATED
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

Source = TypeVar("Source", Load, Body)

_SWITCHES = {"where", "less", "max", "min", "abs", "sign"}


@dataclass(frozen=True, slots=True, eq=False)
class Contribution:
    """One term of a generalized force: `term` = `partial`·`vector`, for a force at a point or a torque on a frame (`place`).

    `source` is the load, reaction or body that exerts it; for a body, `vector` is −m a at its mass centre or −I·α − ω × I·ω on its
    frame.
    """

    source: Load | Reaction | Body
    place: Point | Frame
    vector: Vector
    partial: Vector
    term: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Contributions:
    """The terms of F_r (`active`) and F*_r (`inertia`) for one speed, and the loads and bodies without such terms."""

    speed: Expr
    active: tuple[Contribution, ...]
    inertia: tuple[Contribution, ...]
    noncontributing_loads: tuple[Load, ...]
    noncontributing_bodies: tuple[Body, ...]


@dataclass(frozen=True, slots=True, eq=False)
class MassContribution:
    """The contribution of one body to M_rs: `translation` m v_r·v_s and `rotation` ω_r·I·ω_s."""

    body: Body
    translation: Expr
    rotation: Expr


def contributions(derived: Derived, speed: Expr | str) -> Contributions:
    """See Equations.contributions."""
    speed = _speed_named(derived, speed)
    active, idle_loads = _contributing(derived, derived.active_terms, speed)
    pairs = [_of_pair(derived, speed, r) for r in derived.reactions if (speed, r) in derived.pairs]
    inertia, idle_bodies = _contributing(derived, derived.inertia_terms, speed)
    return Contributions(speed, (*active, *(p for p in pairs if p.term is not ZERO)), inertia, idle_loads, idle_bodies)


def mass_contributions(derived: Derived, r: Expr | str, s: Expr | str) -> tuple[MassContribution, ...]:
    """See Equations.mass_contributions."""
    r, s = _speed_named(derived, r), _speed_named(derived, s)
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


def _speed_named(derived: Derived, speed: Expr | str) -> Expr:
    """The speed of the system given as a symbol or by name."""
    if speed not in derived.all_speeds:
        raise SpeedsError(f"Expected a speed of the system, one of {none_of(derived.all_speeds, speed)}")
    return derived.all_speeds[derived.all_speeds.index(speed)]


def _of_pair(derived: Derived, speed: Expr, reaction: Reaction) -> Contribution:
    """The contribution of the pair ±R n: only the far side, moved by the auxiliary speed, has a partial velocity."""
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
    derived: Derived, table: Mapping[Source, Sequence[LoadTerm]], speed: Expr
) -> tuple[tuple[Contribution, ...], tuple[Source, ...]]:
    """The terms that do not vanish, and the sources whose terms vanish or cancel."""
    kept: list[Contribution] = []
    idle: list[Source] = []
    for source, terms in table.items():
        products = [
            Contribution(source, t.place, t.vector, v, v.dot(t.vector)) for t, v in terms_moved_by(terms, speed)
        ]
        if vanish([sum_of(c.term for c in products)], derived):
            idle.append(source)
        else:
            kept += [c for c in products if not vanish([c.term], derived)]
    return tuple(kept), tuple(idle)


def vanish(exprs: Sequence[Expr], derived: Derived) -> bool:
    """Whether all expressions are zero, structurally or, without switches, beside their terms at random states."""
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
    """A load that contributes to no generalized active force, and the reason."""

    load: Load
    reason: str

    def __repr__(self) -> str:
        return f"{self.load.name}: {self.reason}"


def noncontributing(solved: Solved) -> tuple[Noncontributing, ...]:
    """See Equations.noncontributing."""
    derived, speeds, e = solved.derived.as_declared, solved.independent_speeds, solved.embedding
    if e is not None:  # with all loads, including those along constraint forces
        known = derived.kinematics.with_following(e.following(solved.derived.speeds), {})
        derived = replace(derived, kinematics=known)
    found = []
    for load, terms in derived.active_terms.items():
        reason = _reason(derived, terms, speeds)
        if reason:
            found.append(Noncontributing(load, reason))
    return tuple(found)


def _reason(derived: Derived, terms: Sequence[LoadTerm], speeds: Sequence[Expr]) -> str:
    """The reason why F_r is zero for every speed; "" if it is not."""
    shares = [[generalized([term], u) for u in speeds] for term in terms]
    if not vanish([sum_of(column) for column in zip(*shares, strict=True)], derived):
        return ""
    places = ", ".join(dict.fromkeys(term.place.name for term in terms))
    moving = [term for term in terms if any(not v.is_zero for u, v in term.motion.partials.items() if u in set(speeds))]
    if not moving:
        return f"no speed moves {places}: all partial velocities there are zero"
    if vanish([x for row in shares for x in row], derived):
        return f"perpendicular to the partial velocities of {places}"
    return f"the contributions at {places} add up to zero: action and reaction without relative motion along them"


def inertia_forces(derived: Derived, body: Body) -> ForceSystem:
    """See Equations.inertia_forces."""
    terms = derived.inertia_terms[body]
    return ForceSystem(
        tuple((t.place, t.vector) for t in terms if isinstance(t.place, Point)),
        tuple(t.vector for t in terms if isinstance(t.place, Frame)),
    )


Place = dict[Expr, float]

_PLACES, _WIDE = 8, 1.2
_ABOUT = (0.7, 1.3)
"""Multiples of their defaults between which parameters are drawn."""
_NEIGHBOURS, _STEP, _SPREAD = 4, 1e-11, 0.1
"""Places near by at which a number is computed again, how far they are, and by which share what is not of rounding changes at most."""


def by_rates(derived: Derived, loads: Iterable[Load]) -> Exprs:
    """Q_s of each coordinate; for Euler parameters the component along their length is meaningless."""
    s = InRates(derived)
    return s.power_by(acting(loads), s.velocity_at_any_length)


def sample_points(
    exprs: Iterable[Expr],
    known: Sequence[Mapping[Symbol, float]] = (),
    unit: Sequence[Sequence[Symbol]] = (),
    *,
    varied: bool = True,
) -> list[Place]:
    """Values of all symbols at a few states: those `known`, else random ones, of both signs in every other state.

    If `varied`, parameters are random too, about their defaults, so that conclusions hold for all of their values, even if a damping
    is zero by default. Sets of Euler parameters have `unit` length.
    """
    symbols = free_symbols(exprs)
    starts: Sequence[Mapping[Symbol, float]] = known or [{}] * _PLACES
    result: list[Place] = [{s: _value(s, k, start, varied) for s in symbols} for k, start in enumerate(starts)]
    for place in result:
        for group in unit:
            length = np.linalg.norm([place.get(e, draw(SEED, e)) for e in group])
            place.update((e, place.get(e, draw(SEED, e)) / float(length)) for e in group)
    return result


def states(derived: Derived, exprs: Iterable[Expr], *, varied: bool = True) -> list[Place]:
    """`sample_points` with Euler parameters of unit length that satisfy the constraints."""
    sets = [s.coordinates for s in derived.system.euler_parameters]
    if not derived.constraints.constraints:
        return sample_points(exprs, unit=sets, varied=varied)
    at = derived.compared.at
    return sample_points(exprs, [at.at(k) for k in range(min(at.count, _PLACES))], varied=varied)


def _value(s: Symbol, k: int, known: Mapping[Symbol, float], varied: bool) -> float:
    if s in known:
        return float(known[s])
    if isinstance(s, Parameter) and s.default:
        return float(s.default) * (draw(SEED + k, s, *_ABOUT) if varied else 1.0)
    k = k if varied or not isinstance(s, Parameter) else 0
    wide = isinstance(s, Coordinate | QuasiRate | Rate | Speed) and k % 2
    return draw(SEED + k, s, -_WIDE if wide else 0.3, _WIDE)


def measured(exprs: Sequence[Expr], at: Sequence[Place]) -> Array:
    """The values of expressions (states × expressions); NaN where they are not finite."""
    with np.errstate(all="ignore"):
        result = np.array([np.array(evaluate(list(exprs), dict(place)), dtype=float) for place in at])
    result = result.reshape(len(at), len(exprs))
    result[~np.isfinite(result)] = np.nan
    return result


def differs(groups: Sequence[Sequence[Expr]], at: Sequence[Place]) -> tuple[Array, Mask]:
    """The sums of groups of terms (states × groups), and where they differ from zero by more than rounding.

    A sum counts as zero if it is small beside its terms, or if it changes under a perturbation of the state within rounding, as the
    rounding residue of zero does.
    """
    if not groups:
        return np.zeros((len(at), 0)), np.zeros((len(at), 0), dtype=bool)
    flat = [e for group in groups for e in group]
    ends = np.cumsum([len(group) for group in groups])[:-1]

    def sums(table: Array) -> Array:
        return np.array([part.sum(axis=1) for part in np.split(table, ends, axis=1)]).reshape(len(groups), -1).T

    values = measured(flat, at)
    total, terms = sums(values), sums(np.abs(values))
    spread = np.zeros(total.shape)
    for k in range(_NEIGHBOURS):
        spread = np.fmax(spread, np.abs(sums(measured(flat, [_near(place, k) for place in at])) - total))
    with np.errstate(invalid="ignore"):
        told = (np.abs(total) > UNRELATED * terms) & (spread <= _SPREAD * np.abs(total))
    return total, np.asarray(told)


def _near(place: Place, k: int) -> Place:
    return {s: x * (1 + _STEP * draw(SEED + k, s, -1.0, 1.0)) for s, x in place.items()}
