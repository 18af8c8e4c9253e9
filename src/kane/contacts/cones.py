# SPDX-License-Identifier: BSD-3-Clause
"""The least forces in friction cones that cause given accelerations, for contacts whose forces rigid bodies do not determine.

Minimizes ½ |x − x₀|² for x in K with A x = c, by Newton's method on the dual θ(y) = ½ |P_K(x₀ + Aᵀ y)|² − c·y, which is convex and
once differentiable. K is a product of friction cones (sticking contacts) and rays (slipping contacts). The rows of A are orthonormal.

Each y gives a lower bound on |x|: c·y = x·Aᵀy ≤ |x| |P_K(Aᵀ y)|, as Aᵀ y − P_K(Aᵀ y) lies in the polar cone. If the problem is
infeasible, y diverges along a ray with an infinite bound, and c − A x converges to such a ray.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED, UNRELATED

_STEPS, _HALVINGS = 120, 30
_TOO_LARGE = 1e4
"""Bound on |x| over that of the least solution without cones; larger forces are rejected: bodies would be wedged within 1e-4."""
_DAMPING = 1e-2, 1e-3, 0.8
"""Regularization of the Hessian (norm ≤ 1): factor of the relative residual; upper bound, and its decay per step, so y may diverge."""
_DESCENT = 1e-4
"""Armijo's constant: the least ratio of the decrease of θ to that predicted by its slope."""


class Block(NamedTuple):
    """The unknowns of a contact, from index `first`: the normal force N and `size` − 1 tangential forces F, |F| ≤ μ N."""

    first: int
    size: int
    friction: float


class Least(NamedTuple):
    """The least forces (n), None if none were found; `certain` is false if the search failed without proof that none exist."""

    forces: Array | None
    certain: bool


def projected(blocks: Sequence[Block], x: Array) -> tuple[Array, Array]:
    """The projection of x (n) on the product of cones, and its generalized Jacobian (n × n)."""
    y, slope = x.copy(), np.eye(len(x))
    for first, size, mu in blocks:
        here = slice(first, first + size)
        normal, tangential = x[first], x[first + 1 : first + size]
        friction = float(np.sqrt(tangential @ tangential))
        if normal >= 0 and friction <= mu * normal:  # mu is 0 for a frictionless or slipping contact
            continue
        if mu * friction <= -normal:
            y[here], slope[here, here] = 0.0, 0.0
            continue
        share = (mu * friction + normal) / (1.0 + mu * mu)
        ray = np.concatenate([[1.0], mu * tangential / friction]) if friction > 0 else np.eye(size)[0]
        y[here] = share * ray
        slope[here, here] = np.multiply.outer(ray, ray) / (1.0 + mu * mu)
        if friction > 0:
            across = np.eye(size - 1) - np.multiply.outer(tangential, tangential) / friction**2
            slope[first + 1 : first + size, first + 1 : first + size] += mu * share / friction * across
    return y, slope


def inside(blocks: Sequence[Block], x: Array) -> bool:
    """Whether forces (n) lie in their cones up to rounding."""
    return bool(np.abs(projected(blocks, x)[0] - x).max(initial=0) <= ROUNDED * np.abs(x).max(initial=0))


def least_forces(blocks: Sequence[Block], rows: Array, given: Array, near: Array) -> Least:
    """The x (n) in the cones, nearest to `near` (n), with `rows` x = `rows` `given`; `rows` (m × n) are orthonormal."""
    c, y = rows @ given, np.zeros(len(rows))
    size = float(np.linalg.norm(given)) + float(np.linalg.norm(near))
    enough = _TOO_LARGE * float(np.linalg.norm(c))

    def at(y: Array) -> tuple[Array, Array, Array, float]:
        x, slope = projected(blocks, near + rows.T @ y)
        return x, slope, rows @ x - c, float(x @ x / 2 - c @ y)

    x, slope, left, value = at(y)
    for k in range(_STEPS):
        most = np.abs(left).max(initial=0)
        if most <= ROUNDED * size:
            return Least(x, True)
        if any(c @ ray > enough * np.linalg.norm(projected(blocks, rows.T @ ray)[0]) for ray in (y, -left)):
            return Least(None, True)
        hessian = rows @ slope @ rows.T + min(_DAMPING[0] * most / size, _DAMPING[1] * _DAMPING[2] ** k) * np.eye(
            len(c)
        )
        step, share = -np.linalg.solve(hessian, left), 1.0
        slack = ROUNDED * (abs(value) + abs(float(c @ y)))
        for _ in range(_HALVINGS):
            found = at(y + share * step)
            if found[3] <= value + _DESCENT * share * (left @ step) + slack:
                break
            share /= 2
        else:
            break
        y = y + share * step
        x, slope, left, value = found
    met = np.abs(left).max(initial=0) <= UNRELATED * size
    return Least(x if met else None, bool(met))
