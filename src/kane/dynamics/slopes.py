# SPDX-License-Identifier: BSD-3-Clause
"""Exact derivatives of (q̇, u̇), and of M u̇ − f of trees, by coordinates, speeds, time, inputs and parameters.

Under constraints u̇ of every speed is differentiated as a function of the whole state. The derivatives have the divisors and guards
of the values, so that they are NaN at the same states. For trees they follow from the derivatives of inverse dynamics.
"""

from collections.abc import Iterator, Mapping, Sequence

from kane.dynamics.derivation import Derived
from kane.dynamics.formulation.recursive import WAYS
from kane.dynamics.inverse_dynamics import TreeInverse, inverse_at, inverse_of, mass_matrix, residual
from kane.dynamics.readings.regularity import nan_where_more
from kane.dynamics.solved import Solved
from kane.errors import SingularError
from kane.expr.build import add, neg, sub
from kane.expr.differentiation import tangent, weighted
from kane.expr.evaluation import Prices
from kane.expr.matrix import Matrix, dot, ldl, sparse_order
from kane.expr.node import ONE, ZERO, Expr, Exprs
from kane.expr.symbols import Symbol, rate
from kane.expr.visit import substituted
from kane.kinematics.freedoms import Unsuited, resolved
from kane.progress import collecting_seldom
from kane.tree.tangents import TracedFunction, tangents, total

_SHORT = 30_000
"""Operations times columns up to which trees are differentiated as they stand, too, and the shorter form is taken."""


@collecting_seldom()
def slopes(solved: Solved, symbols: Sequence[Symbol]) -> Matrix:
    """J = ∂(q̇, u̇)/∂symbols, a row for each of q̇ and u̇; of trees by inverse dynamics if that takes fewer operations.

    Derivatives along the length of a set of Euler parameters, which is 1, are undefined.
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
    rates, further = ([[_slope(e, s) for s in symbols] for e in own] for own in (solved.rates, solved.state_rates))
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
    """The derivatives, all NaN at states where one of (q̇, u̇) is."""
    last = solved.right_hand_side[-1:] * len(found)
    return found if all(x is ZERO for x in found) else nan_where_more(solved, last, found)


def acceleration_slopes(
    derived: Derived, u_dot: Sequence[Expr], symbols: Sequence[Symbol], route: str
) -> list[Sequence[Expr]]:
    """∂u̇/∂symbols of trees, a column for each symbol. Unsuited if the system is not a tree of joint speeds.

    ∂ẇ/∂x = −M⁻¹ ∂g/∂x, where g(ẇ, x) are the forces of inverse dynamics, differentiated at constant ẇ. M is that of the
    composite-rigid-body algorithm, factored along the branches without fill-in. `route` is the recursion that u̇ belong to.
    """
    inverse = inverse_of(derived, u_dot, route)
    g = tangents(inverse.tree, inverse.ground, inverse.lambdas, symbols)

    def speeds_by(*lambdas: Expr) -> Exprs:
        found = resolved(zip(inverse.rows, lambdas, strict=True), derived.kinematics)
        return tuple(found[u] for u in derived.speeds)

    last = TracedFunction(speeds_by, inverse.lambdas)
    columns = []
    for x, change in zip(symbols, _solved(inverse, g, symbols), strict=True):
        both = [None if change is None else last.along(change), last.slope(x)]
        columns.append(total(both) or [ZERO] * len(derived.speeds))
    return columns


def _solved(
    inverse: TreeInverse, g: Mapping[tuple[int, Symbol], Expr], symbols: Sequence[Symbol]
) -> Iterator[Sequence[Expr] | None]:
    """∂λ/∂x = −M⁻¹ ∂g/∂x by symbol; None if it is zero."""
    mass = inverse.mass().rows
    factors = ldl(mass, sparse_order(mass))
    for x in symbols:
        right = [neg(g.get((i, x), ZERO)) for i in range(len(mass))]
        yield None if all(e is ZERO for e in right) else factors.solve(right)


def residual_slopes(derived: Derived, symbols: Sequence[Symbol]) -> Matrix:
    """∂(M u̇ − f)/∂symbols in u̇, a row for each speed. Unsuited, with the reason, if the system is not a tree of joint speeds.

    With the forces g of the joint speeds w at λ(u̇, x): Σ_w ∂w/∂u (∂g/∂x + M ∂λ/∂x) + g ∂²w/∂u ∂x. Used for equilibria, steady
    motions and their linearization.
    """
    inverse = inverse_at(derived, [rate(u) for u in derived.speeds])
    g = tangents(inverse.tree, inverse.ground, inverse.lambdas, symbols)
    rows, forces = inverse.by_speeds(derived).T, inverse.forces()
    columns = []
    for x in symbols:
        by_lambda = [_slope(e, x) for e in inverse.lambdas]
        change = [g.get((k, x), ZERO) for k in range(len(inverse.rows))]
        if any(e is not ZERO for e in by_lambda):
            change = list(map(add, change, inverse.mass() @ by_lambda))
        turned = rows.map(lambda e, x=x: _slope(e, x))  # type: ignore[misc]
        columns.append([add(dot(row, change), dot(other, forces)) for row, other in zip(rows, turned, strict=True)])
    return Matrix(zip(*columns, strict=True), (len(derived.speeds), len(symbols)))


def _slope(e: Expr, x: Symbol) -> Expr:
    return tangent(e, {x: ONE}, at_rest=True)


def closed_slopes(solved: Solved, symbols: Sequence[Symbol]) -> list[Sequence[Expr]]:
    """∂u̇/∂symbols, a column for each symbol. Unsuited if the system is not a tree of joint speeds closed by constraints.

        M u̇ − f = Aᵀ λ,   A u̇ + c = 0,   c = Ȧ u + ḃ

    hold for u̇ of the recursion, also off the constraint manifold. With r = M u̇ − f − Aᵀ λ at constant u̇ and λ,

        A M⁻¹ Aᵀ ∂λ = A M⁻¹ ∂r − ∂(A u̇ + c),   ∂u̇ = M⁻¹ (Aᵀ ∂λ − ∂r).
    """
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
    pull = TracedFunction(lambda *x: a.T @ x, [every[r] for r in rows])
    pace = TracedFunction(lambda *x: tuple(map(add, a @ x, drift)), solved.accelerations)
    solver = _Solver(mass_matrix(d), a)
    columns: list[Sequence[Expr]] = []
    for column, x in zip(by_x.T, symbols, strict=True):
        lifted = pull.slope(x) or [ZERO] * len(column)
        turned = pace.slope(x) or [ZERO] * len(rows)
        columns.append(solver([sub(b, c) for b, c in zip(lifted, column, strict=True)], list(map(neg, turned))))
    return columns


class _Solver:
    """Solves M ∂u̇ − Aᵀ ∂λ = b, A ∂u̇ = c for ∂u̇, with M factored along the branches of the tree."""

    def __init__(self, mass: Matrix, a: Matrix) -> None:
        self.factors = ldl(mass.rows, sparse_order(mass.rows))
        self.forwarded = list(map(self.factors.forward, a))
        self.shares = list(map(self.factors.over, self.forwarded))
        self.block = ldl([[dot(x, y) for y in self.shares] for x in self.forwarded])

    def __call__(self, b: Sequence[Expr], c: Sequence[Expr]) -> Sequence[Expr]:
        if all(x is ZERO for x in (*b, *c)):
            return [ZERO] * len(b)
        y = self.factors.forward(b)
        multipliers = self.block.solve([sub(x, dot(share, y)) for x, share in zip(c, self.shares, strict=True)])
        columns = zip(*self.forwarded, strict=True)
        return self.factors.finish([add(v, dot(multipliers, own)) for v, own in zip(y, columns, strict=True)])
