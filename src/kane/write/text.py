# SPDX-License-Identifier: BSD-3-Clause
"""Expressions as one line of plain text each, for reading."""

from collections.abc import Sequence
from typing import ClassVar

from kane import show
from kane.expr.node import Expr, Number
from kane.expr.surd import Surd
from kane.write.arrange import ATOM, COMPARISON, POWER, Notation, Pieces
from kane.write.display import Call, Product, Tree, split_coefficient


def to_text(expr: Expr, *, intermediates: bool | None = None) -> str:
    """`expr` in one line.

    With `intermediates` None, long or very deep expressions are printed with named intermediates, "…, where Z1 = …"; with True
    whenever something is shared, with False never, however long it gets.
    """
    return TEXT.line(expr, intermediates)


class _Text(Notation):
    brackets = ("(", ")")
    power, exponent = ("^", ""), ATOM
    gap = " "
    where = (", where ", ", ")
    calls: ClassVar = {"less": COMPARISON, "": ATOM}

    def name(self, text: str) -> str:
        return text

    def unit_vector(self, frame: str, axis: str) -> str:
        return f"{frame}.{axis}"

    def number(self, value: Number) -> str:
        if isinstance(value, Surd):
            over, under = split_coefficient(value.ratio)
            return ("" if over == 1 else f"{over}*") + f"sqrt({value.radicand})" + ("" if under == 1 else f"/{under}")
        return repr(value) if isinstance(value, float) else str(value)

    def call(self, tree: Call) -> Pieces:
        yield f"{tree.name}("
        for i, a in enumerate(tree.args):
            yield from (", ", a) if i else (a,)
        yield ")"

    def product(self, tree: Product) -> Pieces:
        over, under = split_coefficient(tree.coefficient)
        yield from self._factors(tree.above, "" if over == 1 and tree.above else self.number(over))
        if tree.below or under != 1:
            several = len(tree.below) + (under != 1) > 1
            yield "/(" if several else "/"
            yield from self._factors(tree.below, "" if under == 1 else str(under))
            yield ")" if several else ""

    def _factors(self, factors: Sequence[tuple[Tree, int]], start: str) -> Pieces:
        yield start
        for i, (factor, exponent) in enumerate(factors):
            yield "*" if i or start else ""
            yield from self.within(factor, ATOM if exponent != 1 else POWER)
            yield f"^{exponent}" if exponent != 1 else ""


TEXT = _Text()
show.TEXT[Expr] = to_text
