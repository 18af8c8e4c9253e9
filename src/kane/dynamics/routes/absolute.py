# SPDX-License-Identifier: BSD-3-Clause
"""Absolute rates as speeds: of links that turn about parallel axes each by a speed of its own.

Where frames turn about one axis by θ₁, θ₁ + θ₂, …, the rate of each angle moves every link after it. With

    Ω = θ̇₁ + θ̇₂ + …

in the place of the last of these rates it turns one link alone, as in absolute angles. Declared speeds and u̇ follow by sums and
differences; nothing is divided by.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce
from typing import NamedTuple

from kane.dynamics.constraints.embed import embedding
from kane.dynamics.constraints.partition import Partition
from kane.dynamics.derivation import Derived, by_other_speeds
from kane.dynamics.solved import Solved
from kane.expr.build import add, mul, neg, sub
from kane.expr.linear_parts import affine_forms
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Speed
from kane.expr.visit import substituted
from kane.kinematics.constraints import constraint_rows

Exprs = tuple[Expr, ...]
Row = dict[int, Expr]
"""Numbers by the places of speeds."""

_UNITS = {ONE, neg(ONE)}


class Absolute(NamedTuple):
    """What is `derived` by absolute rates, their `values` in the speeds of the state, and by their places these speeds in them."""

    derived: Derived
    values: Mapping[Expr, Expr]
    rows: Mapping[int, Row]

    def declared(self, found: Solved, d: Derived, partition: Partition | None) -> Solved:
        """What was found, by the speeds that `d` has."""
        memo: dict[Expr, Expr] = {}

        def state(e: Expr) -> Expr:
            return substituted(e, self.values, memo)

        by_state = found.mapped(state)
        own, rates, e = by_state.accelerations, found.shorter_rates, found.embedding
        return replace(
            by_state,
            derived=d,
            accelerations=tuple(_sum(self.rows[i], own) if i in self.rows else x for i, x in enumerate(own)),
            embedding=embedding(d.constraints, partition).watching(e.guards_in_use) if e and partition else None,
            shorter_rates=rates and tuple(map(state, rates)),
        )


def absolute(d: Derived, partition: Partition | None) -> Absolute | None:
    """The same by absolute rates; None where no frame is turned further about its base's axis by a rate that is a speed."""
    sums = _sums(d)
    rows = _inverse(sums)
    while sums and (lost := _exchanged(rows, d, partition)):
        del sums[lost[0]]
        rows = _inverse(sums)
    if not sums:
        return None
    names = {k: Speed.declare(f"Omega_{d.speeds[k].name}", None, "", "absolute rate") for k in sums}
    declared = list(d.system.speeds.values())
    definitions = {
        names.get(i, u): _sum(sums[i], declared) if i in sums else declared[i] for i, u in enumerate(d.speeds)
    }
    twin = by_other_speeds(d, definitions, d.constraints, matched=d.kinematical.nontrivial)
    constraints = constraint_rows(d.constraints.constraints, twin.kinematics, d.auxiliary_speeds)
    return Absolute(
        replace(twin, constraints=constraints), {names[k]: _sum(row, d.speeds) for k, row in sums.items()}, rows
    )


def _sums(d: Derived) -> dict[int, Row]:
    """Ω as sums of speeds that are rates, by the place of the last of them."""
    places: dict[Expr, int] = {rate: i for i, rate in enumerate(d.system.speeds.values())}
    seen: set[Expr] = set()
    found: dict[int, Row] = {}
    for basis in dict.fromkeys(d.kinematics.aligned.rates(f)[0] for f in d.system.frames):
        o = basis.orientation
        if o is None or o.axis is None:
            continue
        ((form, _),) = affine_forms([o.rates[o.axis]], d.kinematical.rates)
        new = [rate for rate in form if rate not in seen]
        seen.update(new)
        row = {places[rate]: c for rate, c in form.items() if rate in places}
        if len(new) == 1 and len(row) == len(form) > 1 and new[0] in places and all(c in _UNITS for c in row.values()):
            found[places[new[0]]] = dict(sorted(row.items()))
    return found


def _inverse(sums: Mapping[int, Row]) -> dict[int, Row]:
    """The rates that absolute ones replace by these and the others: u_k = ±(Ω_k − Σ c_j u_j)."""
    rows: dict[int, Row] = {}
    for k, total in sums.items():
        row = {k: ONE}
        for j, c in total.items():
            if j != k:
                for i, x in rows.get(j, {j: ONE}).items():
                    row[i] = sub(row.get(i, ZERO), mul(c, x))
        rows[k] = {i: mul(total[k], x) for i, x in row.items() if x is not ZERO}
    return rows


def _exchanged(rows: Mapping[int, Row], d: Derived, partition: Partition | None) -> list[int]:
    """Independent speeds by whose replacement other determinants would give the dependent ones."""
    if partition is None:
        return []
    dependent, a = set(partition.dependent), d.constraints.a.take(partition.rows)
    return [
        k
        for k, row in rows.items()
        if k not in dependent
        and not dependent.isdisjoint(row)
        and any(x is not ZERO for x in a.take(columns=[k]).entries)
    ]


def _sum(row: Row, values: Sequence[Expr]) -> Expr:
    return reduce(add, (mul(c, values[i]) for i, c in row.items()), ZERO)
