# SPDX-License-Identifier: BSD-3-Clause
"""Solution of the equations of motion for u̇ and the reactions, as straight-line code.

    M u̇ = f + G R                 n equations
    M_a u̇ = f_a + G_a R           one for each auxiliary speed

M is factored as L D Lᵀ. With y = L⁻¹ f, Z = L⁻¹ G and X = L⁻¹ M_aᵀ the reactions solve

    (G_a − Xᵀ D⁻¹ Z) R = Xᵀ D⁻¹ y − f_a,

a small block, and u̇ = L⁻ᵀ D⁻¹ (y + Z R). Where no reaction enters an active force, Z = 0 and R follows from u̇.

The order in which a symmetric matrix is eliminated, so that little of what is zero is filled.
"""

from collections.abc import Sequence
from typing import NamedTuple

from kane.dynamics.forcing import Blocks, primitive
from kane.errors import SingularError
from kane.expr.build import add, div, mul, sub
from kane.expr.forms.collect import collected
from kane.expr.forms.count import price
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO, Expr
from kane.expr.solve import ldl, solve_lu, sparse_order


class BlockSolution(NamedTuple):
    """u̇ and R, the pivots of M, G_a − Xᵀ D⁻¹ Z, and what that is without loads that hold reactions.

    Where reactions are named in loads alone, these cannot be told from others: the latter is G_a with them.
    """

    accelerations: tuple[Expr, ...]
    reactions: tuple[Expr, ...]
    pivots: tuple[Expr, ...]
    reaction_matrix: Matrix
    bare_reaction_matrix: Matrix


def block_solution(blocks: Blocks) -> BlockSolution:
    """Solve for u̇ and R; a SingularError where a pivot of M, or of what R is solved from, is zero whatever the state.

    Equations that hold each other's u̇ are divided by what parameters and numbers all of their terms have in common, and what is left
    is collected, where that is shorter.
    """
    usual, shorter = _solution(blocks), primitive(blocks)
    if shorter is blocks:
        return usual
    every = [usual, _solution(shorter)]
    forcing = tuple(map(collected, shorter.forcing))
    if any(x is not y for x, y in zip(forcing, shorter.forcing, strict=True)):
        every.append(_solution(shorter._replace(forcing=forcing)))
    return min(every, key=lambda s: price((*s.accelerations, *s.reactions)))


def _solution(blocks: Blocks) -> BlockSolution:
    factors = ldl(blocks.mass.rows, sparse_order(blocks.mass.rows))
    y, z = factors.forward(blocks.forcing), list(map(factors.forward, blocks.coupling.T))
    coupled = any(x is not ZERO for column in z for x in column)
    matrix = blocks.coupling_a
    if not coupled:
        u_dot = factors.finish(y)
        right = [sub(dot(m, u_dot), f) for m, f in zip(blocks.mass_a, blocks.forcing_a, strict=True)]
    else:
        x = [factors.over(factors.forward(row)) for row in blocks.mass_a]
        matrix = Matrix(
            [[sub(g, dot(r, c)) for g, c in zip(row, z, strict=True)] for row, r in zip(matrix, x, strict=True)]
        )
        right = [sub(dot(r, y), f) for r, f in zip(x, blocks.forcing_a, strict=True)]
    reactions = solved_reactions(matrix, right)
    if coupled:
        for reaction, column in zip(reactions, z, strict=True):
            y = [v if c is ZERO else add(v, mul(c, reaction)) for v, c in zip(y, column, strict=True)]
        u_dot = factors.finish(y)
    known = all(any(x is not ZERO for x in row) for row in blocks.evident.rows)
    pivots = dict(zip(factors.order, factors.pivots, strict=True))
    return BlockSolution(
        tuple(u_dot),
        tuple(reactions),
        tuple(pivots[i] for i in range(len(pivots))),
        matrix,
        blocks.evident if known else blocks.coupling_a,
    )


def solved_reactions(matrix: Matrix, right: Sequence[Expr]) -> list[Expr]:
    """R of G_a R = `right`."""
    diagonal = [row[i] for i, row in enumerate(matrix)]
    if any(x is not ZERO for i, row in enumerate(matrix) for j, x in enumerate(row) if i != j):
        return solve_lu(matrix.rows, [right])[0]
    if any(x is ZERO for x in diagonal):
        raise SingularError("Expected each reaction to enter its own equation, got a zero on the diagonal.")
    return [div(b, x) for b, x in zip(right, diagonal, strict=True)]
