# SPDX-License-Identifier: BSD-3-Clause
"""Which small changes of a state the constraints allow, by the implicit function theorem at a point.

    G δq + ∂f/∂r δr = 0                       δq = T ξ,  ξ = N ξ_I + P δr
    A δu + ∂(A u + b)/∂q δq + ∂b/∂r δr = 0     δu = B δu_I + E ξ_I + Q δr

ξ are the perturbations of the coordinates; for Euler parameters three angles θ along the axes of the frame they turn, with
δe = ½ E(e) θ and θ̇ = δω − ω × θ. Arrays hold numbers or expressions alike.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from kane.dynamics.constraints.partition import Partition, choose
from kane.dynamics.readings.unsolved import unsolved
from kane.equations.equations import Equations
from kane.expr.evaluation import free_symbols
from kane.expr.symbols import Coordinate, Time
from kane.numeric.arrays import Array, Entries
from kane.numeric.rank import sizes


class Perturbations(NamedTuple):
    """The free perturbations ξ of the coordinates, δq = T ξ: δq itself; for Euler parameters three small angles.

    The angles are along the axes of the frame that the parameters turn. `coordinates` are those perturbed as they are, `sets` the
    indices of the Euler parameters, whose angles come last. `timed` says whether the time enters the equations.
    """

    names: tuple[str, ...]
    symbols: tuple[Coordinate | None, ...]
    coordinates: tuple[int, ...]
    sets: tuple[tuple[int, int, int, int], ...]
    timed: bool


def perturbations(eom: Equations) -> Perturbations:
    """The perturbations of the coordinates of a system."""
    equations, coordinates = unsolved(eom.derived), eom.coordinates
    place = {q: i for i, q in enumerate(coordinates)}
    sets = [tuple(place[e] for e in s.coordinates) for s in eom.system.euler_parameters]
    turned = {i for s in sets for i in s}
    plain = [i for i in range(len(place)) if i not in turned]
    angles = [f"theta{k}_{coordinates[s[0]].name}" for s in sets for k in (1, 2, 3)]
    return Perturbations(
        (*(coordinates[i].name for i in plain), *angles),
        (*(coordinates[i] for i in plain), *[None] * len(angles)),
        tuple(plain),
        tuple((s[0], s[1], s[2], s[3]) for s in sets),
        any(isinstance(s, Time) for s in free_symbols([*equations.places, *equations.residual])),
    )


def turning(e: Entries) -> Entries:
    """½ E(e), 4 × 3: δe of small angles along the frame's own axes (Kane, Likins, Levinson 1983, sec. 1.13)."""
    e0, e1, e2, e3 = e
    return 0.5 * np.array([[-e1, -e2, -e3], [e0, -e3, e2], [e3, e0, -e1], [-e2, e1, e0]])


def turning_rates(rates: Entries, plain: int) -> Entries:
    """The matrix (ξ × ξ) of ω × θ in the rates of ξ, whose first `plain` are those of coordinates; ω follow them."""
    matrix = np.zeros((len(rates), len(rates)), dtype=rates.dtype)
    for k in range(plain, len(rates), 3):
        x, y, z = rates[k : k + 3]
        matrix[k : k + 3, k : k + 3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    return matrix


def spread(perturbed: Perturbations, q: Entries) -> Entries:
    """T (coordinates × ξ) of δq = T ξ."""
    plain = len(perturbed.coordinates)
    t = np.zeros((len(q), plain + 3 * len(perturbed.sets)), dtype=q.dtype)
    t[perturbed.coordinates, range(plain)] = 1.0
    for k, places in enumerate(perturbed.sets):
        t[list(places), plain + 3 * k : plain + 3 * k + 3] = turning(q[list(places)])
    return t


class Tangents(NamedTuple):
    """N, P, B, E, Q of the changes that the constraints allow; which ξ and u are independent."""

    free_q: tuple[int, ...]
    free_u: tuple[int, ...]
    n: Entries
    p: Entries
    b: Entries
    e: Entries
    q: Entries

    @classmethod
    def of(cls, free_q: Sequence[int], of_q: Entries, free_u: Sequence[int], of_u: Entries) -> "Tangents":
        """From δξ of δ(ξ_I, r) and δu of δ(u_I, ξ_I, r), at one state or with axes of many in front."""
        i, j = len(free_q), len(free_u)
        u_parts = of_u[..., :j], of_u[..., j : j + i], of_u[..., j + i :]
        return cls(tuple(free_q), tuple(free_u), of_q[..., :i], of_q[..., i:], *u_parts)

    @property
    def moves(self) -> Entries:
        """δ(ξ, u, r) of δ(ξ_I, u_I, r)."""
        many, (width, nr), i, j = self.p.shape[:-2], self.p.shape[-2:], len(self.free_q), len(self.free_u)
        rows = (
            [self.n, np.zeros((*many, width, j)), self.p],
            [self.e, self.b, self.q],
            [np.zeros((*many, nr, i + j)), np.broadcast_to(np.eye(nr), (*many, nr, nr))],
        )
        return np.concatenate([np.concatenate(row, axis=-1) for row in rows], axis=-2)


FreePart = Callable[[Entries, Entries], tuple[tuple[int, ...], Entries]]
"""x of a x + rest y = 0 by its free part: which of x are free, and S of x = S (x_free, y)."""


def tangents(g: Entries, v: Entries, width: int, count: int, by_q: FreePart, by_u: FreePart) -> Tangents:
    """The changes that the constraints allow at a point, in numbers or in expressions.

    Parameters
    ----------
    g, v : derivatives of f and of A u + b in (ξ, u, r)
    width, count : how many ξ and u there are
    by_q, by_u : how ξ and u are solved for
    """
    free_q, of_q = by_q(g[:, :width], g[:, width + count :])
    i = len(free_q)
    shift = v[:, :width] @ of_q
    shift[:, i:] = shift[:, i:] + v[:, width + count :]
    free_u, of_u = by_u(v[:, width : width + count], shift)
    return Tangents.of(free_q, of_q, free_u, of_u)


def by_free_part(
    a: Entries, rest: Entries, partition: Partition, solve: Callable[[Entries, Entries], Entries]
) -> tuple[tuple[int, ...], Entries]:
    """See `FreePart`; the dependent x of the partition are solved for."""
    count = a.shape[1]
    free, rows, dependent = partition.independent(count), list(partition.rows), list(partition.dependent)
    solution = np.zeros((count, len(free) + rest.shape[1]), dtype=a.dtype)
    solution[list(free), range(len(free))] = 1
    if rows:
        solution[dependent] = solve(a[np.ix_(rows, dependent)], -np.hstack([a[np.ix_(rows, list(free))], rest[rows]]))
    return free, solution


def in_numbers(root: Array, preferred: Sequence[int]) -> FreePart:
    """Solving in numbers: `preferred` are dependent as far as they are determined; S Sᵀ = M⁻¹ in x of `root` says by what."""

    def solved(a: Entries, rest: Entries) -> tuple[tuple[int, ...], Entries]:
        return by_free_part(a, rest, choose(a, preferred, reach=sizes(a, root)), np.linalg.solve)

    return solved
