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
    if root in values:
        return values[root]
    stack: list[Expr | None] = [root]
    while stack:
        node = stack.pop()
        if node is None:  # what is below the node before it is known
            node = stack.pop()
            if node is not None and node not in values:
                values[node] = combine(node)
        elif node not in values:
            ready = True
            for a in node.args:
                if a not in values:
                    if ready:
                        stack += (node, None)
                        ready = False
                    stack.append(a)
            if ready:
                values[node] = combine(node)
    return values[root]


def substituted(root: Expr, replacements: Mapping[Expr, Expr], memo: dict[Expr, Expr] | None = None) -> Expr:
    """`root` with every key of `replacements` replaced; what does not change stays the same object."""
    images: dict[Expr, Expr] = {} if memo is None else memo
    images.update(replacements)
    return fold(root, images, lambda node: imaged(node, images))


def imaged(node: Expr, images: Mapping[Expr, Expr]) -> Expr:
    """The operation of `node` on the images of its arguments, `node` itself where they are its own."""
    for a in node.args:
        if images[a] is not a:
            return NODE_BUILDERS[node.op.name](*[images[x] for x in node.args])
    return node


def rebuilt(node: Expr, args: Sequence[Expr]) -> Expr:
    """The operation of `node` on `args`, `node` itself where they are its own."""
    for x, y in zip(args, node.args, strict=True):
        if x is not y:
            return NODE_BUILDERS[node.op.name](*args)
    return node
