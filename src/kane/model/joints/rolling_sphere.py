# SPDX-License-Identifier: BSD-3-Clause
"""A sphere on a plane."""

from __future__ import annotations

from typing import Any

from kane.expr.node import as_expr
from kane.model.joints.contact import Contact, positive, wheel_contact
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def sphere_on_plane(
    name: str,
    wheel: Frame,
    center: Point,
    plane: Point,
    *,
    radius: Any,
    normal: Vector,
    along: Vector | None = None,
) -> Contact:
    """A sphere on a plane: contact at centre − r n. Arguments as for `kn.disk_on_plane`."""
    size = as_expr(radius)
    positive(size, f"radius of {name!r}")
    return wheel_contact(name, wheel, center, plane, normal, None, size, along, None)
