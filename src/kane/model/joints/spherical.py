# SPDX-License-Identifier: BSD-3-Clause
"""Joints whose child turns in any direction, by Euler parameters or three angles: ball joint (spherical joint), and free."""

from collections.abc import Sequence
from typing import Literal

from kane.errors import ModelError
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate
from kane.model.joints.joint import Joint, Names, SpeedNames, Twist, seat
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector

Orientation = Literal["euler parameters", "angles"]

STEMS: dict[str, dict[str, str]] = {
    "euler parameters": dict.fromkeys(("e0", "e1", "e2", "e3"), "1"),
    "angles": dict.fromkeys(("q1", "q2", "q3"), "rad"),
}
"""Coordinates of each kind, with their units."""


def check_orientation(name: str, orientation: str) -> None:
    """One of the kinds."""
    if orientation not in STEMS:
        raise ModelError(f"Expected orientation={' or '.join(map(repr, STEMS))} for {name!r}, got {orientation!r}.")


def oriented_child(
    parent: Frame, child: str, coordinates: Sequence[Coordinate], orientation: str, sequence: str
) -> Frame:
    """The child frame."""
    if orientation == "angles":
        return parent.rotate_body(child, coordinates, sequence)
    return parent.rotate_euler_parameters(child, coordinates)


def spins(parent: Frame, frame: Frame) -> list[Expr]:
    """ω of the child in the parent along the child's axes."""
    w = frame.angular_velocity(parent)
    return [w.dot(e) for e in (frame.x, frame.y, frame.z)]


def ball(
    name: str,
    at: Point,
    parent: Frame,
    *,
    orientation: Orientation = "euler parameters",
    sequence: str = "xyz",
    child: str = "",
    coordinates: Names = None,
    speeds: SpeedNames = None,
) -> Joint:
    """A child that turns about a point; speeds are the measure numbers of its ω in the parent along its own axes.

    `orientation` is "euler parameters" (e0, e1, e2, e3; the scalar one first) or "angles", body-fixed ones in the given `sequence`,
    whose rates are singular at some configuration while u and u̇ are not. Other arguments as for `kn.pin`.
    """
    s = seat("ball", name, at, parent, child, coordinates, speeds)
    check_orientation(name, orientation)
    q = s.symbols(**STEMS[orientation])
    frame = oriented_child(parent, s.child, q, orientation, sequence)
    free = [Twist(e, Vector()) for e in (frame.x, frame.y, frame.z)]
    return s.joint(q, frame, free=free, stems=("u_x", "u_y", "u_z"), definitions=spins(parent, frame))


def free(
    name: str,
    at: Point,
    parent: Frame,
    *,
    orientation: Orientation = "euler parameters",
    sequence: str = "xyz",
    velocity: Literal["child", "parent"] = "child",
    child: str = "",
    coordinates: Names = None,
    speeds: SpeedNames = None,
) -> Joint:
    """A child at x, y, z along the parent's axes, oriented as by `kn.ball`.

    Speeds are the measure numbers of its ω in the parent along its own axes, then those of the velocity of its joint point in the
    parent along the axes of the child or of the parent, as `velocity` says. Other arguments as for `kn.pin`.
    """
    s = seat("free", name, at, parent, child, coordinates, speeds)
    check_orientation(name, orientation)
    if velocity not in ("child", "parent"):
        raise ModelError(f"Expected velocity='child' or 'parent' for {name!r}, got {velocity!r}.")
    q = s.symbols(x="m", y="m", z="m", **STEMS[orientation])
    x, y, z = q[:3]
    offset = parent.x * x + parent.y * y + parent.z * z
    frame = oriented_child(parent, s.child, q[3:], orientation, sequence)
    along = frame if velocity == "child" else parent
    v = offset.dt(parent)
    definitions = [*spins(parent, frame), *(v.dot(e) for e in (along.x, along.y, along.z))]
    free = [Twist(e, Vector()) for e in (frame.x, frame.y, frame.z)]
    free += [Twist(Vector(), e) for e in (along.x, along.y, along.z)]
    stems = ("w_x", "w_y", "w_z", "v_x", "v_y", "v_z")
    return s.joint(q, frame, offset, free=free, stems=stems, definitions=definitions)
