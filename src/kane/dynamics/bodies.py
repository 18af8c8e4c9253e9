# SPDX-License-Identifier: BSD-3-Clause
"""The bodies of a system with their motions."""

from __future__ import annotations

from dataclasses import dataclass

from kane.dynamics.inertia_frames import ConstantInertia, constant_inertia
from kane.kinematics.aligned import Aligned
from kane.kinematics.motion import Kinematics, Motion, acceleration_form
from kane.model.bodies import Body, RigidBody
from kane.model.system import System
from kane.space.rotation import Basis
from kane.space.vector import Vector


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


def homes(system: System, aligned: Aligned) -> tuple[dict[Basis, Basis], dict[Body, ConstantInertia]]:
    """For each rigid body its constant inertia; for its frame, the frame along which ω is best written."""
    inertias: dict[Body, ConstantInertia] = {b: constant_inertia(b, aligned) for b in system.rigid_bodies}
    best = {b.frame: inertias[b].frame for b in system.rigid_bodies}
    return {frame: home for frame, home in best.items() if home is not aligned.rates(frame)[0]}, inertias


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
