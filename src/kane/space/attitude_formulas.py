# SPDX-License-Identifier: BSD-3-Clause
"""Direction cosines, Euler parameters, angles and Rodrigues parameters from each other, on arrays of numbers or of expressions.

C (…, 3, 3) is ᴬCᴮ, v_A = C v_B; Euler parameters (…, 4) are e0 = cos θ/2, (e1, e2, e3) = λ sin θ/2, up to a common factor where they
are called homogeneous (Kane, Likins & Levinson 1983, *Spacecraft Dynamics*, sec. 1.2 to 1.4 and 1.7, appendix I).
"""

from typing import Any

import numpy as np

from kane.numeric.arrays import Array, Entries
from kane.numeric.scale import LAST_DIGIT

Sequence3 = tuple[int, int, int]


def symbolic(entries: Entries) -> bool:
    """Whether these are expressions."""
    return entries.dtype == object


def product(p: Entries, q: Entries) -> Entries:
    """Homogeneous Euler parameters of a rotation followed by another one, about axes that the first has turned."""
    (a, b, c, d), (x, y, z, w) = np.moveaxis(p, -1, 0), np.moveaxis(q, -1, 0)
    return _last(
        a * x - b * y - c * z - d * w,
        a * y + b * x + c * w - d * z,
        a * z + c * x + d * y - b * w,
        a * w + d * x + b * z - c * y,
    )


def conjugate(p: Entries) -> Entries:
    """Those of the inverse rotation."""
    return _last(p[..., 0], -p[..., 1], -p[..., 2], -p[..., 3])


def cosines_of(p: Entries, unit: bool) -> Entries:
    """C of homogeneous Euler parameters: of those of `unit` length nothing is divided."""
    a, b, c, d = np.moveaxis(p, -1, 0)
    rows = [
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ]
    if not unit:
        square = a * a + b * b + c * c + d * d
        rows = [[x / square for x in row] for row in rows]
    return _last(*(_last(*row) for row in rows), axis=-2)


def parameters_of(c: Entries) -> Entries:
    """Euler parameters of C, the scalar one not negative; of expressions where the angle is below half a turn."""
    diagonal = [c[..., k, k] for k in range(3)]
    x, y, z = diagonal
    turned = [c[..., 2, 1] - c[..., 1, 2], c[..., 0, 2] - c[..., 2, 0], c[..., 1, 0] - c[..., 0, 1]]
    if symbolic(c):
        twice = np.sqrt(np.asarray(1 + x + y + z, dtype=object))
        return _last(twice / 2, *(t / (2 * twice) for t in turned))
    both = [c[..., 2, 1] + c[..., 1, 2], c[..., 0, 2] + c[..., 2, 0], c[..., 1, 0] + c[..., 0, 1]]
    ways = np.stack(
        [
            _last(1 + x + y + z, *turned),
            _last(turned[0], 1 + x - y - z, both[2], both[1]),
            _last(turned[1], both[2], 1 - x + y - z, both[0]),
            _last(turned[2], both[1], both[0], 1 - x - y + z),
        ],
        axis=-2,
    )
    best = np.argmax(np.diagonal(ways, axis1=-2, axis2=-1), axis=-1)
    found = np.take_along_axis(ways, best[..., None, None], axis=-2)[..., 0, :]
    return upward(found / np.linalg.norm(found, axis=-1, keepdims=True))


def upward(p: Array) -> Array:
    """The same rotations by parameters of which the first that is not zero is above zero."""
    first = np.take_along_axis(p, np.argmax(p != 0, axis=-1)[..., None], axis=-1)
    return np.where(first < 0, -p, p) + 0.0


def about(axis: int, angle: Any) -> Entries:
    """C of a rotation about a basis vector."""
    c, s = np.cos(angle), np.sin(angle)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    zero = 0 * c
    rows = [[zero] * 3 for _ in range(3)]
    rows[axis][axis] = zero + 1
    rows[j][j] = rows[k][k] = c
    rows[k][j], rows[j][k] = s, -s
    return _last(*(_last(*row) for row in rows), axis=-2)


def half_about(axis: int, angle: Any) -> Entries:
    """Euler parameters of a rotation about a basis vector."""
    c, s = np.cos(angle / 2), np.sin(angle / 2)
    return _last(c, *(s if k == axis else 0 * s for k in range(3)))


def angles_of(c: Entries, axes: Sequence3) -> Entries:
    """The angles of three successive rotations about body-fixed axes.

    The second is within ±π/2, where the last axis is the first from 0 to π. At an end of this range only the sum or
    difference of the others is determined: the first is 0 there.
    """
    i, j, last = axes
    k = 3 - i - j
    s = 1 if (j - i) % 3 == 1 else -1
    if last == i:
        first, second = (c[..., j, i], -s * c[..., k, i]), c[..., i, i]
        third = (c[..., i, j], s * c[..., i, k])
    else:
        first, second = (-s * c[..., j, k], c[..., k, k]), s * c[..., i, k]
        third = (-s * c[..., i, j], c[..., i, i])
    across = _length(first)
    b = np.arctan2(across, second) if last == i else np.arctan2(second, across)
    if symbolic(c):
        return _last(np.arctan2(*first), b, np.arctan2(*third))
    a = np.where(across <= LAST_DIGIT, 0.0, np.arctan2(*first))
    rest = about(j, -b) @ about(i, -a) @ c
    p, q = (last + 1) % 3, (last + 2) % 3
    return _last(a, b, np.arctan2(rest[..., q, p], rest[..., p, p]))


def _length(parts: tuple[Any, Any]) -> Any:
    x, y = parts
    return np.hypot(x, y) if np.asarray(x).dtype != object else np.sqrt(np.asarray(x * x + y * y, dtype=object))


def _last(*parts: Any, axis: int = -1) -> Entries:
    """Arrays side by side along a new axis."""
    return np.stack(np.broadcast_arrays(*map(np.asarray, parts)), axis=axis)
