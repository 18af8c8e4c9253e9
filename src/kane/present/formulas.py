# SPDX-License-Identifier: BSD-3-Clause
"""Named expressions and vectors as formulas that share one list of intermediates, Z1 and so on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from kane.expr.node import ONE, ZERO, Expr
from kane.expr.ops import ADD, NEG, SUB
from kane.present.wrap import is_sum, opposite
from kane.space.latex import unit_vector_latex
from kane.space.rotation import Basis
from kane.space.vector import Vector
from kane.write.latex import latex_lines, latex_name
from kane.write.text import text_lines


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
    z_text, texts = _written(items, text_lines, lambda frame, axis: f" {frame.name}.{axis}", "({})")
    z_latex, latex = _written(items, latex_lines, _latex_axis, r"\left({}\right)")
    between = [
        Formula(name, text, left, right, shared=True)
        for (name, text), (left, right) in zip(z_text, z_latex, strict=True)
    ]
    shown = [
        Formula(str(label), text, left(label), right)
        for (label, _), text, right in zip(items, texts, latex, strict=True)
    ]
    return between, shown


def text_formulas(items: Sequence[tuple[object, Any]]) -> tuple[list[tuple[str, str]], list[tuple[str, str]]]:
    """The shared intermediates and the items, as (name, text)."""
    between, texts = _written(items, text_lines, lambda frame, axis: f" {frame.name}.{axis}", "({})")
    return between, [(str(label), text) for (label, _), text in zip(items, texts, strict=True)]


def _latex_axis(frame: Basis, axis: str) -> str:
    return rf"\,{unit_vector_latex(frame, axis)}"


def _written(
    items: Sequence[tuple[object, Any]],
    lines_of: Callable[[Mapping[str, Expr]], list[str]],
    axis_of: Callable[[Basis, str], str],
    brackets: str,
) -> tuple[list[tuple[str, str]], list[str]]:
    scalars: dict[str, Expr] = {}
    for i, (_, value) in enumerate(items):
        if isinstance(value, Vector):
            scalars.update({f"x{i}c{k}": e for k, (_, _, _, e) in enumerate(_terms(value))})
        elif isinstance(value, Expr):
            scalars[f"x{i}c0"] = value
    lines = lines_of(scalars)
    pairs = [(name, body) for name, _, body in (line.partition(" = ") for line in lines)]
    extra = len(pairs) - len(scalars)
    bodies = dict(zip(scalars, (body for _, body in pairs[extra:]), strict=True))
    written = []
    for i, (_, value) in enumerate(items):
        if isinstance(value, Vector):
            terms = [
                (minus, "" if unit else bodies[f"x{i}c{k}"], axis_of(frame, axis))
                for k, (minus, unit, (frame, axis), _) in enumerate(_terms(value))
            ]
            written.append(_joined(terms, brackets))
        else:
            written.append(bodies[f"x{i}c0"] if isinstance(value, Expr) else str(value))
    return pairs[:extra], written


def _terms(v: Vector) -> list[tuple[bool, bool, tuple[Basis, str], Expr]]:
    """Each measure number that is not zero: whether it is negative, whether ±1, its unit vector, its magnitude."""
    found = []
    for frame, triple in v.parts:
        for e, axis in zip(triple, "xyz", strict=True):
            if e is not ZERO:
                minus = e.op is NEG and e.args[0].op not in (ADD, SUB)
                size = e.args[0] if minus else e
                found.append((minus, size is ONE, (frame, axis), size))
    return found


def _joined(terms: Iterable[tuple[bool, str, str]], brackets: str) -> str:
    line = ""
    for minus, body, axis in terms:
        if is_sum(body):
            flipped = opposite(body)
            minus, body = minus ^ (flipped is not None), brackets.format(flipped or body)
        elif body.startswith("-"):
            minus, body = not minus, body[1:]
        body = "" if body == "1" else body
        lead = (" - " if minus else " + ") if line else ("-" if minus else "")
        line += lead + (body + axis if body else axis.removeprefix(" ").removeprefix(r"\,"))
    return line or "0"
