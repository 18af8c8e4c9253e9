# SPDX-License-Identifier: BSD-3-Clause
"""Named expressions and vectors as formulas that share one list of intermediates, Z1 and so on."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from kane.expr.node import ZERO, Expr
from kane.expr.ops import ADD, NEG, SUB
from kane.space.rotation import Basis
from kane.space.vector import Vector
from kane.write.latex import LATEX, latex_name
from kane.write.layout import layout
from kane.write.notation import Notation
from kane.write.text import TEXT
from kane.write.trees import Minus, Tree


@dataclass(frozen=True)
class Formula:
    """left = right, written as plain text or as LaTeX when it is asked for; `shared` says that it is an intermediate.

    `terms` are display trees, each along an axis of a basis; of an expression the one tree, along none.
    """

    name: str
    left: str
    terms: Sequence[tuple[Tree, Basis | None, str]]
    shared: bool = False

    @cached_property
    def text(self) -> str:
        """The right side as plain text."""
        return self._written(TEXT)

    @cached_property
    def right(self) -> str:
        """The right side as LaTeX."""
        return self._written(LATEX)

    @property
    def latex(self) -> str:
        """The whole equation as LaTeX."""
        return f"{self.left} = {self.right}"

    def _written(self, notation: Notation) -> str:
        units = [notation.unit_vector(basis.name, axis) for _, basis, axis in self.terms if basis is not None]
        trees = [tree for tree, _, _ in self.terms]
        return notation.along(trees, units) if units or not trees else notation.write(trees[0])


def formulas(
    items: Sequence[tuple[Any, Expr | Vector]], left: Callable[[Any], str] = latex_name
) -> tuple[list[Formula], list[Formula]]:
    """The shared intermediates, and a formula for each item; `left` gives the LaTeX of a label."""
    parts = [_measures(value) if isinstance(value, Vector) else [(False, value, None, "")] for _, value in items]
    shown = layout([e for part in parts for _, e, _, _ in part])
    trees = iter(shown.trees)
    between = [Formula(name, latex_name(name), ((tree, None, ""),), shared=True) for name, tree in shown.intermediates]
    written = [
        Formula(str(label), left(label), [(_signed(minus, next(trees)), basis, axis) for minus, _, basis, axis in part])
        for (label, _), part in zip(items, parts, strict=True)
    ]
    return between, written


def _measures(v: Vector) -> list[tuple[bool, Expr, Basis | None, str]]:
    """Sign, size, basis and axis of each measure number that is not zero."""
    terms: list[tuple[bool, Expr, Basis | None, str]] = []
    for basis, triple in v.parts:
        for e, axis in zip(triple, "xyz", strict=True):
            minus = e.op is NEG and e.args[0].op not in (ADD, SUB)
            terms.append((minus, e.args[0] if minus else e, basis, axis))
    return [term for term in terms if term[1] is not ZERO]


def _signed(minus: bool, tree: Tree) -> Tree:
    if not minus:
        return tree
    return tree.body if isinstance(tree, Minus) else Minus(tree, tree.tokens)
