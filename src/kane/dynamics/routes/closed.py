# SPDX-License-Identifier: BSD-3-Clause
"""u̇ under constraints by recursion: one more way to the base for each of them, and a block as large as they are many.

With u̇° of the tree without constraints, A u̇ + Ȧ u + ḃ = 0 and M (u̇ − u̇°) = Aᵀ λ,

    A M⁻¹ Aᵀ λ = −(A u̇° + Ȧ u + ḃ),      (A M⁻¹ Aᵀ)_rs = Σ_k e_rk e_sk / D_k,

with the shares e that a row of A, pressing on the freedoms, has of their pivots D on the way to the base. Neither M nor A_n is needed,
and what is divided by vanishes where rows of A depend on each other alone.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

from kane.dynamics.constraints.embed import Embedding, embedding
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived
from kane.dynamics.routes.articulated import Passed, inward
from kane.dynamics.routes.carried import falling, regrouped
from kane.dynamics.routes.composed import Composed
from kane.dynamics.routes.composite import factored
from kane.dynamics.routes.equations import evident, holds_reactions
from kane.dynamics.routes.freed import Articulated, Freed
from kane.dynamics.routes.holding import Holding
from kane.dynamics.routes.pressed import Number, Pressed
from kane.dynamics.routes.recursive import NO_MASS, Carrying, carrying, is_regular, with_reactions, worth_trying
from kane.dynamics.solved import Solved
from kane.errors import SingularError
from kane.expr.build import add, div, mul, neg
from kane.expr.node import ZERO, Expr
from kane.expr.regular import guards
from kane.expr.solve import finish, forward, ldl
from kane.kinematics.freedoms import Unsuited
from kane.kinematics.resolved import resolved
from kane.kinematics.travel import travel
from kane.model.bodies import deforming
from kane.model.reactions import constraint_of


def closings(derived: Derived, partition: Partition) -> Iterator[Solved]:
    """The solutions by the recursions that may be the shortest, as far as the system is a tree that constraints close.

    Of links that turn about parallel axes articulated inertias are shorter than composite ones.
    """
    try:
        carried = carrying(derived, flexible=True, shared=bool(deforming(derived.system.bodies)))
        steps = carried.segments.steps
        planar = any(step.joins for step in steps) and not any(step.modes for step in steps)
        for route in ("recursive",) if planar else worth_trying(derived, carried):
            yield _closed(derived, partition, carried, route)
    except Unsuited:
        return


def closed(derived: Derived, partition: Partition, route: str = "recursive", *, shared: bool = False) -> Solved:
    """u̇ of a tree that constraints close, with the reactions where joints of it transmit these; Unsuited where it is none.

    Joints may share coordinates where these may be `shared`.
    """
    return _closed(derived, partition, carrying(derived, flexible=True, shared=shared), route)


def _closed(derived: Derived, partition: Partition, carried: Carrying, route: str) -> Solved:
    if not (route == "recursive" and carried.crossings is not None):
        if holds_reactions(derived):
            raise Unsuited("loads that hold reactions which no joint transmits")
        carried = carried._replace(crossings=None)
    try:
        whole = _held(derived, partition, carried, _freed(derived, carried, route))
    except SingularError:
        raise Unsuited(NO_MASS) from None
    return _solved(derived, partition, carried, whole, route)


def _freed(derived: Derived, carried: Carrying, route: str) -> Freed:
    """The tree without its constraints."""
    steps, ground, asked = carried.segments.steps, falling(derived), carried.asked
    bodies = regrouped(carried.bodies, steps, route == "recursive", asked)
    if route == "recursive":
        return Articulated(inward(travel(steps), bodies, carried.loads, carried.bent), ground, asked)
    return Composed(factored(steps, bodies, carried.loads, ground, carried.bent), ground)


class _Held(NamedTuple):
    passed: Passed
    multipliers: Mapping[int, Expr]
    pivots: Sequence[Expr]
    sizes: Sequence[Expr]
    placed: Collection[int]
    """Rows whose forces are among what is transmitted."""


def _held(derived: Derived, partition: Partition, carried: Carrying, freed: Freed) -> _Held:
    """What passes with the multipliers λ of the rows."""
    if len(freed.free.rows) < len(derived.speeds):
        raise Unsuited(NO_MASS)
    holding = Holding(derived, carried.segments, freed, falling(derived))
    forces, right = zip(*map(holding.row, partition.rows), strict=True)
    matrix = _products(freed.divisors, forces)
    factors = ldl(matrix)
    solution = finish(factors, forward(factors.lower, list(map(neg, right))))
    sizes = [row[k] for k, row in enumerate(matrix)]
    return _Held(
        freed.passed(forces, solution),
        dict(zip(partition.rows, solution, strict=True)),
        factors.pivots,
        sizes,
        holding.placed(partition.rows),
    )


def _products(d: Mapping[Number, Expr], forces: Sequence[Pressed]) -> list[list[Expr]]:
    """A M⁻¹ Aᵀ."""
    e = [[each.shares.get(k, ZERO) for k in d] for each in forces]
    over = [[x if x is ZERO else div(x, p) for x, p in zip(row, d.values(), strict=True)] for row in e]
    return [[_product(x, y) for y in over] for x in e]


def _product(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    total = ZERO
    for x, y in zip(a, b, strict=True):
        if x is not ZERO and y is not ZERO:
            total = add(total, mul(x, y))
    return total


def _solved(derived: Derived, partition: Partition, carried: Carrying, whole: _Held, route: str) -> Solved:
    if not is_regular(whole.passed.pivots, derived.system.euler_parameters):
        raise Unsuited(NO_MASS)
    values, matrix = resolved(whole.passed.rows, derived.kinematics), evident(derived)
    u_dot = tuple(values[u] for u in derived.speeds)
    own = guards(zip(whole.pivots, whole.sizes, strict=True), (), u_dot)
    e = embedding(derived.constraints, partition).watching(own)
    pivots = tuple(whole.passed.pivots)
    found = Solved(route, derived, e, u_dot, (), pivots, matrix, matrix, of_rows=whole.multipliers)
    if not derived.reactions or carried.crossings is None:
        return found
    return with_reactions(found, _felt(derived, e, carried, whole))


def _felt(derived: Derived, e: Embedding, carried: Carrying, whole: _Held) -> list[Expr]:
    """What G_a R are: what is transmitted, less what the constraints exert on the far side."""
    found = []
    for a, crossing in enumerate(carried.crossings or ()):
        total = ZERO if crossing is None else crossing.measured(whole.passed.transmitted)
        for r, multiplier in whole.multipliers.items():
            if r not in whole.placed or constraint_of(derived.auxiliary_speeds[a]) is not None:
                total = add(total, neg(mul(e.rows.a_auxiliary[r, a], multiplier)))
        found.append(total)
    return found
