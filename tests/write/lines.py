# SPDX-License-Identifier: BSD-3-Clause
"""Several expressions with one list of intermediates, an equation a line."""

from __future__ import annotations

from collections.abc import Mapping

from kane import Expr
from kane.expr import as_expr
from kane.write import LATEX, TEXT, Notation, latex_name, layout


def _lines(named: Mapping[str, Expr], notation: Notation) -> list[str]:
    shown = layout([as_expr(e) for e in named.values()])
    between = [(notation.name(name), tree) for name, tree in shown.intermediates]
    pairs = (*between, *zip(named, shown.trees, strict=True))
    return [f"{name} = {notation.write(tree)}" for name, tree in pairs]


def text_lines(named: Mapping[str, Expr]) -> list[str]:
    return _lines(named, TEXT)


def latex_lines(named: Mapping[str, Expr]) -> list[str]:
    return _lines({name if "\\" in name else latex_name(name): e for name, e in named.items()}, LATEX)
