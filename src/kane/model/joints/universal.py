# SPDX-License-Identifier: BSD-3-Clause
"""Universal joint (Cardan, Hooke): two pins whose axes cross at right angles, with a massless cross between."""

from __future__ import annotations

from typing import Any

from kane.errors import ModelError
from kane.expr.node import ZERO
from kane.model.constraints import Constraint, perpendicular
from kane.model.joints.closing import checked, mirrored, together
from kane.model.joints.joint import (
    Joint,
    Names,
    SpeedNames,
    Twist,
    check_place,
    coordinates_of,
    fixed,
    made,
    numbers,
    reach,
)
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector


def universal(
    name: str,
    at: Point,
    parent: Frame,
    *,
    axes: tuple[Vector, Vector],
    child: str = "",
    coordinates: Names = None,
    speeds: SpeedNames = None,
) -> Joint:
    """A child that turns by q1 about the first axis, fixed in the parent, then by q2 about the second, which turns with the cross.

    `axes` are two perpendicular unit vectors as they lie in the parent at q1 = 0; the second is fixed in the child too. u = q̇.
    The cross is the frame `joint.frame.parent`; it bears no mass. Other arguments as for `kn.pin`.
    """
    check_place(name, at, parent)
    first, second = _axes(name, axes, parent)
    q1, q2 = coordinates_of(name, coordinates, {"q1": "rad", "q2": "rad"})
    cross = parent.rotate(f"{child or name}'", q1, first)
    turned = mirrored(second, parent, cross)
    reached = (reach(name, at), cross.rotate(child or name, q2, turned))
    free = [Twist(first, Vector()), Twist(turned, Vector())]
    q, u = (q1, q2), (q1.dt, q2.dt)
    return made(
        name, "universal", (at, parent), reached, q, speeds, u, [first, turned], free, ("u1", "u2"), given=coordinates
    )  # fmt: skip


def close_universal(
    name: str, at: Point, parent: Frame, point: Point, frame: Frame, *, axes: tuple[Vector, Vector]
) -> tuple[Constraint, ...]:
    """A loop closed by a universal joint, four configuration constraints: `point` stays at `at`, the axes stay perpendicular.

    `axes` are given in the parent; the second is the vector with the same measure numbers in `frame`.
    """
    checked(name, at, parent, point, frame)
    first, second = _axes(name, axes, parent)
    cross = perpendicular(mirrored(second, parent, frame), first, name=f"{name} cross")
    return (*together(name, at, point), cross)


def _axes(name: str, axes: Any, parent: Frame) -> tuple[Vector, Vector]:
    if not isinstance(axes, tuple | list) or len(axes) != 2:
        raise ModelError(f"Expected axes=two perpendicular unit vectors for {name!r}, got {axes!r:.60}.")
    first, second = (fixed(a, parent, f"axis of {name!r}") for a in axes)
    product = first.dot(second)
    if product is not ZERO and abs(numbers([product])[0]) > 1e-9:
        raise ModelError(f"Expected perpendicular axes for the universal joint {name!r}, got {first} and {second}.")
    return first, second
