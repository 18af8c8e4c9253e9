# SPDX-License-Identifier: BSD-3-Clause
"""Expressions, vectors and results of the steps as formulas with shared intermediates Z1, Z2, …; a step as text.

Long formulas are broken at the outermost sums where possible.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Any

from kane.dynamics.readings.seven_steps import Kind, Quantity, Result, Step
from kane.equations.equations import Equations
from kane.expr.forms.two_angles import by_two_angles
from kane.expr.node import ZERO, Expr
from kane.expr.ops import ADD, NEG, SUB
from kane.expr.symbols import Symbol, rate
from kane.space.frame import Frame
from kane.space.rotation import Basis
from kane.space.vector import Vector
from kane.write.arrange import TEXT, Notation, layout
from kane.write.display import Minus, Tree
from kane.write.latex import LATEX, latex_name, point_latex, symbol_latex


@dataclass(frozen=True)
class DisplayedFormula:
    """A formula left = right, written as plain text or LaTeX on demand; `shared` marks an intermediate.

    `terms` are expression trees, each along an axis of a basis; a scalar has one tree without an axis.
    """

    name: str
    left: str
    terms: Sequence[tuple[Tree, Basis | None, str]]
    shared: bool = False

    @cached_property
    def text(self) -> str:
        """The right side as plain text."""
        return self._written(TEXT)

    @cached_property
    def right(self) -> str:
        """The right side as LaTeX."""
        return self._written(LATEX)

    @property
    def latex(self) -> str:
        """The whole equation as LaTeX."""
        return f"{self.left} = {self.right}"

    def _written(self, notation: Notation) -> str:
        units = [notation.unit_vector(basis.name, axis) for _, basis, axis in self.terms if basis is not None]
        trees = [tree for tree, _, _ in self.terms]
        return notation.along(trees, units) if units or not trees else notation.write(trees[0])


def formulas(
    items: Sequence[tuple[Any, Expr | Vector]], left: Callable[[Any], str] = latex_name
) -> tuple[list[DisplayedFormula], list[DisplayedFormula]]:
    """The shared intermediates, and a formula for each item; `left` returns the LaTeX of a label."""
    parts = [_measures(value) if isinstance(value, Vector) else [(False, value, None, "")] for _, value in items]
    shown = layout(by_two_angles([e for part in parts for _, e, _, _ in part]))
    trees = iter(shown.trees)
    between = [
        DisplayedFormula(name, latex_name(name), ((tree, None, ""),), shared=True) for name, tree in shown.intermediates
    ]
    written = []
    for (label, _), part in zip(items, parts, strict=True):
        terms = [(_signed(minus, next(trees)), basis, axis) for minus, _, basis, axis in part]
        written.append(DisplayedFormula(str(label), left(label), terms))
    return between, written


def _measures(v: Vector) -> list[tuple[bool, Expr, Basis | None, str]]:
    """Sign, absolute value, basis and axis of each nonzero measure number."""
    terms: list[tuple[bool, Expr, Basis | None, str]] = []
    for basis, triple in v.parts:
        for e, axis in zip(triple, "xyz", strict=True):
            minus = e.op is NEG and e.args[0].op not in (ADD, SUB)
            terms.append((minus, e.args[0] if minus else e, basis, axis))
    return [term for term in terms if term[1] is not ZERO]


def _signed(minus: bool, tree: Tree) -> Tree:
    if not minus:
        return tree
    return tree.body if isinstance(tree, Minus) else Minus(tree, tree.tokens)


def result_formulas(
    results: Sequence[Result], inertial: Frame
) -> tuple[list[DisplayedFormula], list[DisplayedFormula]]:
    """The shared intermediates of the results of a step, and a formula for each result."""
    return formulas(results, lambda quantity: quantity_latex(quantity, inertial))


def quantity_latex(quantity: Quantity, inertial: Frame | None = None) -> str:
    r"""LaTeX of a quantity, such as {}^N\boldsymbol\omega^C for the angular velocity of C; a symbol has its own."""
    if quantity.kind in _SCALARS:
        return quantity.named(_SCALARS[quantity.kind], _named)
    letter = _VECTORS.get(quantity.kind)
    if letter is None:
        return _named(quantity.place, dots=quantity.kind is Kind.RATE)
    lower = f"_{{{symbol_latex(quantity.speed)}}}" if quantity.speed is not None else ""
    within = rf"{{}}^{{{point_latex(inertial.name)}}}" if inertial is not None else ""
    return rf"{within}{letter}^{{{point_latex(quantity.place.name)}}}{lower}"


def _named(place: Any, dots: bool = False) -> str:
    """LaTeX of a symbol, of its rate, or of the name of a constraint."""
    if not isinstance(place, Symbol):
        return latex_name(place.name)
    return symbol_latex(rate(place) if dots else place)


_VECTORS = {
    Kind.ANGULAR_VELOCITY: r"\boldsymbol{\omega}",
    Kind.PARTIAL_ANGULAR_VELOCITY: r"\boldsymbol{\omega}",
    Kind.ANGULAR_ACCELERATION: r"\boldsymbol{\alpha}",
    Kind.NONHOLONOMIC_PARTIAL_ANGULAR_VELOCITY: r"\tilde{\boldsymbol{\omega}}",
    Kind.VELOCITY: r"\mathbf{v}",
    Kind.NONHOLONOMIC_PARTIAL_VELOCITY: r"\tilde{\mathbf{v}}",
    Kind.PARTIAL_VELOCITY: r"\mathbf{v}",
    Kind.ACCELERATION: r"\mathbf{a}",
}
_SCALARS = {
    Kind.CONSTRAINT: r"\left(A u + b\right)_{{{place}}}",
    Kind.ACTIVE_FORCE: "F_{{{place}}}",
    Kind.INERTIA_FORCE: "F^{{*}}_{{{place}}}",
    Kind.NONHOLONOMIC_ACTIVE_FORCE: r"\tilde{{F}}_{{{place}}}",
    Kind.NONHOLONOMIC_INERTIA_FORCE: r"\tilde{{F}}^{{*}}_{{{place}}}",
    Kind.NONHOLONOMIC_MASS: r"\tilde{{M}}_{{{place}\,{speed}}}",
    Kind.NONHOLONOMIC_FORCING: r"\tilde{{f}}_{{{place}}}",
    Kind.MASS: r"M_{{{place}\,{speed}}}",
    Kind.FORCING: "f_{{{place}}}",
}


WIDTH = 110
"""Columns of a line of text."""
_INDENT = 3

_BREAK = re.compile(r" (?=[+-] )")


def step_text(step: Step, eom: Equations, width: int = WIDTH) -> str:
    """The step as text with one shared list of intermediates, in lines of about `width` columns at most."""
    lines = [f"Step {step.number}. {step.title}", *wrapped(step.text, indent=_INDENT, hang=_INDENT, width=width)]
    if step.number == 1:
        told = (f"{q.name}  {', '.join(filter(None, (q.description, q.unit)))}" for q in eom.coordinates)
        return "\n".join([*lines, *(f"{'':{_INDENT}}{line.rstrip()}" for line in told)])
    between, shown = formulas(step.results, str)
    if between:
        lines += [*_block(between, width), ""]
    return "\n".join([*lines, *_block(shown, width)])


def _block(shown: list[DisplayedFormula], width: int) -> list[str]:
    column = max((len(f.name) for f in shown), default=0)
    hang = _INDENT + column + 3
    return [
        line
        for f in shown
        for line in wrapped(f"{f.name:<{column}} = {f.text}", indent=_INDENT, hang=hang, width=width)
    ]


def wrapped(text: str, *, indent: int = 0, hang: int | None = None, width: int = WIDTH) -> list[str]:
    """Lines of at most `width` columns if possible, the first indented by `indent`, the others by `hang`.

    A line ends at the last of the outermost possible positions: before a + or −, otherwise at a space.
    """
    following = indent + 4 if hang is None else hang
    lines, lead, rest = [], indent, text
    while lead + len(rest) > width:
        at = _break_position(rest, width - lead, width // 3)
        if at is None:
            break
        lines.append(" " * lead + rest[:at].rstrip())
        rest, lead = rest[at:].lstrip(), following
    return [*lines, " " * lead + rest]


def _break_position(text: str, room: int, least: int) -> int | None:
    at = [*accumulate((c in "([{") - (c in ")]}") for c in text)]  # depth of brackets after each character
    for pattern in (_BREAK, re.compile(" ")):
        places = [m.start() for m in pattern.finditer(text) if min(least, room) <= m.start() <= room]
        if places:
            return min(places, key=lambda i: (at[i], -i))
    later = [m.start() for m in _BREAK.finditer(text) if m.start() > room]
    return later[0] if later else None
