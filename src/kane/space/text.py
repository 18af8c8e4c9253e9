# SPDX-License-Identifier: BSD-3-Clause
"""Vectors as text: `u1 B.x + u2 B.y + u2*tan(q2) B.z`."""

from __future__ import annotations

from collections.abc import Iterable

from kane.expr.build import neg
from kane.expr.node import ONE, ZERO, Expr, constant_value
from kane.expr.ops import ADD, NEG, SUB
from kane.space.rotation import Basis, Triple
from kane.write.text import to_text


def parts_text(parts: Iterable[tuple[Basis, Triple]]) -> str:
    """One line of text for the parts of a vector."""
    line = ""
    for basis, triple in parts:
        for x, axis in zip(triple, "xyz", strict=True):
            if x is ZERO:
                continue
            negative = _is_negative(x)
            lead = (" - " if negative else " + ") if line else ("-" if negative else "")
            line += f"{lead}{_factor(neg(x) if negative else x)}{basis.name}.{axis}"
    return line or "0"


def _is_negative(x: Expr) -> bool:
    value = constant_value(x)
    return x.op is NEG or (value is not None and value < 0)


def _factor(x: Expr) -> str:
    if x is ONE:
        return ""
    return f"({to_text(x)}) " if x.op in (ADD, SUB) else f"{to_text(x)} "
