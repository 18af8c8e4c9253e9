# SPDX-License-Identifier: BSD-3-Clause
"""Arguments of compiled code: arrays of doubles of the right length, or an error that says which is not."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from kane.errors import ArgumentError, ValueMissingError, cut
from kane.expr.symbols import Symbol
from kane.numeric.arrays import Array
from kane.numeric.sampling import finite_number, named_values
from kane.program.program import Port

_REAL = "biuf"


def values(port: Port, argument: Any, base: Array | None = None) -> Array:
    """The values of a port: a number or an array of numbers where it is scalar, else (…, n), or by symbol or name.

    `base` fills in what is left out.

    Raises
    ------
    ArgumentError
        if the shape or the type is wrong
    ValueMissingError
        if a name is unknown or a value is missing
    """
    if argument is None and port.scalar and base is not None:
        return complete(port, base)[:1].reshape(())
    if argument is None and (port.optional or base is not None or not port.symbols) and not port.scalar:
        argument = {}
    if isinstance(argument, Mapping) and not port.scalar:
        return _by_name(port, argument, base)
    array = _real(port.name, argument)
    if not port.scalar and (array.ndim < 1 or array.shape[-1] != len(port.symbols)):
        raise ArgumentError(
            f"Expected {port.name} of shape (…, {len(port.symbols)}), got shape {array.shape}. The order is {listed(port.symbols)}."
        )
    return array


def defaults(port: Port) -> Array:
    """The default of every parameter, NaN where there is none."""
    return np.array([np.nan if s.default is None else float(s.default) for s in port.symbols])


def replaced(port: Port, argument: Mapping[Any, Any], base: Array) -> Array:
    """`base` with the values given by symbol or name."""
    own = named_values(port.nouns, port.symbols, argument)
    pairs = zip(port.symbols, base, strict=True)
    return np.array([finite_number("value", s.name, own[s]) if s in own else b for s, b in pairs])


def complete(port: Port, values: Array) -> Array:
    """`values`, none of which may be missing (NaN)."""
    missing = [s.name for s, v in zip(port.symbols, values, strict=True) if np.isnan(v)]
    if missing:
        by_name = f", {{{', '.join(f'{n!r}: value' for n in missing)}}}"
        cure = ", or declare a default, kn.parameter(name, default)" if port.hoisted else by_name * port.optional
        raise ValueMissingError(
            f"Expected a value for every one of the {port.nouns}, got none for {', '.join(missing)}: pass them as "
            f"{port.name}{cure}."
        )
    return values


def finite(port: Port, values: Array) -> None:
    """Refuse NaN and infinity, by name."""
    if np.isfinite(values).all():
        return
    bad = np.argwhere(~np.isfinite(values))
    first = tuple(bad[0])
    name = port.symbols[0 if port.scalar else first[-1]].name
    row = first if port.scalar else first[:-1]
    where = f" at {tuple(map(int, row))}" if row else ""
    raise ArgumentError(f"Expected finite {port.nouns}, got {name} = {values[first]}{where}.")


def listed(symbols: tuple[Symbol, ...]) -> str:
    """Names in order, the middle of long lists left out."""
    names = [s.name for s in symbols]
    return ", ".join(names if len(names) <= 12 else [*names[:6], "…", *names[-3:]]) or "none"


def _real(name: str, value: Any) -> Array:
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise ArgumentError(f"Expected {name} without masked values, got a masked array: fill or drop them.")
    try:
        array = np.asarray(value)
        if array.dtype.kind not in _REAL:
            raise TypeError
        return array.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError) as error:
        got = type(value).__name__ if not isinstance(value, np.ndarray) else f"an array of {value.dtype}"
        raise ArgumentError(f"Expected real numbers as {name}, got {got}: {cut(repr(value))}.") from error


def _by_name(port: Port, argument: Mapping[Any, Any], base: Array | None) -> Array:
    values = named_values(port.nouns, port.symbols, argument)
    filled = np.full(len(port.symbols), np.nan) if base is None else base
    columns = [_real(s.name, values[s]) if s in values else b for s, b in zip(port.symbols, filled, strict=True)]
    complete(port, np.array([0.0 if s in values else b for s, b in zip(port.symbols, filled, strict=True)]))
    try:
        return np.stack(np.broadcast_arrays(*columns), axis=-1) if columns else np.zeros(0)
    except ValueError as error:
        shapes = ", ".join(f"{s.name} {np.shape(c)}" for s, c in zip(port.symbols, columns, strict=True) if np.ndim(c))
        raise ArgumentError(f"Expected {port.nouns} whose shapes broadcast, got {shapes}.") from error
