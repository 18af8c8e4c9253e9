# SPDX-License-Identifier: BSD-3-Clause
"""The visit that rewriting, differentiation and the affine forms share: arguments first, each node once, no recursion."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from kane.expr.node import Expr

R = TypeVar("R")


def fold(root: Expr, known: dict[Expr, R], combine: Callable[[Expr], R]) -> R:
    """`known[root]`, after `known[node] = combine(node)` for every node below it that is not known yet.

    When `combine` is called the results of the node's arguments are in `known`; what is in it at the start is not visited.
    """
    stack = [root]
    while stack:
        node = stack[-1]
        if node in known:
            stack.pop()
            continue
        waiting = [a for a in node.args if a not in known]
        if waiting:
            stack.extend(waiting)
        else:
            stack.pop()
            known[node] = combine(node)
    return known[root]
