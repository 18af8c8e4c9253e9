# SPDX-License-Identifier: BSD-3-Clause
"""Rates of constraints in the places of dependent speeds: w = A_q q̇ + b_q, which vanish."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from kane.dynamics.derivation import Derived
from kane.dynamics.solved import Solved
from kane.expr.evaluation import holds_any
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Speed, rate
from kane.expr.visit import substituted
from kane.model.variables import constraint_rate


@dataclass(frozen=True, slots=True, eq=False)
class ConstraintRates:
    """`rows` are the constraints by the places of the speeds that their rates replace, `speeds` the rates by these rows."""

    rows: Mapping[int, int]
    speeds: Mapping[int, Speed]
    vanishing: Mapping[Expr, Expr]
    _memo: dict[Expr, Expr] = field(default_factory=dict)

    def held(self, e: Expr) -> Expr:
        """An expression on the constraints: w = ẇ = 0."""
        return substituted(e, self.vanishing, self._memo)

    def solution(self, found: Solved) -> Solved:
        """A solution on the constraints; the same one where no w is in it."""
        roots = (*found.accelerations, *found.reactions, *found.pivots, *found.reaction_matrix.entries)
        return (
            found.mapped(self.held)
            if holds_any((*roots, *found.bare_reaction_matrix.entries), self.vanishing.keys())
            else found
        )

    def definitions(self, derived: Derived) -> dict[Speed, Expr]:
        """The speeds with the rates in their places, in the rates of the coordinates."""
        constraints = derived.constraints.constraints
        found: dict[Speed, Expr] = {}
        for i, (u, definition) in enumerate(derived.system.speeds.items()):
            row = self.rows.get(i)
            found[u if row is None else self.speeds[row]] = (
                definition if row is None else constraint_rate(constraints[row])
            )
        return found

    def row(self, constraint: int, count: int) -> list[Expr]:
        """The row w = 0 among `count` speeds, of a constraint that no rate stands for a row of zeros."""
        return [ONE if self.rows.get(j) == constraint else ZERO for j in range(count)]


def constraint_rates(rows: Mapping[int, int]) -> ConstraintRates:
    """The rates of constraints, `rows` by the places of the speeds that they replace."""
    w = {r: Speed.declare(f"w{k + 1}", None, "", "rate of a constraint") for k, r in enumerate(rows.values())}
    return ConstraintRates(rows, w, {x: ZERO for s in w.values() for x in (s, rate(s))})
