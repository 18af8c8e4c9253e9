# SPDX-License-Identifier: BSD-3-Clause
"""Rows that were left out as redundant: what they hold beyond the others at a state, as expressions that every language computes.

With A_R the rows left out and u_D = A_n u_I the speeds that the others leave, they follow where A_R,I + A_R,D A_n vanishes. That is
compared with the sizes of its terms and with what the row holds elsewhere, at states on the constraints: off them nothing is known.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import NamedTuple

import numpy as np

from kane.dynamics.constraints.embed import Embedding
from kane.dynamics.constraints.manifold import Manifold
from kane.dynamics.constraints.partition import Compared
from kane.expr.build import NODE_BUILDERS, add, div, mul, where
from kane.expr.matrix import dot
from kane.expr.node import ONE, ZERO, Expr, constant
from kane.expr.regular import largest
from kane.model.constraints import Constraint
from kane.numeric.scale import CLOSED_NEARLY

_HOLDS = 1e-2
"""Share above which a row holds more: beside a place where branches meet it is the root of what a closed state may leave open."""


class LeftOut(NamedTuple):
    """One row: the largest coefficient that it has `beyond` the others, and the `limit` up to which it follows from them."""

    constraint: Constraint
    beyond: Expr
    limit: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Watch:
    """The rows left out, and how far configuration constraints are `open`, below 1 where they are closed."""

    rows: tuple[LeftOut, ...]
    open: Expr

    def guarding(self) -> tuple[Callable[[Expr], Expr], dict[Expr, Constraint]]:
        """A function that makes an expression NaN where a row holds more, and the guard, 1 or NaN, of each row."""
        less = NODE_BUILDERS["less"]
        off = where(less(self.open, ONE), ZERO, ONE)
        follow = [where(less(r.limit, r.beyond), off, ONE) for r in self.rows]
        guards = [NODE_BUILDERS["regular"](x, ONE) for x in follow]
        lost = guards[-1]
        for x, guard in zip(follow[-2::-1], guards[-2::-1], strict=True):
            lost = where(less(ZERO, x), lost, guard)
        all_follow = less(ZERO, reduce(NODE_BUILDERS["min"], follow))
        names = dict(zip(guards, (r.constraint for r in self.rows), strict=True))
        return lambda value: where(all_follow, value, lost), names


def watch(embedding: Embedding, compared: Compared, conditions: Manifold) -> Watch | None:
    """The rows that the partition of `embedding` leaves out, if any, measured by the configurations that were compared."""
    rows, redundant = embedding.rows, embedding.partition.redundant
    if not redundant:
        return None
    own = rows.a.take(redundant, embedding.independent)
    by_dependent = rows.a.take(redundant, embedding.partition.dependent)
    usual = np.abs(compared.a[:, list(redundant)]).max(axis=(0, 2), initial=0)
    found = []
    for k, r in enumerate(redundant):
        pairs = list(zip(own.rows[k], embedding.a_n.T, strict=True))
        beyond = largest(add(x, dot(by_dependent.rows[k], column)) for x, column in pairs)
        terms = largest(_total(x, by_dependent.rows[k], column) for x, column in pairs)
        limit = mul(constant(_HOLDS), largest([terms, constant(float(usual[k]))]))
        found.append(LeftOut(rows.constraints[r], beyond, limit))
    reach = compared.reach(conditions)
    off = largest(div(f, constant(float(CLOSED_NEARLY * r))) for f, r in zip(conditions.f, reach, strict=True) if r > 0)
    return Watch(tuple(found), off)


def _total(own: Expr, row: Sequence[Expr], column: Sequence[Expr]) -> Expr:
    """The sum of the sizes of the terms of a coefficient."""
    absolute = NODE_BUILDERS["abs"]
    return add(absolute(own), dot([absolute(x) for x in row], [absolute(x) for x in column]))
