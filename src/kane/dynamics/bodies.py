# SPDX-License-Identifier: BSD-3-Clause
"""The parts of bodies with their motions."""

from collections.abc import Iterable
from typing import NamedTuple

from kane.dynamics.inertia_frames import ConstantInertia, constant_inertia
from kane.kinematics.aligned import Aligned
from kane.kinematics.motion import Kinematics, Motion
from kane.model.bodies import Body, Part
from kane.space.frame import Frame
from kane.space.rotation import Basis
from kane.space.vector import Vector


class Turning(NamedTuple):
    """The rotation of a part's frame, and its central inertia."""

    frame: Frame
    motion: Motion
    inertia: ConstantInertia

    def torque(self, alpha: Vector) -> Vector:
        """I·α + ω × I·ω."""
        w = self.motion.total.express(self.inertia.frame)
        return self.inertia.times(alpha) + w.cross(self.inertia.times(w))


class Moving(NamedTuple):
    """A part of a body with the motion of its mass centre and, if it is extended, its rotation."""

    body: Body
    part: Part
    center: Motion
    rotation: Turning | None


Inertias = list[tuple[Body, Part, ConstantInertia | None]]


def inertias_of(bodies: Iterable[Body], aligned: Aligned) -> Inertias:
    """Each part of each body, and its inertia along the frame in which it is constant and short."""
    return [
        (b, p, constant_inertia(p.name, p.frame, p.inertia, aligned) if p.frame and p.inertia else None)
        for b in bodies
        for p in b.parts()
    ]


def homes(inertias: Inertias, aligned: Aligned) -> dict[Basis, Basis]:
    """For the frames of some parts, the frame along which ω is best written."""
    best = {p.frame: inertia.frame for _, p, inertia in inertias if p.frame is not None and inertia is not None}
    return {frame: home for frame, home in best.items() if home is not aligned.rates(frame)[0]}


def moving_parts(inertias: Inertias, kinematics: Kinematics) -> tuple[Moving, ...]:
    """Each part of each body with its motion."""
    return tuple(
        Moving(
            b,
            p,
            kinematics.point(p.mass_center),
            Turning(p.frame, kinematics.frame(p.frame), inertia)
            if p.frame is not None and inertia is not None
            else None,
        )
        for b, p, inertia in inertias
    )
