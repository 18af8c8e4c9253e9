# SPDX-License-Identifier: BSD-3-Clause
"""Constraint embedding: u_D and u̇_D in the independent speeds, and the equations of motion reduced to these.

With the dependent speeds u_D of a partition, A_D u_D + A_I u_I + A_a u_a + b = 0 gives

    u_D = A_n u_I + A_na u_a + b_n          A_n = −A_D⁻¹ A_I,   A_na = −A_D⁻¹ A_a,   b_n = −A_D⁻¹ b
    u̇_D = A_n u̇_I + c_D                     c_D = −A_D⁻¹ (Ȧ u + ḃ)

Each generalized force becomes F̃_r = F_r + Σ_D A_n[D, r] F_D (Kane & Levinson 1985, sec. 4.4). With u̇ = B u̇_I + c, B = [1; A_n],

    (BᵀMB) u̇_I = Bᵀ(f − M c) + BᵀG R

The auxiliary equations are formed with the total partial velocities: (M_a + A_naᵀ M_D) u̇ = f_a + A_naᵀ f_D + (G_a + A_naᵀ G_D) R.

`watch` makes expressions that tell, at a state on the constraints, whether rows A_R left out as redundant follow from the others:
A_R,I + A_R,D A_n must vanish beside the sizes of its terms and of the row at other configurations.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, reduce
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from kane.dynamics.constraints.manifold import Manifold
from kane.dynamics.constraints.partition import Compared, Partition
from kane.dynamics.forcing import Blocks
from kane.dynamics.lazy import read
from kane.expr.build import NODE_BUILDERS, add, div, mul, where
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr, constant
from kane.expr.regular import Guards, Sizes, guarding, guards, guards_by_parts, largest, size
from kane.expr.square_system import Divisor, SquareSolver, square
from kane.expr.symbols import Speed
from kane.kinematics.velocities import Following
from kane.kinematics.velocity_constraints import ConstraintRows
from kane.model.constraints import Constraint
from kane.numeric.scale import CLOSED_NEARLY


class DependentSpeeds(NamedTuple):
    """A_n (d × i), A_na (d × a), b_n and c_D (d), the divisors, and the sizes of these and of their factors."""

    a_n: Matrix
    a_na: Matrix
    b_n: tuple[Expr, ...]
    c: Callable[[], tuple[Expr, ...]]
    divisors: tuple[Divisor, ...] = ()
    guards: Guards = MappingProxyType({})

    def guarded(self, by: Guards) -> "DependentSpeeds":
        """The same expressions, NaN where a divisor vanishes."""
        guard = guarding({**by, **self.guards})
        return self._replace(
            a_n=self.a_n.map(guard),
            a_na=self.a_na.map(guard),
            b_n=tuple(map(guard, self.b_n)),
            c=lambda: tuple(map(guard, self.c())),
        )


@dataclass(frozen=True, eq=False)
class Embedding:
    """The dependent speeds in the independent ones, solved for when first read.

    `beside` are the sizes of further divisors of results. Solutions are guarded last, after all cancellation.
    """

    rows: ConstraintRows
    partition: Partition
    independent: tuple[int, ...]
    solve: Callable[[], DependentSpeeds]
    beside: Guards = field(default_factory=dict)

    solution = read[DependentSpeeds](lambda e: e.solve(), "The solution for the dependent speeds and their rates.")
    a_n = read[Matrix](lambda e: e.solution.a_n, "A_n of u_D = A_n u_I + A_na u_a + b_n.")
    a_na = read[Matrix](lambda e: e.solution.a_na, "A_na of u_D = A_n u_I + A_na u_a + b_n.")
    b_n = read[tuple[Expr, ...]](lambda e: e.solution.b_n, "b_n of u_D = A_n u_I + A_na u_a + b_n.")
    c = read[tuple[Expr, ...]](lambda e: e.solution.c(), "c_D of u̇_D = A_n u̇_I + c_D.")
    divisors = read[tuple[Divisor, ...]](lambda e: e.solution.divisors, "The solver of the constraints.")
    guards = read[Guards](
        lambda e: {**e.beside, **e.solution.guards},
        "The sizes of the divisors, of their factors, and of other divisors of the results.",
    )

    @property
    def guards_in_use(self) -> Guards:
        """The guards of divisors; those of the solution only if it has been read."""
        return self.guards if "solution" in self.__dict__ else self.beside

    transposed = read[SquareSolver](
        lambda e: square(e.rows.a.take(e.partition.rows, e.partition.dependent).T.rows),
        "The solver with A_Dᵀ, separate because its expressions differ wherever a factor is a quotient.",
    )

    def multipliers(self, residual: Sequence[Expr]) -> tuple[Expr, ...]:
        """λ by constraint, from A_Dᵀ λ = (M u̇ − f)_D, the `residual` of the dependent speeds; zero for redundant rows."""
        solution, divisors = self.transposed.solve(residual), self.transposed.divisors
        own = guards([(d.value, d.size) for d in divisors], [*self.rows.a.entries, *residual], solution)
        values = dict(zip(self.partition.rows, map(guarding(own | dict(self.guards)), solution), strict=True))
        return tuple(values.get(r, ZERO) for r in range(len(self.rows.constraints)))

    def following(self, speeds: Sequence[Speed]) -> dict[Expr, Following]:
        """The dependent speeds as functions of the independent ones."""
        own = [speeds[i] for i in self.independent]
        rows: list[dict[Expr, Expr]] = [
            {u: c for u, c in zip(own, row, strict=True) if c is not ZERO} for row in self.a_n.rows
        ]
        places = [speeds[d] for d in self.partition.dependent]
        parts = zip(places, rows, self.b_n, self.c, strict=True)
        return {u: Following(row, rest, bias) for u, row, rest, bias in parts}

    def every(self, u_dot: Sequence[Expr]) -> tuple[Expr, ...]:
        """u̇ = B u̇_I + c."""
        values = dict(zip(self.independent, u_dot, strict=True))
        dependent = self.a_n @ Matrix.column(u_dot) + Matrix.column(self.c)
        values.update(zip(self.partition.dependent, dependent.entries, strict=True))
        return tuple(values[i] for i in range(len(values)))

    def transposed_times(self, m: Matrix) -> Matrix:
        """Bᵀ m."""
        return m.take(self.independent) + self.a_n.T @ m.take(self.partition.dependent)

    def reduced(self, blocks: Blocks) -> Blocks:
        """M, f and G of the independent speeds, BᵀMB, Bᵀ(f − M c) and BᵀG, and those of auxiliary speeds in u̇_I."""
        dependent, a_na_t, c = self.partition.dependent, self.a_na.T, Matrix.column(self.c)

        def times_b(m: Matrix) -> Matrix:
            return m.take(columns=self.independent) + m.take(columns=dependent) @ self.a_n

        def total(m_a: Matrix, m: Matrix) -> Matrix:
            return m_a + a_na_t @ m.take(dependent)

        spread = times_b(blocks.mass)
        forcing = Matrix.column(blocks.forcing)
        left = forcing - blocks.mass.take(columns=dependent) @ c
        left_a = Matrix.column(blocks.forcing_a) - blocks.mass_a.take(columns=dependent) @ c
        if any(x is not ZERO for x in self.a_na.entries):
            right = self.transposed_times(left)
        else:
            right = self.transposed_times(forcing) - spread.take(dependent).T @ c
        return Blocks(
            self.transposed_times(spread).mirrored(),
            right.entries,
            self.transposed_times(blocks.coupling),
            total(times_b(blocks.mass_a), spread),
            total(left_a, left).entries,
            total(blocks.coupling_a, blocks.coupling),
            blocks.evident,
        )

    def watching(self, beside: Guards) -> "Embedding":
        """The embedding with the sizes of further divisors."""
        return replace(self, solve=lambda: self.solution, beside=beside)

    def guarded(self) -> "Embedding":
        """The same expressions, NaN where a divisor vanishes."""
        return replace(self, solve=lambda: self.solution.guarded(self.beside))


def embedding(rows: ConstraintRows, partition: Partition) -> Embedding:
    """The embedding of constraints with the dependent speeds of `partition`."""
    free = partition.independent(rows.a.shape[1])
    return Embedding(rows, partition, free, lambda: _solution(rows, partition, free))


def _solution(rows: ConstraintRows, partition: Partition, free: Sequence[int]) -> DependentSpeeds:
    memo: Sizes = {}
    whole = rows.a.take(partition.rows).rows
    solver = square(
        rows.a.take(partition.rows, partition.dependent).rows, lambda i: largest(size(x, memo) for x in whole[i])
    )

    def negative_solution(right: Matrix) -> Matrix:
        columns = (-right.take(partition.rows)).T
        return Matrix([solver.solve(b) for b in columns], columns.shape).T

    @cache
    def c() -> tuple[Expr, ...]:
        return negative_solution(Matrix.column(rows.drift)).entries

    inputs = (rows.a.take(columns=free), rows.a_auxiliary, Matrix.column(rows.b))
    a_n, a_na, b_n = map(negative_solution, inputs)

    before = (lambda: (x for m in (rows.a, *inputs) for x in m.entries), lambda: rows.drift)
    after = (lambda: (x for m in (a_n, a_na, b_n) for x in m.entries), c)
    sizes = guards_by_parts([(d.value, d.size) for d in solver.divisors], before, after)
    return DependentSpeeds(a_n, a_na, b_n.entries, c, solver.divisors, sizes)


_HOLDS = 1e-2
"""Share above which a row holds more: beside a place where branches meet it is the root of what a closed state may leave open."""


class RedundantRow(NamedTuple):
    """A redundant row: the largest entry of A_R,I + A_R,D A_n (`beyond`), and the `limit` below which the row follows."""

    constraint: Constraint
    beyond: Expr
    limit: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Watch:
    """The redundant rows, and the residual `open` of the configuration constraints, scaled to be below 1 if they are closed."""

    rows: tuple[RedundantRow, ...]
    open: Expr

    def guarding(self) -> tuple[Callable[[Expr], Expr], dict[Expr, Constraint]]:
        """A function that makes an expression NaN where a row does not follow, and the guard, 1 or NaN, of each row."""
        less = NODE_BUILDERS["less"]
        off = where(less(self.open, ONE), ZERO, ONE)
        follow = [where(less(r.limit, r.beyond), off, ONE) for r in self.rows]
        guards = [NODE_BUILDERS["regular"](x, ONE) for x in follow]
        lost = guards[-1]
        for x, guard in zip(follow[-2::-1], guards[-2::-1], strict=True):
            lost = where(less(ZERO, x), lost, guard)
        all_follow = less(ZERO, reduce(NODE_BUILDERS["min"], follow))
        names = dict(zip(guards, (r.constraint for r in self.rows), strict=True))
        return lambda value: where(all_follow, value, lost), names


def watch(embedding: Embedding, compared: Compared, conditions: Manifold) -> Watch | None:
    """The watch of the redundant rows of `embedding`, with sizes from the `compared` configurations; None if there are no rows."""
    rows, redundant = embedding.rows, embedding.partition.redundant
    if not redundant:
        return None
    own = rows.a.take(redundant, embedding.independent)
    by_dependent = rows.a.take(redundant, embedding.partition.dependent)
    usual = np.abs(compared.a[:, list(redundant)]).max(axis=(0, 2), initial=0)
    found, absolute = [], NODE_BUILDERS["abs"]
    for k, r in enumerate(redundant):
        sizes = list(map(absolute, by_dependent.rows[k]))
        pairs = list(zip(own.rows[k], embedding.a_n.T, strict=True))
        beyond = largest(add(x, dot(by_dependent.rows[k], column)) for x, column in pairs)
        terms = largest(add(absolute(x), dot(sizes, list(map(absolute, column)))) for x, column in pairs)
        limit = mul(constant(_HOLDS), largest([terms, constant(float(usual[k]))]))
        found.append(RedundantRow(rows.constraints[r], beyond, limit))
    reach = compared.reach(conditions)
    off = largest(div(f, constant(float(CLOSED_NEARLY * r))) for f, r in zip(conditions.f, reach, strict=True) if r > 0)
    return Watch(tuple(found), off)
