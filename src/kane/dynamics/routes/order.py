# SPDX-License-Identifier: BSD-3-Clause
"""The order in which a symmetric matrix is eliminated, so that little of what is zero is filled."""

from collections.abc import Sequence

from kane.expr.node import ZERO, Expr


def sparse_order(rows: Sequence[Sequence[Expr]]) -> list[int]:
    """Minimum degree: next is what is tied to the fewest of those left, the first of several (Tinney & Walker 1967).

    Branches of a tree are eliminated from their ends, without any fill; a full matrix keeps its order.
    """
    ties = [{j for j, x in enumerate(row) if j != i and x is not ZERO} for i, row in enumerate(rows)]
    left, order = list(range(len(ties))), []
    while left:
        chosen = min(left, key=lambda i: len(ties[i]))
        left.remove(chosen)
        order.append(chosen)
        for i in ties[chosen]:
            ties[i] |= ties[chosen] - {i}
            ties[i].discard(chosen)
    return order
