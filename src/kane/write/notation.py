# SPDX-License-Identifier: BSD-3-Clause
"""What writing shares in all notations: brackets where they are needed, signs, sums, measure numbers along unit vectors."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction
from typing import ClassVar, TypeAlias

from kane.expr.node import Expr, Number, as_expr
from kane.expr.surd import Surd
from kane.write.arrange import layout
from kane.write.trees import Call, Minus, Name, NumberTree, Power, Product, Sum, Tree

COMPARISON, SUM, PRODUCT, PREFIX, POWER, ATOM = range(6)
"""How firmly a tree holds together, loosest first."""

Pieces: TypeAlias = "Iterator[str | Tree]"


class Notation(ABC):
    """A way to write display trees. The methods give pieces, text and trees that are still to be written: depth costs nothing."""

    brackets: tuple[str, str]
    power: tuple[str, str]
    """What stands before and after an exponent."""
    exponent: int
    """How firmly an exponent must hold together."""
    gap: str
    """Between a measure number and its unit vector."""
    where: tuple[str, str]
    """Between an expression and its intermediates, and between these."""
    calls: ClassVar[Mapping[str, int]]
    """How firmly functions hold together; "" stands for the others."""

    @abstractmethod
    def name(self, text: str) -> str:
        """A symbol or an intermediate."""

    @abstractmethod
    def unit_vector(self, frame: str, axis: str) -> str:
        """A unit vector of the frame of that name."""

    @abstractmethod
    def number(self, value: Number) -> str:
        """A number that is not negative."""

    @abstractmethod
    def call(self, tree: Call) -> Pieces:
        """A function of its arguments."""

    @abstractmethod
    def product(self, tree: Product) -> Pieces:
        """A product of powers, some of them below the line."""

    def binding(self, tree: Tree) -> int:
        """How firmly a tree holds together."""
        if isinstance(tree, Sum | Minus):
            return SUM
        if isinstance(tree, Call):
            return self.calls.get(tree.name, self.calls[""])
        if isinstance(tree, NumberTree):
            return PRODUCT if isinstance(tree.value, Fraction | Surd) else ATOM
        return PRODUCT if isinstance(tree, Product) else POWER if isinstance(tree, Power) else ATOM

    def within(self, tree: Tree, least: int) -> Pieces:
        """The tree, in brackets where it holds together less firmly than `least`."""
        if self.binding(tree) < least:
            yield from (self.brackets[0], tree, self.brackets[1])
        else:
            yield tree

    def pieces(self, tree: Tree) -> Pieces:
        """What a tree consists of."""
        if isinstance(tree, NumberTree):
            yield self.number(tree.value)
        elif isinstance(tree, Name):
            yield self.name(tree.text)
        elif isinstance(tree, Minus):
            yield "-"
            yield from self.within(tree.body, PRODUCT)
        elif isinstance(tree, Sum):
            for i, (minus, term) in enumerate(tree.terms):
                yield sign(minus, not i)
                yield from self.within(term, PRODUCT)
        elif isinstance(tree, Product):
            yield from self.product(tree)
        elif isinstance(tree, Power):
            yield from self.within(tree.base, ATOM)
            yield from (self.power[0], *self.within(tree.exponent, self.exponent), self.power[1])
        elif tree.name == "less":
            yield from (*self.within(tree.args[0], SUM), " < ", *self.within(tree.args[1], SUM))
        else:
            yield from self.call(tree)

    def write(self, tree: Tree, least: int = COMPARISON) -> str:
        """The text of a tree, in brackets where it holds together less firmly than `least`."""
        out: list[str] = []
        stack: list[str | Tree] = [*reversed(list(self.within(tree, least)))]
        while stack:
            item = stack.pop()
            if isinstance(item, str):
                out.append(item)
            else:
                stack.extend(reversed(list(self.pieces(item))))
        return "".join(out)

    def line(self, expr: Expr, intermediates: bool | None) -> str:
        """An expression, and after "where" what it shares."""
        shown = layout((as_expr(expr),), intermediates)
        return self.defined(self.write(shown.trees[0]), shown.intermediates)

    def defined(self, line: str, intermediates: Iterable[tuple[str, Tree]]) -> str:
        """A line, and after "where" the intermediates in it."""
        definitions = [f"{self.name(name)} = {self.write(tree)}" for name, tree in intermediates]
        head, comma = self.where
        return line + (head + comma.join(definitions) if definitions else "")

    def along(self, trees: Iterable[Tree], units: Iterable[str]) -> str:
        """The sum of measure numbers, each along its unit vector; "0" where there are none."""
        line = ""
        for tree, unit in zip(trees, units, strict=True):
            minus, size = (True, tree.body) if isinstance(tree, Minus) else (False, tree)
            if isinstance(size, Sum) and all(negative for negative, _ in size.terms):
                minus, size = not minus, size.flipped()
            one = isinstance(size, NumberTree) and size.value == 1
            line += sign(minus, not line) + ("" if one else self.write(size, PRODUCT) + self.gap) + unit
        return line or "0"


def sign(minus: bool, first: bool) -> str:
    """The sign of a term."""
    return ("-" if minus else "") if first else " - " if minus else " + "
