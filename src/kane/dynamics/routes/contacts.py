# SPDX-License-Identifier: BSD-3-Clause
"""Rates of constraints as speeds: what a rolling body touches gives its motion, v = ω × r, as one writes it by hand.

In the place of dependent speeds stand the rates w of constraints (no slip, no lifting, a blade). They vanish, so that nothing is
eliminated for them. Where they are all of the velocity of a body's particle, velocities of the body go through that particle:

    v^X = v^Ĉ + ω × r = Σ n w + ω × r

(Kane & Levinson 1985, sec. 2.7 and 2.13). Constraints are replaced so where they give dependent speeds divided by constants alone.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

from kane.dynamics.constraints.partition import Partition
from kane.dynamics.constraints.touches import Touch, contacts
from kane.dynamics.derivation import Derived, by_other_speeds
from kane.dynamics.routes.rates import ConstraintRates, constraint_rates
from kane.errors import KaneError
from kane.expr.build import add, mul
from kane.expr.evaluation import is_constant_in_time
from kane.expr.matrix import Matrix
from kane.expr.node import ZERO, Expr
from kane.expr.solve import determinant
from kane.kinematics.constraints import constraint_rows

Exprs = tuple[Expr, ...]


def twins(derived: Derived, partition: Partition, held: Sequence[Touch]) -> Iterator[tuple[Derived, ConstraintRates]]:
    """The same with the rates of motion constraints as speeds, all together and each point's alone, with the rows w = 0."""
    constraints = derived.constraints.constraints
    moving = [t for t in held if any(constraints[r].kind == "motion" for r in t.rows)]
    for chosen in _choices(moving):
        rows = _given(derived.constraints.a, partition, [r for t in chosen for r in t.rows])
        if rows is not None:
            w = constraint_rates(rows)
            try:
                yield _twin(derived, w, chosen), w
            except KaneError:  # the speeds are no speeds then
                continue


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


def _twin(derived: Derived, w: ConstraintRates, chosen: Sequence[Touch]) -> Derived:
    """The same by other speeds, with the rows w = 0."""
    known = contacts(chosen, w.speeds, derived.kinematics)
    twin = by_other_speeds(derived, w.definitions(derived), derived.constraints, known)
    constraints, (m, n) = derived.constraints.constraints, derived.constraints.a.shape
    others = [r for r in range(m) if r not in w.speeds]
    rows = constraint_rows([constraints[r] for r in others], twin.kinematics, derived.auxiliary_speeds)
    a = [w.row(r, n) for r in range(m)]
    for k, r in enumerate(others):
        a[r] = list(map(w.held, rows.a.rows[k]))

    def every(own: Exprs) -> Exprs:
        by_row = dict(zip(others, own, strict=True))
        return tuple(w.held(by_row.get(r, ZERO)) for r in range(m))

    own = replace(derived.constraints, a=Matrix(a, (m, n)), b=every(rows.b), differentiated=lambda: every(rows.drift))
    return replace(twin, constraints=own)


def by_definitions(derived: Derived, twin: Derived, u_dot: Exprs, w: ConstraintRates) -> Exprs:
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
