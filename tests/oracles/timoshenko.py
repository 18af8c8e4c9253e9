# SPDX-License-Identifier: BSD-3-Clause
"""Frequencies of Timoshenko beams of unit length, mass and EI, by characteristic equations, without `kane`.

With r² = I/(A L²) and s² = EI/(k_s G A L²) (Huang, T. C. (1961), The effect of rotatory inertia and of shear deformation on the
frequency and normal mode equations of uniform beams with simple end conditions, *J. Appl. Mech.* 28(4), 579-584): solutions e^(λξ) of
v and of the slope ψ of sections,

    (v' − ψ)'/s² + b² v = 0,        ψ'' + (v' − ψ)/s² + b² r² ψ = 0.
"""

import numpy as np
from scipy.optimize import brentq


def cantilever(r: float, s: float, count: int, tip: float = 0.0) -> np.ndarray:
    """The first b of v(0) = ψ(0) = 0, ψ'(1) = 0, v'(1) − ψ(1) = s² b² μ v(1), below the second spectrum, b < 1/(r s).

    μ is a mass at the `tip` over the beam's.
    """

    def residual(b: float) -> float:
        mean, spread = b * (r**2 + s**2), np.sqrt(b**2 * (r**2 - s**2) ** 2 + 4)
        alpha, beta = np.sqrt(b * (spread - mean) / 2), np.sqrt(b * (spread + mean) / 2)
        # v = A cosh αξ + B sinh αξ + C cos βξ + D sin βξ, and ψ' = v'' + b² s² v
        g, h = (alpha**2 + b**2 * s**2) / alpha, (beta**2 - b**2 * s**2) / beta
        ch, sh, c, d = np.cosh(alpha), np.sinh(alpha), np.cos(beta), np.sin(beta)
        rows = [
            [1, 0, 1, 0],
            [0, g, 0, h],
            [g * alpha * ch, g * alpha * sh, -h * beta * c, -h * beta * d],
            [(alpha - g) * sh, (alpha - g) * ch, (-beta + h) * d, (beta - h) * c],
        ]
        rows[3] = [x - (s * b) ** 2 * tip * v for x, v in zip(rows[3], (ch, sh, c, d), strict=True)]
        return float(np.linalg.det(np.array(rows)) / ch)

    grid = np.linspace(0.05, 0.99 / (r * s), 4000)
    values = np.array([residual(b) for b in grid])
    ends = [(a, b) for a, b, x, y in zip(grid, grid[1:], values, values[1:], strict=False) if x * y < 0]
    return np.array([brentq(residual, a, b, xtol=1e-13, rtol=1e-14) for a, b in ends[:count]])


def simply_supported(r: float, s: float, count: int) -> np.ndarray:
    """The lower roots of r² s² b⁴ − (1 + k² (r² + s²)) b² + k⁴ = 0, k = nπ."""
    k = np.pi * np.arange(1, count + 1)
    middle = 1 + k**2 * (r**2 + s**2)
    lower: np.ndarray = np.sqrt(2 * k**4 / (middle + np.sqrt(middle**2 - 4 * r**2 * s**2 * k**4)))
    return lower
