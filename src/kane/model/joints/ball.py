# SPDX-License-Identifier: BSD-3-Clause
"""Ball joint (spherical joint): any rotation about a point."""

from __future__ import annotations

from kane.model.joints.joint import Joint, Names, SpeedNames, Twist, seat
from kane.model.joints.orientation import STEMS, Orientation, check_orientation, oriented_child, spins
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def ball(
    name: str,
    at: Point,
    parent: Frame,
    *,
    orientation: Orientation = "euler parameters",
    sequence: str = "xyz",
    child: str = "",
    coordinates: Names = None,
    speeds: SpeedNames = None,
) -> Joint:
    """A child that turns about a point; speeds are the measure numbers of its ω in the parent along its own axes.

    `orientation` is "euler parameters" (e0, e1, e2, e3; the scalar one first) or "angles", body-fixed ones in the given `sequence`,
    whose rates are singular at some configuration while u and u̇ are not. Other arguments as for `kn.pin`.
    """
    s = seat("ball", name, at, parent, child, coordinates, speeds)
    check_orientation(name, orientation)
    q = s.symbols(**STEMS[orientation])
    frame = oriented_child(parent, s.child, q, orientation, sequence)
    free = [Twist(e, Vector()) for e in (frame.x, frame.y, frame.z)]
    return s.joint(q, frame, free=free, stems=("u_x", "u_y", "u_z"), definitions=spins(parent, frame))
