# SPDX-License-Identifier: BSD-3-Clause
"""How large what is compared with zero could be at a state: the terms that cancel in it, whatever the units are.

A force of 1 N is nothing beside weights of 10⁹ N that cancel, and everything where it stands alone. So u̇ is measured by |M⁻¹| times
the sizes of the terms of M u̇ = f + Aᵀλ + G R, sines and cosines taken as 1 and A as large as it can be elsewhere; speeds by themselves
and by what such accelerations make of them in the time 1/p, p being the pace at which the state changes; q̇ = W u + X and A u + b by
their terms at such speeds.
"""

from dataclasses import dataclass

import numpy as np

from kane.analysis.local import Slopes, Values
from kane.numeric.arrays import Array
from kane.numeric.projection import mobility, sizes
from kane.numeric.time_scale import pace

_REMOTE = 1e-4
"""Share of all terms together, in the mass metric, that counts in the size of each: solving carries their rounding everywhere."""


@dataclass(frozen=True, slots=True, eq=False)
class Magnitudes:
    """Sizes of u̇ (n), of q̇ (nq), of the spins of Euler parameters, and of A u + b (m).

    Besides, the `pace` (1/s), the `inverse` M⁻¹ (n × n), and each speed `alone` (n) with the energy of all.
    """

    accelerations: Array
    rates: Array
    spins: Array
    motion: Array
    pace: float
    inverse: Array
    alone: Array


def magnitudes(values: Values, slopes: Slopes, z: Array, u: Array) -> Magnitudes:
    """The sizes at a state with the speeds u, for z = (u̇, λ, R) there."""
    n, nq = len(u), len(values.rates)
    m, held = values.matrix[:n, :n], values.constraints(n)
    root = mobility(m, held)
    inverse, far = root @ root.T, np.linalg.norm(root, axis=1)
    k = n + len(held)
    forces = values.terms[:n] + sizes(held, root).T @ np.abs(z[n:k]) + np.abs(values.matrix[:n, k:]) @ np.abs(z[k:])
    accelerations = np.abs(inverse) @ forces + _REMOTE * far * np.linalg.norm(np.abs(root.T) @ forces)
    own = np.vstack([slopes.rates[:, : nq + n], -inverse @ slopes.residual[:n, : nq + n]])
    fastest = pace(own)
    alone = far * np.sqrt(np.maximum(u @ m @ u, 0.0))
    speeds = np.maximum(np.abs(u), _REMOTE * alone)
    speeds = np.maximum(speeds, accelerations / fastest if fastest > 0 else 0.0)

    def terms(linear: Array, whole: Array) -> Array:
        return np.asarray(np.abs(linear) @ speeds + np.abs(whole - linear @ u))

    return Magnitudes(
        accelerations,
        terms(slopes.rates[:, nq : nq + n], values.rates),
        terms(slopes.spins[:, nq : nq + n], values.spins),
        terms(held, values.motion),
        fastest,
        inverse,
        alone,
    )


def share(value: Array, size: Array) -> Array:
    """|value| over its size: what is zero has none, what has no size beside it is all of it."""
    return np.asarray(np.abs(value) / np.maximum(np.maximum(size, np.abs(value)), np.finfo(float).tiny))
