# SPDX-License-Identifier: BSD-3-Clause
"""Flexible bodies on a tree (Shabana 2013, ch. 5): elastic coordinates, generalized forces on them, and spatial inertias of parts.

A point that moves along inertial axes by elastic coordinates alone has partial velocities for these alone: its loads are generalized
forces on them and need no segment of the tree.

Parts whose momentum is shared, at positions d_k in the link, with masses μ_kl, p_k = Σ_l μ_kl d_l, w_k = Σ_l μ_kl and derivatives
∂_j d_k by the elastic coordinates, have the inertia

    J = Σ (d_k·p_k 1 − p_k d_k),   n_j = Σ p_k × ∂_j d_k,   f_j = Σ w_k ∂_j d_k,   m_ij = Σ μ_kl ∂_i d_k·∂_j d_l

and at zero acceleration, with P_k = ω × (ω × p_k) + 2 ω × ṗ_k + p̈_k, the moment Σ d_k × P_k, the force by the same formula with
Σ w_k d_k in the place of p_k, and the forces e_j = Σ ∂_j d_k·P_k on the elastic coordinates.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import NamedTuple

from kane.dynamics.derivation import Derived
from kane.expr.build import add, mul, neg, sub, sum_of
from kane.expr.differentiation import affine_forms, time_derivative
from kane.expr.matrix import dot
from kane.expr.node import TWO, ZERO, Expr
from kane.kinematics.freedoms import Shift, Stages, Unsuited
from kane.kinematics.links import Carried, Link
from kane.kinematics.segments import Elastic, Segments
from kane.model.bodies import deforming
from kane.space.frame import Frame, Point
from kane.space.rotation import NOTHING, Triple, cross3
from kane.space.vector import Vector, angular_velocity
from kane.tree.triples import as_rows, centripetal, mirrored, skew, summed, times, triple
from kane.tree.values import NO_INERTIA, Column, SpatialForce, SpatialInertia, joined

Rows = Sequence[Mapping[int, Expr]]


class SharedMomenta(NamedTuple):
    """Parts with shared momentum: positions along B with their rates, the masses μ by number, and w."""

    places: Sequence[Triple]
    moves: Sequence[Shift]
    masses: Rows
    weights: Sequence[Expr]


@dataclass(frozen=True, slots=True, eq=False)
class Bent:
    """The parts with shared momentum, by segment, and the generalized forces on elastic coordinates."""

    bodies: Mapping[int, SharedMomenta]
    forces: Mapping[Expr, Expr]

    def elastic(self, i: int, rates: Sequence[Expr]) -> Elastic:
        """The spatial inertia of segment i's flexible parts as a function of ω and ω·ω, along B, with the forces on `rates`."""
        applied = {b: Column(force=neg(self.forces[b])) for b in rates if b in self.forces}

        def inertia(w: Triple, square: Expr) -> SpatialInertia:
            own = inertia_of(self.bodies[i], w, square) if i in self.bodies else NO_INERTIA
            return own._replace(columns=joined(own.columns, applied))

        return inertia


def bending_bodies(
    derived: Derived, found: Segments, links: Sequence[Link], rates: Collection[Expr]
) -> dict[int, SharedMomenta]:
    """The parts with shared momentum, by the segment in which they move by `rates`."""
    stages, bodies = Stages(derived.kinematics, rates), dict[int, SharedMomenta]()
    for number, link in zip(found.ends, links, strict=True):
        parts = [each for each in link.parts if each.part.momenta]
        if parts:
            places = [summed(arm.components(link.basis), found.steps[number].shift) for _, arm in parts]
            moves = [_moves(stages, place) for place in places]
            weights = [part.mass for part, _ in parts]
            bodies[number] = SharedMomenta(places, moves, _masses(parts), weights)
    return bodies


def _moves(stages: Stages, place: Triple) -> Shift:
    stage = stages.stage(stages.raw(triple(map(time_derivative, place))), by_rates=True)
    if stage.freedoms:
        raise Unsuited("points of a flexible body that move by more than its deformation")
    return stage


def _masses(parts: Sequence[Carried]) -> Rows:
    numbers: dict[Point, int] = {part.mass_center: k for k, (part, _) in enumerate(parts)}
    if any(p not in numbers for part, _ in parts for p, _ in part.momenta):
        raise Unsuited("points of a flexible body in several links")
    return [{numbers[p]: mass for p, mass in part.momenta} for part, _ in parts]


def inertia_of(body: SharedMomenta, w: Triple, square: Expr) -> SpatialInertia:
    """The spatial inertia of the parts about the origin, with the wrench and forces at zero acceleration, at angular velocity ω."""
    places, moves = body.places, body.moves
    p = [_weighed(row, lambda k: places[k]) for row in body.masses]
    rows = [[ZERO] * 3 for _ in range(3)]
    for d, own in zip(places, p, strict=True):
        whole = dot(d, own)
        for a in range(3):
            for b in range(a, 3):
                rows[a][b] = add(rows[a][b], sub(whole if a == b else ZERO, mul(own[a], d[b])))
    mass = sum_of(body.weights)
    h = _weighed(dict(enumerate(body.weights)), lambda k: places[k])
    bias_forces = [_swung(body, row, w, square) for row in body.masses]
    n = reduce(summed, map(cross3, places, bias_forces), NOTHING)
    f = _swung(body, dict(enumerate(body.weights)), w, square)
    columns: dict[Expr, Column] = {}
    for k, stage in enumerate(moves):
        for rate, v in stage.shared:
            before = columns.get(rate, Column())
            row = dict(_entries(body, k, v))
            wrench = SpatialForce(cross3(p[k], v), times(body.weights[k], v))
            columns[rate] = before.plus(Column(wrench, row, dot(v, bias_forces[k])))
    m = ((mass, ZERO, ZERO), (ZERO, mass, ZERO), (ZERO, ZERO, mass))
    return SpatialInertia(mirrored(as_rows(rows)), skew(h), m, SpatialForce(n, f), columns)


def _entries(body: SharedMomenta, k: int, v: Triple) -> Iterator[tuple[Expr, Expr]]:
    """The entries m_ij of part k with v = ∂_i d_k, by the rate j."""
    found: dict[Expr, Expr] = {}
    for other, mass in body.masses[k].items():
        for rate, x in body.moves[other].shared:
            found[rate] = add(found.get(rate, ZERO), mul(mass, dot(v, x)))
    return ((rate, x) for rate, x in found.items() if x is not ZERO)


def _weighed(row: Mapping[int, Expr], what: Callable[[int], Triple]) -> Triple:
    """Σ_l μ_kl v_l of a row of μ and vectors `what`."""
    return reduce(summed, (times(mass, what(k)) for k, mass in row.items()), NOTHING)


def _swung(body: SharedMomenta, row: Mapping[int, Expr], w: Triple, square: Expr) -> Triple:
    """P_k = ω × (ω × p) + 2 ω × ṗ + p̈ with p = Σ_l μ_kl d_l."""
    p = _weighed(row, lambda k: body.places[k])
    change = _weighed(row, lambda k: body.moves[k].total)
    drift = _weighed(row, lambda k: body.moves[k].drift)
    return summed(summed(centripetal(w, p, square), times(TWO, cross3(w, change))), drift)


def shared_rates(derived: Derived) -> tuple[Expr, ...]:
    """The rates of the elastic coordinates."""
    return tuple(rate for body in deforming(derived.system.bodies) for rate in body.speeds.values())


def bent_frames(derived: Derived) -> list[Frame]:
    """The frames with torques that rotate relative to their parents by deformation alone, and need links."""
    rates = shared_rates(derived)
    frames = dict.fromkeys(f for load in derived.declared_loads for f, _ in load.torques) if rates else {}
    pairs = [(f, f.parent) for f in frames if f.parent is not None]
    return [f for f, base in pairs if _by_deformation(angular_velocity(f, base).components(base), rates)]


def _by_deformation(moved: Sequence[Expr], rates: Sequence[Expr]) -> bool:
    forms = affine_forms(moved, rates)
    return any(row for row, _ in forms) and all(rest is ZERO for _, rest in forms)


def gauged(derived: Derived) -> tuple[list[tuple[Point, Vector]], dict[Expr, Expr]]:
    """The forces of loads, except on points that move by deformation alone, and those as generalized forces by rate."""
    forces = [x for load in derived.declared_loads for x in load.forces]
    rates, aligned = shared_rates(derived), derived.kinematics.aligned
    if not rates:
        return forces, {}
    kept, on = [], dict[Expr, Expr]()
    for point, force in forces:
        columns = _columns(derived, point, rates)
        if columns is None:
            kept.append((point, force))
            continue
        for b, v in columns.items():
            on[b] = add(on.get(b, ZERO), dot(aligned.vector(force).components(derived.system.inertial), v))
    return kept, on


def _columns(derived: Derived, point: Point, rates: Sequence[Expr]) -> dict[Expr, Triple] | None:
    """The partial velocities of a point that moves along inertial axes by elastic coordinates alone; None of another point."""
    parent, inertial = point.parent, derived.system.inertial
    if point.body is not None or parent is None or parent.parent is not None:
        return None
    if any(f is not inertial for f, _ in point.offset.parts):
        return None
    moved = [time_derivative(x) for _, v in point.offset.parts for x in v]
    if len(moved) != 3 or not _by_deformation(moved, rates):
        return None
    forms = affine_forms(moved, rates)
    return {b: triple(row.get(b, ZERO) for row, _ in forms) for b in {b: None for row, _ in forms for b in row}}
