# SPDX-License-Identifier: BSD-3-Clause
"""The equations of motion solved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.derived import Derived
from kane.expr.build import add, sub
from kane.expr.count import Operations, count_operations
from kane.expr.matrix import Matrix, dot
from kane.expr.node import Expr
from kane.expr.ops import CONST, DIV, NEG
from kane.expr.symbols import Speed, rate
from kane.model.constraints import Constraint


class Pivot(NamedTuple):
    """A pivot of A_D, the dependent speed that it gives, and what code that divides by it has as denominators."""

    speed: Speed
    value: Expr
    divisors: tuple[Expr, ...]


@dataclass(frozen=True, eq=False)
class Solved:
    """u̇ and R by one route with one choice of dependent speeds, and what was divided by on the way.

    `pivots` are those of the mass matrix. `reaction_matrix` is what the reactions are solved from, `bare_reaction_matrix` the same
    without the loads that hold reactions: a change of the sign of their determinants' ratio is Painlevé's case.
    """

    route: str
    derived: Derived
    embedding: Embedding | None
    accelerations: tuple[Expr, ...]
    reactions: tuple[Expr, ...]
    pivots: tuple[Expr, ...]
    reaction_matrix: Matrix
    bare_reaction_matrix: Matrix

    @property
    def right_hand_side(self) -> tuple[Expr, ...]:
        """(q̇, u̇) as functions of the state."""
        return (*self.derived.rates, *self.accelerations)

    @cached_property
    def operations(self) -> Operations:
        """Operations of one evaluation of (q̇, u̇) and the reactions."""
        return count_operations((*self.right_hand_side, *self.reactions))

    # Dependent speeds ----------------------------------------------------------------------------------------------------

    @property
    def dependent_speeds(self) -> tuple[Speed, ...]:
        """u_D, the speeds that the constraints give."""
        return tuple(self.derived.speeds[i] for i in self.embedding.partition.dependent) if self.embedding else ()

    @property
    def independent_speeds(self) -> tuple[Speed, ...]:
        """u_I, as many as there are degrees of freedom."""
        speeds = self.derived.speeds
        return tuple(speeds[i] for i in self.embedding.independent) if self.embedding else speeds

    @property
    def redundant(self) -> tuple[Constraint, ...]:
        """Constraints that follow from the others, where they were compared."""
        rows = self.embedding.partition.redundant if self.embedding else ()
        return tuple(self.derived.constraints.constraints[r] for r in rows)

    @cached_property
    def dependent_pivots(self) -> tuple[Pivot, ...]:
        """The pivots of A_D that are not plain numbers, in the order of elimination; multipliers divide by those of A_Dᵀ."""
        e = self.embedding
        if e is None:
            return ()
        rows = zip(self.dependent_speeds, e.pivots, e.transposed.pivots, strict=True)
        return tuple(Pivot(u, x, (_divisor(x), _divisor(y))) for u, x, y in rows if x.op is not CONST)

    @cached_property
    def multipliers(self) -> Mapping[Constraint, Expr]:
        """λ of M u̇ = f + Aᵀ λ by constraint, in u̇ and reactions."""
        e, d = self.embedding, self.derived
        if e is None:
            return {}
        u_dot = [rate(u) for u in d.speeds]
        residual = [sub(dot(d.blocks.mass.rows[i], u_dot), d.forcing[i]) for i in e.partition.dependent]
        return dict(zip(d.constraints.constraints, e.multipliers(residual), strict=True))

    def nonholonomic(self, forces: Sequence[Expr]) -> tuple[Expr, ...]:
        """F̃_r = F_r + Σ_D A_n[D, r] F_D of the independent, then the auxiliary speeds, for the `forces` F_r of all speeds."""
        e, n = self.embedding, len(self.derived.speeds)
        if e is None:
            return tuple(forces)
        dependent = [forces[i] for i in e.partition.dependent]
        own = [*(forces[i] for i in e.independent), *forces[n:]]
        columns = (*e.a_n.T, *e.a_na.T)
        return tuple(add(f, dot(column, dependent)) for f, column in zip(own, columns, strict=True))

    @cached_property
    def Fr_nh(self) -> tuple[Expr, ...]:
        """F̃_r."""
        return self.nonholonomic(self.derived.Fr)

    @cached_property
    def Fr_star_nh(self) -> tuple[Expr, ...]:
        """F̃*_r."""
        return self.nonholonomic(self.derived.Fr_star)


def _divisor(pivot: Expr) -> Expr:
    """What x / pivot is written with as its denominator: signs are taken out, and x / (a/b) is x b / a."""
    while pivot.op is NEG or pivot.op is DIV:
        pivot = pivot.args[0]
    return pivot
