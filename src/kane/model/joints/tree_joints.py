# SPDX-License-Identifier: BSD-3-Clause
"""Joints of the tree: pin, slider, cylindrical joint, screw, planar joint, universal joint, weld, ball joint (spherical) and free."""

from typing import Any, Literal, Unpack

from kane import expect
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import Coordinate
from kane.model.joints.joint import Joint, JointNames, Seat, Twist, across, mirrored, perpendicular_axes
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

_called = expect.keywords(*JointNames.__annotations__)


@_called
def pin(name: str, at: Point, parent: Frame, *, axis: Vector, **called: Unpack[JointNames]) -> Joint:
    """A pin (revolute) joint: the child frame turns by an angle q about `axis` of the parent; u = q̇.

    Parameters
    ----------
    name : of the joint; unless given, the child frame, the coordinate (q_name) and the speed (u_name) are named after it
    at, parent : the joint's point and frame on the parent
    axis : unit vector fixed in the parent frame
    child : name of the child frame
    coordinates, speeds : names or symbols; for speeds also a mapping of each to its definition. Coordinates made from names are in
        rad or m, speeds in rad/s or m/s
    """
    s = Seat("pin", name, at, parent, **called)
    a = s.axis(axis)
    (q,) = s.symbols(q="rad")
    return s.joint([q], s.turned(q, a), axes=[a], free=[Twist(a, Vector())])


@_called
def slider(name: str, at: Point, parent: Frame, *, axis: Vector, **called: Unpack[JointNames]) -> Joint:
    """A slider (prismatic joint): the child slides by q along `axis` of the parent; u = q̇. Arguments as for `kn.pin`."""
    s = Seat("slider", name, at, parent, **called)
    a = s.axis(axis)
    (q,) = s.symbols(q="m")
    return s.joint([q], s.turned(0, parent.x), a * q, axes=[a], free=[Twist(Vector(), a)])


@_called
def cylindrical(name: str, at: Point, parent: Frame, *, axis: Vector, **called: Unpack[JointNames]) -> Joint:
    """A cylindrical joint: the child turns by q about `axis`, slides by s along it; u_q = q̇, u_s = ṡ. Arguments as for `kn.pin`."""
    seated = Seat("cylindrical", name, at, parent, **called)
    a = seated.axis(axis)
    q, s = seated.symbols(q="rad", s="m")
    free = [Twist(a, Vector()), Twist(Vector(), a)]
    return seated.joint([q, s], seated.turned(q, a), a * s, axes=[a], free=free, stems=("u_q", "u_s"))


@_called
def screw(name: str, at: Point, parent: Frame, *, axis: Vector, pitch: Any, **called: Unpack[JointNames]) -> Joint:
    """A screw joint: the child turns by q about `axis` and advances by `pitch`·q along it; u = q̇. Other arguments as for `kn.pin`.

    `pitch` is in m/rad, positive for a right-hand thread: a lead of l per turn is a pitch of l/(2π).
    """
    s = Seat("screw", name, at, parent, **called)
    a, h = s.axis(axis), as_expr(pitch)
    (q,) = s.symbols(q="rad")
    return s.joint([q], s.turned(q, a), a * (h * q), axes=[a], free=[Twist(a, a * h)])


@_called
def planar(name: str, at: Point, parent: Frame, *, normal: Vector, **called: Unpack[JointNames]) -> Joint:
    """A planar joint: the child moves by x e₁ + y e₂ in the plane perpendicular to `normal`, and turns by q about it; u = (ẋ, ẏ, q̇).

    `normal` is a unit vector fixed in the parent frame. So are e₁ and e₂, with e₁ × e₂ = normal (x and y if normal is z);
    `joint.axes` is (normal, e₁, e₂). Other arguments as for `kn.pin`.
    """
    s = Seat("planar", name, at, parent, **called)
    n = s.axis(normal, "normal")
    e1, e2 = across(n, parent)
    x, y, q = s.symbols(x="m", y="m", q="rad")
    free = [Twist(Vector(), e1), Twist(Vector(), e2), Twist(n, Vector())]
    stems = ("u_x", "u_y", "u_q")
    return s.joint([x, y, q], s.turned(q, n), e1 * x + e2 * y, axes=[n, e1, e2], free=free, stems=stems)


@_called
def universal(
    name: str, at: Point, parent: Frame, *, axes: tuple[Vector, Vector], **called: Unpack[JointNames]
) -> Joint:
    """A universal (Cardan) joint: the child turns by q1 about an axis of the parent, then by q2 about an axis of the cross; u = q̇.

    `axes` are these two axes, perpendicular unit vectors given in the parent frame for q1 = 0; the second is fixed in the child
    too. The cross, without mass, is the frame `joint.frame.parent`. Other arguments as for `kn.pin`.
    """
    s = Seat("universal", name, at, parent, **called)
    first, second = perpendicular_axes(name, axes, parent)
    q1, q2 = s.symbols(q1="rad", q2="rad")
    cross = parent.rotate(f"{s.child}'", q1, first)
    turned = mirrored(second, parent, cross)
    free = [Twist(first, Vector()), Twist(turned, Vector())]
    frame = cross.rotate(s.child, q2, turned)
    return s.joint([q1, q2], frame, axes=[first, turned], free=free, stems=("u1", "u2"))


def weld(name: str, at: Point, parent: Frame, *, child: str = "") -> Joint:
    """A weld: a child frame fixed to the parent, without coordinates and speeds."""
    s = Seat("weld", name, at, parent, child)
    return s.joint([], s.turned(0, parent.x))


Orientation = Literal["euler parameters", "angles"]

_STEMS: dict[str, dict[str, str]] = {
    "euler parameters": dict.fromkeys(("e0", "e1", "e2", "e3"), "1"),
    "angles": dict.fromkeys(("q1", "q2", "q3"), "rad"),
}
"""Coordinates of each parametrization of orientation, with their units."""


def _turned(
    s: Seat, orientation: str, sequence: str, **lengths: str
) -> tuple[Frame, tuple[Coordinate, ...], list[Twist], list[Expr]]:
    """The child frame rotated by the coordinates before `lengths`; all coordinates, the free rotations, ω along the child's axes."""
    expect.that(orientation in _STEMS, f"orientation={' or '.join(map(repr, _STEMS))} for {s.name!r}", orientation)
    q = s.symbols(**_STEMS[orientation], **lengths)
    turning = q[: len(_STEMS[orientation])]
    if orientation == "angles":
        frame = s.parent.rotate_body(s.child, turning, sequence)
    else:
        frame = s.parent.rotate_euler_parameters(s.child, turning)
    w, axes = frame.angular_velocity(s.parent), (frame.x, frame.y, frame.z)
    return frame, q, [Twist(e, Vector()) for e in axes], [w.dot(e) for e in axes]


@_called
def ball(
    name: str,
    at: Point,
    parent: Frame,
    *,
    orientation: Orientation = "euler parameters",
    sequence: str = "xyz",
    **called: Unpack[JointNames],
) -> Joint:
    """A ball joint; its speeds are the measure numbers of the child's angular velocity in the parent along the child's axes.

    `orientation` is "euler parameters" (e0, e1, e2, e3; e0 the scalar one) or "angles": three body-fixed ones (rad) about the axes
    of `sequence`, whose rates are singular in some orientation, while u and u̇ are not. Other arguments as for `kn.pin`.
    """
    s = Seat("ball", name, at, parent, **called)
    frame, q, free, spins = _turned(s, orientation, sequence)
    return s.joint(q, frame, free=free, stems=("u_x", "u_y", "u_z"), definitions=spins)


@_called
def free(
    name: str,
    at: Point,
    parent: Frame,
    *,
    orientation: Orientation = "euler parameters",
    sequence: str = "xyz",
    velocity: Literal["child", "parent"] = "child",
    **called: Unpack[JointNames],
) -> Joint:
    """A joint with six degrees of freedom: the child's orientation as for `kn.ball`, and its position x, y, z along the parent's axes.

    Coordinates are those of orientation, then x, y, z. Speeds are the measure numbers of the child's angular velocity in the parent
    along the child's axes, then those of its joint point's velocity in the parent along the axes of the child or of the parent, as
    `velocity` says. Other arguments as for `kn.pin`.
    """
    s = Seat("free", name, at, parent, **called)
    expect.that(velocity in ("child", "parent"), f"velocity='child' or 'parent' for {name!r}", velocity)
    frame, q, free, spins = _turned(s, orientation, sequence, x="m", y="m", z="m")
    x, y, z = q[-3:]
    offset = parent.x * x + parent.y * y + parent.z * z
    along = frame if velocity == "child" else parent
    v = offset.dt(parent)
    spins += [v.dot(e) for e in (along.x, along.y, along.z)]
    free += [Twist(Vector(), e) for e in (along.x, along.y, along.z)]
    stems = ("w_x", "w_y", "w_z", "v_x", "v_y", "v_z")
    return s.joint(q, frame, offset, free=free, stems=stems, definitions=spins)
