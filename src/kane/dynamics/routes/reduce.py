# SPDX-License-Identifier: BSD-3-Clause
"""Solution of the equations of motion for u̇ and the reactions, as straight-line code.

    M u̇ = f + G R                 n equations
    M_a u̇ = f_a + G_a R           one for each auxiliary speed

M is factored as L D Lᵀ. With y = L⁻¹ f, Z = L⁻¹ G and X = L⁻¹ M_aᵀ the reactions solve

    (G_a − Xᵀ D⁻¹ Z) R = Xᵀ D⁻¹ y − f_a,

a small block, and u̇ = L⁻ᵀ D⁻¹ (y + Z R). Where no reaction enters an active force, Z = 0 and R follows from u̇.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from kane.errors import SingularError
from kane.expr.build import add, div, mul, sub
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO, Expr
from kane.expr.solve import finish, forward, ldl, solve_lu

Rows = list[list[Expr]]


class Blocks(NamedTuple):
    """M, f, G of the generalized speeds and M_a, f_a, G_a of the auxiliary ones."""

    mass: Rows
    forcing: list[Expr]
    coupling: Rows
    mass_a: Rows
    forcing_a: list[Expr]
    coupling_a: Rows


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """u̇, R, and what was divided by on the way.

    `pivots` are those of M. `reaction_matrix` is G_a − Xᵀ D⁻¹ Z, `bare_reaction_matrix` is G_a: a change of the sign of their
    determinants' ratio is Painlevé's case.
    """

    accelerations: tuple[Expr, ...]
    reactions: tuple[Expr, ...]
    pivots: tuple[Expr, ...]
    reaction_matrix: Matrix
    bare_reaction_matrix: Matrix


def solve_motion(blocks: Blocks) -> Solved:
    """Solve for u̇ and R."""
    mass, forcing, coupling, mass_a, forcing_a, coupling_a = blocks
    factors = ldl(mass)
    d = factors.pivots
    y = forward(factors, forcing)
    count = len(forcing_a)
    if not count:
        u_dot = finish(factors, y)
        return Solved(tuple(u_dot), (), tuple(d), Matrix([], (0, 0)), Matrix([], (0, 0)))
    columns = [[row[j] for row in coupling] for j in range(count)]
    coupled = any(x is not ZERO for column in columns for x in column)
    if not coupled:
        u_dot = finish(factors, y)
        right = [sub(dot(m, u_dot), f) for m, f in zip(mass_a, forcing_a, strict=True)]
        matrix = coupling_a
    else:
        z = [forward(factors, column) for column in columns]
        x = [[div(v, p) for v, p in zip(forward(factors, row), d, strict=True)] for row in mass_a]
        matrix = [[sub(coupling_a[i][j], dot(x[i], z[j])) for j in range(count)] for i in range(count)]
        right = [sub(dot(x[i], y), forcing_a[i]) for i in range(count)]
    reactions = _solve_block(matrix, right)
    if coupled:
        for j, column in enumerate(z):
            y = [v if c is ZERO else add(v, mul(c, reactions[j])) for v, c in zip(y, column, strict=True)]
        u_dot = finish(factors, y)
    return Solved(tuple(u_dot), tuple(reactions), tuple(d), Matrix(matrix), Matrix(coupling_a))


def _solve_block(matrix: list[list[Expr]], right: list[Expr]) -> list[Expr]:
    diagonal = all(x is ZERO for i, row in enumerate(matrix) for j, x in enumerate(row) if i != j)
    if diagonal:
        if any(matrix[i][i] is ZERO for i in range(len(right))):
            raise SingularError("Expected each reaction to enter its own equation, got a zero on the diagonal.")
        return [div(b, matrix[i][i]) for i, b in enumerate(right)]
    return solve_lu(matrix, [right])[0]
