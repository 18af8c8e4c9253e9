# SPDX-License-Identifier: BSD-3-Clause
"""Replacement of leaves (or any nodes) in a graph."""

from __future__ import annotations

from collections.abc import Mapping

from kane.expr.build import NODE_BUILDERS
from kane.expr.node import Expr
from kane.expr.visit import fold


def substitute(root: Expr, replacements: Mapping[Expr, Expr], memo: dict[Expr, Expr] | None = None) -> Expr:
    """`root` with every key of `replacements` replaced; what does not change stays the same object."""
    images: dict[Expr, Expr] = {} if memo is None else memo
    images.update(replacements)

    def rebuilt(node: Expr) -> Expr:
        args = [images[a] for a in node.args]
        same = all(x is y for x, y in zip(args, node.args, strict=True))
        return node if same else NODE_BUILDERS[node.op.name](*args)

    return fold(root, images, rebuilt)
