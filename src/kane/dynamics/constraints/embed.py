# SPDX-License-Identifier: BSD-3-Clause
"""Constraints embedded: the equations of motion in the independent speeds.

With the dependent speeds of a partition, A_D u_D + A_I u_I + A_a u_a + b = 0 gives

    u_D = A_n u_I + A_na u_a + b_n          A_n = −A_D⁻¹ A_I,   A_na = −A_D⁻¹ A_a,   b_n = −A_D⁻¹ b
    u̇_D = A_n u̇_I + c_D                     c_D = −A_D⁻¹ (Ȧ u + ḃ)

and, each generalized force being F̃_r = F_r + Σ_D A_n[D, r] F_D (Kane & Levinson 1985, sec. 4.4), with u̇ = B u̇_I + c, B = [1; A_n],

    (BᵀMB) u̇_I = Bᵀ(f − M c) + BᵀG R

The auxiliary equations take the total partial velocities likewise: (M_a + A_naᵀ M_D) u̇ = f_a + A_naᵀ f_D + (G_a + A_naᵀ G_D) R.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from kane.dynamics.constraints.partition import Partition
from kane.dynamics.routes.reduce import Blocks, Rows, Solved, solve_motion
from kane.expr.build import add, neg, sub
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO, Expr
from kane.expr.solve import eliminate
from kane.kinematics.constraints import ConstraintRows


@dataclass(frozen=True, slots=True, eq=False)
class Embedding:
    """The dependent speeds by the independent ones: A_n (d × i), A_na (d × a), b_n, c_D (d), and what was divided by."""

    partition: Partition
    independent: tuple[int, ...]
    a_n: Matrix
    a_na: Matrix
    b_n: tuple[Expr, ...]
    c: tuple[Expr, ...]
    pivots: tuple[Expr, ...]


def embedding(rows: ConstraintRows, partition: Partition, count: int, auxiliary: int) -> Embedding:
    """Solve the constraints for the dependent speeds of `partition` among `count` speeds."""
    free = partition.independent(count)
    square = [[rows.a[r][c] for c in partition.dependent] for r in partition.rows]
    columns = [[neg(rows.a[r][i]) for r in partition.rows] for i in free]
    columns += [[neg(rows.a_auxiliary[r][a]) for r in partition.rows] for a in range(auxiliary)]
    columns += [[neg(rows.b[r]) for r in partition.rows], [neg(rows.drift[r]) for r in partition.rows]]
    solved, pivots = eliminate(square, columns)
    d, i = len(partition.rows), len(free)
    return Embedding(
        partition,
        free,
        _across(solved[:i], d),
        _across(solved[i : i + auxiliary], d),
        tuple(solved[-2]),
        tuple(solved[-1]),
        tuple(pivots),
    )


def _across(columns: Sequence[Sequence[Expr]], height: int) -> Matrix:
    return Matrix([[column[k] for column in columns] for k in range(height)], (height, len(columns)))


def reduced(e: Embedding, blocks: Blocks) -> Blocks:
    """The equations of motion in the independent speeds."""
    mass, forcing, coupling, mass_a, forcing_a, coupling_a = blocks
    free, given = e.independent, e.partition.dependent
    b_columns = [[row[k] for row in e.a_n.rows] for k in range(len(free))]
    # M B, column by column over all speeds, then Bᵀ (M B)
    spread = [
        [add(row[i], dot([row[g] for g in given], b)) for i, b in zip(free, b_columns, strict=True)] for row in mass
    ]
    held = [dot([row[g] for g in given], e.c) for row in mass]
    left = [sub(f, h) for f, h in zip(forcing, held, strict=True)]

    def gather(values: Sequence[Expr], k: int) -> Expr:
        return add(values[free[k]], dot([values[g] for g in given], b_columns[k]))

    count = len(free)
    m: Rows = [[ZERO] * count for _ in range(count)]
    for k in range(count):
        for j in range(k + 1):
            m[k][j] = m[j][k] = gather([row[j] for row in spread], k)
    width = len(coupling[0]) if coupling else 0
    g = [[gather([row[j] for row in coupling], k) for j in range(width)] for k in range(count)]
    a_columns = [[row[k] for row in e.a_na.rows] for k in range(len(mass_a))]
    spread_a = [
        [add(row[i], dot([row[x] for x in given], b)) for i, b in zip(free, b_columns, strict=True)] for row in mass_a
    ]
    total_a = [
        [add(x, dot([spread[v][j] for v in given], a)) for j, x in enumerate(row)]
        for row, a in zip(spread_a, a_columns, strict=True)
    ]
    left_a = [
        add(sub(f, dot([row[x] for x in given], e.c)), dot([left[v] for v in given], a))
        for f, row, a in zip(forcing_a, mass_a, a_columns, strict=True)
    ]
    g_a = [
        [add(x, dot([coupling[v][j] for v in given], a)) for j, x in enumerate(row)]
        for row, a in zip(coupling_a, a_columns, strict=True)
    ]
    return Blocks(m, [gather(left, k) for k in range(count)], g, total_a, left_a, g_a)


def solve_embedded(e: Embedding, blocks: Blocks, count: int) -> Solved:
    """u̇ of all `count` speeds, dependent ones too, and the reactions, from the reduced equations."""
    solved = solve_motion(blocks)
    u_dot: list[Expr] = [ZERO] * count
    for i, a in zip(e.independent, solved.accelerations, strict=True):
        u_dot[i] = a
    for d, row, c in zip(e.partition.dependent, e.a_n.rows, e.c, strict=True):
        u_dot[d] = add(dot(row, solved.accelerations), c)
    return Solved(tuple(u_dot), solved.reactions, solved.pivots, solved.reaction_matrix, solved.bare_reaction_matrix)


def multipliers(rows: ConstraintRows, partition: Partition, residual: Sequence[Expr]) -> tuple[Expr, ...]:
    """λ with A_Dᵀ λ = (M u̇ − f)_D, by constraint; zero for redundant rows."""
    square = [[rows.a[r][c] for r in partition.rows] for c in partition.dependent]
    (found,), _ = eliminate(square, [[residual[c] for c in partition.dependent]])
    values: list[Expr] = [ZERO] * len(rows.constraints)
    for r, x in zip(partition.rows, found, strict=True):
        values[r] = x
    return tuple(values)
