# SPDX-License-Identifier: BSD-3-Clause
"""Bodies: what has mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from kane.errors import ModelError
from kane.expr.node import Expr, as_expr
from kane.model.plausible import check_inertia, check_mass
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Dyadic
from kane.write.excerpt import excerpt


def _check_center(name: str, point: Any) -> None:
    if not isinstance(point, Point):
        raise ModelError(f"Expected a Point as the place of {name}, got {point!r:.60}.")
    if point.body is not None:
        raise ModelError(
            f"Expected a geometric point for {name}, got {point.name}, the particle of {point.body.name} that is there now. Make the "
            "point with at(...)."
        )


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Particle:
    """A particle: a mass at a point."""

    name: str
    point: Point
    mass: Expr

    def __init__(self, name: str, point: Point, mass: Any) -> None:
        m = as_expr(mass)
        check_mass(name, m)
        _check_center(name, point)
        for slot, value in (("name", name), ("point", point), ("mass", m)):
            object.__setattr__(self, slot, value)

    @property
    def mass_center(self) -> Point:
        """The particle's own place."""
        return self.point

    def __repr__(self) -> str:
        return f"Particle({self.name!r}, at {self.point.name})"


@dataclass(frozen=True, slots=True, eq=False, init=False)
class RigidBody:
    """A rigid body: frame, mass centre, mass and central inertia dyadic."""

    name: str
    frame: Frame
    mass_center: Point
    mass: Expr
    inertia: Dyadic

    def __init__(self, name: str, *, frame: Frame, mass_center: Point, mass: Any, inertia: Dyadic) -> None:
        m = as_expr(mass)
        check_mass(name, m)
        _check_center(name, mass_center)
        if not isinstance(frame, Frame):
            raise ModelError(f"Expected a Frame for the body {name}, got {frame!r:.60}.")
        if not isinstance(inertia, Dyadic):
            raise ModelError(
                f"Expected an inertia dyadic for {name}, such as kn.inertia({frame.name}, Ixx, Iyy, Izz), got "
                f"{type(inertia).__name__} ({excerpt(inertia)}). kn.rod, kn.thin_disk, kn.box, … make those of solids."
            )
        check_inertia(name, inertia)
        mass_center.frame._check(frame)
        values = (("name", name), ("frame", frame), ("mass_center", mass_center), ("mass", m), ("inertia", inertia))
        for slot, value in values:
            object.__setattr__(self, slot, value)

    def __repr__(self) -> str:
        return f"RigidBody({self.name!r}, frame {self.frame.name}, mass centre {self.mass_center.name})"


Body = Particle | RigidBody
