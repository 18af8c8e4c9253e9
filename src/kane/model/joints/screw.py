# SPDX-License-Identifier: BSD-3-Clause
"""Screw: an angle about an axis, and a displacement along it in proportion."""

from __future__ import annotations

from typing import Any

from kane.expr.node import as_expr
from kane.model.joints.joint import Joint, Names, SpeedNames, Twist, seat
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def screw(
    name: str,
    at: Point,
    parent: Frame,
    *,
    axis: Vector,
    pitch: Any,
    child: str = "",
    coordinates: Names = None,
    speeds: SpeedNames = None,
) -> Joint:
    """A child that turns by q about `axis` and advances by `pitch`·q along it; u = q̇. Other arguments as for `kn.pin`.

    `pitch` is in m/rad, positive for a right-hand thread: a lead of l a turn is l/(2π).
    """
    s = seat("screw", name, at, parent, child, coordinates, speeds)
    a, h = s.axis(axis), as_expr(pitch)
    (q,) = s.symbols(q="rad")
    return s.joint([q], s.turned(q, a), a * (h * q), axes=[a], free=[Twist(a, a * h)])
