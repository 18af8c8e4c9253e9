# SPDX-License-Identifier: BSD-3-Clause
"""Cylindrical joint: an angle about and a displacement along one axis."""

from __future__ import annotations

from kane.model.constraints import Constraint
from kane.model.joints.closing import aligned, checked, on_axis
from kane.model.joints.joint import Joint, Names, SpeedNames, Twist, check_place, coordinates_of, fixed, made, reach
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
    check_place(name, at, parent)
    a = fixed(axis, parent, f"axis of {name!r}")
    q, s = coordinates_of(name, coordinates, {"q": "rad", "s": "m"})
    reached = (reach(name, at, a * s), parent.rotate(child or name, q, a))
    free = [Twist(a, Vector()), Twist(Vector(), a)]
    return made(
        name, "cylindrical", (at, parent), reached, [q, s], speeds, [q.dt, s.dt], [a], free, ("u_q", "u_s"), given=coordinates
    )  # fmt: skip


def close_cylindrical(
    name: str, at: Point, parent: Frame, point: Point, frame: Frame, *, axis: Vector
) -> tuple[Constraint, ...]:
    """A loop closed by a cylindrical joint, four configuration constraints: `point` on the line, `axis` the same in both frames."""
    checked(name, at, parent, point, frame)
    a = fixed(axis, parent, f"axis of {name!r}")
    return (*on_axis(name, a, at, parent, point), *aligned(name, a, parent, frame))
