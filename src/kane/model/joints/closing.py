# SPDX-License-Identifier: BSD-3-Clause
"""What loop closures are made of.

`kn.close_pin(name, at, parent, point, frame, axis=…)` demands of a point and frame that exist what `kn.pin(name, at, parent,
axis=…)` makes them be, and so for each joint. The constraints of a closure are named after it: "G x", "G y", …; their
multipliers are the forces and torques on the side of `point` and `frame`, and `eom.reaction("G")` is all of them together.
"""

from __future__ import annotations

from typing import Any

from kane.errors import ModelError
from kane.model.constraints import Constraint, coincident, perpendicular
from kane.model.joints.joint import across, check_place
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def checked(name: str, at: Any, parent: Any, point: Any, frame: Any) -> None:
    """Both sides of a closure are points and frames."""
    check_place(name, at, parent)
    check_place(name, point, frame)
    if parent is frame:
        raise ModelError(f"Expected two different frames to close a loop by {name!r}, got {parent.name} twice.")


def mirrored(v: Vector, frame: Frame, other: Frame) -> Vector:
    """The vector with the same measure numbers in the other frame."""
    return Vector(((other, v.components(frame)),))


def together(name: str, at: Point, point: Point) -> tuple[Constraint, ...]:
    """Two points coincide; forces along the inertial axes."""
    n = at.root().frame
    return coincident(point, at, (n.x, n.y, n.z), name=name)


def on_axis(name: str, axis: Vector, at: Point, parent: Frame, point: Point) -> tuple[Constraint, ...]:
    """`point` stays on the line through `at`; forces along axes of the parent."""
    return tuple(
        c
        for k, e in enumerate(across(axis, parent), 1)
        for c in coincident(point, at, e, name=f"{name} across{k}")
    )  # fmt: skip


def aligned(name: str, axis: Vector, parent: Frame, frame: Frame) -> tuple[Constraint, ...]:
    """The axis has the same direction in both frames."""
    turned = mirrored(axis, parent, frame)
    return tuple(perpendicular(turned, e, name=f"{name} tilt{k}") for k, e in enumerate(across(axis, parent), 1))


def oriented(name: str, parent: Frame, frame: Frame) -> tuple[Constraint, ...]:
    """Both frames have one orientation; it also vanishes where axes are opposite, half a turn away."""
    pairs = ((frame.y, parent.z), (frame.z, parent.x), (frame.x, parent.y))
    return tuple(perpendicular(b, a, name=f"{name} turn{k}") for k, (b, a) in enumerate(pairs, 1))
