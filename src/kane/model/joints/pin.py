# SPDX-License-Identifier: BSD-3-Clause
"""Pin joint (revolute, hinge): one angle about an axis."""

from __future__ import annotations

from kane.model.joints.joint import Joint, Names, SpeedNames, Twist, seat
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def pin(
    name: str,
    at: Point,
    parent: Frame,
    *,
    axis: Vector,
    child: str = "",
    coordinates: Names = None,
    speeds: SpeedNames = None,
) -> Joint:
    """A child frame turned by an angle q about `axis`; u = q̇.

    Parameters
    ----------
    name : of the joint; child, coordinate (q_name) and speed (u_name) are named after it where they are not given
    at, parent : the parent's joint point and frame
    axis : a unit vector fixed in the parent frame
    child : name of the child frame
    coordinates, speeds : names or symbols; speeds also as a mapping to definitions. By name they are in rad, m and per second
    """
    s = seat("pin", name, at, parent, child, coordinates, speeds)
    a = s.axis(axis)
    (q,) = s.symbols(q="rad")
    return s.joint([q], s.turned(q, a), axes=[a], free=[Twist(a, Vector())])
