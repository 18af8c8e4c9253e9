# SPDX-License-Identifier: BSD-3-Clause
"""A first step over which an Euler step and the change of rates are small: Hairer, Nørsett & Wanner, sec. II.4."""

from collections.abc import Callable

import numpy as np

from kane.numeric.arrays import Array


def first_step(
    rate: Callable[[float, Array], Array], order: int, tolerances: tuple[float, float], t: float, y: Array, end: float
) -> float:
    """Its length, up to `end`, for a method of an order; `tolerances` are the relative one and the absolute one."""
    rtol, atol = tolerances
    scale, now = atol + np.abs(y) * rtol, rate(t, y)
    size, speed = np.abs(y / scale).max(), np.abs(now / scale).max()
    tried = min(0.01 * size / speed if min(size, speed) > 1e-5 else 1e-6, end - t)
    change = np.abs((rate(t + tried, y + tried * now) - now) / scale).max() / tried
    most = max(speed, change)
    step = (0.01 / most) ** (1 / order) if most > 1e-15 else max(1e-6, tried * 1e-3)
    return float(min(100 * tried, step, end - t)) if np.isfinite(step) else float(tried)
