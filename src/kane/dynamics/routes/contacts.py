# SPDX-License-Identifier: BSD-3-Clause
"""The route through contacts: what a rolling body touches gives its motion, v = ω × r, as one writes it by hand.

In the place of dependent speeds stand the rates w of constraints (no slip, no lifting, a blade). They vanish, so that nothing is
eliminated for them. Where they are all of the velocity of a body's particle, velocities of the body go through that particle:

    v^X = v^Ĉ + ω × r = Σ n w + ω × r

(Kane & Levinson 1985, sec. 2.7 and 2.13). The route is taken where it is shorter, where the constraints give those dependent speeds
divided by constants alone, and where it divides by nothing of W by which the classical route does not.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derived import Derived, by_other_speeds
from kane.dynamics.routes.classical import all_accelerations, classical
from kane.dynamics.routes.rates import ConstraintRates, constraint_rates
from kane.dynamics.routes.touches import Touch, contacts, touches
from kane.dynamics.solved import Solved
from kane.errors import KaneError
from kane.expr.build import NODE_BUILDERS, add, mul
from kane.expr.count import count_operations
from kane.expr.evaluate import is_constant_in_time
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr, postorder
from kane.expr.ops import OPS
from kane.expr.regular import denominators, factors, unguarded
from kane.expr.solve import determinant

Exprs = tuple[Expr, ...]


def shortest(derived: Derived, partition: Partition | None) -> Solved:
    """Of the classical route and those through contacts the one with the fewest operations."""
    usual = classical(derived, partition)
    if partition is None:
        return usual
    held, found = touches(derived.constraints.constraints, partition.rows, derived.kinematics), [usual]
    allowed = _divisors((*usual.accelerations, *usual.reactions)) if held else set()
    for chosen in _choices(held):
        rows = _given(derived.constraints.a, partition, [r for t in chosen for r in t.rows])
        if rows is not None:
            found += _through(derived, partition, usual, chosen, constraint_rates(rows), allowed)
    return min(found, key=lambda s: count_operations((*s.accelerations, *s.reactions)).total)


def _choices(held: Sequence[Touch]) -> Iterator[tuple[Touch, ...]]:
    """All together, and each alone."""
    if held:
        yield tuple(held)
    if len(held) > 1:
        yield from ((t,) for t in held)


def _given(a: Matrix, partition: Partition, rows: Sequence[int]) -> dict[int, int] | None:
    """Dependent speeds that these constraints give, divided by constants alone, with the row that each stands for."""
    for dependent in combinations(partition.dependent, len(rows)):
        size = determinant(a.take(rows, dependent).rows)
        if size is not ZERO and is_constant_in_time([size]):
            return dict(zip(dependent, rows, strict=True))
    return None


def _through(
    derived: Derived,
    partition: Partition,
    usual: Solved,
    chosen: Sequence[Touch],
    w: ConstraintRates,
    allowed: set[Expr],
) -> list[Solved]:
    """The solutions with the rates of these constraints in the places of dependent speeds; none where they divide by more."""
    try:
        twin = _twin(derived, w, chosen)
        found = classical(twin, partition).mapped(w.held)
    except KaneError:  # the speeds are no speeds then
        return []
    e = usual.embedding
    assert e is not None
    ways = (
        all_accelerations(e, [found.accelerations[i] for i in e.independent]),
        _by_definitions(derived, twin, found.accelerations, w),
    )
    pivots = (f for p in twin.kinematical.pivots for f in factors(p))
    more = {f for f in pivots if not is_constant_in_time([f])} - allowed
    return [
        replace(found, route="contacts", derived=derived, embedding=e, accelerations=way)
        for way in ways
        if more.isdisjoint(_divisors((*way, *found.reactions)))
    ]


def _twin(derived: Derived, w: ConstraintRates, chosen: Sequence[Touch]) -> Derived:
    """The same by other speeds, with the rows w = 0."""
    twin = by_other_speeds(derived, w.definitions(derived), contacts=contacts(chosen, w.speeds, derived))
    rows = twin.constraints
    m, n = rows.a.shape

    def rest(values: Exprs) -> Exprs:
        return tuple(ZERO if r in w.speeds else w.held(x) for r, x in enumerate(values))

    a = Matrix([w.row(r, n) if r in w.speeds else [w.held(x) for x in rows.a.rows[r]] for r in range(m)], (m, n))
    own = replace(rows, a=a, a_auxiliary=derived.constraints.a_auxiliary, b=rest(rows.b), drift=rest(rows.drift))
    return replace(twin, constraints=own)


def _by_definitions(derived: Derived, twin: Derived, u_dot: Exprs, w: ConstraintRates) -> Exprs:
    """u̇ with those that w replaced from the derivatives of their definitions."""
    values, speeds = list(u_dot), derived.speeds
    forms = twin.kinematical.forms([derived.system.speeds[speeds[i]] for i in w.rows])
    for i, form in zip(w.rows, forms, strict=True):
        value, rest = ZERO, form.rest
        for j, u in enumerate(speeds):
            if j not in w.rows and u in form.coefficients:
                c = form.coefficients[u]
                value, rest = add(value, mul(c, u_dot[j])), add(rest, mul(c, u))
        values[i] = add(value, w.held(twin.kinematics.drift(rest)))
    return tuple(values)


def _divisors(exprs: Sequence[Expr]) -> set[Expr]:
    """What expressions divide by, with its factors; of tangents their cosines."""
    plain = unguarded(exprs)
    tangents = (node for node in postorder(plain) if node.op is OPS["tan"])
    found = {f for d in denominators(plain) for f in factors(d)}
    return found | {NODE_BUILDERS["cos"](node.args[0]) for node in tangents}
