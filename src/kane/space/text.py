# SPDX-License-Identifier: BSD-3-Clause
"""Vectors as text and LaTeX: `u1 B.x + u2 B.y + u2*tan(q2) B.z`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kane.expr.build import neg
from kane.expr.latex import to_latex
from kane.expr.node import ONE, ZERO, Expr, constant_value
from kane.expr.ops import ADD, NEG, SUB
from kane.expr.text import to_text

if TYPE_CHECKING:
    from kane.space.vector import Vector

_AXES = ("x", "y", "z")


def _terms(v: Vector) -> list[tuple[str, bool, Expr, str, str]]:
    return [
        ("-" if _is_negative(x) else "+", x.op in (ADD, SUB), neg(x) if _is_negative(x) else x, frame.name, axis)
        for frame, triple in v.parts
        for x, axis in zip(triple, _AXES, strict=True)
        if x is not ZERO
    ]


def _is_negative(x: Expr) -> bool:
    value = constant_value(x)
    return x.op is NEG or (value is not None and value < 0)


def vector_text(v: Vector) -> str:
    """One line of text."""
    line = ""
    for sign, _, x, frame, axis in _terms(v):
        factor = "" if x is ONE else (f"({to_text(x)}) " if x.op in (ADD, SUB) else f"{to_text(x)} ")
        lead = f" {sign} " if line else ("-" if sign == "-" else "")
        line += f"{lead}{factor}{frame}.{axis}"
    return line or "0"


def vector_latex(v: Vector) -> str:
    r"""LaTeX with unit vectors such as \hat{b}_x."""
    line = ""
    for sign, _, x, frame, axis in _terms(v):
        inner = to_latex(x)
        factor = "" if x is ONE else (rf"\left({inner}\right)" if x.op in (ADD, SUB) else inner)
        lead = f" {sign} " if line else ("-" if sign == "-" else "")
        name = frame.lower() if frame.isascii() and frame.isalpha() and len(frame) == 1 else rf"\mathrm{{{frame}}}"
        line += rf"{lead}{factor}\,\hat{{{name}}}_{{{axis}}}"
    return line or "0"
