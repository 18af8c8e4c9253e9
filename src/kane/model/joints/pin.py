# SPDX-License-Identifier: BSD-3-Clause
"""Pin joint (revolute, hinge): one angle about an axis."""

from __future__ import annotations

from kane.model.constraints import Constraint
from kane.model.joints.closing import aligned, checked, together
from kane.model.joints.joint import Joint, Names, SpeedNames, Twist, check_place, coordinates_of, fixed, made, reach
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
    check_place(name, at, parent)
    a = fixed(axis, parent, f"axis of {name!r}")
    (q,) = coordinates_of(name, coordinates, {"q": "rad"})
    reached = (reach(name, at), parent.rotate(child or name, q, a))
    return made(name, "pin", (at, parent), reached, [q], speeds, [q.dt], [a], [Twist(a, Vector())], given=coordinates)


def close_pin(
    name: str, at: Point, parent: Frame, point: Point, frame: Frame, *, axis: Vector
) -> tuple[Constraint, ...]:
    """A loop closed by a pin, five configuration constraints: `point` stays at `at`, `axis` the same vector in both frames.

    Three forces along the inertial axes and two torques about axes of `parent` across the axis, on the side of `point` and `frame`.
    """
    checked(name, at, parent, point, frame)
    a = fixed(axis, parent, f"axis of {name!r}")
    return (*together(name, at, point), *aligned(name, a, parent, frame))
