# SPDX-License-Identifier: BSD-3-Clause
"""The classical route: M_rs and f_r from partial velocities and biases.

    M_rs = Σ m v_r·v_s + ω_r·I·ω_s
    f_r  = Σ v_r·(F − m a_b) + Σ ω_r·(T − I·α_b − ω × I·ω)

Bodies that share a partial velocity share its scalar product: Σ_k V·X_k = V·Σ_k X_k. Sums run from the last body to the
first, so that along a chain every partial sum is one node used many times.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from kane.dynamics.inertia_frames import ConstantInertia, constant_inertia
from kane.expr.build import add
from kane.expr.node import ZERO, Expr
from kane.kinematics.motion import Kinematics, Motion
from kane.model.bodies import Body, RigidBody
from kane.model.loads import Load
from kane.model.system import System
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Parts, Vector


@dataclass(frozen=True, slots=True, eq=False)
class Moving:
    """A body with the motion of its mass centre and, if rigid, its rotation and inertia."""

    body: Body
    center: Motion
    rotation: Motion | None
    inertia: ConstantInertia | None

    def inertia_torque_bias(self) -> Vector:
        """I·α_b + ω × I·ω."""
        if self.rotation is None or self.inertia is None:
            return Vector()
        w = self.rotation.total.express(self.inertia.frame)
        return self.inertia.times(self.rotation.bias) + w.cross(self.inertia.times(w))


def homes(system: System) -> tuple[dict[Frame, Frame], dict[Body, ConstantInertia]]:
    """For each rigid body its constant inertia; for its frame, the frame along which ω is best written."""
    inertias: dict[Body, ConstantInertia] = {b: constant_inertia(b) for b in system.rigid_bodies}
    found = {b.frame: inertias[b].frame for b in system.rigid_bodies}
    return {frame: home for frame, home in found.items() if home is not frame}, inertias


def moving_bodies(system: System, kinematics: Kinematics, inertias: dict[Body, ConstantInertia]) -> tuple[Moving, ...]:
    """Every body with its motion."""
    return tuple(
        Moving(
            b,
            kinematics.point(b.mass_center),
            kinematics.frame(b.frame) if isinstance(b, RigidBody) else None,
            inertias.get(b),
        )
        for b in system.bodies
    )


class _Sum:
    """Σ V·X grouped by V, then by the vector X is a multiple of."""

    __slots__ = ("groups",)

    def __init__(self) -> None:
        self.groups: dict[Parts, dict[Parts, Expr] | Vector] = {}

    def scaled(self, v: Vector, factor: Expr, x: Vector) -> None:
        """Add V·(factor X)."""
        group = self.groups.setdefault(v.parts, {})
        assert isinstance(group, dict)
        group[x.parts] = add(group.get(x.parts, ZERO), factor)

    def plain(self, v: Vector, x: Vector) -> None:
        """Add V·X."""
        known = self.groups.get(v.parts)
        assert not isinstance(known, dict)
        self.groups[v.parts] = x if known is None else (known + x).gathered()

    def value(self) -> Expr:
        """The sum."""
        total = ZERO
        for parts, group in self.groups.items():
            if isinstance(group, dict):
                joined = Vector()
                for x, factor in group.items():
                    joined = joined + Vector(x) * factor
                group = joined.gathered()
            total = add(total, Vector(parts).dot(group))
        return total


def mass_matrix_entry(bodies: Sequence[Moving], r: Expr, s: Expr, spun: dict[tuple[int, Expr], Vector]) -> Expr:
    """M_rs; `spun` keeps I·ω_s by body and speed."""
    shift, turn = _Sum(), _Sum()
    for k in range(len(bodies) - 1, -1, -1):
        b = bodies[k]
        v_r, v_s = b.center.partials.get(r), b.center.partials.get(s)
        if v_r is not None and v_s is not None:
            shift.scaled(v_r, b.body.mass, v_s)
        if b.rotation is None or b.inertia is None:
            continue
        w_r, w_s = b.rotation.partials.get(r), b.rotation.partials.get(s)
        if w_r is None or w_s is None:
            continue
        if (k, s) not in spun:
            spun[k, s] = b.inertia.times(w_s)
        turn.plain(w_r, spun[k, s])
    return add(shift.value(), turn.value())


def mass_matrix(bodies: Sequence[Moving], rows: Sequence[Expr], columns: Sequence[Expr]) -> list[list[Expr]]:
    """M_rs for r in `rows` and s in `columns`; equal where (r, s) is asked as (s, r)."""
    spun: dict[tuple[int, Expr], Vector] = {}
    place = {s: i for i, s in enumerate(columns)}
    made: list[list[Expr]] = []
    for i, r in enumerate(rows):
        line = []
        for j, s in enumerate(columns):
            mirrored = place.get(r)
            if mirrored is not None and rows[i] is columns[i] and j < i:
                line.append(made[j][i])
            else:
                line.append(mass_matrix_entry(bodies, r, s, spun))
        made.append(line)
    return made


@dataclass(frozen=True, slots=True, eq=False)
class PointForce:
    """A force at a point, or a torque on a frame, by the motion it works on."""

    motion: Motion
    vector: Vector


def forcing_terms(
    system: System, kinematics: Kinematics, bodies: Sequence[Moving], loads: Iterable[Load]
) -> tuple[list[PointForce], list[PointForce]]:
    """Everything that f_r is summed from: forces and torques, loads and inertia bias together, by place."""
    by_point: dict[Point, Vector] = {}
    by_frame: dict[Frame, Vector] = {}
    for load in loads:
        for point, f in load.forces:
            by_point[point] = by_point.get(point, Vector()) + f
        for frame, t in load.torques:
            by_frame[frame] = by_frame.get(frame, Vector()) + t
    fall = Vector()
    for g in system.gravities:
        fall = fall + g.acceleration
    forces: list[PointForce] = []
    torques: list[PointForce] = []
    for b in reversed(bodies):
        own = (fall - b.center.bias).gathered() * b.body.mass
        forces.append(PointForce(b.center, (own + by_point.pop(b.body.mass_center, Vector())).gathered()))
        if b.rotation is not None and isinstance(b.body, RigidBody):
            torques.append(PointForce(b.rotation, by_frame.pop(b.body.frame, Vector()) - b.inertia_torque_bias()))
    forces += [PointForce(kinematics.point(p), f) for p, f in by_point.items()]
    torques += [PointForce(kinematics.frame(f), t) for f, t in by_frame.items()]
    return forces, torques


def generalized(terms: Iterable[PointForce], r: Expr) -> Expr:
    """Σ V_r·X."""
    total = _Sum()
    for term in terms:
        v = term.motion.partials.get(r)
        if v is not None and not term.vector.is_zero:
            total.plain(v, term.vector)
    return total.value()
