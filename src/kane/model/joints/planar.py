# SPDX-License-Identifier: BSD-3-Clause
"""Planar joint: two displacements in a plane and an angle about its normal."""

from __future__ import annotations

from kane.model.constraints import Constraint, coincident
from kane.model.joints.closing import aligned, checked
from kane.model.joints.joint import (
    Joint,
    Names,
    SpeedNames,
    Twist,
    across,
    check_place,
    coordinates_of,
    fixed,
    made,
    reach,
)
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
    check_place(name, at, parent)
    n = fixed(normal, parent, f"normal of {name!r}")
    e1, e2 = across(n, parent)
    x, y, q = coordinates_of(name, coordinates, {"x": "m", "y": "m", "q": "rad"})
    reached = (reach(name, at, e1 * x + e2 * y), parent.rotate(child or name, q, n))
    free = [Twist(Vector(), e1), Twist(Vector(), e2), Twist(n, Vector())]
    stems = ("u_x", "u_y", "u_q")
    return made(
        name, "planar", (at, parent), reached, [x, y, q], speeds, [x.dt, y.dt, q.dt], [n, e1, e2], free, stems, given=coordinates
    )  # fmt: skip


def close_planar(
    name: str, at: Point, parent: Frame, point: Point, frame: Frame, *, normal: Vector
) -> tuple[Constraint, ...]:
    """A loop closed by a planar joint, three configuration constraints: `point` in the plane, `normal` the same in both frames."""
    checked(name, at, parent, point, frame)
    n = fixed(normal, parent, f"normal of {name!r}")
    return (*coincident(point, at, n, name=f"{name} normal"), *aligned(name, n, parent, frame))
