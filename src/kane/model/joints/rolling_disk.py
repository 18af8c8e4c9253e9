# SPDX-License-Identifier: BSD-3-Clause
"""A disk that touches a plane with its edge."""

from __future__ import annotations

from typing import Any

from kane.expr.node import ZERO, as_expr
from kane.model.joints.contact import Contact, positive, wheel_contact
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def disk_on_plane(
    name: str,
    wheel: Frame,
    center: Point,
    plane: Point,
    *,
    axis: Vector,
    radius: Any,
    normal: Vector,
    along: Vector | None = None,
    down: Vector | None = None,
) -> Contact:
    """The edge of a disk on a plane: contact at centre + R d, d down the disk's plane; valid for any lean but the flat one.

    Parameters
    ----------
    name : of the contact; its constraints are "name normal", "name 1" and "name 2"
    wheel, center : the disk's frame and centre
    plane : a point of the plane, fixed in the frame that `normal` is written in
    axis : of the disk, a unit vector fixed in it
    radius : of its edge, m
    normal : of the plane, a unit vector to the side on which the disk is
    along : the first direction of rolling, a unit vector in the plane; by default an axis of the normal's frame
    down : the unit vector d itself, where frames of the model have it: shorter equations
    """
    size = as_expr(radius)
    positive(size, f"radius of {name!r}")
    return wheel_contact(name, wheel, center, plane, normal, (size, axis), ZERO, along, down)
