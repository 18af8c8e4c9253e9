# SPDX-License-Identifier: BSD-3-Clause
"""Universal joint (Cardan, Hooke): two pins whose axes cross at right angles, with a massless cross between."""

from __future__ import annotations

from kane.model.joints.joint import Joint, Names, SpeedNames, Twist, mirrored, perpendicular_axes, seat
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def universal(
    name: str,
    at: Point,
    parent: Frame,
    *,
    axes: tuple[Vector, Vector],
    child: str = "",
    coordinates: Names = None,
    speeds: SpeedNames = None,
) -> Joint:
    """A child that turns by q1 about the first axis, fixed in the parent, then by q2 about the second, which turns with the cross.

    `axes` are two perpendicular unit vectors as they lie in the parent at q1 = 0; the second is fixed in the child too. u = q̇.
    The cross is the frame `joint.frame.parent`; it bears no mass. Other arguments as for `kn.pin`.
    """
    s = seat("universal", name, at, parent, child, coordinates, speeds)
    first, second = perpendicular_axes(name, axes, parent)
    q1, q2 = s.symbols(q1="rad", q2="rad")
    cross = parent.rotate(f"{s.child}'", q1, first)
    turned = mirrored(second, parent, cross)
    free = [Twist(first, Vector()), Twist(turned, Vector())]
    frame = cross.rotate(s.child, q2, turned)
    return s.joint([q1, q2], frame, axes=[first, turned], free=free, stems=("u1", "u2"))
