# SPDX-License-Identifier: BSD-3-Clause
"""Forces within their cones that give asked accelerations: the least ones, where rigid bodies leave the forces open.

minimize ½ |x − x₀|² for x in K with A x = c, by Newton's method on the dual θ(y) = ½ |P_K(x₀ + Aᵀ y)|² − c·y, which is convex and has
one derivative. K is a product of friction cones (of contacts that stick) and of rays (of those that slip).

Any y says how large forces must be at least: c·y = x·Aᵀy ≤ |x| |P_K(Aᵀ y)|, as the rest of Aᵀ y lies in the polar cone. Where there
are none, y goes off along a ray with an infinite bound, and c − A x comes to one. Rows of A are made orthonormal before.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED, UNRELATED

_STEPS, _HALVINGS = 120, 30
_TOO_LARGE = 1e4
"""Times the least solution without cones beyond which forces do not count: bodies would be wedged within 1e-4 of their cones."""
_DAMPING = 1e-2, 1e-3, 0.8
"""Added to the second derivative, 1 at most: times what is left; at most; and how this falls with each step, so that y goes far."""
_DESCENT = 1e-4
"""Share of the fall that the slope predicts which a step must reach (Armijo)."""


class Block(NamedTuple):
    """Unknowns from `first` on: the normal force and `size` − 1 tangential ones, |F| ≤ μ N."""

    first: int
    size: int
    friction: float


class Least(NamedTuple):
    """The least forces, None where none were found; `certain` says whether there are none that are not too large, indeed."""

    forces: Array | None
    certain: bool


def projected(blocks: Sequence[Block], x: Array) -> tuple[Array, Array]:
    """The nearest point of the cones (n), and its derivative (n × n) in x."""
    y, slope = x.copy(), np.eye(len(x))
    for first, size, mu in blocks:
        here = slice(first, first + size)
        normal, tangential = x[first], x[first + 1 : first + size]
        friction = float(np.sqrt(tangential @ tangential))
        if normal >= 0 and friction <= mu * normal:  # mu is 0 of a contact that is smooth, or slips
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
    """Whether forces lie in their cones but for rounding."""
    return bool(np.abs(projected(blocks, x)[0] - x).max(initial=0) <= ROUNDED * np.abs(x).max(initial=0))


def least_forces(blocks: Sequence[Block], rows: Array, given: Array, near: Array) -> Least:
    """The x (n) in the cones nearest to `near` with the products that `given` (n) has with `rows` (m × n, orthonormal)."""
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
