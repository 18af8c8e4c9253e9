# SPDX-License-Identifier: BSD-3-Clause
"""The planar pendulum of rods by elimination from the free end, for any kind of scalar: work proportional to n.

Below each pin hangs what answers an acceleration a of the pin with the force A a + b. A rod with direction d, across e,
length l, mass m and ω = u adds, with D = m l²/3 + l² e·A e, h = l (A e + m e/2), r = b − l ω² A d and
k = l e·r + m g l e_y/2,

    α = −(h·a + k)/D,    A ← A + m 1 − h hᵀ/D,    b ← r − ½ m l ω² d + m g y − h k/D.
"""

from collections.abc import Callable, Sequence
from typing import Any


def accelerations(
    q: Sequence[Any],
    u: Sequence[Any],
    m: Sequence[Any],
    l: Sequence[Any],
    g: Any,
    sin: Callable[[Any], Any],
    cos: Callable[[Any], Any],
) -> list[Any]:
    """u̇ of n rods at absolute angles q from the downward vertical, u = q̇."""
    xx = xy = yy = bx = by = 0.0
    rods = []
    for i in reversed(range(len(q))):
        s, c = sin(q[i]), cos(q[i])
        half, squared = m[i] * l[i] / 2, u[i] * u[i]
        Ae = xx * c + xy * s, xy * c + yy * s
        hx, hy = half * c + l[i] * Ae[0], half * s + l[i] * Ae[1]
        pull = l[i] * squared
        rx, ry = bx - pull * (xx * s - xy * c), by - pull * (xy * s - yy * c)
        k = l[i] * (c * rx + s * ry) + half * g * s
        D = m[i] * l[i] * l[i] / 3 + l[i] * l[i] * (c * Ae[0] + s * Ae[1])
        tx, ty = hx / D, hy / D
        xx, xy, yy = xx + m[i] - tx * hx, xy - tx * hy, yy + m[i] - ty * hy
        bx, by = rx - half * squared * s - tx * k, ry + half * squared * c + m[i] * g - ty * k
        rods.append((l[i], s, c, squared, tx, ty, k / D))
    ax = ay = 0.0
    found = []
    for length, s, c, squared, tx, ty, k in reversed(rods):
        alpha = -(tx * ax + ty * ay + k)
        ax, ay = ax + length * (c * alpha - s * squared), ay + length * (s * alpha + c * squared)
        found.append(alpha)
    return found
