# SPDX-License-Identifier: BSD-3-Clause
"""Direction cosines (3, 3) and angles in numbers, or in expressions of parameters where those are not known.

Arrays of numbers are of floats, others of objects. What is computed of parameters alone is computed once for given ones, so that it
counts little; where axes are parallel at some parameters, γ is any angle, and what is left of the rotation is taken with it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from kane.expr.build import add, cos, mul, neg, sin, sqrt
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.matrix import dot
from kane.expr.node import BUILDERS, ONE, ZERO, Expr, as_expr, constant, constant_value
from kane.numeric import rotations
from kane.numeric.arrays import Array, product
from kane.numeric.sampling import SEED, value_of
from kane.space.rotation import NOTHING, Basis, Cosines, Orientation, Triple

Angle = float | Expr
_APART = 1e-3
"""The least sine of the angle between axes, at the parameters' defaults, beyond which γ may be taken of parameters."""


def are_numbers(cosines: Array) -> bool:
    """Whether they are known."""
    return cosines.dtype != object


def numbers(exprs: Iterable[Expr]) -> list[float] | None:
    """The values of expressions; None where one has symbols."""
    values = []
    for e in exprs:
        value = constant_value(e)
        if value is None and free_symbols([e]):
            return None
        values.append(float(evaluate(e, {}) if value is None else value))
    return values


def given(rows: Cosines) -> Array:
    """Direction cosines as an array, of floats where all are numbers."""
    known = numbers(x for row in rows for x in row)
    if known is not None:
        return np.reshape(np.array(known), (3, 3))
    return _array(rows)


def _array(rows: Sequence[Sequence[Expr]]) -> Array:
    found = np.empty((3, 3), dtype=object)
    for i, row in enumerate(rows):
        for j, x in enumerate(row):
            found[i, j] = x
    return found


def times(a: Array, b: Array) -> Array:
    """A B."""
    if are_numbers(a) and are_numbers(b):
        return product(a, b)
    left, right = exact(a), exact(b)
    columns = tuple(zip(*right, strict=True))
    return _array([[dot(row, column) for column in columns] for row in left])


def exact(cosines: Array) -> Cosines:
    """The entries as expressions."""
    a, b, c = ((_as_expr(x), _as_expr(y), _as_expr(z)) for x, y, z in cosines.tolist())
    return a, b, c


def _as_expr(x: Angle) -> Expr:
    """A number as an expression."""
    return constant(x) if isinstance(x, float) else as_expr(x)


def turn_about(axis: int, angle: Angle) -> Array:
    """Of a rotation about a basis vector."""
    if not isinstance(angle, Expr):
        return rotations.about(axis, angle)
    return turned(axis, cos(angle), sin(angle))


def turned(axis: int, c: Expr, s: Expr) -> Array:
    """Of a rotation about a basis vector, by cosine and sine."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    rows = [[ONE if a == b else ZERO for b in range(3)] for a in range(3)]
    rows[j][j] = rows[k][k] = c
    rows[k][j], rows[j][k] = s, neg(s)
    return _array(rows)


def is_apart(direction: Triple) -> bool:
    """Whether a direction lies well aside of z at the parameters' defaults."""
    symbols = free_symbols(direction)
    x, y, z = (float(v) for v in evaluate(list(direction), {s: value_of(s, SEED) for s in symbols}))
    return math.hypot(x, y) > _APART * math.hypot(x, y, z)


def about_z(cosines: Array) -> Expr:
    """The angle of a rotation about z."""
    (c, _, _), (s, _, _), _ = exact(cosines)
    return BUILDERS["atan2"](s, c)


class Leaning(NamedTuple):
    """R_z(γ) R_x(α) as a rotation, γ, and α, which stands for its cosine and sine."""

    cosines: Array
    gamma: Expr
    alpha: Alpha


class Alpha(NamedTuple):
    """An angle by its cosine and sine."""

    c: Expr
    s: Expr

    def about_x(self, base: Basis) -> Orientation:
        """The orientation of what is turned by it about x."""
        return Orientation(base, NOTHING, axis=0, c=self.c, s=self.s, angle=BUILDERS["atan2"](self.s, self.c))


def leaning(direction: Triple) -> Leaning:
    """γ and α with R_z(γ) R_x(α) z = direction, a unit vector."""
    x, y, z = direction
    across, gamma = sqrt(add(mul(x, x), mul(y, y))), BUILDERS["atan2"](x, neg(y))
    return Leaning(times(turn_about(2, gamma), turned(0, z, across)), gamma, Alpha(z, across))
