# SPDX-License-Identifier: BSD-3-Clause
"""Weld: no motion; the force and torque in it can be asked for."""

from __future__ import annotations

from kane.model.joints.joint import Joint, seat
from kane.space.frame import Frame
from kane.space.point import Point


def weld(name: str, at: Point, parent: Frame, *, child: str = "") -> Joint:
    """A child fixed to the parent: no coordinate, no speed."""
    s = seat("weld", name, at, parent, child)
    return s.joint([], s.turned(0, parent.x))
