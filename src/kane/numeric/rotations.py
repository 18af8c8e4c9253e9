# SPDX-License-Identifier: BSD-3-Clause
"""Direction cosines in numbers, arrays of shape (3, 3): v in the base = C v in the turned frame."""

import math

import numpy as np

from kane.expr.ops import COS, OPS, SIN
from kane.expr.rounded_functions import value_of_numbers
from kane.numeric.arrays import Array, product
from kane.numeric.scale import LAST_DIGIT

ATAN2 = OPS["atan2"]


def turned(axis: int, c: float, s: float) -> Array:
    """Of a rotation about a basis vector, by cosine and sine."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    cosines = np.eye(3)
    cosines[j, j] = cosines[k, k] = c
    cosines[k, j], cosines[j, k] = s, -s
    return cosines


def about(axis: int, angle: float) -> Array:
    """Of a rotation about a basis vector."""
    return turned(axis, value_of_numbers(COS, angle), value_of_numbers(SIN, angle))


def rounded(cosines: Array) -> Array:
    """With what is 0 or ±1 up to rounding made so."""
    near = np.round(cosines)
    return np.where(np.abs(cosines - near) <= LAST_DIGIT, near, cosines)


def zx(direction: Array) -> tuple[float, float]:
    """γ and α with R_z(γ) R_x(α) z = direction; γ is 0 where that is ±z up to rounding."""
    x, y, z = direction.tolist()
    across = math.hypot(x, y)
    if across <= LAST_DIGIT:
        return 0.0, 0.0 if z > 0 else math.pi
    return value_of_numbers(ATAN2, x, -y), value_of_numbers(ATAN2, across, z)


def zxz(cosines: Array) -> tuple[float, float, float]:
    """a, b, c of R_z(a) R_x(b) R_z(c); c from what a and b leave, so that the product is exact where b is small."""
    a, b = zx(cosines[:, 2])
    rest = product(product(about(2, a), about(0, b)).T, cosines)
    return a, b, value_of_numbers(ATAN2, *rest[1::-1, 0].tolist())
