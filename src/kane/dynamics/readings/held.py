# SPDX-License-Identifier: BSD-3-Clause
"""Speeds at a state: the dependent ones follow from the independent ones, and those that are given must satisfy A u + b = 0.

A constraint is missed where |A u + b| is more than a share of the largest of its terms, and more than noise leaves of terms that
vanish at the state: coordinates and speeds that were computed are right to some digits of the largest, and so are entries of A.
"""

import warnings
from collections.abc import Sequence, Set
from typing import Any

import numpy as np

from kane.dynamics.solved import Reading, Solved
from kane.errors import KaneWarning, SimulationError
from kane.expr.build import add, mul
from kane.expr.evaluation import Walk, free_symbols
from kane.expr.matrix import dot
from kane.expr.node import Expr, constant
from kane.expr.size import Sizes, largest, size
from kane.expr.symbols import Parameter, Speed
from kane.expr.visit import substituted
from kane.numeric.places import first_place
from kane.numeric.scale import CLOSED, SIX_DIGITS

_NONE_FREE = "The constraints give all speeds: leave them out."


def reading(solved: Solved, walk: Walk, known: Set[Expr]) -> Reading:
    """Expressions of q, u, t, parameters and inputs with those dependent speeds filled in that are not `known`.

    The constraints are read too where dependent speeds are given, and the expressions hold speeds: those of which all is known.
    """
    dependent, count = solved.dependent_speeds, len(walk.roots)
    if not dependent or not any(isinstance(s, Speed) for s in walk.symbols):
        return Reading(walk, count, ())
    filled: dict[Expr, Expr] = {
        u: value
        for u, value in zip(solved.derived.speeds, solved.speeds_by_independent, strict=True)
        if value is not u and u not in known
    }
    rows = _rows(solved, {*known, *filled}) if len(filled) < len(dependent) else ()
    every = [*walk.roots, *(rate for _, rate, _ in rows), *(limit for _, _, limit in rows)]
    if filled:
        memo: dict[Expr, Expr] = {}
        every = [substituted(e, filled, memo) for e in every]
    return Reading(Walk(every) if rows or filled else walk, count, tuple(name for name, _, _ in rows))


def _rows(solved: Solved, known: Set[Expr]) -> list[tuple[str, Expr, Expr]]:
    """The constraints in which all is known: names, A u + b, and what it may be for rounding's sake."""
    speeds, rows = solved.derived.speeds, []
    memo: Sizes = {}
    fastest = largest(speeds)
    for constraint, a, b in zip(solved.held.constraints, solved.held.a, solved.held.b, strict=True):
        rate = add(dot(a, speeds), b)
        if all(s in known or _has_default(s) for s in free_symbols([rate])):
            terms = largest([*map(mul, a, speeds), b])
            left = add(size(rate, memo), mul(largest(size(x, memo) for x in a), fastest))
            limit = add(mul(constant(SIX_DIGITS), terms), mul(constant(CLOSED), left))
            rows.append((constraint.name, rate, limit))
    return rows


def _has_default(s: Expr) -> bool:
    return isinstance(s, Parameter) and s.default is not None


def check_held(solved: Solved, names: Sequence[str], numbers: Sequence[Any]) -> None:
    """Speeds that miss constraints: at one state an error, of arrays a warning that names the first place.

    `numbers` are A u + b of the constraints `names`, then its limits; where they are not finite nothing can be said.
    """
    count, numbers = len(names), np.broadcast_arrays(*numbers)
    with np.errstate(invalid="ignore"):
        off = [np.abs(rate) > limit for rate, limit in zip(numbers[:count], numbers[count:], strict=True)]
    anywhere = np.any(off, axis=0)
    if not anywhere.any():
        return
    place, index, more = first_place(anywhere)
    miss = ", ".join(f"{n!r} by {r[place]:.3g}" for n, r, x in zip(names, numbers, off, strict=False) if x[place])
    own = ", ".join(u.name for u in solved.independent_speeds)
    cure = f"Give the independent speeds alone, u= of {own}: the others follow." if own else _NONE_FREE
    expected = "Expected speeds that satisfy the constraints A u + b = 0"
    if not place:
        raise SimulationError(f"{expected}, got some that miss {miss}. {cure}")
    warnings.warn(
        f"{expected} at every state, got some that miss {miss} at index {index}"
        f"{f', and at {more} more' if more else ''}: the values there do not belong to one motion. {cure}",
        KaneWarning,
        stacklevel=4,
    )
