# SPDX-License-Identifier: BSD-3-Clause
r"""Vectors and dyadics as LaTeX: u_{1}\,\hat{b}_{x} + u_{2}\,\hat{b}_{y}."""

from __future__ import annotations

import re
from collections.abc import Sequence

from kane.expr.build import add, mul
from kane.expr.node import ZERO, Expr
from kane.space.frame import Frame
from kane.space.vector import Dyadic, Vector
from kane.write.display import Formula, typeset
from kane.write.latex import latex_name, tree_latex
from kane.write.trees import Minus, NumberTree, Sum, Tree


def place_latex(name: str) -> str:
    r"""LaTeX of a frame's or point's name: C* is C^{*}, C^ is \hat{C}, B1* is B_{1}^{*}."""
    stem = name.rstrip("*^'")
    marks = name[len(stem) :]
    text = latex_name(stem) if stem else latex_name(name)
    if "^" in marks:
        text = rf"\hat{{{text}}}"
    raised = "*" * marks.count("*") + r"\prime" * marks.count("'")
    return f"{text}^{{{raised}}}" if raised else text


def unit_vector_latex(frame: Frame, axis: str) -> str:
    r"""\hat{b}_{x} of a frame B, \hat{b}_{1x} of a frame B1, \widehat{\mathrm{rod}}_{x} of a frame rod."""
    found = re.fullmatch(r"([A-Za-z])([0-9]*)", frame.name)
    if found:
        return rf"\hat{{{found[1].lower()}}}_{{{found[2]}{axis}}}"
    return rf"\widehat{{{latex_name(frame.name)}}}_{{{axis}}}"


def vector_formula(v: Vector) -> Formula:
    """A vector, as it is written: along the axes of all its frames."""
    terms = _terms(v)
    return _linear([x for x, _, _ in terms], [unit_vector_latex(f, axis) for _, f, axis in terms])


def dyadic_formula(d: Dyadic) -> Formula:
    """A dyadic multiplied out, a term for each pair of unit vectors."""
    found: dict[tuple[Frame, str, Frame, str], Expr] = {}
    for a, b in d.dyads:
        for x, f, i in _terms(a):
            for y, g, k in _terms(b):
                found[f, i, g, k] = add(found.get((f, i, g, k), ZERO), mul(x, y))
    kept = {key: x for key, x in found.items() if x is not ZERO}
    pairs = [f"{unit_vector_latex(f, i)} {unit_vector_latex(g, k)}" for f, i, g, k in kept]
    return _linear(list(kept.values()), pairs)


def _terms(v: Vector) -> list[tuple[Expr, Frame, str]]:
    return [(x, f, axis) for f, t in v.parts for x, axis in zip(t, "xyz", strict=True) if x is not ZERO]


def _linear(factors: Sequence[Expr], units: Sequence[str]) -> Formula:
    return typeset(factors, lambda trees: [_joined(trees, units)])


def _joined(trees: Sequence[Tree], units: Sequence[str]) -> str:
    line = ""
    for tree, unit in zip(trees, units, strict=True):
        minus, size = (True, tree.body) if isinstance(tree, Minus) else (False, tree)
        if isinstance(size, Sum) and all(negative for negative, _ in size.terms):
            minus, size = not minus, size.flipped()
        one = isinstance(size, NumberTree) and size.value == 1
        lead = (" - " if minus else " + ") if line else ("-" if minus else "")
        line += lead + unit if one else rf"{lead}{tree_latex(size, factor=True)}\,{unit}"
    return line or "0"
