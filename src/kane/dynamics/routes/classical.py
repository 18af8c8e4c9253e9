# SPDX-License-Identifier: BSD-3-Clause
"""The classical route: M, f and G assembled, constraints embedded, M factored as L D Lᵀ.

Each generalized force being F̃_r = F_r + Σ_D A_n[D, r] F_D (Kane & Levinson 1985, sec. 4.4), with u̇ = B u̇_I + c, B = [1; A_n],

    (BᵀMB) u̇_I = Bᵀ(f − M c) + BᵀG R

The auxiliary equations take the total partial velocities likewise: (M_a + A_naᵀ M_D) u̇ = f_a + A_naᵀ f_D + (G_a + A_naᵀ G_D) R.
"""

from collections.abc import Sequence

from kane.dynamics.blocks import Blocks
from kane.dynamics.checks import check_mass
from kane.dynamics.constraints.embed import Embedding, embedding
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived
from kane.dynamics.routes.block_solution import block_solution
from kane.dynamics.solved import Solved
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr


def classical(derived: Derived, partition: Partition | None) -> Solved:
    """u̇ and the reactions from M u̇ = f + G R; a speed, or a combination of speeds, that moves no mass is a ModelError."""
    return unguarded_classical(derived, partition).guarded()


def unguarded_classical(derived: Derived, partition: Partition | None, e: Embedding | None = None) -> Solved:
    """The same, where what is divided by is not watched yet, with the embedding `e` of the partition, if there is one already."""
    system, speeds, blocks = derived.system, derived.speeds, derived.blocks
    if partition is None:
        check_mass(system, speeds, blocks.mass)
        return Solved("classical", derived, None, *block_solution(blocks))
    e = e or embedding(derived.constraints, partition)
    inner = _reduced(e, blocks)
    check_mass(system, [speeds[i] for i in e.independent], inner.mass)
    solution = block_solution(inner)
    every = solution._replace(accelerations=all_accelerations(e, solution.accelerations))
    return Solved("classical", derived, e, *every)


def _reduced(e: Embedding, blocks: Blocks) -> Blocks:
    """The equations of motion in the independent speeds, and the auxiliary ones with total partial velocities."""
    own, dependent = e.independent, e.partition.dependent
    a_n_t, a_na_t, c = e.a_n.T, e.a_na.T, Matrix.column(e.c)

    def times_b(m: Matrix) -> Matrix:
        return m.take(columns=own) + m.take(columns=dependent) @ e.a_n

    def b_t_times(m: Matrix) -> Matrix:
        return m.take(own) + a_n_t @ m.take(dependent)

    def total(m_a: Matrix, m: Matrix) -> Matrix:
        return m_a + a_na_t @ m.take(dependent)

    spread = times_b(blocks.mass)
    forcing = Matrix.column(blocks.forcing)
    left = forcing - blocks.mass.take(columns=dependent) @ c
    released = any(x is not ZERO for x in e.a_na.entries)
    left_a = Matrix.column(blocks.forcing_a) - blocks.mass_a.take(columns=dependent) @ c
    return Blocks(
        b_t_times(spread).mirrored(),
        (b_t_times(left) if released else b_t_times(forcing) - spread.take(dependent).T @ c).entries,
        b_t_times(blocks.coupling),
        total(times_b(blocks.mass_a), spread),
        total(left_a, left).entries,
        total(blocks.coupling_a, blocks.coupling),
        blocks.evident,
    )


def all_accelerations(e: Embedding, u_dot: Sequence[Expr]) -> tuple[Expr, ...]:
    """u̇ = B u̇_I + c."""
    values = dict(zip(e.independent, u_dot, strict=True))
    dependent = e.a_n @ Matrix.column(u_dot) + Matrix.column(e.c)
    values.update(zip(e.partition.dependent, dependent.entries, strict=True))
    return tuple(values[i] for i in range(len(values)))
