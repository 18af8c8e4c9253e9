# SPDX-License-Identifier: BSD-3-Clause
"""`kn.substitute`: replacement in whatever is made of expressions, by symbols, nodes or names, with numbers or expressions."""

from collections.abc import Mapping
from typing import Any

from kane.errors import ExpressionError, ValueMissingError, alike, cut
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import Symbol
from kane.expr.visit import substituted as replaced


def substitute(what: Any, replacements: Mapping[Any, Any]) -> Any:
    """`what` with every key of `replacements` replaced, all at once; what does not change stays the same object.

    Parameters
    ----------
    what : an expression, a Vector, a Matrix, or a list of these
    replacements : an expression or number for each symbol, name of a symbol, or other expression

    Raises
    ------
    ValueMissingError
        if a name is none of the symbols in it
    """
    if not isinstance(replacements, Mapping):
        raise ValueMissingError(
            f"Expected replacements as a dict {{symbol or name: expression}}, got {cut(repr(replacements))}."
        )
    roots: list[Expr] = []

    def noted(e: Expr) -> Expr:
        roots.append(e)
        return e

    _each(what, noted)
    names: dict[str, list[Symbol]] = {}
    for s in free_symbols(roots) if any(isinstance(key, str) for key in replacements) else ():
        names.setdefault(s.name, []).append(s)
    images: dict[Expr, Expr] = {}
    for key, value in replacements.items():
        if isinstance(key, str) and key not in names:
            raise ValueMissingError(
                f"Expected names of symbols to replace ({', '.join(names) or 'none'}), got {key!r}.{alike(key, names)}"
            )
        for own in names[key] if isinstance(key, str) else [as_expr(key)]:
            images[own] = as_expr(value)
    memo: dict[Expr, Expr] = {}
    return _each(what, lambda e: replaced(e, images, memo))


def _each(what: Any, change: Any) -> Any:
    """`change` of every expression that `what` is made of."""
    if isinstance(what, list | tuple):
        return type(what)([_each(x, change) for x in what])
    if hasattr(what, "map"):  # a vector, a matrix
        return what.map(change)
    try:
        return change(as_expr(what))
    except ExpressionError as error:
        raise ExpressionError(
            f"Expected an expression, Vector, Matrix or a list of these to substitute in, got {cut(repr(what))}."
        ) from error
