# SPDX-License-Identifier: BSD-3-Clause
"""The route through contacts: what a rolling body touches gives its motion, v = ω × r, as one writes it by hand.

In the place of dependent speeds stand the rates w of constraints (no slip, no lifting, a blade). They vanish, so that nothing is
eliminated for them. Where they are all of the velocity of a body's particle, velocities of the body go through that particle:

    v^X = v^Ĉ + ω × r = Σ n w + ω × r

(Kane & Levinson 1985, sec. 2.7 and 2.13). The route is taken where it is shorter, where the constraints give those dependent speeds
divided by constants alone, and where it divides by nothing of W by which the classical route does not.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derived import Derived, by_other_speeds
from kane.dynamics.poles import constraint_rate
from kane.dynamics.routes.classical import all_accelerations, classical
from kane.dynamics.routes.touches import Touch, contacts, touches
from kane.dynamics.solved import Solved
from kane.errors import KaneError
from kane.expr.build import NODE_BUILDERS, add, mul, sub
from kane.expr.count import count_operations
from kane.expr.evaluate import free_symbols
from kane.expr.matrix import Matrix
from kane.expr.node import ONE, ZERO, Expr, postorder
from kane.expr.ops import DIV, MUL, OPS
from kane.expr.symbols import Parameter, Speed, rate
from kane.expr.visit import substitute

Exprs = tuple[Expr, ...]


def shortest(derived: Derived, partition: Partition | None) -> Solved:
    """Of the classical route and those through contacts the one with the fewest operations."""
    usual = classical(derived, partition)
    if partition is None:
        return usual
    held, found = touches(derived.constraints.constraints, partition.rows, derived.kinematics), [usual]
    for chosen in _choices(held):
        dependent = _given(derived.constraints.a, partition, [r for t in chosen for r in t.rows])
        if dependent is not None:
            found += _through(derived, partition, usual, chosen, dependent)
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
        determinant = _determinant(a.take(rows, dependent))
        if determinant is not ZERO and _is_constant(determinant):
            return dict(zip(dependent, rows, strict=True))
    return None


def _determinant(a: Matrix) -> Expr:
    """By the first row: there are few, and they are sparse."""
    n, total = a.shape[0], ZERO
    if n == 0:
        return ONE
    for j in range(n):
        if a[0, j] is not ZERO:
            minor = _determinant(a.take(range(1, n), [k for k in range(n) if k != j]))
            total = (sub if j % 2 else add)(total, mul(a[0, j], minor))
    return total


def _is_constant(e: Expr) -> bool:
    return all(isinstance(s, Parameter) for s in free_symbols([e]))


def _through(
    derived: Derived, partition: Partition, usual: Solved, chosen: Sequence[Touch], dependent: Mapping[int, int]
) -> list[Solved]:
    """The solutions with the rates of these constraints in the place of the `dependent` speeds; none where they divide by more."""
    w = {r: Speed.declare(f"w{k + 1}", None, "", "rate of a constraint") for k, r in enumerate(dependent.values())}
    zero: dict[Expr, Expr] = {x: ZERO for s in w.values() for x in (s, rate(s))}
    memo: dict[Expr, Expr] = {}

    def held(e: Expr) -> Expr:
        return substitute(e, zero, memo)

    try:
        twin = _twin(derived, dependent, w, chosen, held)
        solution = classical(twin, partition)
    except KaneError:  # the speeds are no speeds then
        return []
    e = usual.embedding
    assert e is not None
    u_dot = tuple(map(held, solution.accelerations))
    reactions = tuple(map(held, solution.reactions))
    ways = (
        all_accelerations(e, [u_dot[i] for i in e.independent]),
        _by_definitions(derived, twin, u_dot, dependent, held),
    )
    divided = {f for p in twin.kinematical.pivots for f in _factors(p)}
    allowed = _divisors((*usual.accelerations, *usual.reactions))
    return [
        Solved(
            "contacts",
            derived,
            e,
            way,
            reactions,
            tuple(map(held, solution.pivots)),
            solution.reaction_matrix.map(held),
            solution.bare_reaction_matrix.map(held),
        )
        for way in ways
        if not (_divisors((*way, *reactions)) & divided) - allowed
    ]


def _twin(
    derived: Derived,
    dependent: Mapping[int, int],
    w: Mapping[int, Speed],
    chosen: Sequence[Touch],
    held: Callable[[Expr], Expr],
) -> Derived:
    """The same by other speeds, with the rows w = 0."""
    constraints, count = derived.constraints.constraints, len(derived.speeds)
    definitions: dict[Speed, Expr] = {}
    for i, (u, definition) in enumerate(derived.system.speeds.items()):
        if i in dependent:
            definitions[w[dependent[i]]] = constraint_rate(constraints[dependent[i]])
        else:
            definitions[u] = definition
    twin = by_other_speeds(derived, definitions, contacts=contacts(chosen, w, derived))
    place, rows = {r: i for i, r in dependent.items()}, twin.constraints

    def row(r: int) -> list[Expr]:
        return (
            [ONE if place[r] == j else ZERO for j in range(count)] if r in place else [held(x) for x in rows.a.rows[r]]
        )

    def rest(values: Exprs) -> Exprs:
        return tuple(ZERO if r in place else held(x) for r, x in enumerate(values))

    a = Matrix([row(r) for r in range(len(constraints))], rows.a.shape)
    own = replace(rows, a=a, a_auxiliary=derived.constraints.a_auxiliary, b=rest(rows.b), drift=rest(rows.drift))
    return replace(twin, constraints=own)


def _by_definitions(
    derived: Derived, twin: Derived, u_dot: Exprs, dependent: Mapping[int, int], held: Callable[[Expr], Expr]
) -> Exprs:
    """u̇ with those that w replaced from the derivatives of their definitions."""
    values, speeds = list(u_dot), derived.speeds
    forms = twin.kinematical.forms([derived.system.speeds[speeds[i]] for i in dependent])
    for i, form in zip(dependent, forms, strict=True):
        value, rest = ZERO, form.rest
        for j, u in enumerate(speeds):
            if j not in dependent and u in form.coefficients:
                c = form.coefficients[u]
                value, rest = add(value, mul(c, u_dot[j])), add(rest, mul(c, u))
        values[i] = add(value, held(twin.kinematics.drift(rest)))
    return tuple(values)


def _divisors(exprs: Iterable[Expr]) -> set[Expr]:
    """Factors of what expressions divide by, of tangents their cosines."""
    found: set[Expr] = set()
    for node in postorder(list(exprs)):
        if node.op is DIV:
            found |= _factors(node.args[1])
        elif node.op is OPS["tan"]:
            found.add(NODE_BUILDERS["cos"](node.args[0]))
    return found


def _factors(e: Expr) -> set[Expr]:
    """Factors of a product that are no constants."""
    if e.op is MUL:
        return _factors(e.args[0]) | _factors(e.args[1])
    return set() if _is_constant(e) else {e}
