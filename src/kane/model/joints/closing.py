# SPDX-License-Identifier: BSD-3-Clause
"""Loop closures: the constraints of each joint between points and frames that already exist.

`kn.close_pin(name, at, parent, point, frame, axis=…)` constrains `point` and `frame` as `kn.pin(name, at, parent, axis=…)` would. The
constraints of a closure are named after it: "G x", "G y", …; their multipliers are the forces and torques on the side of `point`
and `frame`, and `eom.reaction("G")` is all of them together.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

from kane.errors import ModelError
from kane.expr.build import cos, sin
from kane.expr.node import ONE, ZERO, Expr, as_expr
from kane.model.constraints import ClosureBranch, Constraint, Constraints, coincident, perpendicular
from kane.model.joints.joint import across, check_attachment, fixed, mirrored, perpendicular_axes
from kane.space.frame import Frame, Point
from kane.space.vector import Vector


class Closing(NamedTuple):
    """Both sides of a closure, its axes, fixed in the parent, and the pitch of a screw."""

    name: str
    at: Point
    parent: Frame
    point: Point
    frame: Frame
    axes: tuple[Vector, ...] = ()
    pitch: Expr = ONE


def _together(c: Closing) -> Constraints:
    """The points coincide; the multipliers are forces along the inertial axes."""
    n = c.at.root().frame
    return coincident(c.point, c.at, (n.x, n.y, n.z), name=c.name)


def _on_axis(c: Closing) -> Constraints:
    """The point stays on the line through `at`; the multipliers are forces along axes of the parent."""
    pairs = enumerate(across(c.axes[0], c.parent), 1)
    return tuple(x for k, e in pairs for x in coincident(c.point, c.at, e, name=f"{c.name} across{k}"))


def _in_plane(c: Closing) -> Constraints:
    """The point stays in the plane through `at`."""
    return coincident(c.point, c.at, c.axes[0], name=f"{c.name} normal")


def _meant(c: Closing, what: str, cosine: Expr, rows: Constraints) -> Constraints:
    """The rows with the intended branch: these products of axes also vanish at other orientations."""
    branch = ClosureBranch(c.name, what, cosine, tuple(x.expr for x in rows))
    return tuple(replace(x, branch=branch) for x in rows)


def _aligned(c: Closing) -> Constraints:
    """The axis has the same direction in both frames; the rows also vanish for opposite directions, which the branch excludes."""
    turned = mirrored(c.axes[0], c.parent, c.frame)
    pairs = enumerate(across(c.axes[0], c.parent), 1)
    rows = tuple(perpendicular(turned, e, name=f"{c.name} tilt{k}") for k, e in pairs)
    return _meant(c, "axis", turned.dot(c.axes[0]), rows)


def _oriented(c: Closing) -> Constraints:
    """Both frames have the same orientation; the rows also vanish after three half turns and four third turns, other branches."""
    a, b = c.parent, c.frame
    pairs = ((b.y, a.z), (b.z, a.x), (b.x, a.y))
    rows = tuple(perpendicular(v, w, name=f"{c.name} turn{k}") for k, (v, w) in enumerate(pairs, 1))
    return _meant(c, "frame", (a.x.dot(b.x) + a.y.dot(b.y) + a.z.dot(b.z) - 1) / 2, rows)


def _cross(c: Closing) -> Constraints:
    """The second axis, fixed in the frame, stays perpendicular to the first."""
    first, second = c.axes
    return (perpendicular(mirrored(second, c.parent, c.frame), first, name=f"{c.name} cross"),)


def _thread(c: Closing) -> Constraints:
    """b₁·e₂ = 0 for b₁ of the frame perpendicular to the axis, and e₂ of the parent rotated by the advance divided by the pitch."""
    (a,) = c.axes
    p1, p2 = across(a, c.parent)
    b1 = mirrored(p1, c.parent, c.frame)
    r = c.point.position(c.at)
    turn = r.dot(a) / c.pitch
    e1, e2 = p1 * cos(turn) + p2 * sin(turn), p2 * cos(turn) - p1 * sin(turn)
    torque, push = b1.cross(e2), a * (-b1.dot(e1) / c.pitch)
    forces = ((c.point, push), (c.at, -push))
    torques = ((c.frame, torque), (c.parent, -torque - r.cross(push)))
    thread = Constraint(f"{c.name} thread", "configuration", b1.dot(e2), forces, torques, "N*m")
    return _meant(c, "thread", b1.dot(e1), (thread,))


_CLOSURES: dict[str, tuple[Callable[[Closing], Constraints], ...]] = {
    "pin": (_together, _aligned),
    "slider": (_on_axis, _oriented),
    "cylindrical": (_on_axis, _aligned),
    "screw": (_on_axis, _aligned, _thread),
    "universal": (_together, _cross),
    "ball": (_together,),
    "planar": (_in_plane, _aligned),
    "weld": (_together, _oriented),
}
"""The constraints that close a loop by each kind of joint."""


def _closed(kind: str, c: Closing, what: str = "axis") -> Constraints:
    check_attachment(c.name, c.at, c.parent)
    check_attachment(c.name, c.point, c.frame)
    if c.parent is c.frame:
        raise ModelError(f"Expected two different frames to close a loop by {c.name!r}, got {c.parent.name} twice.")
    checked = c._replace(axes=tuple(fixed(a, c.parent, f"{what} of {c.name!r}") for a in c.axes))
    return tuple(x for piece in _CLOSURES[kind] for x in piece(checked))


def close_pin(name: str, at: Point, parent: Frame, point: Point, frame: Frame, *, axis: Vector) -> Constraints:
    """A loop closed by a pin, five configuration constraints: `point` coincides with `at`, `axis` is fixed in both frames.

    Their multipliers are three forces along the inertial axes and two torques perpendicular to `axis`, fixed in `parent`, that act
    on the side of `point` and `frame`.
    """
    return _closed("pin", Closing(name, at, parent, point, frame, (axis,)))


def close_slider(name: str, at: Point, parent: Frame, point: Point, frame: Frame, *, axis: Vector) -> Constraints:
    """A loop closed by a slider, five configuration constraints: `point` stays on the axis, `frame` stays parallel to `parent`."""
    return _closed("slider", Closing(name, at, parent, point, frame, (axis,)))


def close_cylindrical(name: str, at: Point, parent: Frame, point: Point, frame: Frame, *, axis: Vector) -> Constraints:
    """A loop closed by a cylindrical joint, four configuration constraints: `point` stays on `axis`, which is fixed in both frames."""
    return _closed("cylindrical", Closing(name, at, parent, point, frame, (axis,)))


def close_screw(
    name: str, at: Point, parent: Frame, point: Point, frame: Frame, *, axis: Vector, pitch: Any
) -> Constraints:
    """A loop closed by a screw joint, five configuration constraints: those of a cylindrical joint, and one of the thread.

    The thread, of `pitch` (m/rad), relates the angle of the frame to its advance s: with e₁, e₂ of the parent perpendicular to the
    axis and turned by s/pitch, and b₁ of the frame, b₁·e₂ = 0 and b₁·e₁ > 0, which holds over many turns. Its multiplier is the
    torque about the axis that the thread exerts.
    """
    h = as_expr(pitch)
    if h is ZERO:
        raise ModelError(f"Expected a pitch that is not zero for the screw {name!r}: use kn.close_pin.")
    return _closed("screw", Closing(name, at, parent, point, frame, (axis,), h))


def close_universal(
    name: str, at: Point, parent: Frame, point: Point, frame: Frame, *, axes: tuple[Vector, Vector]
) -> Constraints:
    """A loop closed by a universal joint, four configuration constraints: `point` coincides with `at`, the axes stay perpendicular.

    `axes` are written in `parent`; the second is fixed in `frame`, with the same measure numbers there.
    """
    return _closed("universal", Closing(name, at, parent, point, frame, perpendicular_axes(name, axes, parent)))


def close_ball(name: str, at: Point, parent: Frame, point: Point, frame: Frame) -> Constraints:
    """A loop closed by a ball joint, three configuration constraints: `point` of the body `frame` coincides with `at` of `parent`."""
    return _closed("ball", Closing(name, at, parent, point, frame))


def close_planar(name: str, at: Point, parent: Frame, point: Point, frame: Frame, *, normal: Vector) -> Constraints:
    """A loop closed by a planar joint, three configuration constraints: `point` stays in the plane, `normal` fixed in both frames."""
    return _closed("planar", Closing(name, at, parent, point, frame, (normal,)), "normal")


def close_weld(name: str, at: Point, parent: Frame, point: Point, frame: Frame) -> Constraints:
    """A loop closed by a weld, six configuration constraints: `point` coincides with `at`, `frame` stays parallel to `parent`."""
    return _closed("weld", Closing(name, at, parent, point, frame))
