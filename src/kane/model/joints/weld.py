# SPDX-License-Identifier: BSD-3-Clause
"""Weld: no motion; the force and torque in it can be asked for."""

from __future__ import annotations

from kane.model.constraints import Constraint
from kane.model.joints.closing import checked, oriented, together
from kane.model.joints.joint import Joint, check_place, made, reach, still
from kane.space.frame import Frame
from kane.space.point import Point


def weld(name: str, at: Point, parent: Frame, *, child: str = "") -> Joint:
    """A child fixed to the parent: no coordinate, no speed."""
    check_place(name, at, parent)
    return made(name, "weld", (at, parent), (reach(name, at), still(parent, child or name)), [], None, [], [], [])


def close_weld(name: str, at: Point, parent: Frame, point: Point, frame: Frame) -> tuple[Constraint, ...]:
    """A loop closed by a weld, six configuration constraints: `point` at `at`, `frame` oriented as `parent`."""
    checked(name, at, parent, point, frame)
    return (*together(name, at, point), *oriented(name, parent, frame))
