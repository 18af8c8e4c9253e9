# SPDX-License-Identifier: BSD-3-Clause
"""Vectors as text: `u1 B.x + u2 B.y + u2*tan(q2) B.z`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from kane.expr.build import neg
from kane.expr.node import ONE, ZERO, Expr, constant_value
from kane.expr.ops import ADD, NEG, SUB
from kane.write.text import to_text

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
