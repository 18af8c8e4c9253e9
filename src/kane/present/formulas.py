# SPDX-License-Identifier: BSD-3-Clause
"""Named expressions and vectors as formulas that share one list of intermediates, Z1 and so on."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from kane.expr.node import ZERO, Expr
from kane.expr.ops import ADD, NEG, SUB
from kane.space.rotation import Basis
from kane.space.vector import Vector
from kane.write.latex import LATEX, latex_name
from kane.write.layout import Layout, layout
from kane.write.notation import Notation
from kane.write.text import TEXT
from kane.write.trees import Minus, Tree


@dataclass(frozen=True, slots=True)
class Formula:
    """left = right, as plain text and as LaTeX; `shared` says that it is an intermediate."""

    name: str
    text: str
    left: str
    right: str
    shared: bool = False

    @property
    def latex(self) -> str:
        """The whole equation."""
        return f"{self.left} = {self.right}"


def formulas(
    items: Sequence[tuple[Any, Any]], left: Callable[[Any], str] = latex_name
) -> tuple[list[Formula], list[Formula]]:
    """The shared intermediates, and a formula for each item; `left` gives the LaTeX of a label."""
    shown, values = _laid_out(value for _, value in items)
    between = [
        Formula(name, TEXT.write(t), latex_name(name), LATEX.write(t), shared=True) for name, t in shown.intermediates
    ]
    written = [
        Formula(str(label), _written(value, TEXT), left(label), _written(value, LATEX))
        for (label, _), value in zip(items, values, strict=True)
    ]
    return between, written


def text_formulas(items: Sequence[tuple[object, Any]]) -> tuple[list[tuple[str, str]], list[tuple[str, str]]]:
    """The shared intermediates and the items, as (name, text)."""
    shown, values = _laid_out(value for _, value in items)
    written = [(str(label), _written(value, TEXT)) for (label, _), value in zip(items, values, strict=True)]
    return [(name, TEXT.write(tree)) for name, tree in shown.intermediates], written


_Terms = list[tuple[Tree, Basis | None, str]]
"""Display trees, each along an axis of a basis; of an expression the one tree, along none."""


def _laid_out(values: Iterable[Expr | Vector]) -> tuple[Layout, list[_Terms]]:
    parts = [_measures(value) if isinstance(value, Vector) else [(False, value, None, "")] for value in values]
    shown = layout([e for part in parts for _, e, _, _ in part])
    trees = iter(shown.trees)
    return shown, [[(_signed(minus, next(trees)), basis, axis) for minus, _, basis, axis in part] for part in parts]


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


def _written(terms: _Terms, notation: Notation) -> str:
    units = [notation.unit_vector(basis.name, axis) for _, basis, axis in terms if basis is not None]
    trees = [tree for tree, _, _ in terms]
    return notation.along(trees, units) if units or not trees else notation.write(trees[0])
