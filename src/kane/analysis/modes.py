# SPDX-License-Identifier: BSD-3-Clause
"""Normal modes of small vibrations: M ẍ + K x = 0 with x = B η, BᵀM B = 1, BᵀK B = Λ (Kane & Levinson 1985, sec. 7.9)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.analysis.linear import Linear, SecondOrder
from kane.errors import ArgumentError, Attributes, SimulationError, cut
from kane.numeric.arrays import Array
from kane.numeric.scale import EPS, UNRELATED

_ROUNDING = 16 * EPS
"""Share of the largest λ, a coordinate, that rounding leaves of a λ that vanishes."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class NormalModes(Attributes):
    """x = B η with η̈_k + λ_k η_k = 0.

    Attributes
    ----------
    names : of the coordinates x, deviations from the equilibrium
    squares : λ (n), by rising size: ω² in 1/s², negative where a mode grows, 0 where nothing holds it
    shapes : B (n × n), the modal matrix, one column a mode, BᵀM B = 1
    M, K : those of M ẍ + K x = 0
    """

    names: tuple[str, ...]
    squares: Array
    shapes: Array
    M: Array
    K: Array

    @property
    def frequencies(self) -> Array:
        """ω (rad/s); NaN where a mode does not swing."""
        with np.errstate(invalid="ignore"):
            return np.asarray(np.sqrt(self.squares))

    @property
    def stable(self) -> bool:
        """Whether every mode swings."""
        return bool((self.squares > 0).all())

    def normal_coordinates(self, x: Any) -> Array:
        """η = BᵀM x, of deviations or of their rates; x is n, or n × any."""
        return np.asarray(self.shapes.T @ self.M @ self._checked(x))

    def motion(self, t: Any, x: Any, rates: Any) -> Array:
        """x at the times t (n_t × n) from x and its rates at t = 0: η cos ω t + η̇ sin ω t/ω, hyperbolic where λ < 0."""
        start, drift = self.normal_coordinates(x), self.normal_coordinates(rates)
        times = np.asarray(t, dtype=float)[..., None]
        omega = np.sqrt(np.abs(self.squares))
        angle = omega * times
        with np.errstate(divide="ignore", invalid="ignore"):
            swing = np.where(self.squares > 0, np.sin(angle), np.sinh(np.where(self.squares < 0, angle, 0.0)))
            reach = np.where(omega > 0, swing / omega, times)
        even = np.where(self.squares > 0, np.cos(angle), np.cosh(np.where(self.squares < 0, angle, 0.0)))
        return np.asarray((start * even + drift * reach) @ self.shapes.T)

    def _checked(self, x: Any) -> Array:
        own = np.asarray(x, dtype=float)
        if own.ndim < 1 or own.shape[0] != len(self.names):
            raise ArgumentError(
                f"Expected {len(self.names)} values, of {', '.join(self.names)}, got shape {own.shape}."
            )
        return own

    def __repr__(self) -> str:
        shown = ", ".join(
            f"{w:.4g}" if s >= 0 else f"λ = {s:.3g}" for w, s in zip(self.frequencies, self.squares, strict=True)
        )
        return f"NormalModes({', '.join(self.names)}; {shown} rad/s)"


def normal_modes(linear: Linear | SecondOrder) -> NormalModes:
    """The normal modes of a linear system without damping and gyroscopic terms.

    Parameters
    ----------
    linear : from `kn.linearize` at an equilibrium, or its `second_order()` form

    Returns
    -------
    NormalModes
        frequencies, the modal matrix, normal coordinates, motions in closed form

    Raises
    ------
    SimulationError
        if velocities matter, or K is not symmetric: then modes are complex, `linear.modes`
    """
    if not isinstance(linear, Linear | SecondOrder):
        raise ArgumentError(
            f"Expected what kn.linearize gives, got {cut(repr(linear))}. Linearize first: kn.linearize(eom, q=…)."
        )
    second = linear.second_order() if isinstance(linear, Linear) else linear
    m, c, k = second.M, second.C, second.K
    scale = np.sqrt(np.diag(m))
    unit = np.outer(scale, scale)
    stiff = np.abs(k / unit).max(initial=0.0)
    if np.abs(c / unit).max(initial=0.0) > UNRELATED * np.sqrt(stiff):
        raise SimulationError(
            "Expected equations without damping and gyroscopic terms for normal modes, got C with "
            f"{np.abs(c).max():.3g}. linear.modes has the complex modes; second_order() has C."
        )
    if np.abs((k - k.T) / unit).max(initial=0.0) > UNRELATED * stiff:
        raise SimulationError(
            "Expected a symmetric K for normal modes, got one of forces without a potential energy. linear.modes has "
            "the complex modes."
        )
    from scipy.linalg import eigh  # takes its time to import

    squares, shapes = eigh((k + k.T) / 2, m)
    squares[np.abs(squares) <= _ROUNDING * len(m) * np.abs(squares).max(initial=0.0)] = 0.0
    largest = shapes[np.abs(shapes).argmax(axis=0), range(len(m))]
    return NormalModes(second.names, squares, shapes * np.sign(largest), m, k)
