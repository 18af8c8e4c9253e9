# SPDX-License-Identifier: BSD-3-Clause
"""Which small changes of a state the constraints allow, by the implicit function theorem at a point.

    G δq + ∂f/∂r δr = 0                       δq = T ξ,  ξ = N ξ_I + P δr
    A δu + ∂(A u + b)/∂q δq + ∂b/∂r δr = 0     δu = B δu_I + E ξ_I + Q δr

ξ are the perturbations of the coordinates; for Euler parameters three angles θ along the axes of the frame they turn, with
δe = ½ E(e) θ and θ̇ = δω − ω × θ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kane.analysis.local import Slopes
from kane.dynamics.constraints.partition import choose
from kane.dynamics.readings.unsolved import Perturbations
from kane.numeric.arrays import Array
from kane.numeric.projection import mobility, sizes


def turning(e: Array) -> Array:
    """½ E(e), 4 × 3: δe of small angles along the frame's own axes (Kane, Likins, Levinson 1983, sec. 1.13)."""
    e0, e1, e2, e3 = e
    return 0.5 * np.array([[-e1, -e2, -e3], [e0, -e3, e2], [e3, e0, -e1], [-e2, e1, e0]])


def cross(w: Array) -> Array:
    """The matrix of w ×."""
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def spread(known: Perturbations, q: Array) -> Array:
    """T of δq = T ξ."""
    plain = len(known.coordinates)
    t = np.zeros((len(q), plain + 3 * len(known.sets)))
    t[known.coordinates, range(plain)] = 1.0
    for k, places in enumerate(known.sets):
        t[list(places), plain + 3 * k : plain + 3 * k + 3] = turning(q[list(places)])
    return t


@dataclass(frozen=True, slots=True, eq=False)
class Tangents:
    """T, and N, P, B, E, Q of the changes that the constraints allow; which ξ and u are independent."""

    t: Array
    free_q: tuple[int, ...]
    free_u: tuple[int, ...]
    n: Array
    p: Array
    b: Array
    e: Array
    q: Array


def tangents(
    known: Perturbations,
    q: Array,
    slopes: Slopes,
    a: Array,
    m: Array,
    given_q: Sequence[int],
    given_u: Sequence[int],
) -> Tangents:
    """The changes that the constraints allow at a point.

    Parameters
    ----------
    slopes : derivatives in (q, u, r) at the point
    a : A
    m : the mass matrix
    given_q, given_u : which perturbations and speeds are to be dependent, as far as the constraints determine them
    """
    nq, n = len(q), a.shape[1]
    t = spread(known, q)
    g = slopes.configuration[:, :nq] @ t
    w = np.vstack([slopes.rates[list(known.coordinates)], slopes.spins])[:, nq : nq + n]
    root = mobility(m, a)
    free_q, n_q, p = _solved(g, slopes.configuration[:, nq + n :], w @ root, given_q)
    moved = slopes.motion[:, :nq] @ t
    shift = np.hstack([moved @ n_q, moved @ p + slopes.motion[:, nq + n :]])
    free_u, b, eq = _solved(a, shift, root, given_u)
    return Tangents(t, free_q, free_u, n_q, p, b, eq[:, : len(free_q)], eq[:, len(free_q) :])


def _solved(a: Array, rest: Array, root: Array, given: Sequence[int]) -> tuple[tuple[int, ...], Array, Array]:
    """x of a x + rest y = 0 by its free part: x = first x_free + second y; what is dependent is chosen by `sizes`."""
    count = a.shape[1]
    if not len(a):
        return tuple(range(count)), np.eye(count), np.zeros((count, rest.shape[1]))
    found = choose(a, given, reach=sizes(a, root))
    free = found.independent(count)
    rows, held = list(found.rows), list(found.dependent)
    first, second = np.zeros((count, len(free))), np.zeros((count, rest.shape[1]))
    first[list(free), range(len(free))] = 1.0
    square = a[np.ix_(rows, held)]
    first[held] = -np.linalg.solve(square, a[np.ix_(rows, list(free))])
    second[held] = -np.linalg.solve(square, rest[rows])
    return free, first, second
