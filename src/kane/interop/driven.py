# SPDX-License-Identifier: BSD-3-Clause
"""Coordinates for what a source moves by velocities alone, which it has none for: each with the rate that the velocity gives it.

A point moves by a length for each component of its velocity. A frame turns by an angle where its axis stands still, else by Euler
parameters, whose quasi-rates are the components of its angular velocity.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Coordinate, rate
from kane.space.frame import Frame, Point
from kane.space.vector import Vector, axes

New = Callable[[str], Coordinate]
"""A coordinate for what is called x, y, z, angle, e0, …."""


@dataclass(frozen=True, slots=True, eq=False)
class GivenRates:
    """Coordinates, and their rates or quasi-rates, each with what it is."""

    coordinates: tuple[Coordinate, ...]
    rates: tuple[tuple[Expr, Expr], ...]


def moved(start: Point, name: str, frame: Frame, velocity: Sequence[Expr], new: New) -> tuple[Point, GivenRates]:
    """A point that moves from another one by a velocity, given along the axes of a frame."""
    moving = [
        (axis, new(letter), v) for axis, letter, v in zip(axes(frame), "xyz", velocity, strict=True) if v is not ZERO
    ]
    offset = sum((axis * q for axis, q, _ in moving), Vector())
    return start.at(name, offset), GivenRates(tuple(q for _, q, _ in moving), tuple((rate(q), v) for _, q, v in moving))


def turned_about(base: Frame, name: str, axis: int, spin: Expr, new: New) -> tuple[Frame, GivenRates]:
    """A frame that turns about an axis of another one."""
    angle = new("angle")
    return base.rotate(name, angle, axes(base)[axis]), GivenRates((angle,), ((rate(angle), spin),))


def turned_freely(base: Frame, name: str, new: New) -> tuple[Frame, tuple[Coordinate, ...]]:
    """A frame that turns in another one by Euler parameters."""
    e = tuple(new(f"e{k}") for k in range(4))
    return base.rotate_euler_parameters(name, e), e


def spinning(frame: Frame, spin: Iterable[Expr]) -> GivenRates:
    """The Euler parameters of a frame, by its angular velocity along its own axes."""
    turn = frame.orientation
    assert turn is not None
    return GivenRates(turn.parameters, tuple(zip(turn.quasi, spin, strict=True)))
