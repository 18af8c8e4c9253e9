# SPDX-License-Identifier: BSD-3-Clause
"""Rack and pinion: teeth do not slip at the pitch point.

The multiplier is the tangential tooth force on the pinion along the rack. With the pinion on a pin and the rack on a slider of one
carrier it is the configuration constraint r (θ − φ) − s = 0, otherwise a motion constraint.
"""

from __future__ import annotations

from typing import Any

from kane.errors import ModelError
from kane.expr.build import mul, sub
from kane.expr.node import as_expr
from kane.model.constraints import Constraint, no_slip
from kane.model.joints.joint import Joint, fixed, numbers
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def rack_and_pinion(
    name: str,
    pinion: Joint | tuple[Frame, Point],
    rack: Joint | tuple[Frame, Point],
    *,
    radius: Any,
    axis: Vector | None = None,
    along: Vector | None = None,
    phase: Any = 0,
) -> Constraint:
    """A pinion meshes with a rack.

    Parameters
    ----------
    name : of the constraint
    pinion : its pin joint, or (frame, centre)
    rack : its slider, or (frame, any point fixed in it)
    radius : of the pinion's pitch circle, m
    axis : unit vector of the pinion's axis; that of its pin
    along : unit vector along the rack, fixed in a carrier of the pinion; the slider's axis. The teeth are on the side
        along × axis of the pinion, so that turning about +axis moves the rack along +along; for the other side reverse `along`
    phase : the angle φ of the pinion at s = 0, for joints of one carrier: list the constraint in holonomic=

    Returns
    -------
    Constraint
        a configuration constraint for a pin and a slider of one carrier, else a motion constraint, for nonholonomic=
    """
    n = axis if axis is not None else pinion.axis if isinstance(pinion, Joint) else None
    d = along if along is not None else rack.axis if isinstance(rack, Joint) else None
    if n is None or d is None:
        raise ModelError(f"Expected axis= and along= for {name!r}, which is not given by a pin and a slider.")
    (wheel, center), (bar, foot) = _side(name, pinion, "pin"), _side(name, rack, "slider")
    r = as_expr(radius)
    if abs(numbers([n.dot(d)])[0]) > 1e-9:
        raise ModelError(f"Expected the rack {name!r} across the pinion's axis, got {d} and {n}.")
    arm = d.cross(n) * r
    p = center.fixed_in(wheel, f"{name} {wheel.name}", arm)
    q = foot.fixed_in(bar, f"{name} {bar.name}", center.position(foot) + arm)
    slip = no_slip(p, q, along=d, name=name)[0]
    if not (isinstance(pinion, Joint) and isinstance(rack, Joint) and pinion.parent is rack.parent):
        return slip
    forward = numbers([fixed(rack.axis, rack.parent, "axis").dot(d), pinion.axis.dot(n)])
    s, turn = rack.coordinates[0], sub(pinion.coordinates[0], as_expr(phase))
    way = sub(mul(r, turn if forward[1] > 0 else -turn), s if forward[0] > 0 else -s)
    return Constraint(name, "configuration", way, slip.forces, slip.torques, "N")


def _side(name: str, part: Any, kind: str) -> tuple[Frame, Point]:
    if isinstance(part, Joint):
        if part.kind != kind:
            raise ModelError(f"Expected a {kind} joint for {name!r}, got {part.name!r}, a {part.kind} joint.")
        return part.frame, part.point
    if isinstance(part, tuple) and len(part) == 2 and isinstance(part[0], Frame) and isinstance(part[1], Point):
        return part
    raise ModelError(f"Expected a {kind} joint or (frame, point) for {name!r}, got {part!r:.60}.")
