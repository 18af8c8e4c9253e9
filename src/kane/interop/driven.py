# SPDX-License-Identifier: BSD-3-Clause
"""Additional coordinates for points and frames that an imported model moves by velocities only; their rates are these velocities.

A point is displaced by a length for each component of its velocity. A frame is rotated by an angle if its axis is fixed, else by Euler
parameters, whose quasi-rates are the components of its angular velocity. Independent kinematical equations then define speeds.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from kane.errors import ModelError
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Coordinate, rate
from kane.numeric.arrays import Array
from kane.numeric.scale import SPEEDS_RANK
from kane.space.frame import Frame, Point
from kane.space.vector import Vector, axes

New = Callable[[str], Coordinate]
"""Makes a coordinate from the suffix of its name: x, y, z, angle, e0, …."""


@dataclass(frozen=True, slots=True, eq=False)
class GivenRates:
    """Coordinates, and pairs of a rate or quasi-rate and its value."""

    coordinates: tuple[Coordinate, ...]
    rates: tuple[tuple[Expr, Expr], ...]


def moved(start: Point, name: str, frame: Frame, velocity: Sequence[Expr], new: New) -> tuple[Point, GivenRates]:
    """A point displaced from another one, with a velocity relative to it along the axes of a frame."""
    moving = [
        (axis, new(letter), v) for axis, letter, v in zip(axes(frame), "xyz", velocity, strict=True) if v is not ZERO
    ]
    offset = sum((axis * q for axis, q, _ in moving), Vector())
    return start.at(name, offset), GivenRates(tuple(q for _, q, _ in moving), tuple((rate(q), v) for _, q, v in moving))


def turned_about(base: Frame, name: str, axis: int, spin: Expr, new: New) -> tuple[Frame, GivenRates]:
    """A frame rotated about an axis of another one, with the rate `spin`."""
    angle = new("angle")
    return base.rotate(name, angle, axes(base)[axis]), GivenRates((angle,), ((rate(angle), spin),))


def turned_freely(base: Frame, name: str, new: New) -> tuple[Frame, tuple[Coordinate, ...]]:
    """A frame rotated in another one by Euler parameters."""
    e = tuple(new(f"e{k}") for k in range(4))
    return base.rotate_euler_parameters(name, e), e


def spinning(frame: Frame, spin: Iterable[Expr]) -> GivenRates:
    """The quasi-rates of a frame's Euler parameters: its angular velocity along its own axes."""
    turn = frame.orientation
    assert turn is not None
    return GivenRates(turn.parameters, tuple(zip(turn.quasi, spin, strict=True)))


def independent_rows(numbers: Array) -> list[int]:
    """The first maximal set of rows (rows × columns × states) that is independent at all states; ModelError if the rank varies."""
    kept: list[int] = []
    for i in range(len(numbers)):
        ranks = {int(_rank(numbers[[*kept, i], :, k])) for k in range(numbers.shape[2])}
        if len(ranks) != 1:
            raise ModelError(
                "Expected kinematical equations of one rank at all configurations, got a singular matrix at random ones."
            )
        if ranks.pop() == len(kept) + 1:
            kept.append(i)
    return kept


def _rank(a: Array) -> int:
    sizes = np.abs(a).max(axis=1, keepdims=True, initial=0)
    return int(np.linalg.matrix_rank(a / np.where(sizes > 0, sizes, 1.0), tol=SPEEDS_RANK)) if a.size else 0
