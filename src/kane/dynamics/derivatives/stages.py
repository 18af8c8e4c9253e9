# SPDX-License-Identifier: BSD-3-Clause
"""Functions of numbers or vectors by the symbols that they hold beside these: derivatives where these are held."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from kane.expr.build import add
from kane.expr.differentiation import tangent
from kane.expr.evaluation import free_symbols
from kane.expr.node import ONE, ZERO, Expr
from kane.expr.symbols import Parameter
from kane.expr.visit import substituted


class Stage:
    """`make` of vectors, or of numbers, at those of `at`; what it holds beside them is in `symbols`."""

    def __init__(self, make: Callable[..., Sequence[Any]], at: Sequence[Any]) -> None:
        names = (Parameter.declare(f"held{k}", description="what is held") for k, _ in enumerate(_flat(at)))
        held = _like(at, names)
        self.values: dict[Expr, Expr] = dict(zip(_flat(held), _flat(at), strict=True))
        self.made = make(*held)
        self.symbols = frozenset(free_symbols(_flat(self.made))).difference(self.values)

    def slope(self, x: Expr) -> Any:
        """The derivative by a symbol, `at` held; None where it is zero."""
        return self._derivative({x: ONE}) if x in self.symbols else None

    def along(self, change: Sequence[Any]) -> Any:
        """The derivative along a change of `at`."""
        return self._derivative(dict(zip(self.values, _flat(change), strict=True)))

    def _derivative(self, seeds: dict[Expr, Expr]) -> Any:
        memo: dict[Expr, Expr] = {}
        images: dict[Expr, Expr] = {}
        found = [substituted(tangent(e, seeds, memo, at_rest=True), self.values, images) for e in _flat(self.made)]
        return None if all(x is ZERO for x in found) else _like(self.made, iter(found))


def total(parts: Sequence[Any]) -> Any:
    """Their sum, of those that are not None."""
    found: Any = None
    for part in parts:
        if found is None:
            found = part
        elif part is not None:
            found = _like(found, map(add, _flat(found), _flat(part)))
    return found


def _flat(vectors: Sequence[Any]) -> list[Expr]:
    return [x for v in vectors for x in (v if isinstance(v, tuple) else (v,))]


def _like(vectors: Sequence[Any], values: Iterator[Expr]) -> tuple[Any, ...]:
    return tuple(tuple(next(values) for _ in v) if isinstance(v, tuple) else next(values) for v in vectors)
