# SPDX-License-Identifier: BSD-3-Clause
"""A dumb-bell on a universal joint: one body of two parts, and the same as two bodies."""

from __future__ import annotations

from dataclasses import dataclass

import kane as kn
from kane.model import Part

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
m, M, L, r = (
    kn.parameter(n, v, u) for n, v, u in (("m", 0.5, "kg"), ("M", 1.2, "kg"), ("L", 0.7, "m"), ("r", 0.1, "m"))
)
g = kn.parameter("g", 9.81, "m/s^2")
HINGE = kn.universal("hinge", O, N, axes=(N.x, N.y))
B = HINGE.frame
NEAR = HINGE.point.at("near", L * B.z)
FAR = HINGE.point.at("far", 3 * L * B.z)


@dataclass(frozen=True, eq=False)
class Dumbbell:
    """A particle and a ball on one rod."""

    name: str
    near: kn.Expr = m

    def parts(self):
        return (Part(self.name, self.near, NEAR), Part(self.name, M, FAR, B, kn.solid_sphere(B, M, r)))


def derive(*bodies):
    push = kn.Force(FAR, 0.3 * N.x + 0.2 * B.y, name="push")
    drag = kn.Torque(B, -0.05 * B.angular_velocity(N), name="drag")
    pull = kn.reaction("R", at=HINGE.point, along=N.z)
    return kn.derive(
        kn.System(N, bodies=bodies, joints=[HINGE], loads=[kn.gravity(-g * N.z), push, drag], reactions=[pull])
    )


ONE = derive(Dumbbell("dumb-bell"))
TWO = derive(
    kn.Particle("particle", NEAR, m),
    kn.RigidBody("ball", frame=B, mass_center=FAR, mass=M, inertia=kn.solid_sphere(B, M, r)),
)
