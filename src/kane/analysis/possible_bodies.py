# SPDX-License-Identifier: BSD-3-Clause
"""Inertial parameters that bodies can have, nearest to measured forces: a convex problem.

Of Y π = F the sum of squares ½ |Y π − F|²/σ² + μ Σ D(J, J₀) is least, with the pseudo-inertia J(π) of each body and its distance D to
that of the model, infinite outside of J ≻ 0 and small beside the noise of F within. It says, too, what the forces do not tell.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kane.errors import SimulationError
from kane.numeric.arrays import Array
from kane.numeric.pseudo_inertia import UNITS, WEIGHT, distance, made_positive, root_of, step_rows

_ROUNDS, _SHORT, _FEWER = 200, 1e-12, 10.0
_ARRIVED, _ROUNDED = 1e-8, 1e-2
"""What a step is to promise at last, of the weight of the distance; and what rounding of large sums of squares may leave."""
_LEAST = 1e-7
"""The deviation of forces without noise, of their size."""
_PARTICLE = np.ones((1, 1, 1))


@dataclass(frozen=True, slots=True, eq=False)
class _Body:
    """Where its parameters stand, J of a unit of each, and J₀."""

    at: slice
    units: Array
    first: Array

    def lower(self, pi: Array) -> Array | None:
        """L of J = L Lᵀ; None outside."""
        return root_of(np.tensordot(pi[self.at], self.units, 1))


def possible(y: Array, forces: Array, sizes: Sequence[int], model: Array) -> Array:
    """π (k) of bodies with so many parameters each: 10 or, of a particle, 1; `model` has π₀, made positive where it is not.

    Raises
    ------
    SimulationError
        if a mass of the model is not above zero, or no minimum is found
    """
    bodies, pi, start = list[_Body](), model.astype(float), 0
    for size in sizes:
        at = slice(start, start := start + size)
        if not pi[at.start] > 0:
            raise SimulationError(f"Expected masses above zero to begin with, got {pi[at.start]:g}. Give parameters=.")
        units = UNITS if size > 1 else _PARTICLE
        first = made_positive(np.tensordot(pi[at], units, 1))
        pi[at] = np.linalg.lstsq(units.reshape(size, -1).T, first.reshape(-1))[0]
        bodies.append(_Body(at, units, first))
    free = forces - y @ np.linalg.lstsq(y, forces)[0]
    spread = np.linalg.norm(free) / max(len(forces) - np.linalg.matrix_rank(y), 1) ** 0.5
    sigma = max(float(spread), _LEAST * float(np.linalg.norm(forces)) / len(forces) ** 0.5, 1e-300)
    return _least(y / sigma, forces / sigma, bodies, pi)


def _least(y: Array, forces: Array, bodies: Sequence[_Body], pi: Array) -> Array:
    """By ever smaller weights: from far away the last one alone would take a step for each of the many times it is less than ½ r²."""
    weight = max(1.0, 0.5 * float(np.sum((y @ pi - forces) ** 2)))
    while weight > WEIGHT:
        pi = _newton(y, forces, bodies, pi, weight, 0.1)
        weight = max(WEIGHT, weight / _FEWER)
    return _newton(y, forces, bodies, pi, WEIGHT, _ARRIVED)


def _newton(y: Array, forces: Array, bodies: Sequence[_Body], pi: Array, weight: float, near: float) -> Array:
    """The least with a weight, as near as what a step promises is of it."""
    root, fall = weight**0.5, float("inf")
    now, lowers = _value(y, forces, bodies, pi, weight)
    for _ in range(_ROUNDS):
        rows, right = [y], [forces - y @ pi]
        for body, lower in zip(bodies, lowers, strict=True):
            c, slope = step_rows(lower, body.units, body.first)
            rows.append(np.zeros((len(c), len(pi))))
            rows[-1][:, body.at] = root * c
            right.append(-root * slope)
        whole = np.vstack(rows)
        scale = np.linalg.norm(whole, axis=0)
        d = np.linalg.lstsq(whole / scale, np.concatenate(right), rcond=1e-15)[0] / scale
        fall, share = float(np.sum((whole @ d) ** 2)), 1.0
        if fall <= near * weight:
            return pi
        while share > _SHORT:
            value, there = _value(y, forces, bodies, pi + share * d, weight)
            if value <= now - 1e-4 * share * fall + 1e-14 * abs(now):
                break
            share /= 2
        else:
            break
        pi, now, lowers = pi + share * d, value, there
    if fall <= _ROUNDED * weight:
        return pi
    raise SimulationError(
        f"Expected forces to which possible bodies come nearest, got none in {_ROUNDS} steps. Scale Y and F̃ so that deviations of "
        "rows are alike, or begin nearer: parameters= have the model's values."
    )


def _value(y: Array, forces: Array, bodies: Sequence[_Body], pi: Array, weight: float) -> tuple[float, list[Array]]:
    lowers = [body.lower(pi) for body in bodies]
    there = [lower for lower in lowers if lower is not None]
    if len(there) < len(bodies):
        return float("inf"), []
    far = sum(distance(lower, body.first) for body, lower in zip(bodies, there, strict=True))
    return 0.5 * float(np.sum((y @ pi - forces) ** 2)) + weight * far, there
