# SPDX-License-Identifier: BSD-3-Clause
"""Slider (prismatic joint): one displacement along an axis, no rotation."""

from __future__ import annotations

from kane.model.joints.joint import Joint, Names, SpeedNames, Twist, seat
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def slider(
    name: str,
    at: Point,
    parent: Frame,
    *,
    axis: Vector,
    child: str = "",
    coordinates: Names = None,
    speeds: SpeedNames = None,
) -> Joint:
    """A child that slides by q along `axis` of the parent; u = q̇. Arguments as for `kn.pin`."""
    s = seat("slider", name, at, parent, child, coordinates, speeds)
    a = s.axis(axis)
    (q,) = s.symbols(q="m")
    return s.joint([q], s.turned(0, parent.x), a * q, axes=[a], free=[Twist(Vector(), a)])
