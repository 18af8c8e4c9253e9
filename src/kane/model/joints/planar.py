# SPDX-License-Identifier: BSD-3-Clause
"""Planar joint: two displacements in a plane and an angle about its normal."""

from __future__ import annotations

from kane.model.joints.joint import Joint, Names, SpeedNames, Twist, across, seat
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def planar(
    name: str,
    at: Point,
    parent: Frame,
    *,
    normal: Vector,
    child: str = "",
    coordinates: Names = None,
    speeds: SpeedNames = None,
) -> Joint:
    """A child displaced by x e₁ + y e₂ in the plane across `normal`, then turned by q about it; u = (ẋ, ẏ, q̇).

    `normal` is a unit vector fixed in the parent frame, e₁ and e₂ are parent's, e₁ × e₂ = normal (x and y for z), in `joint.axes`
    after it. Other arguments as for `kn.pin`.
    """
    s = seat("planar", name, at, parent, child, coordinates, speeds)
    n = s.axis(normal, "normal")
    e1, e2 = across(n, parent)
    x, y, q = s.symbols(x="m", y="m", q="rad")
    free = [Twist(Vector(), e1), Twist(Vector(), e2), Twist(n, Vector())]
    stems = ("u_x", "u_y", "u_q")
    return s.joint([x, y, q], s.turned(q, n), e1 * x + e2 * y, axes=[n, e1, e2], free=free, stems=stems)
