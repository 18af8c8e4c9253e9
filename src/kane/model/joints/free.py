# SPDX-License-Identifier: BSD-3-Clause
"""A child that is free: six degrees of freedom from its parent."""

from __future__ import annotations

from typing import Literal

from kane.errors import ModelError
from kane.model.joints.joint import Joint, Names, SpeedNames, Twist, seat
from kane.model.joints.orientation import STEMS, Orientation, check_orientation, oriented_child, spins
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


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
