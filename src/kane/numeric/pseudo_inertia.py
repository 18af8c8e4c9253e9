# SPDX-License-Identifier: BSD-3-Clause
"""Pseudo-inertias: which masses, first moments and moments of inertia some distribution of mass has.

With m, h = ∫ r dm and I about a point, and Σ = ∫ r rᵀ dm = ½ tr(I) 1 − I, those that a body can have are those with

    J = ⎡Σ  h⎤ ⪰ 0
        ⎣hᵀ m⎦

(Wensing, Kim, Slotine 2018, Linear matrix inequalities for physically consistent inertial parameter identification, IEEE Robotics and
Automation Letters 3(1), 60–67). How far J is from J₀ is told by tr(J₀⁻¹ J) − log det(J₀⁻¹ J) − 4 = Σ (λ − 1 − log λ) ≥ 0 with the
eigenvalues λ of J by J₀, which no choice of units changes and which is infinite where J ceases to be positive (Lee, Wensing, Park 2020,
Geometric robot dynamic identification, IEEE Transactions on Robotics 36(2), 348–365).
"""

import numpy as np
from scipy.linalg import eigh

from kane.numeric.arrays import Array

_PAIRS = ((0, 1), (1, 2), (2, 0))
WEIGHT = 1e-4
"""Of the distance, beside half the squares of residuals of the size of their deviations: far less than their noise changes."""
_INSIDE = 1e-6
"""Eigenvalues of what is made positive, of the largest."""


def _units() -> Array:
    """J of a unit of each of m, h_x, h_y, h_z, I_xx, I_yy, I_zz, I_xy, I_yz, I_zx (10 × 4 × 4)."""
    found = np.zeros((10, 4, 4))
    found[0, 3, 3] = 1.0
    for i in range(3):
        found[1 + i, i, 3] = found[1 + i, 3, i] = 1.0
        found[4 + i, range(3), range(3)] = 0.5
        found[4 + i, i, i] -= 1.0
        j, k = _PAIRS[i]
        found[7 + i, j, k] = found[7 + i, k, j] = -1.0
    return found


UNITS = _units()


def of(values: Array) -> Array:
    """J of the ten parameters of a rigid body (4 × 4)."""
    return np.asarray(np.tensordot(values, UNITS, 1))


def made_positive(j: Array) -> Array:
    """The nearest to J whose eigenvalues are above zero."""
    values, vectors = np.linalg.eigh(j)
    return np.asarray((vectors * np.maximum(values, _INSIDE * max(float(values[-1]), 1e-300))) @ vectors.T)


def apart(j: Array, slopes: Array, first: Array) -> tuple[Array, Array] | None:
    """s (n) with ½ s² = Σ (λ − 1 − log λ) between J and the first, and its slopes (n × k) by those of J (k × n × n); None outside."""
    values, vectors = eigh(j, first)
    if not values[0] > 0:
        return None
    rise = values - 1
    s = np.sign(rise) * np.sqrt(2 * np.maximum(rise - np.log(values), 0.0))
    near = np.abs(rise) < 1e-4  # the root of a difference of equal numbers
    s = np.where(near, rise * (1 - rise / 3), s)
    steep = np.where(near, 1 - 2 * rise / 3, (rise / values) / np.where(near, 1.0, s))
    return s, steep[:, None] * np.einsum("ia,kij,ja->ak", vectors, slopes, vectors)
