# SPDX-License-Identifier: BSD-3-Clause
"""Flexible systems by Lagrange's equations, written without `kane`: all mass as particles, whose places are functions of q by hand.

    Jᵀ m (J q̈ + J̇ q̇) = Q + Aᵀλ        J = ∂r/∂q, A = ∂f/∂q

J is exact to rounding by complex steps, J̇ q̇ = d²r(q + ε q̇)/dε² by differences of fourth order of these. A beam is particles at
Gauss's points with ∫ (v'² + w'²)/2 as its foreshortening, its strain energy that of eigenfunctions, ½ EI β⁴/L³ q².
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.legendre import leggauss

_STEP = 1e-30
"""Of the complex step: nothing is subtracted."""
_WIDE = 1e-2
"""Of the differences along the motion."""
_BETA = np.array([1.8751040687119611, 4.694091132974175, 7.854757438237612])

Array = Any
"""Of numbers, of complex ones where derivatives are taken."""
Places = Callable[[Array], Array]


def changed(of: Places, q: Array, along: Array) -> Array:
    """The derivative of a function of q along a direction."""
    found: Array = np.imag(of(q + 1j * _STEP * along)) / _STEP
    return found


def jacobian(of: Places, q: Array) -> Array:
    """∂of/∂q."""
    return np.array([changed(of, q, e).ravel() for e in np.eye(len(q))]).T


def bent(of: Places, q: Array, v: Array) -> Array:
    """d²of(q + ε v)/dε²."""
    h = _WIDE / max(1.0, float(np.abs(v).max()))
    steps = [changed(of, q + k * h * v, v).ravel() for k in (-2, -1, 1, 2)]
    found: Array = (steps[0] - 8 * steps[1] + 8 * steps[2] - steps[3]) / (12 * h)
    return found


class Matter(NamedTuple):
    """Places of all particles (m × 3) as a function of q, their masses (m), and constraints f(q) = 0, if any."""

    places: Places
    masses: Array
    closures: Places | None = None


def accelerations(matter: Matter, q: Array, v: Array, forces: Array, given: Sequence[int] = ()) -> Array:
    """q̈ under generalized forces Q; coordinates `given`, such as an angle Ω t, have none."""
    weights = np.repeat(matter.masses, 3)
    j = jacobian(matter.places, q)
    free = [k for k in range(len(q)) if k not in given]
    m = j.T @ (weights[:, None] * j)
    rest = forces - j.T @ (weights * bent(matter.places, q, v))
    m, rest = m[np.ix_(free, free)], rest[free]
    count = 0
    if matter.closures is not None:
        a = jacobian(matter.closures, q)[:, free]
        count = len(a)
        m = np.block([[m, a.T], [a, np.zeros((count, count))]])
        rest = np.concatenate([rest, -bent(matter.closures, q, v)])
    found = np.zeros(len(q))
    found[free] = np.linalg.solve(m, rest)[: len(free)]
    return found


class Axis(NamedTuple):
    """Functions of a beam at Gauss's points ξ and its tip, (m + 1) × n; `drawn` holds the integrals of their slopes' products."""

    xi: Array
    weights: Array
    values: Array
    tip_slopes: Array
    drawn: Array
    waves: Array


def axis(count: int, pinned: bool = False, points: int = 24) -> Axis:
    """Eigenfunctions of a uniform beam, clamped or pinned, with ∫ φ² dξ = 1; the foreshortening ∫₀^ξ φ'_i φ'_j at the same places."""
    z, w = leggauss(points)
    xi = np.append((z + 1) / 2, 1.0)
    waves = np.pi * np.arange(1, count + 1) if pinned else _BETA[:count]

    def functions(x: Array, order: int) -> Array:
        y = np.multiply.outer(x, waves)
        if pinned:
            return np.sqrt(2) * (np.cos(y) * waves if order else np.sin(y))
        s = (np.sinh(waves) - np.sin(waves)) / (np.cosh(waves) + np.cos(waves))
        if order:
            return waves * (np.sinh(y) + np.sin(y) - s * (np.cosh(y) - np.cos(y)))
        return np.cosh(y) - np.cos(y) - s * (np.sinh(y) - np.sin(y))

    inner = [functions(x * (z + 1) / 2, 1) for x in xi]
    drawn = np.array([x * np.einsum("g,gi,gj->ij", w / 2, f, f) for x, f in zip(xi, inner, strict=True)])
    return Axis(xi, np.append(w / 2, 0.0), functions(xi, 0), functions(np.ones(1), 1)[0], drawn, waves)


def along(a: Axis, length: float, *deflections: Array) -> Array:
    """Places (m × 3) in the beam's frame: along it, and its deflections v and w."""
    found = np.zeros((len(a.xi), 3), dtype=np.result_type(*deflections))
    found[:, 0] = length * a.xi
    for k, q in enumerate(deflections, 1):
        found[:, k] = a.values[:, : len(q)] @ q
        found[:, 0] -= np.einsum("mij,i,j->m", a.drawn[:, : len(q), : len(q)], q, q) / (2 * length)
    return found


def elastic(a: Axis, q: Array, stiff: float, length: float) -> Array:
    """−∂V/∂q of bending."""
    found: Array = -stiff / length**3 * a.waves[: len(q)] ** 4 * q
    return found


def turn(angle: complex, about: int = 2) -> Array:
    """The matrix whose columns are the axes after a turn about one of them."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = (about + 1) % 3, (about + 2) % 3
    found = np.eye(3, dtype=np.result_type(c, s))
    found[i, i] = found[j, j] = c
    found[j, i], found[i, j] = s, -s
    return found


def ring(radius_squared: float, mass: float, axis: int = 2) -> tuple[Array, Array]:
    """Four particles with the moment of inertia `mass` · `radius_squared` about an axis: places and masses."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    places = np.zeros((4, 3))
    r = np.sqrt(radius_squared)
    places[0, i] = places[2, j] = r
    places[1, i] = places[3, j] = -r
    return places, np.full(4, mass / 4)


def six(moments: Array, mass: float) -> tuple[Array, Array]:
    """Six particles on three axes with the moments of inertia about them."""
    squares = (moments.sum() / 2 - moments) * 3 / mass
    places = np.concatenate([np.diag(np.sqrt(squares)), -np.diag(np.sqrt(squares))])
    return places, np.full(6, mass / 6)


def turned(vector: Array) -> Array:
    """The matrix of a turn about a vector by its length, as a series: analytic, where the vector is zero, too."""
    x, y, z = vector
    skew = np.array([[0 * x, -z, y], [z, 0 * x, -x], [-y, x, 0 * x]])
    found, power = np.eye(3) + skew, skew
    for k in range(2, 16):
        power = power @ skew / k
        found = found + power
    return found
