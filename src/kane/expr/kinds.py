# SPDX-License-Identifier: BSD-3-Clause
"""Questions about the kinds of symbols below expressions."""

from __future__ import annotations

from collections.abc import Iterable

from kane.expr.evaluate import free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Parameter


def is_constant_in_time(exprs: Iterable[Expr]) -> bool:
    """Whether the expressions hold parameters and numbers only."""
    return all(isinstance(s, Parameter) for s in free_symbols(exprs))
