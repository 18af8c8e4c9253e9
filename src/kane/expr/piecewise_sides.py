# SPDX-License-Identifier: BSD-3-Clause
"""Corners of data: a quantity that changes its sign at each of them, and what the data are on either side.

Between corners κ₀ < κ₁ < … the quantity is (x − κᵢ)(κᵢ₊₁ − x)/(κᵢ₊₁ − κᵢ), with + and − in turn, and x − κ beyond the last. What
is on the side of + goes on across a corner as it was there, up to the middle of what belongs to −, where it becomes that of the next.
"""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from kane.expr.piecewise import Data, Piecewise, piecewise

_ROUNDED = 1e-9
"""Share of their sizes that values and slopes of two sides differ by at a corner."""
Piece = tuple[float, float, list[float]]
"""Where it ends, its center, its coefficients."""


def with_corners(data: Data, label: str, unit: str, of: str) -> Piecewise:
    """The operation of data, and of its sides where it has corners."""
    corners = found(data)
    if not corners:
        return piecewise(data, label, unit, of)
    if data.period is not None and len(corners) % 2:  # signs must come round
        corners = (data.period[0], *corners)
    data = replace(data, corners=corners)
    turning = piecewise(_turning(data), f"corners of {label}")
    one, other = (piecewise(_side(data, k), f"{label}{'+-'[k]}", unit, of) for k in (0, 1))
    return piecewise(data, label, unit, of, 0, (turning, one, other))


def found(data: Data) -> tuple[float, ...]:
    """The ends of pieces at which values or slopes differ."""
    apart = _apart(data) | _apart(data.slope())
    return tuple(data.ends[apart].tolist())


@cache
def leaps(op: Piecewise) -> bool:
    """Whether values differ at an end of pieces: the operation jumps there, and does not only bend."""
    return bool(_apart(op.data).any())


def _apart(data: Data) -> npt.NDArray[np.bool_]:
    """At which ends the values of two pieces differ."""
    powers = np.arange(data.coefficients.shape[1])
    before, after = (
        data.coefficients[k : k + len(data.ends)]
        * (data.ends - data.centers[k : k + len(data.ends)])[:, None] ** powers
        for k in (0, 1)
    )
    sizes = np.maximum(np.abs(before).max(axis=1, initial=0), np.abs(after).max(axis=1, initial=0))
    far: npt.NDArray[np.bool_] = np.abs(before.sum(axis=1) - after.sum(axis=1)) > _ROUNDED * sizes
    return far


def _turning(data: Data) -> Data:
    """The quantity that changes its sign at the corners."""
    corners = list(data.corners)
    if data.period is None:
        bounds = [-np.inf, *corners, np.inf]
    else:
        start, period = data.period
        bounds = [*([corners[-1] - period] if corners[0] > start else []), *corners, corners[0] + period]
    rows, centers = [], []
    for i, (a, b) in enumerate(pairwise(bounds)):
        sign = -1.0 if i % 2 else 1.0
        if np.isinf(a):
            centers.append(b)
            rows.append([0.0, -sign, 0.0])
        else:
            centers.append(a)
            rows.append([0.0, sign, 0.0 if np.isinf(b) else -sign / (b - a)])
    return Data(np.array(bounds[1:-1]), np.array(centers), np.array(rows), data.period)


def _side(data: Data, which: int) -> Data:
    """The data on the side of + (0) or − (1), going on across the corners."""
    corners = list(data.corners)
    if data.period is not None:
        corners += [data.period[0] + data.period[1]] if corners[0] > data.period[0] else []
    pieces: list[Piece] = []
    ends = [*data.ends.tolist(), np.inf]
    own = list(zip(ends, data.centers.tolist(), data.coefficients.tolist(), strict=True))
    regions = [-np.inf, *[c for c in corners if np.isfinite(c)], np.inf]
    shift = 1 if data.period is not None and data.corners[0] == data.period[0] else 0
    for i, (a, b) in enumerate(pairwise(regions)):
        inside = [p for k, p in enumerate(own) if p[0] > a and (k == 0 or own[k - 1][0] < b)]
        if (i - shift) % 2 == which or not inside:
            pieces += [(min(end, b), c, row) for end, c, row in inside]
            continue
        before = next((p for p in reversed(own) if p[0] <= a), None)
        after = next((p for k, p in enumerate(own) if k and own[k - 1][0] >= b), None)
        if before is not None and after is not None:
            pieces.append(((a + b) / 2, before[1], before[2]))
        last = after or before
        if last is not None:
            pieces.append((b, last[1], last[2]))
    return Data(
        np.array([end for end, _, _ in pieces[:-1]]),
        np.array([center for _, center, _ in pieces]),
        np.array([row for _, _, row in pieces]),
        data.period,
    )
