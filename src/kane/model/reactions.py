# SPDX-License-Identifier: BSD-3-Clause
"""Noncontributing forces brought into evidence: reactions by name, and explicit auxiliary speeds.

A reaction cuts the tree: everything reached through its point (or frame) is the far side and gets the auxiliary velocity
u_a n. It is an action–reaction pair, +R n on the far side and −R n on the near one. Declaring one changes nothing; listing it
in `System(reactions=…)` does.
"""

from typing import NamedTuple

from kane import expect
from kane.errors import ReactionError, cut
from kane.expr.node import Expr
from kane.expr.symbols import AuxiliarySpeed, Reaction
from kane.model.constraints import Constraint
from kane.model.directions import is_unit, length
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Parts, Vector


class Cut(NamedTuple):
    """Where an auxiliary speed acts: at a point, or on a frame, along a direction."""

    at: Point | Frame
    parts: Parts

    @property
    def along(self) -> Vector:
        """The direction."""
        return Vector(self.parts)


def _cut(kind: str, name: str, at: Point | None, frame: Frame | None, along: Vector | None) -> Cut:
    if (at is None) == (frame is None):
        raise ReactionError(
            f"Expected {kind} {name!r} at=point for a force or frame=frame for a torque, got "
            f"{'both' if at is not None else 'neither'}."
        )
    place = at if at is not None else frame
    expect.instance(
        place, Point if at is not None else Frame, f"at=Point or frame=Frame for {kind} {name!r}", error=ReactionError
    )
    assert place is not None
    if place.parent is None:
        raise ReactionError(
            f"Expected a place of {kind} {name!r} that has a near side, got {place!r}, which is a root. Make the cut explicit: "
            f"{place.name}.{'at' if at is not None else 'rotate'}(…)."
        )
    if isinstance(place, Point) and place.body is not None:
        raise ReactionError(
            f"Expected a geometric point for {kind} {name!r}, got {place.name}, a particle: nothing is reached through it."
        )
    expected = f"along=unit vector for {kind} {name!r}"
    if not isinstance(along, Vector) or along.is_zero:
        raise expect.refusal(ReactionError, expected, cut(repr(along)))
    if not is_unit(along):
        raise ReactionError(
            f"Expected {expected}, got {cut(repr(along))} of length {length(along):.6g}: the reaction would not be measured in "
            "units of force. Use along.normalized()."
        )
    return Cut(place, along.parts)


def reaction(
    name: str,
    at: Point | None = None,
    along: Vector | None = None,
    frame: Frame | None = None,
    unit: str = "",
    *,
    constraint: Constraint | None = None,
) -> Reaction:
    """A force (`at` a point) or torque (on a `frame`) along a unit vector that the far side feels from the near side.

    With `constraint` it is that constraint's multiplier: the force or torque that holds it. Without any place it is a bare
    unknown for use with explicit auxiliary speeds.
    """
    if constraint is not None:
        other: object = constraint
        alone = isinstance(other, Constraint) and all(x is None for x in (at, frame, along))
        expected = f"constraint=one Constraint, and no other place, for the reaction {name!r}"
        expect.that(alone, expected, other, error=ReactionError)
        return Reaction.declare(name, None, unit or constraint.unit, "", constraint)
    if at is None and frame is None and along is None:
        return Reaction.declare(name, None, unit, "", None)
    place = _cut("the reaction", name, at, frame, along)
    return Reaction.declare(name, None, unit or ("N" if at is not None else "N*m"), "", place)


def auxiliary_speed(
    name: str, at: Point | None = None, along: Vector | None = None, frame: Frame | None = None
) -> AuxiliarySpeed:
    """An explicit auxiliary speed: the velocity u_a n of everything reached through the point or frame, zero throughout.

    List it in `System(auxiliary_speeds=…)` with one bare reaction for each, and write the force it brings into evidence as a load.
    """
    cut = _cut("the auxiliary speed", name, at, frame, along)
    return AuxiliarySpeed.declare(name, None, "m/s" if at is not None else "rad/s", "", cut)


def cut_of(symbol: Expr) -> Cut | None:
    """The cut of a reaction or auxiliary speed, None for a bare unknown."""
    place = getattr(symbol, "place", None)
    return place if isinstance(place, Cut) else None


def constraint_of(symbol: Expr) -> Constraint | None:
    """The constraint whose multiplier a reaction is, None for any other symbol."""
    place = getattr(symbol, "place", None)
    return place if isinstance(place, Constraint) else None
