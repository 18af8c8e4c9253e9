# SPDX-License-Identifier: BSD-3-Clause
"""The shortest of a few ways to write what is read: as it was built, collected, or multiplied out with common factors taken out."""

from collections.abc import Iterable, Sequence

from kane.expr.collect import collected, factored
from kane.expr.count import price
from kane.expr.expand import expanded
from kane.expr.node import Expr, postorder

_LONG = 300
"""Nodes above which an expression is left as it was built."""


def shortened(*ways: Sequence[Expr]) -> tuple[Expr, ...]:
    """Of each expression, given in one or more ways, the shortest; all as they come first where that is shorter together."""
    first = tuple(ways[0])
    if len(postorder(x for way in ways for x in way)) > _LONG:
        return min(map(tuple, ways), key=price)
    best = tuple(min(_forms(same), key=lambda e: price([e])) for same in zip(*ways, strict=True))
    return min((first, best), key=price)


def _forms(same: Iterable[Expr]) -> list[Expr]:
    found: list[Expr] = []
    for e in same:
        terms = expanded(e)
        found += [e, collected(e)] if terms is None else [e, collected(e), factored(terms)]
    return found
