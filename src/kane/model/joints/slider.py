# SPDX-License-Identifier: BSD-3-Clause
"""Slider (prismatic joint): one displacement along an axis, no rotation."""

from __future__ import annotations

from kane.model.constraints import Constraint
from kane.model.joints.closing import checked, on_axis, oriented
from kane.model.joints.joint import (
    Joint,
    Names,
    SpeedNames,
    Twist,
    check_place,
    coordinates_of,
    fixed,
    made,
    reach,
    still,
)
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
    check_place(name, at, parent)
    a = fixed(axis, parent, f"axis of {name!r}")
    (q,) = coordinates_of(name, coordinates, {"q": "m"})
    reached = (reach(name, at, a * q), still(parent, child or name))
    return made(
        name, "slider", (at, parent), reached, [q], speeds, [q.dt], [a], [Twist(Vector(), a)], given=coordinates
    )


def close_slider(
    name: str, at: Point, parent: Frame, point: Point, frame: Frame, *, axis: Vector
) -> tuple[Constraint, ...]:
    """A loop closed by a slider, five configuration constraints: `point` on the line, `frame` oriented as `parent`."""
    checked(name, at, parent, point, frame)
    a = fixed(axis, parent, f"axis of {name!r}")
    return (*on_axis(name, a, at, parent, point), *oriented(name, parent, frame))
