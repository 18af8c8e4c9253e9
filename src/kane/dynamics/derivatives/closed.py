# SPDX-License-Identifier: BSD-3-Clause
"""∂u̇/∂x of trees that constraints close, u̇ and λ of what is left of the equations held.

    M u̇ − f = Aᵀ λ,   A u̇ + c = 0,   c = Ȧ u + ḃ

hold wherever the recursion gives u̇, on the constraints or off them. With r = M u̇ − f − Aᵀ λ,

    A M⁻¹ Aᵀ ∂λ = A M⁻¹ ∂r − ∂(A u̇ + c),   ∂u̇ = M⁻¹ (Aᵀ ∂λ − ∂r).
"""

from collections.abc import Sequence

from kane.dynamics.derivatives.inverse import residual_slopes
from kane.dynamics.derivatives.stages import Stage
from kane.dynamics.routes.block_solution import sparse_order
from kane.dynamics.solved import Solved
from kane.dynamics.trees.inverse_dynamics import mass_matrix, residual
from kane.expr.build import add, div, neg, sub
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ZERO, Expr
from kane.expr.solve import finish, forward, ldl
from kane.expr.symbols import Symbol, rate
from kane.expr.visit import substituted
from kane.kinematics.freedoms import Unsuited


def closed_slopes(solved: Solved, symbols: Sequence[Symbol]) -> list[Sequence[Expr]]:
    """∂u̇/∂symbols, a column for each symbol; Unsuited where the system is no tree of joint speeds that constraints close."""
    d, e = solved.derived, solved.embedding
    if e is None:
        raise Unsuited("no constraints")
    rows, a = e.partition.rows, d.constraints.a.take(e.partition.rows)
    held: dict[Expr, Expr] = dict(zip(map(rate, d.speeds), solved.accelerations, strict=True))
    memo: dict[Expr, Expr] = {}
    by_x = residual_slopes(d, symbols).map(lambda x: substituted(x, held, memo))
    left = [substituted(x, held, memo) for x in residual(d)]
    every = e.multipliers([left[i] for i in e.partition.dependent])
    drift = [d.constraints.drift[r] for r in rows]
    pull = Stage(lambda *x: a.T @ x, [every[r] for r in rows])
    pace = Stage(lambda *x: tuple(map(add, a @ x, drift)), solved.accelerations)
    solver = _Solver(mass_matrix(d), a)
    columns: list[Sequence[Expr]] = []
    for column, x in zip(by_x.T, symbols, strict=True):
        lifted = pull.slope(x) or [ZERO] * len(column)
        turned = pace.slope(x) or [ZERO] * len(rows)
        columns.append(solver([sub(b, c) for b, c in zip(lifted, column, strict=True)], list(map(neg, turned))))
    return columns


class _Solver:
    """∂u̇ of M ∂u̇ − Aᵀ ∂λ = b and A ∂u̇ = c, M factored along its branches."""

    def __init__(self, mass: Matrix, a: Matrix) -> None:
        self.order = sparse_order(mass.rows)
        self.factors = ldl(mass.take(self.order, self.order).rows)
        self.pressed = [forward(self.factors.lower, [row[i] for i in self.order]) for row in a]
        self.shares = [self._over(row) for row in self.pressed]
        self.block = ldl([[dot(x, y) for y in self.shares] for x in self.pressed])

    def _over(self, column: Sequence[Expr]) -> list[Expr]:
        return [x if x is ZERO else div(x, p) for x, p in zip(column, self.factors.pivots, strict=True)]

    def __call__(self, b: Sequence[Expr], c: Sequence[Expr]) -> Sequence[Expr]:
        if all(x is ZERO for x in (*b, *c)):
            return [ZERO] * len(b)
        y = forward(self.factors.lower, [b[i] for i in self.order])
        right = [sub(x, dot(share, y)) for x, share in zip(c, self.shares, strict=True)]
        multipliers = finish(self.block, forward(self.block.lower, right))
        whole = [add(v, dot(multipliers, own)) for v, own in zip(y, zip(*self.pressed, strict=True), strict=True)]
        found = dict(zip(self.order, finish(self.factors, whole), strict=True))
        return [found[i] for i in range(len(b))]
