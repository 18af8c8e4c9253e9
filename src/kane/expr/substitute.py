# SPDX-License-Identifier: BSD-3-Clause
"""Replacement of leaves (or any nodes) in a graph."""

from __future__ import annotations

from collections.abc import Mapping

from kane.expr.build import NODE_BUILDERS
from kane.expr.node import Expr


def substitute(root: Expr, replacements: Mapping[Expr, Expr], memo: dict[Expr, Expr] | None = None) -> Expr:
    """`root` with every key of `replacements` replaced; what does not change stays the same object."""
    known: dict[Expr, Expr] = {} if memo is None else memo
    stack = [root]
    while stack:
        node = stack[-1]
        if node in known:
            stack.pop()
            continue
        new = replacements.get(node)
        if new is not None or not node.args:
            known[node] = node if new is None else new
            stack.pop()
            continue
        waiting = [a for a in node.args if a not in known]
        if waiting:
            stack.extend(waiting)
            continue
        stack.pop()
        args = [known[a] for a in node.args]
        same = all(x is y for x, y in zip(args, node.args, strict=True))
        known[node] = node if same else NODE_BUILDERS[node.op.name](*args)
    return known[root]
