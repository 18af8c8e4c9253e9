# SPDX-License-Identifier: BSD-3-Clause
"""Joints whose child turns in any direction, by Euler parameters or three angles: ball joint (spherical joint), and free."""

from typing import Literal

from kane.errors import ModelError
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate
from kane.model.joints.joint import Joint, Names, Seat, SpeedNames, Twist
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector

Orientation = Literal["euler parameters", "angles"]

_STEMS: dict[str, dict[str, str]] = {
    "euler parameters": dict.fromkeys(("e0", "e1", "e2", "e3"), "1"),
    "angles": dict.fromkeys(("q1", "q2", "q3"), "rad"),
}
"""Coordinates of each kind, with their units."""


def _turned(
    s: Seat, orientation: str, sequence: str, **lengths: str
) -> tuple[Frame, tuple[Coordinate, ...], list[Twist], list[Expr]]:
    """The child, turned by the coordinates before `lengths`; all coordinates, the free turns, ω along the child's axes."""
    if orientation not in _STEMS:
        raise ModelError(f"Expected orientation={' or '.join(map(repr, _STEMS))} for {s.name!r}, got {orientation!r}.")
    q = s.symbols(**_STEMS[orientation], **lengths)
    turning = q[: len(_STEMS[orientation])]
    if orientation == "angles":
        frame = s.parent.rotate_body(s.child, turning, sequence)
    else:
        frame = s.parent.rotate_euler_parameters(s.child, turning)
    w, axes = frame.angular_velocity(s.parent), (frame.x, frame.y, frame.z)
    return frame, q, [Twist(e, Vector()) for e in axes], [w.dot(e) for e in axes]


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
    s = Seat("ball", name, at, parent, child, coordinates, speeds)
    frame, q, free, spins = _turned(s, orientation, sequence)
    return s.joint(q, frame, free=free, stems=("u_x", "u_y", "u_z"), definitions=spins)


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
    """A child oriented as by `kn.ball`, at x, y, z along the parent's axes: coordinates and speeds stand in this order.

    Speeds are the measure numbers of its ω in the parent along its own axes, then those of the velocity of its joint point in the
    parent along the axes of the child or of the parent, as `velocity` says. Other arguments as for `kn.pin`.
    """
    s = Seat("free", name, at, parent, child, coordinates, speeds)
    if velocity not in ("child", "parent"):
        raise ModelError(f"Expected velocity='child' or 'parent' for {name!r}, got {velocity!r}.")
    frame, q, free, spins = _turned(s, orientation, sequence, x="m", y="m", z="m")
    x, y, z = q[-3:]
    offset = parent.x * x + parent.y * y + parent.z * z
    along = frame if velocity == "child" else parent
    v = offset.dt(parent)
    spins += [v.dot(e) for e in (along.x, along.y, along.z)]
    free += [Twist(Vector(), e) for e in (along.x, along.y, along.z)]
    stems = ("w_x", "w_y", "w_z", "v_x", "v_y", "v_z")
    return s.joint(q, frame, offset, free=free, stems=stems, definitions=spins)
