# SPDX-License-Identifier: BSD-3-Clause
"""Symbols by themselves or by name, and numbers for them, as users give them."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from kane.errors import SimulationError, ValueMissingError, alike, cut
from kane.expr.node import Expr
from kane.expr.symbols import Parameter, Symbol, Symbols, declared


def named_values(what: str, symbols: Sequence[Symbol], given: Any) -> dict[Expr, Any]:
    """Values by symbol, from a mapping by symbol or name, or a sequence in the symbols' order.

    A parameter that the system does not hold is left out where it is given by symbol, so that variants of a model share their values.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        values = list(_listed(what, symbols, given))
        if len(values) != len(symbols):
            raise ValueMissingError(
                f"Expected {len(symbols)} {what} ({', '.join(s.name for s in symbols)}), got {len(values)} values. Give one for each "
                "in that order, or a dict {name: value}."
            )
        return dict(zip(symbols, values, strict=True))
    by_name = {s.name: s for s in symbols}
    by_symbol: dict[Expr, Any] = {}
    for key, value in given.items():
        if isinstance(key, Parameter) and "parameters" in what and key.name not in by_name:
            continue
        symbol = _found(by_name, key)
        if symbol is None:
            raise ValueMissingError(
                f"Expected values for {what} of the system ({', '.join(by_name) or 'none'}), got one for "
                f"{unknown(key, symbols)}"
            )
        if symbol in by_symbol:
            raise ValueMissingError(
                f"Expected one value for {symbol.name}, got two, by symbol and by name. Leave one out."
            )
        by_symbol[symbol] = value
    return by_symbol


def symbols_named(what: str, symbols: Sequence[Symbol], keys: Any) -> Symbols[Any]:
    """The symbols that a list of symbols and names means, in the order of the list."""
    by_name = {s.name: s for s in symbols}
    found = []
    for key in _listed(what, symbols, keys):
        symbol = _found(by_name, key)
        if symbol is None:
            raise ValueMissingError(f"Expected one of {', '.join(by_name) or 'none'}, got {unknown(key, symbols)}")
        found.append(symbol)
    return Symbols(found)


def symbol_named(symbols: Iterable[Symbol], key: Any) -> Symbol:
    """The one of `symbols` that a symbol or name means."""
    symbol: Symbol
    (symbol,) = symbols_named("symbols", tuple(symbols), [key])
    return symbol


def unknown(key: Any, symbols: Iterable[Symbol]) -> str:
    """What is said of a key that is none of `symbols`: how it differs from the one of its name, or which names resemble it."""
    names = {s.name: s for s in symbols}
    if isinstance(key, Symbol) and key.name in names:
        return (
            f"another symbol of the name {key.name!r}: {declared(key)} in place of {declared(names[key.name])}. Take the system's "
            "own symbol, or give the name alone."
        )
    return f"{cut(repr(key))}.{alike(str(key), names)}"


def _found(by_name: Mapping[str, Symbol], key: Any) -> Symbol | None:
    symbol = by_name.get(key.name if isinstance(key, Symbol) else key) if isinstance(key, Symbol | str) else None
    return symbol if symbol is key or isinstance(key, str) else None


def _listed(what: str, symbols: Sequence[Symbol], given: Any) -> Iterable[Any]:
    """What stands in a list, a tuple or an array."""
    flat = isinstance(given, np.ndarray) and given.ndim == 0
    if flat or isinstance(given, str | Expr) or not isinstance(given, Iterable):
        raise ValueMissingError(
            f"Expected a list of {what} or a dict {{name: value}} for {', '.join(s.name for s in symbols) or 'none'}, got "
            f"{cut(repr(given))}."
        )
    return given


def finite_number(what: str, name: str, value: Any) -> float:
    """`value` as a finite float."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise SimulationError(f"Expected a number as the {what} for {name}, got {_came(what, name, value)}") from error
    if not math.isfinite(number):
        raise SimulationError(
            f"Expected a finite {what} for {name}, got {number}. Give a number that motion can go on from."
        )
    return number


def _came(what: str, name: str, value: Any) -> str:
    """What came in the place of a number, and what to do."""
    if isinstance(value, Expr):
        cure = f", or write it into the model in the place of {name}" if "time" in what else ""
        return f"the expression {cut(value)}. Give the number that it stands for, kn.evaluate(…){cure}."
    if callable(value):
        return f"the function {cut(getattr(value, '__name__', value))}. Call it, or give the number that it stands for."
    if isinstance(value, np.ndarray | list | tuple):
        return f"an array of shape {np.shape(value)}. Give one number, in the unit of {name}."
    return f"{cut(repr(value))}. Give a plain number in the unit of {name}."
