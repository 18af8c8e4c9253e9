# SPDX-License-Identifier: BSD-3-Clause
"""A wheel with a rounded rim, a torus, on a plane."""

from __future__ import annotations

from typing import Any

from kane.expr.node import as_expr
from kane.model.joints.contact import Contact, positive, wheel_contact
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def torus_on_plane(
    name: str,
    wheel: Frame,
    center: Point,
    plane: Point,
    *,
    axis: Vector,
    radius: Any,
    crown: Any,
    normal: Vector,
    along: Vector | None = None,
    down: Vector | None = None,
) -> Contact:
    """A torus-rimmed wheel on a plane: contact at centre + R d − r n; valid for any lean but the flat one.

    `radius` R is that of the circle on which the crown's centres lie, `crown` r that of the rounding: upright, the centre is
    R + r high. Other arguments as for `kn.disk_on_plane`.
    """
    large, small = as_expr(radius), as_expr(crown)
    positive(large, f"radius of {name!r}")
    positive(small, f"crown radius of {name!r}")
    return wheel_contact(name, wheel, center, plane, normal, (large, axis), small, along, down)
