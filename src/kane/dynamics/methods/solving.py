# SPDX-License-Identifier: BSD-3-Clause
"""M x = f + Aᵀ λ, A x + c = 0, as every method ends, solved for x, and for λ where it is asked for.

x_D = B_D x_I + d,   B_D = −A_D⁻¹ A_I,  d = −A_D⁻¹ c;   (BᵀMB) x_I = Bᵀ(f − M [d; 0]),   A_Dᵀ λ = (M x − f)_D
"""

from collections.abc import Sequence
from typing import NamedTuple

from kane.dynamics.methods.in_rates import Held
from kane.dynamics.routes.recursive import is_regular
from kane.errors import ModelError, SingularError
from kane.expr.build import add, mul, neg, sub
from kane.expr.linear_parts import affine_forms
from kane.expr.matrix import Matrix, dot
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.solve import finish, forward, ldl
from kane.expr.square_system import square

Exprs = tuple[Expr, ...]

_SINGULAR = (
    "Expected every coordinate to move a mass, got a mass matrix of the q̇ that is singular everywhere: a coordinate moves none, or "
    "some depend on each other, as Euler parameters. Kane's method, eom.by('kane'), or Lagrange's, eom.by('lagrange'), may take them."
)


class Solution(NamedTuple):
    """x and λ."""

    x: Exprs
    multipliers: Exprs


def solved(mass: Matrix, right: Sequence[Expr], held: Held | None, with_multipliers: bool = False) -> Solution:
    """x with M x = right + Aᵀ λ, A x + c = 0."""
    if held is None:
        return Solution(tuple(definite(mass.rows, right)), ())
    return _embedded(mass, right, held, with_multipliers)


def definite(rows: Sequence[Sequence[Expr]], right: Sequence[Expr]) -> list[Expr]:
    """x with M x = right, M symmetric and positive definite; a ModelError where a pivot is zero everywhere."""
    try:
        factors = ldl(rows)
    except SingularError:
        raise ModelError(_SINGULAR) from None
    if not is_regular(factors.pivots):
        raise ModelError(_SINGULAR)
    return finish(factors, forward(factors.lower, right))


class Admitted(NamedTuple):
    """x = B x_I + d of A x + c = 0: the columns of B, and d."""

    basis: list[list[Expr]]
    rest: list[Expr]


def admitted(held: Held) -> Admitted:
    """What the constraints admit."""
    n, dependent = held.a.shape[1], list(held.dependent)
    free = [i for i in range(n) if i not in set(dependent)]
    solver = square(held.a.take(columns=dependent).rows)
    rest = [ZERO] * n
    for d, x in zip(dependent, solver.solve([neg(c) for c in held.drift]), strict=True):
        rest[d] = x
    basis: list[list[Expr]] = []
    for i in free:
        own = [ZERO] * n
        own[i] = ONE
        for d, x in zip(dependent, solver.solve([neg(row[i]) for row in held.a.rows]), strict=True):
            own[d] = x
        basis.append(own)
    return Admitted(basis, rest)


def on_constraints(left: Sequence[Expr], held: Held | None, x: Sequence[Expr]) -> Exprs:
    """What must vanish: `left`; of constraints Bᵀ `left`, without multipliers, and A x + c."""
    if held is None:
        return tuple(left)
    return (*(dot(column, left) for column in admitted(held).basis), *constrained(held, x))


def constrained(held: Held, x: Sequence[Expr]) -> Exprs:
    """A x + c."""
    return tuple(add(dot(row, x), c) for row, c in zip(held.a.rows, held.drift, strict=True))


def told(held: Held | None, how: str = "a basis of the admitted motions") -> tuple[str, ...]:
    """What is said of multipliers that are eliminated."""
    if held is None:
        return ()
    count = len(held.names)
    return (f"{count} multiplier{'s' * (count > 1)}, by {how}",)


def solved_for(
    unknowns: Sequence[Expr], left: Sequence[Expr], held: Held | None, with_multipliers: bool = False
) -> Solution:
    """The unknowns with `left` = Aᵀ λ, which is affine in them, and A x + c = 0."""
    forms = affine_forms(left, unknowns)
    mass = Matrix([[form.get(x, ZERO) for x in unknowns] for form, _ in forms])
    return solved(mass, [neg(rest) for _, rest in forms], held, with_multipliers)


def _embedded(mass: Matrix, right: Sequence[Expr], held: Held, with_multipliers: bool) -> Solution:
    dependent = list(held.dependent)
    basis, rest = admitted(held)
    carried = [mass @ column for column in basis]
    left = [sub(f, dot(row, rest)) for f, row in zip(right, mass.rows, strict=True)]
    reduced = [[dot(b, c) for c in carried] for b in basis]
    found = definite(reduced, [dot(b, left) for b in basis]) if basis else []
    x = rest
    for value, column in zip(found, basis, strict=True):
        x = [add(a, mul(c, value)) for a, c in zip(x, column, strict=True)]
    if not with_multipliers:
        return Solution(tuple(x), ())
    missing = [sub(dot(mass.rows[d], x), right[d]) for d in dependent]
    return Solution(tuple(x), tuple(square(held.a.take(columns=dependent).T.rows).solve(missing)))
