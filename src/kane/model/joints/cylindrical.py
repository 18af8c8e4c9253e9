# SPDX-License-Identifier: BSD-3-Clause
"""Cylindrical joint: an angle about and a displacement along one axis."""

from __future__ import annotations

from kane.model.joints.joint import Joint, Names, SpeedNames, Twist, seat
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def cylindrical(
    name: str,
    at: Point,
    parent: Frame,
    *,
    axis: Vector,
    child: str = "",
    coordinates: Names = None,
    speeds: SpeedNames = None,
) -> Joint:
    """A child that turns by q about `axis` and slides by s along it; u_q = q̇, u_s = ṡ. Arguments as for `kn.pin`."""
    seated = seat("cylindrical", name, at, parent, child, coordinates, speeds)
    a = seated.axis(axis)
    q, s = seated.symbols(q="rad", s="m")
    free = [Twist(a, Vector()), Twist(Vector(), a)]
    return seated.joint([q, s], seated.turned(q, a), a * s, axes=[a], free=free, stems=("u_q", "u_s"))
