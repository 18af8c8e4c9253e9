# SPDX-License-Identifier: BSD-3-Clause
"""What generalized forces are summed from: forces at points and torques on frames, each with the motion it meets.

    F_r = Σ v_r·F + Σ ω_r·T,   F*_r = Σ v_r·(−m a) + Σ ω_r·(−I·α − ω × I·ω)

(Kane & Levinson 1985, sec. 4.4 and 4.11). The equations that are solved take the same terms with u̇ left out, those of one place
summed before the product with its partial velocity:

    f_r = Σ v_r·(F − m a_b) + Σ ω_r·(T − I·α_b − ω × I·ω)
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import starmap
from types import MappingProxyType
from typing import NamedTuple

from kane.dynamics.bodies import Moving
from kane.expr.build import add
from kane.expr.evaluation import free_symbols
from kane.expr.linear_parts import Affine
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import QuasiRate, Rate
from kane.kinematics.motion import Kinematics, Motion, acceleration_form
from kane.kinematics.speeds import Speeds
from kane.model.loads import Load, Slip
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Parts, Vector


class Term(NamedTuple):
    """A force at a point, or a torque on a frame, and the motion of its place."""

    place: Point | Frame
    vector: Vector
    motion: Motion


def active_terms(load: Load, kinematics: Kinematics) -> tuple[Term, ...]:
    """Forces and torques of one load."""
    aligned = kinematics.aligned.vector
    return (
        *(Term(point, aligned(f), kinematics.point(point)) for point, f in load.forces),
        *(Term(frame, aligned(t), kinematics.frame(frame)) for frame, t in load.torques),
    )


def inertia_terms(moving: Moving) -> tuple[Term, ...]:
    """−m a at the mass centre and −(I·α + ω × I·ω) on the frame of one part of a body, in u̇."""
    part, center, rotation = moving.part, moving.center, moving.rotation
    force = sum((acceleration_form(m) * -mass for m, mass in moving.momenta), start=Vector())
    shift = Term(part.mass_center, force, center)
    if rotation is None:
        return (shift,)
    return shift, Term(rotation.frame, -rotation.torque(acceleration_form(rotation.motion)), rotation.motion)


def bias_terms(
    loads: Iterable[Term], bodies: Sequence[Moving], fall: Vector, u_dot: Mapping[Expr, Expr] = MappingProxyType({})
) -> list[Term]:
    """The terms of f: loads, gravity's acceleration `fall`, and inertia at u̇ = 0 or `u_dot`; one a place, forces first."""
    by_place: dict[Point | Frame, Term] = {}
    for term in loads:
        before = by_place.get(term.place)
        by_place[term.place] = term if before is None else term._replace(vector=before.vector + term.vector)
    forces: list[Term] = []
    torques: list[Term] = []
    for moving in reversed(bodies):
        part, center, rotation = moving.part, moving.center, moving.rotation
        own = _inertia_force(moving, fall, u_dot)
        load = by_place.pop(part.mass_center, None)
        forces.append(Term(part.mass_center, (own if load is None else own + load.vector).gathered(), center))
        if rotation is not None:
            load = by_place.pop(rotation.frame, None)
            torque = Vector() if load is None else load.vector
            torque = torque - rotation.bias
            if u_dot:
                torque = (torque - rotation.inertia.times(_acceleration(rotation.motion, u_dot))).gathered()
            torques.append(Term(rotation.frame, torque, rotation.motion))
    forces += [term for place, term in by_place.items() if isinstance(place, Point)]
    torques += [term for place, term in by_place.items() if isinstance(place, Frame)]
    return [*forces, *torques]


def _inertia_force(moving: Moving, fall: Vector, u_dot: Mapping[Expr, Expr]) -> Vector:
    """Σ m (g − a) at u̇ = 0 or `u_dot`."""
    total = Vector()
    for motion, mass in moving.momenta:
        own = (fall - motion.bias).gathered()
        if u_dot:
            own = (own - _acceleration(motion, u_dot)).gathered()
        total = total + own * mass
    return total.gathered() if moving.shared else total


def _acceleration(motion: Motion, u_dot: Mapping[Expr, Expr]) -> Vector:
    """Σ v_r u̇_r."""
    return sum((v * u_dot[s] for s, v in motion.partials.items() if s in u_dot), start=Vector()).gathered()


def met(terms: Iterable[Term], speed: Expr) -> Iterator[tuple[Term, Vector]]:
    """The terms whose place moves with a speed, each with its partial velocity."""
    return ((term, term.motion.partials[speed]) for term in terms if speed in term.motion.partials)


def generalized(terms: Iterable[Term], speed: Expr) -> Expr:
    """Σ v_r·F + Σ ω_r·T, term by term."""
    return sum_of(partial.dot(term.vector) for term, partial in met(terms, speed))


def generalized_by_motion(
    terms: Iterable[Term], speed: Expr, product: Callable[[Vector, Vector], Expr] = Vector.dot
) -> Expr:
    """Σ v_r·F + Σ ω_r·T, forces that share a v_r, and torques that share an ω_r, summed before the scalar `product`."""
    groups: tuple[dict[Parts, tuple[Vector, Vector]], ...] = {}, {}
    for term, partial in met(terms, speed):
        if not term.vector.is_zero:
            group, key = groups[isinstance(term.place, Frame)], partial.parts
            group[key] = partial, (group[key][1] + term.vector).gathered() if key in group else term.vector
    shift, turn = (sum_of(starmap(product, group.values())) for group in groups)
    return add(shift, turn)


def sum_of(terms: Iterable[Expr]) -> Expr:
    """Σ terms."""
    total = ZERO
    for x in terms:
        total = add(total, x)
    return total


def loads_in_speeds(loads: Sequence[Load], speeds: Speeds) -> tuple[Load, ...]:
    """The loads with every rate written in speeds."""
    memo: dict[Expr, Affine] = {}

    def convert(e: Expr) -> Expr:
        return speeds.in_speeds(e, memo)

    symbols = free_symbols(x for load in loads for _, v in (*load.forces, *load.torques) for x in v.scalars())
    if not any(isinstance(s, Rate | QuasiRate) for s in symbols):
        return tuple(loads)
    return tuple(
        Load(
            load.name,
            tuple((p, v.map(convert)) for p, v in load.forces),
            tuple((f, v.map(convert)) for f, v in load.torques),
            load.potential,
            _converted(load.slip, convert),
        )
        for load in loads
    )


def _converted(slip: Slip | None, convert: Callable[[Expr], Expr]) -> Slip | None:
    return slip if slip is None or slip.speed is None else replace(slip, speed=convert(slip.speed))
