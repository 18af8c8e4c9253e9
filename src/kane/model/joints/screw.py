# SPDX-License-Identifier: BSD-3-Clause
"""Screw: an angle about an axis, and a displacement along it in proportion."""

from __future__ import annotations

from typing import Any

from kane.errors import ModelError
from kane.expr.build import cos, sin
from kane.expr.node import ZERO, Expr, as_expr
from kane.model.constraints import Constraint
from kane.model.joints.closing import aligned, checked, mirrored, on_axis
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
from kane.space.frame import Frame, frames_of
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
    check_place(name, at, parent)
    a, h = fixed(axis, parent, f"axis of {name!r}"), as_expr(pitch)
    (q,) = coordinates_of(name, coordinates, {"q": "rad"})
    reached = (reach(name, at, a * (h * q)), parent.rotate(child or name, q, a))
    return made(name, "screw", (at, parent), reached, [q], speeds, [q.dt], [a], [Twist(a, a * h)], given=coordinates)


def close_screw(
    name: str, at: Point, parent: Frame, point: Point, frame: Frame, *, axis: Vector, pitch: Any
) -> tuple[Constraint, ...]:
    """A loop closed by a screw, five configuration constraints: as a cylindrical joint, and the thread.

    With s the advance, e₂ the second of the parent's vectors across the axis turned by s/pitch, and b₁ the frame's first one, the
    thread is b₁·e₂ = 0: it holds for any number of turns. Its multiplier is the torque about the axis that the thread exerts.
    """
    checked(name, at, parent, point, frame)
    a, h = fixed(axis, parent, f"axis of {name!r}"), as_expr(pitch)
    if h is ZERO:
        raise ModelError(f"Expected a pitch that is not zero for the screw {name!r}: use kn.close_pin.")
    return (
        *on_axis(name, a, at, parent, point),
        *aligned(name, a, parent, frame),
        _thread(name, at, point, a, h, frame),
    )


def _thread(name: str, at: Point, point: Point, a: Vector, h: Expr, frame: Frame) -> Constraint:
    (parent,) = frames_of(a)
    p1, p2 = across(a, parent)
    b1 = mirrored(p1, parent, frame)
    r = point.position(at)
    turn = r.dot(a) / h
    e1, e2 = p1 * cos(turn) + p2 * sin(turn), p2 * cos(turn) - p1 * sin(turn)
    torque, push = b1.cross(e2), a * (-b1.dot(e1) / h)
    return Constraint(
        f"{name} thread",
        "configuration",
        b1.dot(e2),
        ((point, push), (at, -push)),
        ((frame, torque), (parent, -torque - r.cross(push))),
        "N*m",
    )
