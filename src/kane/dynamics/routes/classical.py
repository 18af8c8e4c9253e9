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
from typing import Any

from kane.dynamics.inertia_frames import ConstantInertia, constant_inertia
from kane.expr.build import add
from kane.expr.node import ZERO, Expr
from kane.kinematics.motion import Kinematics, Motion, acceleration_form
from kane.model.bodies import Body, RigidBody
from kane.model.loads import Load
from kane.model.system import System
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.rotation import Basis
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
        return self._inertia_torque(self.rotation, self.inertia, self.rotation.bias)

    def inertia_torque(self) -> Vector:
        """I·α + ω × I·ω, in u̇; zero for a particle."""
        if self.rotation is None or self.inertia is None:
            return Vector()
        return self._inertia_torque(self.rotation, self.inertia, acceleration_form(self.rotation))

    @staticmethod
    def _inertia_torque(rotation: Motion, inertia: ConstantInertia, alpha: Vector) -> Vector:
        w = rotation.total.express(inertia.frame)
        return inertia.times(alpha) + w.cross(inertia.times(w))


def homes(system: System) -> tuple[dict[Basis, Basis], dict[Body, ConstantInertia]]:
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


def mass_matrix(bodies: Sequence[Moving], speeds: Sequence[Expr], auxiliary: Sequence[Expr]) -> list[list[Expr]]:
    """M_rs for r in `speeds`, then `auxiliary`, and s in `speeds`; the square block is symmetric."""
    symbols = [*speeds, *auxiliary]
    n = len(speeds)
    shift = _shift_groups(bodies, symbols, n)
    turn = _turn_groups(bodies, symbols, n)
    rows: list[list[Expr]] = []
    carried: dict[tuple[Any, ...], Vector] = {}
    for i in range(len(symbols)):
        line = []
        for j in range(n):
            if j < i < n:
                line.append(rows[j][i])
                continue
            moved, turned = ZERO, ZERO
            for v, group in shift.get((i, j), {}).items():
                moved = add(moved, v.dot(_carried(group, carried)))
            for w, h in turn.get((i, j), {}).items():
                turned = add(turned, w.dot(h))
            line.append(add(moved, turned))
        rows.append(line)
    return rows


Masses = dict[Vector, Expr]


def _carried(group: Masses, known: dict[tuple[Any, ...], Vector]) -> Vector:
    """Σ m v_s of one group; the same group met again is the same vector."""
    name = tuple(group.items())
    found = known.get(name)
    if found is None:
        found = Vector()
        for v, mass in group.items():
            found = found + v * mass
        known[name] = found = found.gathered()
    return found


def _unique(vectors: dict[Parts, Vector], v: Vector) -> Vector:
    """One object for equal vectors, so that they can be compared by identity."""
    return vectors.setdefault(v.parts, v)


def _shift_groups(
    bodies: Sequence[Moving], symbols: Sequence[Expr], n: int
) -> dict[tuple[int, int], dict[Vector, Masses]]:
    """For each pair of speeds, v_r → (v_s → Σ m) over the bodies that both move."""
    vectors: dict[Parts, Vector] = {}
    groups: dict[tuple[int, int], dict[Vector, Masses]] = {}
    for b in reversed(bodies):
        mass, partials = b.body.mass, b.center.partials
        moved = [(i, _unique(vectors, partials[s])) for i, s in enumerate(symbols) if s in partials]
        for i, v in moved:
            for j, w in moved:
                if j < n and (i <= j or i >= n):
                    group = groups.setdefault((i, j), {}).setdefault(v, {})
                    group[w] = add(group[w], mass) if w in group else mass
    return groups


def _turn_groups(
    bodies: Sequence[Moving], symbols: Sequence[Expr], n: int
) -> dict[tuple[int, int], dict[Vector, Vector]]:
    """For each pair of speeds, ω_r → Σ I·ω_s over the bodies that both turn."""
    vectors: dict[Parts, Vector] = {}
    groups: dict[tuple[int, int], dict[Vector, Vector]] = {}
    for b in reversed(bodies):
        if b.rotation is None or b.inertia is None:
            continue
        partials = b.rotation.partials
        turned = [(i, _unique(vectors, partials[s])) for i, s in enumerate(symbols) if s in partials]
        spun = [(j, b.inertia.times(w)) for j, w in turned if j < n]
        for i, v in turned:
            for j, h in spun:
                if i <= j or i >= n:
                    group = groups.setdefault((i, j), {})
                    group[v] = (group[v] + h).gathered() if v in group else h
    return groups


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
    """Σ V_r·X, the X that share a V summed first."""
    groups: dict[Parts, Vector] = {}
    for term in terms:
        v = term.motion.partials.get(r)
        if v is not None and not term.vector.is_zero:
            known = groups.get(v.parts)
            groups[v.parts] = term.vector if known is None else (known + term.vector).gathered()
    total = ZERO
    for parts, x in groups.items():
        total = add(total, Vector(parts).dot(x))
    return total
