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
    """A child frame turned by an angle q about `axis`; u = q̇.

    Parameters
    ----------
    name : of the joint; child, coordinate (q_name) and speed (u_name) are named after it where they are not given
    at, parent : the parent's joint point and frame
    axis : a unit vector fixed in the parent frame
    child : name of the child frame
    coordinates, speeds : names or symbols; speeds also as a mapping to definitions. By name they are in rad, m and per second
    """
    s = Seat("pin", name, at, parent, **called)
    a = s.axis(axis)
    (q,) = s.symbols(q="rad")
    return s.joint([q], s.turned(q, a), axes=[a], free=[Twist(a, Vector())])


@_called
def slider(name: str, at: Point, parent: Frame, *, axis: Vector, **called: Unpack[JointNames]) -> Joint:
    """A child that slides by q along `axis` of the parent; u = q̇. Arguments as for `kn.pin`."""
    s = Seat("slider", name, at, parent, **called)
    a = s.axis(axis)
    (q,) = s.symbols(q="m")
    return s.joint([q], s.turned(0, parent.x), a * q, axes=[a], free=[Twist(Vector(), a)])


@_called
def cylindrical(name: str, at: Point, parent: Frame, *, axis: Vector, **called: Unpack[JointNames]) -> Joint:
    """A child that turns by q about `axis` and slides by s along it; u_q = q̇, u_s = ṡ. Arguments as for `kn.pin`."""
    seated = Seat("cylindrical", name, at, parent, **called)
    a = seated.axis(axis)
    q, s = seated.symbols(q="rad", s="m")
    free = [Twist(a, Vector()), Twist(Vector(), a)]
    return seated.joint([q, s], seated.turned(q, a), a * s, axes=[a], free=free, stems=("u_q", "u_s"))


@_called
def screw(name: str, at: Point, parent: Frame, *, axis: Vector, pitch: Any, **called: Unpack[JointNames]) -> Joint:
    """A child that turns by q about `axis` and advances by `pitch`·q along it; u = q̇. Other arguments as for `kn.pin`.

    `pitch` is in m/rad, positive for a right-hand thread: a lead of l a turn is l/(2π).
    """
    s = Seat("screw", name, at, parent, **called)
    a, h = s.axis(axis), as_expr(pitch)
    (q,) = s.symbols(q="rad")
    return s.joint([q], s.turned(q, a), a * (h * q), axes=[a], free=[Twist(a, a * h)])


@_called
def planar(name: str, at: Point, parent: Frame, *, normal: Vector, **called: Unpack[JointNames]) -> Joint:
    """A child displaced by x e₁ + y e₂ in the plane across `normal`, then turned by q about it; u = (ẋ, ẏ, q̇).

    `normal` is a unit vector fixed in the parent frame, e₁ and e₂ are parent's, e₁ × e₂ = normal (x and y for z), in `joint.axes`
    after it. Other arguments as for `kn.pin`.
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
    """A child that turns by q1 about the first axis, fixed in the parent, then by q2 about the second, which turns with the cross.

    `axes` are two perpendicular unit vectors as they lie in the parent at q1 = 0; the second is fixed in the child too. u = q̇.
    The cross is the frame `joint.frame.parent`; it bears no mass. Other arguments as for `kn.pin`.
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
    """A child fixed to the parent: no coordinate, no speed."""
    s = Seat("weld", name, at, parent, child)
    return s.joint([], s.turned(0, parent.x))


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
    """A child that turns about a point; speeds are the measure numbers of its ω in the parent along its own axes.

    `orientation` is "euler parameters" (e0, e1, e2, e3; the scalar one first) or "angles", body-fixed ones in the given `sequence`,
    whose rates are singular at some configuration while u and u̇ are not. Other arguments as for `kn.pin`.
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
    """A child oriented as by `kn.ball`, at x, y, z along the parent's axes: coordinates and speeds stand in this order.

    Speeds are the measure numbers of its ω in the parent along its own axes, then those of the velocity of its joint point in the
    parent along the axes of the child or of the parent, as `velocity` says. Other arguments as for `kn.pin`.
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
