# SPDX-License-Identifier: BSD-3-Clause
r"""Expressions as LaTeX: plain commands only, so that KaTeX and MathML converters take it.

Names: trailing digits and what follows an underscore become subscripts, Greek names letters, rates dots:
q1 is q_{1}, mu_k is \mu_{k}, u1' is \dot{u}_{1}.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

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


def to_latex(expr: Expr, *, intermediates: bool | None = None) -> str:
    """`expr` as LaTeX, without the dollar signs.

    `intermediates` as in `to_text`; their definitions follow after "where". `latex_lines` gives them apart.
    """
    shown = layout((as_expr(expr),), intermediates)
    text = write(shown.trees[0], _pieces)
    if not shown.intermediates:
        return text
    where = r",\; ".join(f"{latex_name(name)} = {write(tree, _pieces)}" for name, tree in shown.intermediates)
    return rf"{text} \quad\text{{where}}\quad {where}"


def latex_lines(named: Mapping[str, Expr], *, intermediates: bool | None = None) -> list[str]:
    """Equations "Z_{1} = …" for what the expressions share, then an equation for each.

    The keys are names such as "u1'", or LaTeX where they contain a backslash or a brace.
    """
    shown = layout([as_expr(e) for e in named.values()], intermediates)
    lines = [*shown.intermediates, *zip(named, shown.trees, strict=True)]
    return [f"{_left(name)} = {write(tree, _pieces)}" for name, tree in lines]


def tree_latex(tree: Tree, *, factor: bool = False) -> str:
    """LaTeX of a display tree; as a factor in brackets where it is a sum or a comparison."""
    text = write(tree, _pieces)
    return rf"\left({text}\right)" if factor and _binding(tree) < _PRODUCT else text


def _left(name: str) -> str:
    return name if "\\" in name or "{" in name else latex_name(name)


# Names -------------------------------------------------------------------------------------------------

_GREEK = re.compile(
    "(var)?epsilon|(var)?theta|(var)?phi|alpha|beta|gamma|delta|zeta|eta|iota|kappa|lambda|mu|nu|xi|pi|rho|sigma|"
    "tau|upsilon|chi|psi|omega|Gamma|Delta|Theta|Lambda|Xi|Pi|Sigma|Upsilon|Phi|Psi|Omega"
)
_SPECIAL = {c: "\\" + c for c in "#$%&{}_"} | {" ": "\\ ", "~": r"\sim ", "^": r"\hat{}", "\\": r"\backslash "}


def latex_name(name: str) -> str:
    r"""LaTeX of a symbol's name.

    >>> latex_name("mu_k"), latex_name("q12"), latex_name("u1'"), latex_name("Ixx")
    ('\\mu_{k}', 'q_{12}', '\\dot{u}_{1}', 'I_{xx}')
    """
    stem = name.rstrip("'")
    dots = len(name) - len(stem)
    head, *lower = [part for part in stem.split("_") if part] or [stem]
    inertia = re.fullmatch(r"([A-Z])([xyz]{1,2})", head)
    digits = re.fullmatch(r"(.*?[^0-9])([0-9]+)", head)
    if inertia:
        head, lower = inertia[1], [inertia[2], *lower]
    elif digits:
        head, lower = digits[1], [digits[2], *lower]
    text = _word(head)
    if dots:
        text = rf"\{'d' * min(dots, 3)}ot{{{text}}}" if dots <= 2 else rf"{text}^{{({dots})}}"
    return text + (f"_{{{','.join(_subscript(p) for p in lower)}}}" if lower else "")


def _word(word: str) -> str:
    if _GREEK.fullmatch(word):
        return "\\" + word
    if len(word) == 1 and word not in _SPECIAL:
        return word
    return rf"\mathrm{{{''.join(_SPECIAL.get(c, c) for c in word)}}}"


def _subscript(word: str) -> str:
    if word.isalnum() and not _GREEK.fullmatch(word) and (len(word) <= 2 or word.isdigit()):
        return word
    digits = re.fullmatch(r"(.*?[^0-9])([0-9]+)", word)
    return _word(digits[1]) + digits[2] if digits else _word(word)


# Trees -------------------------------------------------------------------------------------------------

_COMPARISON, _SUM, _PRODUCT, _PREFIX, _POWER, _ATOM = range(6)
_FUNCTIONS = {
    "sin": r"\sin",
    "cos": r"\cos",
    "tan": r"\tan",
    "asin": r"\arcsin",
    "acos": r"\arccos",
    "atan": r"\arctan",
    "sinh": r"\sinh",
    "cosh": r"\cosh",
    "tanh": r"\tanh",
    "log": r"\ln",
    "min": r"\min",
    "max": r"\max",
    "sign": r"\operatorname{sgn}",
    "atan2": r"\operatorname{atan2}",
}
_POWERED = {"sin", "cos", "tan", "sinh", "cosh", "tanh"}


def _binding(tree: Tree) -> int:
    if isinstance(tree, Sum | Minus):
        return _SUM
    if isinstance(tree, Product):
        return _PRODUCT
    if isinstance(tree, Power):
        return _POWER
    if isinstance(tree, Call):
        if tree.name in ("less", "where"):
            return _COMPARISON
        if tree.name in ("exp", "sqrt"):
            return _POWER if tree.name == "exp" else _ATOM
        return _ATOM if tree.name == "abs" else _PREFIX
    if isinstance(tree, NumberTree):
        return _PRODUCT if isinstance(tree.value, Fraction) or "e" in str(tree.value) else _ATOM
    return _ATOM


def _within(tree: Tree, least: int) -> Iterator[str | Tree]:
    if _binding(tree) < least:
        yield from (r"\left(", tree, r"\right)")
    else:
        yield tree


def _number(value: Number) -> str:
    if isinstance(value, Fraction):
        return rf"\frac{{{value.numerator}}}{{{value.denominator}}}"
    mantissa, e, exponent = repr(value).partition("e")
    if not e:
        return mantissa
    return f"10^{{{int(exponent)}}}" if mantissa == "1" else rf"{mantissa} \cdot 10^{{{int(exponent)}}}"


def _pieces(tree: Tree) -> Iterator[str | Tree]:
    if isinstance(tree, NumberTree):
        yield _number(tree.value)
    elif isinstance(tree, Name):
        yield latex_name(tree.text)
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
        yield from ("^{", tree.exponent, "}")
    else:
        yield from _call(tree, 1)


def _call(tree: Call, exponent: int) -> Iterator[str | Tree]:
    name, args = tree.name, tree.args
    if name == "less":
        yield from _within(args[0], _SUM)
        yield " < "
        yield from _within(args[1], _SUM)
    elif name == "where":
        yield from (r"\begin{cases} ", args[1], r" & \text{if } ", args[0], r" \\ ", args[2])
        yield r" & \text{otherwise} \end{cases}"
    elif name == "sqrt":
        yield from (r"\sqrt{", args[0], "}")
    elif name == "exp":
        yield from ("e^{", args[0], "}")
    elif name == "abs":
        yield from (r"\left|", args[0], r"\right|")
    else:
        power = f"^{{{exponent}}}" if exponent != 1 else ""
        yield _FUNCTIONS.get(name) or rf"\operatorname{{{name}}}"
        yield power
        if len(args) == 1 and isinstance(args[0], Name):
            yield from (" ", args[0])
            return
        yield r"\left("
        for i, a in enumerate(args):
            if i:
                yield ", "
            yield a
        yield r"\right)"


def _fraction(tree: Product) -> Iterator[str | Tree]:
    over, under = split_coefficient(tree.coefficient)
    above = list(_factors(tree.above, "" if over == 1 and tree.above else _number(over)))
    if tree.below or under != 1:
        yield from (r"\frac{", *above, "}{")
        yield from _factors(tree.below, "" if under == 1 else str(under))
        yield "}"
    else:
        yield from above


def _factors(factors: Sequence[tuple[Tree, int]], start: str) -> Iterator[str | Tree]:
    alone = len(factors) == 1 and not start
    yield start
    for i, (factor, exponent) in enumerate(factors):
        if i or start:
            number = start if not i else ""
            yield r" \cdot " if number and isinstance(factor, NumberTree) else " "
        if exponent != 1 and isinstance(factor, Call) and factor.name in _POWERED:
            yield from _call(factor, exponent)
        elif exponent != 1:
            yield from _within(factor, _ATOM)
            yield f"^{{{exponent}}}"
        else:
            yield from _within(factor, _SUM if alone else _PREFIX)
