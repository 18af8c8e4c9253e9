# SPDX-License-Identifier: BSD-3-Clause
"""Perturbations of a state that satisfy the constraints, by the implicit function theorem.

    G δq + ∂f/∂r δr = 0                       δq = T ξ,  ξ = N ξ_I + P δr
    A δu + ∂(A u + b)/∂q δq + ∂b/∂r δr = 0     δu = B δu_I + E ξ_I + Q δr

ξ are free perturbations of the coordinates, three angles θ along the axes of the oriented frame for each set of Euler parameters, with
δe = ½ E(e) θ and θ̇ = δω − ω × θ. Arrays have entries that are numbers or expressions.
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

    The angles are along the axes of the oriented frame. `coordinates` are indices of the other coordinates, `sets` those of Euler
    parameters, whose angles come last in ξ. `timed` is true if the equations contain the time.
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
    """½ E(e) (4 × 3), δe = ½ E(e) θ for small angles θ along axes of the frame (Kane, Likins & Levinson 1983, sec. 1.13)."""
    e0, e1, e2, e3 = e
    return 0.5 * np.array([[-e1, -e2, -e3], [e0, -e3, e2], [e3, e0, -e1], [-e2, e1, e0]])


def turning_rates(rates: Entries, plain: int) -> Entries:
    """The matrix of θ ↦ ω × θ (ξ × ξ); `rates` are those of ξ: first those of `plain` coordinates, then ω of each set."""
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
    """N, P, B, E, Q of the perturbations that satisfy the constraints, and the indices of the independent ξ and u."""

    free_q: tuple[int, ...]
    free_u: tuple[int, ...]
    n: Entries
    p: Entries
    b: Entries
    e: Entries
    q: Entries

    @classmethod
    def of(cls, free_q: Sequence[int], of_q: Entries, free_u: Sequence[int], of_u: Entries) -> "Tangents":
        """From the derivatives of ξ in (ξ_I, r) and of u in (u_I, ξ_I, r), at one state or at many (leading axes)."""
        i, j = len(free_q), len(free_u)
        u_parts = of_u[..., :j], of_u[..., j : j + i], of_u[..., j + i :]
        return cls(tuple(free_q), tuple(free_u), of_q[..., :i], of_q[..., i:], *u_parts)

    @property
    def moves(self) -> Entries:
        """Derivative of (ξ, u, r) in (ξ_I, u_I, r)."""
        many, (width, nr), i, j = self.p.shape[:-2], self.p.shape[-2:], len(self.free_q), len(self.free_u)
        rows = (
            [self.n, np.zeros((*many, width, j)), self.p],
            [self.e, self.b, self.q],
            [np.zeros((*many, nr, i + j)), np.broadcast_to(np.eye(nr), (*many, nr, nr))],
        )
        return np.concatenate([np.concatenate(row, axis=-1) for row in rows], axis=-2)


FreePart = Callable[[Entries, Entries], tuple[tuple[int, ...], Entries]]
"""A solver of a x + rest y = 0: returns the indices of the independent x, and S of x = S (x_independent, y)."""


def tangents(g: Entries, v: Entries, width: int, count: int, by_q: FreePart, by_u: FreePart) -> Tangents:
    """The perturbations that satisfy the constraints at a point, in numbers or in expressions.

    Parameters
    ----------
    g, v : derivatives of f and of A u + b in (ξ, u, r)
    width, count : numbers of ξ and of u
    by_q, by_u : solvers for ξ and for u
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
    """Solve for the dependent x of a partition; see `FreePart`."""
    count = a.shape[1]
    free, rows, dependent = partition.independent(count), list(partition.rows), list(partition.dependent)
    solution = np.zeros((count, len(free) + rest.shape[1]), dtype=a.dtype)
    solution[list(free), range(len(free))] = 1
    if rows:
        solution[dependent] = solve(a[np.ix_(rows, dependent)], -np.hstack([a[np.ix_(rows, list(free))], rest[rows]]))
    return free, solution


def in_numbers(root: Array, preferred: Sequence[int]) -> FreePart:
    """Numerical solver; `preferred` x become dependent where the rank allows. `root` is S of S Sᵀ = M⁻¹, which sets the sizes."""

    def solved(a: Entries, rest: Entries) -> tuple[tuple[int, ...], Entries]:
        return by_free_part(a, rest, choose(a, preferred, reach=sizes(a, root)), np.linalg.solve)

    return solved
