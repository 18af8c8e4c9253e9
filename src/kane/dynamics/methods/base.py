# SPDX-License-Identifier: BSD-3-Clause
"""What a method gives: equations in its own unknowns and variables, solved, and u̇ from them.

Every method ends in M x = f + Aᵀ λ, A x + c = 0, solved for x, and for λ where it is asked for:

    x = B x_I + d,   (BᵀMB) x_I = Bᵀ(f − M d),   A_Dᵀ λ = (M x − f)_D
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, NamedTuple

from kane import show
from kane.dynamics.forcing import blocks
from kane.dynamics.formulation.recursive import is_regular
from kane.dynamics.in_rates import InRates, LinearConstraints
from kane.dynamics.lazy import read
from kane.errors import ModelError, SingularError
from kane.expr.build import add, neg, sub
from kane.expr.differentiation import affine_forms
from kane.expr.evaluation import Operations, count_operations
from kane.expr.matrix import Matrix, dot, ldl
from kane.expr.node import ZERO, Expr, Exprs
from kane.expr.ops import Immutable


@dataclass(frozen=True, eq=False, repr=False)
class Formulation(Immutable):
    """The equations of motion of a system by one method, from `eom.by`.

    `equations` are expressions in the `unknowns` that must be zero. Solved for the unknowns, and without the quantities that
    `eliminated` lists, they give `right_hand_side`, the rates of the variables `state` of the method. `accelerations` are u̇ of
    the declared generalized speeds that follow, in q and u, for comparison between methods.
    """

    method: str
    source: str
    state: Exprs
    unknowns: Exprs
    eliminated: tuple[str, ...]
    equations_by: Callable[[], Exprs]
    right_hand_side_by: Callable[[], Exprs]
    accelerations_by: Callable[[], Exprs]

    equations = read[Exprs](lambda f: f.equations_by(), "Expressions in the unknowns that must be zero.")
    right_hand_side = read[Exprs](lambda f: f.right_hand_side_by(), "The rates of the state.")
    accelerations = read[Exprs](lambda f: f.accelerations_by(), "u̇ of the declared generalized speeds, in q and u.")
    operations = read[Operations](
        lambda f: count_operations(f.right_hand_side), "Operations of one evaluation of the right-hand side."
    )

    def __reduce__(self) -> tuple[Callable[..., "Formulation"], tuple[Any, ...]]:
        written = (self.equations, self.right_hand_side, self.accelerations)
        known = (partial(tuple, exprs) for exprs in written)
        return Formulation, (self.method, self.source, self.state, self.unknowns, self.eliminated, *known)

    def __repr__(self) -> str:
        gone = f"; eliminated: {', '.join(self.eliminated)}" if self.eliminated else ""
        return f"Formulation({self.method}: {len(self.unknowns)} unknowns{gone})"

    def __str__(self) -> str:
        lines = [f"0 = {e}" for e in self.equations]
        return "\n".join([f"{self.method} ({self.source}), in {', '.join(map(str, self.unknowns))}", *lines])

    _repr_html_ = show.html


_SINGULAR = (
    "Expected every coordinate to move a mass, got a mass matrix of the q̇ that is singular everywhere: a coordinate moves none, or "
    "some depend on each other, as Euler parameters do. Use Kane's method, eom.by('kane'), or Lagrange's, eom.by('lagrange')."
)


class SolvedUnknowns(NamedTuple):
    """x and λ."""

    x: Exprs
    multipliers: Exprs


def solved(
    mass: Matrix, right: Sequence[Expr], held: LinearConstraints | None, with_multipliers: bool = False
) -> SolvedUnknowns:
    """x with M x = right + Aᵀ λ, A x + c = 0."""
    if held is None:
        return SolvedUnknowns(tuple(definite(mass.rows, right)), ())
    e = held.embedding
    inner = e.reduced(blocks([list(row) for row in mass.rows], right, (), (), {}))
    x = e.every(definite(inner.mass.rows, inner.forcing) if e.independent else ())
    if not with_multipliers:
        return SolvedUnknowns(x, ())
    residual = [sub(dot(mass.rows[d], x), right[d]) for d in held.dependent]
    return SolvedUnknowns(x, tuple(e.transposed.solve(residual)))


def definite(rows: Sequence[Sequence[Expr]], right: Sequence[Expr]) -> list[Expr]:
    """x with M x = right, M symmetric and positive definite; a ModelError where a pivot is zero everywhere."""
    try:
        factors = ldl(rows)
    except SingularError:
        raise ModelError(_SINGULAR) from None
    if not is_regular(factors.pivots):
        raise ModelError(_SINGULAR)
    return factors.solve(right)


def on_constraints(left: Sequence[Expr], held: LinearConstraints | None, x: Sequence[Expr]) -> Exprs:
    """What must vanish: `left`; of constraints Bᵀ `left`, without multipliers, and A x + c."""
    if held is None:
        return tuple(left)
    return (*held.embedding.transposed_times(Matrix.column(left)).entries, *constrained(held, x))


def constrained(held: LinearConstraints, x: Sequence[Expr]) -> Exprs:
    """A x + c."""
    return tuple(add(dot(row, x), c) for row, c in zip(held.a.rows, held.drift, strict=True))


def elimination_notes(held: LinearConstraints | None, how: str = "a basis of the admitted motions") -> tuple[str, ...]:
    """What is said of multipliers that are eliminated."""
    if held is None:
        return ()
    count = len(held.names)
    return (f"{count} multiplier{'s' * (count > 1)}, by {how}",)


def solved_for(
    unknowns: Sequence[Expr], left: Sequence[Expr], held: LinearConstraints | None, with_multipliers: bool = False
) -> SolvedUnknowns:
    """The unknowns with `left` = Aᵀ λ, which is affine in them, and A x + c = 0."""
    forms = affine_forms(left, unknowns)
    mass = Matrix([[form.get(x, ZERO) for x in unknowns] for form, _ in forms])
    return solved(mass, [neg(rest) for _, rest in forms], held, with_multipliers)


def in_accelerations(
    s: InRates,
    name: str,
    source: str,
    inertia: Callable[[], Exprs],
    gone: tuple[str, ...] = (),
    multipliers: tuple[Expr, ...] = (),
) -> Formulation:
    """The formulation `inertia` − Q = Aᵀ λ in the unknowns q̈ and, where they are named, the multipliers λ."""
    left = cache(lambda: tuple(sub(e, q) for e, q in zip(inertia(), s.forces, strict=True)))
    solution = cache(lambda: solved_for(s.accelerations, left(), s.held, bool(multipliers)))

    def equations() -> Exprs:
        if s.held is None or not multipliers:
            return on_constraints(left(), s.held, s.accelerations)
        with_forces = (sub(e, dot(column, multipliers)) for e, column in zip(left(), s.held.a.T, strict=True))
        return (*with_forces, *constrained(s.held, s.accelerations))

    return Formulation(
        name,
        source,
        (*s.coordinates, *s.rates),
        (*s.accelerations, *multipliers),
        gone if multipliers else (*gone, *elimination_notes(s.held)),
        equations,
        lambda: (*s.rates, *solution().x, *solution().multipliers),
        lambda: s.speeds_rates(solution().x),
    )
