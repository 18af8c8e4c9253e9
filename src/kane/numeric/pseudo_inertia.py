# SPDX-License-Identifier: BSD-3-Clause
"""Pseudo-inertia matrices: the condition for inertial parameters to be physically consistent, and a distance between them.

The mass m, h = ∫ r dm and I about a point belong to some distribution of mass if, with Σ = ∫ r rᵀ dm = ½ tr(I) 1 − I,

    J = ⎡Σ  h⎤ ⪰ 0
        ⎣hᵀ m⎦

(Wensing, Kim, Slotine 2018, Linear matrix inequalities for physically consistent inertial parameter identification, IEEE Robotics
and Automation Letters 3(1), 60–67). The distance of J from J₀ is tr(J₀⁻¹ J) − log det(J₀⁻¹ J) − 4 = Σ (λ − 1 − log λ) ≥ 0 with the
eigenvalues λ of J₀⁻¹ J; it does not depend on units, and is infinite if J is not positive definite (Lee, Wensing, Park 2020, Geometric
robot dynamic identification, IEEE Transactions on Robotics 36(2), 348–365).
"""

import numpy as np

from kane.numeric.arrays import Array, by_substitution

_PAIRS = ((0, 1), (1, 2), (2, 0))
WEIGHT = 1e-4
"""Of the distance, beside half the squares of residuals of the size of their deviations: far less than their noise changes."""
_INSIDE = 4e-5
"""Least eigenvalue of a matrix that is made positive, as a share of the largest, with lengths in √(tr Σ/m)."""


def _units() -> Array:
    """J of a unit of each of m, h_x, h_y, h_z, I_xx, I_yy, I_zz, I_xy, I_yz, I_zx (10 × 4 × 4)."""
    result = np.zeros((10, 4, 4))
    result[0, 3, 3] = 1.0
    for i in range(3):
        result[1 + i, i, 3] = result[1 + i, 3, i] = 1.0
        result[4 + i, range(3), range(3)] = 0.5
        result[4 + i, i, i] -= 1.0
        j, k = _PAIRS[i]
        result[7 + i, j, k] = result[7 + i, k, j] = -1.0
    return result


UNITS = _units()


def of(values: Array) -> Array:
    """J of the ten parameters of a rigid body (4 × 4)."""
    return np.asarray(np.tensordot(values, UNITS, 1))


def made_positive(j: Array) -> Array:
    """The nearest symmetric matrix to J with positive eigenvalues, if lengths are measured in √(tr Σ/m)."""
    second, m = abs(float(np.trace(j[:-1, :-1]))), abs(float(j[-1, -1]))
    sizes = np.ones(len(j))
    sizes[:-1] = np.sqrt(second / m) if second and m else 1.0
    values, vectors = np.linalg.eigh(j / np.outer(sizes, sizes))
    least = _INSIDE * max(float(values[-1]), 1e-300)
    return np.asarray((vectors * np.maximum(values, least)) @ vectors.T * np.outer(sizes, sizes))


def root_of(j: Array) -> Array | None:
    """The Cholesky factor L of J = L Lᵀ; None if J is not positive definite."""
    try:
        return np.asarray(np.linalg.cholesky(j))
    except np.linalg.LinAlgError:
        return None


def distance(lower: Array, first: Array) -> float:
    """The distance of J = L Lᵀ from J₀ = `first`."""
    back = np.linalg.solve(first, lower @ lower.T)
    return float(np.trace(back)) - float(np.linalg.slogdet(back)[1]) - len(first)


def step_rows(lower: Array, slopes: Array, first: Array) -> tuple[Array, Array]:
    """C (n² × k) and c of the distance's slope Cᵀ c and curvature Cᵀ C along slopes of J (k × n × n): Newton's step is least squares.

    With J = L Lᵀ, C is L⁻¹ ∂J L⁻ᵀ and c is Lᵀ J₀⁻¹ L − 1.
    """
    own = by_substitution(lower, by_substitution(lower, slopes).transpose(0, 2, 1)).reshape(len(slopes), -1)
    return own.T, (lower.T @ np.linalg.solve(first, lower) - np.eye(len(lower))).reshape(-1)
