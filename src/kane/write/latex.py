# SPDX-License-Identifier: BSD-3-Clause
r"""Expressions as LaTeX: plain commands only, so that KaTeX and MathML converters take it.

Names: trailing digits and what follows an underscore become subscripts, Greek names letters, rates dots:
q1 is q_{1}, mu_k is \mu_{k}, u1' is \dot{u}_{1}.
"""

import re
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, ClassVar

from kane.expr.node import Expr, Number
from kane.expr.numbers import Surd
from kane.expr.symbols import Rate, Symbol
from kane.write.arrange import ATOM, COMPARISON, POWER, PREFIX, PRODUCT, SUM, Notation, Pieces
from kane.write.display import Call, Name, NumberTree, Product, Tree, split_coefficient


def to_latex(expr: Expr, *, intermediates: bool | None = None) -> str:
    """`expr` as LaTeX, without the dollar signs.

    `intermediates` as in `to_text`; their definitions follow after "where".
    """
    return LATEX.line(expr, intermediates)


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
    elif digits and " " not in head:  # a number among words, as in "rod at 0.5", is no index
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


def symbol_latex(symbol: Symbol) -> str:
    r"""LaTeX of a symbol: its derivatives have dots, and a prime that its own name ends in stays one."""
    origin: Any = symbol
    dots = 0
    while isinstance(origin, Rate):
        origin, dots = origin.place, dots + 1
    stem = origin.name.rstrip("'")
    primes = len(origin.name) - len(stem)
    text = latex_name(stem + "'" * dots)
    raised = r"\prime" * primes
    return f"{{{text}^{{{raised}}}}}" if primes else text


def point_latex(name: str) -> str:
    r"""LaTeX of a frame's or point's name: C* is C^{*}, C^ is \hat{C}, B1* is B_{1}^{*}."""
    stem = name.rstrip("*^'")
    marks = name[len(stem) :]
    text = latex_name(stem) if stem else latex_name(name)
    if "^" in marks:
        text = rf"\hat{{{text}}}"
    raised = "*" * marks.count("*") + r"\prime" * marks.count("'")
    return f"{text}^{{{raised}}}" if raised else text


def unit_vector_latex(frame: str, axis: str) -> str:
    r"""\hat{b}_{x} of a frame named B, \hat{b}_{1x} of a frame B1, \hat{e}_{x,\,\mathrm{rod}} of a frame rod."""
    parts = re.fullmatch(r"([A-Za-z])([0-9]*)", frame)
    if parts:
        return rf"\hat{{{parts[1].lower()}}}_{{{parts[2]}{axis}}}"
    return rf"\hat{{e}}_{{{axis},\,{point_latex(frame)}}}"


# Trees -------------------------------------------------------------------------------------------------

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
_AROUND = {"sqrt": (r"\sqrt{", "}"), "exp": ("e^{", "}"), "abs": (r"\left|", r"\right|")}


class _Latex(Notation):
    brackets = (r"\left(", r"\right)")
    power, exponent = ("^{", "}"), COMPARISON
    gap = r"\,"
    where = (r" \quad\text{where}\quad ", r",\; ")
    calls: ClassVar = {"less": COMPARISON, "where": COMPARISON, "exp": POWER, "sqrt": ATOM, "abs": ATOM, "": PREFIX}

    def name(self, text: str) -> str:
        return latex_name(text)

    def symbol(self, tree: Name) -> str:
        return latex_name(tree.text) if tree.symbol is None else symbol_latex(tree.symbol)

    def unit_vector(self, frame: str, axis: str) -> str:
        return unit_vector_latex(frame, axis)

    def number(self, value: Number) -> str:
        if isinstance(value, Surd):
            over, under = split_coefficient(value.ratio)
            top = ("" if over == 1 else f"{over} ") + rf"\sqrt{{{value.radicand}}}"
            return top if under == 1 else rf"\frac{{{top}}}{{{under}}}"
        if isinstance(value, Fraction):
            return rf"\frac{{{value.numerator}}}{{{value.denominator}}}"
        mantissa, e, exponent = repr(value).partition("e")
        if not e:
            return mantissa
        return f"10^{{{int(exponent)}}}" if mantissa == "1" else rf"{mantissa} \cdot 10^{{{int(exponent)}}}"

    def binding(self, tree: Tree) -> int:
        return PRODUCT if isinstance(tree, NumberTree) and "e" in str(tree.value) else super().binding(tree)

    def call(self, tree: Call, exponent: int = 1) -> Pieces:
        name, args = tree.name, tree.args
        if name == "where":
            yield from (r"\begin{cases} ", args[1], r" & \text{if } ", args[0], r" \\ ", args[2])
            yield r" & \text{otherwise} \end{cases}"
        elif name in _AROUND:
            before, after = _AROUND[name]
            yield from (before, args[0], after)
        else:
            yield _FUNCTIONS.get(name) or rf"\operatorname{{{name}}}"
            yield f"^{{{exponent}}}" if exponent != 1 else ""
            if len(args) == 1 and isinstance(args[0], Name):
                yield from (" ", args[0])
                return
            yield r"\left("
            for i, a in enumerate(args):
                yield from (", ", a) if i else (a,)
            yield r"\right)"

    def product(self, tree: Product) -> Pieces:
        over, under = split_coefficient(tree.coefficient)
        above = self._factors(tree.above, "" if over == 1 and tree.above else self.number(over))
        if tree.below or under != 1:
            yield from (r"\frac{", *above, "}{", *self._factors(tree.below, "" if under == 1 else str(under)), "}")
        else:
            yield from above

    def _factors(self, factors: Sequence[tuple[Tree, int]], start: str) -> Pieces:
        alone = len(factors) == 1 and not start
        yield start
        for i, (factor, exponent) in enumerate(factors):
            if i or start:
                yield (
                    r" \cdot "
                    if not i and isinstance(factor, NumberTree)
                    else _apart(factors[i - 1][0] if i else None, factor)
                )
            if exponent != 1 and isinstance(factor, Call) and factor.name in _POWERED:
                yield from self.call(factor, exponent)
            elif exponent != 1:
                yield from (*self.within(factor, ATOM), f"^{{{exponent}}}")
            else:
                yield from self.within(factor, SUM if alone else PREFIX)


def _apart(before: object, after: object) -> str:
    """Between two factors: a space that shows where one is a name of several letters, which would run into the other."""
    words = (isinstance(x, Name) and r"\mathrm" in latex_name(x.text) for x in (before, after))
    return r" \, " if before is not None and any(words) else " "


LATEX = _Latex()
