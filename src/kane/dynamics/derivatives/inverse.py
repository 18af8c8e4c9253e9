# SPDX-License-Identifier: BSD-3-Clause
"""∂(M u̇ − f)/∂x of trees with u̇ held: what an equilibrium, a steady motion and the flow beside one are made of."""

from collections.abc import Sequence

from kane.dynamics.derivation import Derived
from kane.dynamics.derivatives.changes import changes
from kane.dynamics.derivatives.tree import Tree
from kane.dynamics.trees.inverse_dynamics import joint_forces, joint_mass, joint_rows
from kane.dynamics.trees.line import line_at, motions
from kane.expr.build import add
from kane.expr.differentiation import tangent
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Symbol, rate


def residual_slopes(derived: Derived, symbols: Sequence[Symbol]) -> Matrix:
    """∂(M u̇ − f)/∂symbols in u̇, a row for each speed; Unsuited, with what is in the way, where the system is no tree of joint speeds.

    With g of the joint speeds w at λ(u̇, x): Σ_w ∂w/∂u (∂g/∂x + M ∂λ/∂x) + g ∂²w/∂u ∂x.
    """
    line = line_at(derived, [rate(u) for u in derived.speeds])
    moving = motions(line)
    g = Tree(line, moving, changes(line, moving, symbols), symbols).left()
    rows, forces = joint_rows(line, derived).T, joint_forces(line)
    columns = []
    for x in symbols:
        by_lambda = [_slope(e, x) for e in line.lambdas]
        change = [g.entries.get((k, x), ZERO) for k in range(len(line.places))]
        if any(e is not ZERO for e in by_lambda):
            change = list(map(add, change, joint_mass(line) @ by_lambda))
        turned = rows.map(lambda e, x=x: _slope(e, x))  # type: ignore[misc]
        columns.append([add(dot(row, change), dot(other, forces)) for row, other in zip(rows, turned, strict=True)])
    return Matrix(zip(*columns, strict=True), (len(derived.speeds), len(symbols)))


def _slope(e: Expr, x: Symbol) -> Expr:
    return tangent(e, {x: ONE}, at_rest=True)
