# SPDX-License-Identifier: BSD-3-Clause
"""Directions that are declared: of unit length, fixed in one frame."""

import math

from kane.errors import ModelError, cut
from kane.expr.evaluation import free_symbols, is_constant_in_time
from kane.expr.symbols import Parameter
from kane.numeric.sampling import SEED, sample
from kane.numeric.scale import DECLARED
from kane.space.frame import Frame, frames_of
from kane.space.vector import Vector


def length(v: Vector) -> float:
    """|v| at parameters' defaults and a random configuration; 1 where a parameter has no default."""
    square = v.dot(v)
    symbols = free_symbols([square])
    if any(isinstance(s, Parameter) and s.default is None for s in symbols):
        return 1.0
    return math.sqrt(sample([square], SEED)[0])


def is_unit(v: Vector) -> bool:
    """Whether |v| = 1."""
    return abs(length(v) - 1) <= DECLARED


def check_unit(v: object, what: str) -> None:
    """Raise a ModelError unless `v` is a unit vector."""
    if not isinstance(v, Vector) or v.is_zero:
        raise ModelError(f"Expected a unit vector as the {what}, got {cut(repr(v))}.")
    if not is_unit(v):
        raise ModelError(f"Expected a unit vector as the {what}, got {v} of length {length(v):.6g}. Use .normalized().")


def home_of(v: Vector, what: str) -> Frame:
    """The one frame in which the unit vector `v` is written and fixed; a ModelError where it is no unit vector, or there is none."""
    check_unit(v, what)
    frames = frames_of(v)
    if len(frames) != 1 or not is_constant_in_time(v.scalars()):
        raise ModelError(
            f"Expected the {what} fixed in the one frame that it is written in, got {v}. Make a frame that turns with it and write "
            "it there."
        )
    return frames[0]
