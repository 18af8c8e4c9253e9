# SPDX-License-Identifier: BSD-3-Clause
"""Numbers by symbol or name, as users give them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kane.errors import SimulationError, ValueMissingError, alike
from kane.expr.node import Expr
from kane.expr.symbols import Symbol


def named_values(what: str, symbols: Sequence[Symbol], given: Any) -> dict[Expr, Any]:
    """Values by symbol, from a mapping by symbol or name, or a sequence in the symbols' order."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        values = list(given)
        if len(values) != len(symbols):
            raise ValueMissingError(
                f"Expected {len(symbols)} {what} ({', '.join(s.name for s in symbols)}), got {len(values)} values. Give one for each "
                "in that order, or a dict {name: value}."
            )
        return dict(zip(symbols, values, strict=True))
    by_name = {s.name: s for s in symbols}
    by_symbol: dict[Expr, Any] = {}
    for key, value in given.items():
        name = key.name if isinstance(key, Symbol) else key
        symbol = by_name.get(name) if isinstance(name, str) else None
        if symbol is None or (isinstance(key, Symbol) and key is not symbol):
            raise ValueMissingError(
                f"Expected values for {what} of the system ({', '.join(by_name) or 'none'}), got one for {key!r}."
                f"{'' if name in by_name else alike(str(name), by_name)}"
            )
        by_symbol[symbol] = value
    return by_symbol


def finite_number(what: str, name: str, value: Any) -> float:
    """`value` as a finite float."""
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise SimulationError(
            f"Expected a number as the {what} for {name}, got {value!r:.60}. Give a plain number in the unit of {name}."
        ) from error
    if not np.isfinite(number):
        raise SimulationError(
            f"Expected a finite {what} for {name}, got {number}. Give a number that motion can go on from."
        )
    return number
