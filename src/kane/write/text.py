# SPDX-License-Identifier: BSD-3-Clause
"""Expressions as one line of plain text each, for reading."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

from kane import show
from kane.expr.node import Expr, Number, as_expr
from kane.write.layout import layout
from kane.write.trees import (
    Call,
    Minus,
    Name,
    NumberTree,
    Power,
    Product,
    Sum,
    Tree,
    split_coefficient,
    write,
)


def to_text(expr: Expr, *, intermediates: bool | None = None) -> str:
    """`expr` in one line.

    Parameters
    ----------
    expr
        What to print.
    intermediates
        None: long or very deep expressions are printed with named intermediates, "…, where Z1 = …"; True:
        whenever something is shared; False: never, however long it gets.
    """
    shown = layout((as_expr(expr),), intermediates)
    text = write(shown.trees[0], _pieces)
    if not shown.intermediates:
        return text
    return f"{text}, where {', '.join(f'{name} = {write(t, _pieces)}' for name, t in shown.intermediates)}"


show.TEXT[Expr] = to_text


def text_lines(named: Mapping[str, Expr], *, intermediates: bool | None = None) -> list[str]:
    """Lines "Z1 = …" for what the expressions share, then a line "name = …" for each."""
    shown = layout([as_expr(e) for e in named.values()], intermediates)
    lines = [*shown.intermediates, *zip(named, shown.trees, strict=True)]
    return [f"{name} = {write(tree, _pieces)}" for name, tree in lines]


_COMPARISON, _SUM, _PRODUCT, _POWER, _ATOM = range(5)


def _binding(tree: Tree) -> int:
    if isinstance(tree, Sum | Minus):
        return _SUM
    if isinstance(tree, Product):
        return _PRODUCT
    if isinstance(tree, Power):
        return _POWER
    if isinstance(tree, Call):
        return _COMPARISON if tree.name == "less" else _ATOM
    if isinstance(tree, NumberTree):
        return _PRODUCT if isinstance(tree.value, Fraction) else _ATOM
    return _ATOM


def _within(tree: Tree, least: int) -> Iterator[str | Tree]:
    if _binding(tree) < least:
        yield from ("(", tree, ")")
    else:
        yield tree


def _text_of(value: Number) -> str:
    return repr(value) if isinstance(value, float) else str(value)


def _pieces(tree: Tree) -> Iterator[str | Tree]:
    if isinstance(tree, NumberTree):
        yield _text_of(tree.value)
    elif isinstance(tree, Name):
        yield tree.text
    elif isinstance(tree, Minus):
        yield "-"
        yield from _within(tree.body, _PRODUCT)
    elif isinstance(tree, Sum):
        for i, (minus, term) in enumerate(tree.terms):
            yield (" - " if minus else " + ") if i else "-" if minus else ""
            yield from _within(term, _PRODUCT)
    elif isinstance(tree, Product):
        yield from _fraction(tree)
    elif isinstance(tree, Power):
        yield from _within(tree.base, _ATOM)
        yield "^"
        yield from _within(tree.exponent, _ATOM)
    elif tree.name == "less":
        yield from _within(tree.args[0], _SUM)
        yield " < "
        yield from _within(tree.args[1], _SUM)
    else:
        yield f"{tree.name}("
        for i, a in enumerate(tree.args):
            if i:
                yield ", "
            yield a
        yield ")"


def _fraction(tree: Product) -> Iterator[str | Tree]:
    over, under = split_coefficient(tree.coefficient)
    yield from _factors(tree.above, "" if over == 1 and tree.above else _text_of(over))
    if tree.below or under != 1:
        several = len(tree.below) + (under != 1) > 1
        yield "/(" if several else "/"
        yield from _factors(tree.below, "" if under == 1 else str(under))
        if several:
            yield ")"


def _factors(factors: Sequence[tuple[Tree, int]], start: str) -> Iterator[str | Tree]:
    yield start
    for i, (factor, exponent) in enumerate(factors):
        if i or start:
            yield "*"
        yield from _within(factor, _ATOM if exponent != 1 else _POWER)
        if exponent != 1:
            yield f"^{exponent}"
