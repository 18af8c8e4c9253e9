# SPDX-License-Identifier: BSD-3-Clause
"""Constraints embedded: the dependent speeds, first chosen, by the independent ones.

With the dependent speeds of a partition, A_D u_D + A_I u_I + A_a u_a + b = 0 gives

    u_D = A_n u_I + A_na u_a + b_n          A_n = −A_D⁻¹ A_I,   A_na = −A_D⁻¹ A_a,   b_n = −A_D⁻¹ b
    u̇_D = A_n u̇_I + c_D                     c_D = −A_D⁻¹ (Ȧ u + ḃ)
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kane.dynamics.constraints.choice import Compared, chosen
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.constraints.redundancy import check_determinate
from kane.errors import ModelError
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr, constant_value
from kane.expr.solve import LU, lu
from kane.kinematics.constraints import ConstraintRows
from kane.model.system import System


@dataclass(frozen=True, eq=False)
class Embedding:
    """The dependent speeds by the independent ones: A_n (d × i), A_na (d × a), b_n, c_D (d), and what was divided by."""

    rows: ConstraintRows
    partition: Partition
    independent: tuple[int, ...]
    a_n: Matrix
    a_na: Matrix
    b_n: tuple[Expr, ...]
    c: tuple[Expr, ...]
    pivots: tuple[Expr, ...]

    @cached_property
    def transposed(self) -> LU:
        """The factors of A_Dᵀ.

        They are its own, not those of A_D transposed: the same numbers, but other expressions wherever a factor is a quotient.
        """
        return lu(self.rows.a.take(self.partition.rows, self.partition.dependent).T.rows)

    def multipliers(self, residual: Sequence[Expr]) -> tuple[Expr, ...]:
        """λ with A_Dᵀ λ = (M u̇ − f)_D, the `residual` of the dependent speeds, by constraint; zero for redundant rows."""
        values = dict(zip(self.partition.rows, self.transposed.solve(residual), strict=True))
        return tuple(values.get(r, ZERO) for r in range(len(self.rows.constraints)))


def embedding(rows: ConstraintRows, partition: Partition) -> Embedding:
    """Solve the constraints for the dependent speeds of `partition`; no pivot of A_D may be zero whatever the state."""
    free = partition.independent(rows.a.shape[1])
    factors = lu(rows.a.take(partition.rows, partition.dependent).rows)

    def negative_solution(right: Matrix) -> Matrix:
        columns = (-right.take(partition.rows)).T
        return Matrix([factors.solve(b) for b in columns], columns.shape).T

    return Embedding(
        rows,
        partition,
        free,
        negative_solution(rows.a.take(columns=free)),
        negative_solution(rows.a_auxiliary),
        negative_solution(Matrix.column(rows.b)).entries,
        negative_solution(Matrix.column(rows.drift)).entries,
        factors.pivots,
    )


def first_partition(system: System, rows: ConstraintRows, compared: Compared) -> Partition:
    """The partition at configurations that satisfy the constraints, parameters at their defaults.

    What the user made dependent is taken first. There the constraints must give `dependent_speeds` and not contradict each other, and
    every reaction must be determined.
    """
    place = {u: i for i, u in enumerate(system.speeds)}
    easy = np.array([constant_value(x) is not None for x in rows.a.entries]).reshape(rows.a.shape)
    partition = chosen(compared.a, [place[u] for u in system.dependent_speeds], easy)
    strangers = [str(u) for u in system.dependent_speeds if place[u] not in partition.dependent]
    if strangers:
        raise ModelError(
            f"Expected dependent_speeds= that the constraints give, got {', '.join(strangers)}, which they do not determine together "
            "with the others listed. Choose others, or leave them out to have them chosen."
        )
    check_determinate(system, rows, compared.a, compared.at)
    return partition
