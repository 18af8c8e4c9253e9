# SPDX-License-Identifier: BSD-3-Clause
"""Motions for finite differences: each coordinate runs along a parabola, so that q, q̇ and q̈ at t = 0 are known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

import kane as kn

Array = npt.NDArray[np.float64]

STEP = 1e-3


def derivative(f: Callable[[float], Any], t: float = 0.0, h: float = STEP) -> Array:
    """f'(t) by the central seven-point rule, error O(h⁶)."""
    weights = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    terms = [w * (np.asarray(f(t + k * h)) - np.asarray(f(t - k * h))) for k, w in weights.items()]
    return np.asarray(sum(terms) / h, dtype=float)


def second_derivative(f: Callable[[float], Any], t: float = 0.0, h: float = 1e-2) -> Array:
    """f''(t) by the central nine-point rule, error O(h⁸)."""
    weights = {0: -205 / 72, 1: 8 / 5, 2: -1 / 5, 3: 8 / 315, 4: -1 / 560}
    total = weights[0] * np.asarray(f(t))
    for k in range(1, 5):
        total = total + weights[k] * (np.asarray(f(t + k * h)) + np.asarray(f(t - k * h)))
    return np.asarray(total / h**2, dtype=float)


class Path:
    """q(t) = q + q̇ s + q̈ s²/2 with s = t − t0, drawn at random."""

    def __init__(self, symbols: Sequence[Any], seed: int, t0: float = 0.0, spread: float = 1.0) -> None:
        rng = np.random.default_rng(seed)
        self.symbols, self.t0 = tuple(symbols), t0
        n = len(self.symbols)
        self.q, self.v, self.a = rng.uniform(-spread, spread, (3, n)) * np.array([[1.2], [1.0], [1.0]])

    def at(self, t: float) -> Array:
        """q at time t."""
        s = t - self.t0
        return np.asarray(self.q + self.v * s + self.a * s * s / 2)

    def values(self, t: float | None = None) -> dict[Any, float]:
        """Coordinates, rates, second rates and time at t (t0 unless told)."""
        t = self.t0 if t is None else t
        s = t - self.t0
        found: dict[Any, float] = {kn.time: t}
        for symbol, q, v, a in zip(self.symbols, self.at(t), self.v + self.a * s, self.a, strict=True):
            found.update({symbol: float(q), symbol.dt: float(v), symbol.dt.dt: float(a)})
        return found


def numbers(exprs: Any, values: dict[Any, Any]) -> Array:
    """Values of scalars, or of a matrix, as one array."""
    return np.asarray(kn.evaluate(exprs if isinstance(exprs, kn.Matrix) else list(exprs), values), dtype=float)


def unskew(m: Array) -> Array:
    """w with m = [w×]."""
    return np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]) / 2
