# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of (q̇, u̇) as functions of all coordinates, all speeds, time, inputs and parameters.

They are those of the expressions as they stand: under constraints u̇ of all speeds, each as a function of the whole state. What is
divided by is what the values are divided by, with its guards, so that derivatives are NaN where they are.
"""

from collections.abc import Sequence

from kane.collector import collecting_seldom
from kane.dynamics.derivatives.closed import closed_slopes
from kane.dynamics.derivatives.tree import acceleration_slopes
from kane.dynamics.readings.regularity import nan_where_more
from kane.dynamics.routes.recursive import WAYS
from kane.dynamics.solved import Solved
from kane.errors import SingularError
from kane.expr.count import Prices
from kane.expr.differentiation import tangent, weighted
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Symbol
from kane.kinematics.freedoms import Unsuited

_SHORT = 30_000
"""Operations times columns up to which trees are differentiated as they stand, too, and the shorter form is taken."""


@collecting_seldom()
def slopes(solved: Solved, symbols: Sequence[Symbol]) -> Matrix:
    """J = ∂(q̇, u̇)/∂symbols, a row for each of q̇ and u̇; of trees by inverse dynamics, where that is shorter.

    Along the length of a set of Euler parameters, which is 1, no derivative means anything, and none is promised.
    """
    shape = len(solved.right_hand_side), len(symbols)
    by_tree = _of_tree(solved, symbols)
    if by_tree is not None and solved.operations.total * len(symbols) > _SHORT:
        return Matrix(by_tree, shape)
    columns = [forward(solved, [s], [ONE]) for s in symbols]
    ways: list[list[Sequence[Expr]]] = [list(zip(*columns, strict=True))]
    if by_tree is not None:
        ways.append(by_tree)
    price = Prices((*solved.right_hand_side,))
    return Matrix(min(ways, key=lambda rows: price(x for row in rows for x in row)), shape)


def _of_tree(solved: Solved, symbols: Sequence[Symbol]) -> list[Sequence[Expr]] | None:
    if not symbols or (solved.embedding is not None and solved.route not in WAYS):
        return None
    route = solved.route if solved.route in WAYS else next(iter(WAYS))
    try:
        if solved.embedding is None:
            columns = acceleration_slopes(solved.derived, solved.accelerations, symbols, route)
        else:
            columns = closed_slopes(solved, symbols)
    except (Unsuited, SingularError):
        return None
    rates = [[tangent(e, {s: ONE}, at_rest=True) for s in symbols] for e in solved.rates]
    further = [[tangent(e, {s: ONE}, at_rest=True) for s in symbols] for e in solved.state_rates]
    return [*rates, *zip(*columns, strict=True), *further]


def forward(solved: Solved, symbols: Sequence[Symbol], v: Sequence[Expr]) -> Sequence[Expr]:
    """J v."""
    roots, memo = solved.right_hand_side, dict[Expr, Expr]()
    seeds: dict[Expr, Expr] = dict(zip(symbols, v, strict=True))
    return nan_where_more(solved, roots, [tangent(e, seeds, memo, at_rest=True) for e in roots])


def backward(solved: Solved, symbols: Sequence[Symbol], w: Sequence[Expr]) -> Sequence[Expr]:
    """wᵀ J."""
    return _all_or_none(solved, weighted(solved.right_hand_side, w, symbols))


def second(solved: Solved, symbols: Sequence[Symbol], w: Sequence[Expr], v: Sequence[Expr]) -> Sequence[Expr]:
    """∂(wᵀ J v)/∂symbols: the Hessians of (q̇, u̇), weighted by w, times v."""
    memo: dict[Expr, Expr] = {}
    seeds: dict[Expr, Expr] = dict(zip(symbols, v, strict=True))
    own = weighted(solved.right_hand_side, w, symbols)
    return _all_or_none(solved, [tangent(e, seeds, memo, at_rest=True) for e in own])


def _all_or_none(solved: Solved, found: Sequence[Expr]) -> Sequence[Expr]:
    """NaN where one of (q̇, u̇), the last of which is one under constraints, is."""
    last = solved.right_hand_side[-1:] * len(found)
    return found if all(x is ZERO for x in found) else nan_where_more(solved, last, found)
