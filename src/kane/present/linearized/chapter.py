# SPDX-License-Identifier: BSD-3-Clause
"""A chapter of sentences, formulas, tables and figures, independent of the format; numbers in formulas."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kane.equations.equations import Equations
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array
from kane.numeric.scale import ROUNDED
from kane.present.overview import PageTable, Tex
from kane.write.latex import latex_name, symbol_latex

if TYPE_CHECKING:
    from kane.present.motion_plots import Plot

Part = str | Tex | PageTable
"""A sentence with LaTeX between dollar signs, a displayed formula, or a table."""


@dataclass(frozen=True, slots=True)
class Section:
    """A chapter: its anchor name, its title, its parts in reading order, and figures after them."""

    name: str
    title: str
    parts: tuple[Part, ...]
    plots: "tuple[Plot, ...]" = ()


_NEXT = r" \\ "


def number(x: float, digits: int = 5) -> str:
    """LaTeX of a number."""
    mantissa, e, power = f"{x + 0.0:.{digits}g}".partition("e")
    return rf"{mantissa} \cdot 10^{{{int(power)}}}" if e else mantissa


def matrix(a: Array) -> str:
    """LaTeX of a matrix of numbers; entries within rounding of zero beside the largest are written as zero."""
    least = ROUNDED * np.abs(a).max(initial=0.0)
    rows = (" & ".join(number(x if abs(x) > least else 0.0) for x in row) for row in a.tolist())
    return rf"\begin{{bmatrix}} {_NEXT.join(rows)} \end{{bmatrix}}"


def latex_of(eom: Equations, names: Sequence[str]) -> list[str]:
    """LaTeX of states and inputs by name; small angles of Euler parameters are not symbols."""
    symbols: tuple[Symbol, ...] = (*eom.state, *eom.inputs)
    known = {s.name: symbol_latex(s) for s in symbols}
    return [known.get(n, latex_name(n)) for n in names]
