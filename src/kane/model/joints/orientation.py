# SPDX-License-Identifier: BSD-3-Clause
"""The orientation of a child that turns in any direction: Euler parameters, or three angles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from kane.errors import ModelError
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate
from kane.space.frame import Frame

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
