# SPDX-License-Identifier: BSD-3-Clause
"""The visit that differentiation, the affine forms and `substitute` share: arguments first, each node once, no recursion."""

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from kane.expr.build import NODE_BUILDERS
from kane.expr.node import Expr

R = TypeVar("R")


def fold(root: Expr, values: dict[Expr, R], combine: Callable[[Expr], R]) -> R:
    """`values[root]`, after `values[node] = combine(node)` for every node below it that is not known yet.

    When `combine` is called the results of the node's arguments are in `values`; what is in it at the start is not visited.
    """
    stack = [root]
    while stack:
        node = stack[-1]
        if node in values:
            stack.pop()
            continue
        waiting = [a for a in node.args if a not in values]
        if waiting:
            stack.extend(waiting)
        else:
            stack.pop()
            values[node] = combine(node)
    return values[root]


def substitute(root: Expr, replacements: Mapping[Expr, Expr], memo: dict[Expr, Expr] | None = None) -> Expr:
    """`root` with every key of `replacements` replaced; what does not change stays the same object."""
    images: dict[Expr, Expr] = {} if memo is None else memo
    images.update(replacements)
    return fold(root, images, lambda node: rebuilt(node, [images[a] for a in node.args]))


def rebuilt(node: Expr, args: Sequence[Expr]) -> Expr:
    """The operation of `node` on `args`, `node` itself where they are its own."""
    same = all(x is y for x, y in zip(args, node.args, strict=True))
    return node if same else NODE_BUILDERS[node.op.name](*args)
