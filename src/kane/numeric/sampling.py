# SPDX-License-Identifier: BSD-3-Clause
"""Values for symbols: given ones, else defaults of parameters, else reproducible random numbers.

A random number depends on the seed and the symbol's declaration alone, not on other draws or on the process. Users give values by
symbol or by name.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kane import expect
from kane.errors import ModelError, SimulationError, ValueMissingError, alike, cut
from kane.expr.evaluation import FLOAT
from kane.expr.node import Expr, as_expr, constant_value, postorder
from kane.expr.ops import ADD, CONST, MUL, PI, SUB, SYMBOL
from kane.expr.symbols import Parameter, Symbol, Symbols, declared
from kane.units.rules import parse

LOW, HIGH = 0.3, 1.2
"""Numbers are drawn from this range: no angle there is special, no length zero."""
SEEDS = (20042, 20043, 20044)
"""Of the samples that tell whether something is zero everywhere: what is not, vanishes at none of them but by a chance of 1e-12."""
SEED = 20322
"""Of whatever else is drawn at random: starts, configurations, values that nothing gives. Choices made from these depend on it."""
ASSEMBLY_SEED = 20048
"""Of starts of assembly, and of places that tell sizes of coordinates: by these distances are measured, and what is nearest."""
_WORD = 2**64 - 1


def draw(seed: int, symbol: Expr, low: float = LOW, high: float = HIGH) -> float:
    """A pseudorandom number between `low` and `high`, by SplitMix64 (Steele, Lea & Flood 2014) of the symbol's key and the seed.

    Every bit of the result depends on every bit of both.
    """
    z = (symbol.key + seed * 0x9E3779B97F4A7C15) & _WORD
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & _WORD
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & _WORD
    return low + (high - low) * ((z ^ (z >> 31)) >> 11) * 2.0**-53


def draws(seeds: int, symbols: Iterable[Expr]) -> NDArray[np.float64]:
    """The numbers of `draw` (seeds × symbols) with the seeds 0, 1, …."""
    keys = np.array([s.key & _WORD for s in symbols], dtype=np.uint64)
    z = keys[:, None] + np.arange(seeds, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    whole: NDArray[np.float64] = ((z ^ (z >> np.uint64(31))) >> np.uint64(11)).astype(float)
    return LOW + (HIGH - LOW) * whole * 2.0**-53


def value_of(symbol: Any, seed: int) -> float:
    """The default of the symbol, else a random number."""
    return draw(seed, symbol) if symbol.default is None else float(symbol.default)


def values_of(symbols: Iterable[Any], seed: int, values: Mapping[Any, float] | None = None) -> dict[Any, float]:
    """A value for every symbol: the one in `values`, else its default, else a random number. Other entries of `values` are kept."""
    complete = dict(values or {})
    complete.update((s, value_of(s, seed)) for s in symbols if s not in complete)
    return complete


def unit(values: dict[Any, Any], groups: Iterable[Sequence[Any]]) -> dict[Any, Any]:
    """The values with each group of Euler parameters divided by its length, as those of a rotation.

    Otherwise vectors would be scaled by one more factor in each link.
    """
    for group in groups:
        own = np.array([values[e] for e in group if e in values])
        if len(own) == len(group):
            values.update(zip(group, own / np.linalg.norm(own, axis=0), strict=True))
    return values


def sample(roots: Iterable[Expr], seed: int, groups: Iterable[Sequence[Expr]] = (), spread: float = 1.0) -> list[float]:
    """The values of expressions with parameters at their defaults and other symbols random; `groups` are Euler parameters.

    Random numbers are multiplied by `spread`, except angles and Euler parameters. Used in derivations for structural questions, as
    whether an expression is zero everywhere: one pass over the graph.
    """
    wanted = list(roots)
    values: dict[Expr, float] = {}
    order = postorder(wanted)
    symbols = [node for node in order if node.op is SYMBOL]
    held = {e for group in groups for e in group}
    values.update(
        (s, value_of(s, seed) * (1.0 if spread == 1.0 or s in held or _sized(s) else spread)) for s in symbols
    )
    values = {s: float(x) for s, x in unit(values, groups).items()}
    with np.errstate(all="ignore"):
        for node in order:
            op, args = node.op, node.args
            if op is MUL:  # most are, or sums
                values[node] = values[args[0]] * values[args[1]]
            elif op is ADD:
                values[node] = values[args[0]] + values[args[1]]
            elif op is SUB:
                values[node] = values[args[0]] - values[args[1]]
            elif args:
                values[node] = FLOAT[op](*[values[a] for a in args])
            elif op is CONST:
                values[node] = float(constant_value(node) or 0)
            elif op is PI:
                values[node] = math.pi
    return [values[e] for e in wanted]


def _sized(symbol: Any) -> bool:
    """Whether a symbol has a known size, as parameters and angles have."""
    return isinstance(symbol, Parameter) or bool(symbol.unit and not any(parse(symbol.unit).exponents))


def default_of(e: Expr) -> float | None:
    """The value at the defaults of parameters; None if a parameter has no default, or if there are other symbols."""
    symbols = [node for node in postorder([e]) if node.op is SYMBOL]
    if any(not isinstance(s, Parameter) or s.default is None for s in symbols):
        return None
    return float(sample([e], SEEDS[0])[0])


SIGN = "Check its sign, or the default."


def positive(given: Any, expected: str, cure: str = SIGN) -> Expr:
    """An expression; raises ModelError if it is not above zero at default parameters; what has no value there passes."""
    return in_range(given, f"{expected} above zero", cure, above=True)


def not_negative(given: Any, expected: str, cure: str = SIGN) -> Expr:
    """An expression; raises ModelError if it is negative at default parameters."""
    return in_range(given, f"{expected} at or above zero", cure, above=False)


def in_range(given: Any, expected: str, cure: str = SIGN, *, above: bool) -> Expr:
    """An expression that is positive, if `above`, or not negative, with all that is `expected` in words."""
    e = as_expr(given)
    value = default_of(e)
    if value is not None and not (value > 0 or (value == 0 and not above)):
        came = f"{value:g}" if constant_value(e) is not None else f"{cut(e)} = {value:g}"
        raise expect.refusal(ModelError, expected, came, cure)
    return e


def named_values(what: str, symbols: Sequence[Symbol], given: Any) -> dict[Expr, Any]:
    """Values by symbol, from a mapping by symbol or name, or a sequence in the symbols' order; the number 0 stands for all at zero.

    A parameter that the system does not hold is left out where it is given by symbol, so that variants of a model share their values.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        values = list(_listed(what, symbols, spelled_out(what, symbols, given)))
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
        symbol = _symbol_of(by_name, key)
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


def spelled_out(what: str, symbols: Sequence[Symbol], given: Any) -> Any:
    """Zeros in place of the number 0, but for parameters; else what is given."""
    return [0.0] * len(symbols) if stands_for_zeros(what, given) else given


def stands_for_zeros(what: str, given: Any) -> bool:
    """Whether it is the number 0, but for parameters, which are hardly ever all 0."""
    number = isinstance(given, int | float) and not isinstance(given, bool)
    return number and given == 0 and "parameters" not in what


def symbols_named(what: str, symbols: Sequence[Symbol], keys: Any) -> Symbols[Any]:
    """The symbols given by a list of symbols and names, in the order of the list."""
    by_name = {s.name: s for s in symbols}
    found = []
    for key in _listed(what, symbols, keys):
        symbol = _symbol_of(by_name, key)
        if symbol is None:
            raise ValueMissingError(f"Expected one of {', '.join(by_name) or 'none'}, got {unknown(key, symbols)}")
        found.append(symbol)
    return Symbols(found)


def names_in(expected: str, given: Any) -> list[str]:
    """The names of symbols and names in a list; one that stands alone is a list of it."""
    alone = isinstance(given, str | Expr)
    listed = (given,) if alone else expect.items(given, expected, "List symbols or names.", error=ValueMissingError)
    return [x.name if isinstance(x, Symbol) else str(x) for x in listed]


def symbol_named(symbols: Iterable[Symbol], key: Any) -> Symbol:
    """The symbol of `symbols` given as a symbol or by name."""
    symbol: Symbol
    (symbol,) = symbols_named("symbols", tuple(symbols), [key])
    return symbol


def unknown(key: Any, symbols: Iterable[Symbol]) -> str:
    """Words for a key that is not in `symbols`: its difference from the symbol of the same name, or similar names."""
    names = {s.name: s for s in symbols}
    if isinstance(key, Symbol) and key.name in names:
        return (
            f"another symbol of the name {key.name!r}: {declared(key)} in place of {declared(names[key.name])}. Take the system's "
            "own symbol, or give the name alone."
        )
    return f"{cut(repr(key))}.{alike(str(key), names)}"


def _symbol_of(by_name: Mapping[str, Symbol], key: Any) -> Symbol | None:
    symbol = by_name.get(key.name if isinstance(key, Symbol) else key) if isinstance(key, Symbol | str) else None
    return symbol if symbol is key or isinstance(key, str) else None


def _listed(what: str, symbols: Sequence[Symbol], given: Any) -> Iterable[Any]:
    """The entries of a list, a tuple or an array."""
    if isinstance(given, Expr) or not expect.is_list(given):
        cure = f" Write [{given}]." if len(symbols) == 1 and isinstance(given, int | float) else ""
        raise ValueMissingError(
            f"Expected a list of {what} or a dict {{name: value}} for {', '.join(s.name for s in symbols) or 'none'}, got "
            f"{cut(repr(given))}.{cure}"
        )
    return given


def finite_number(what: str, name: str, value: Any) -> float:
    """`value` as a finite float."""
    try:
        if isinstance(value, str | bytes) or (isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "cUS"):
            raise TypeError("a text, or a complex number, of which NumPy would drop the imaginary part")
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise SimulationError(f"Expected a number as the {what} for {name}, got {_came(what, name, value)}") from error
    if not math.isfinite(number):
        raise SimulationError(f"Expected a finite {what} for {name}, got {number}. Give a finite number.")
    return number


def _came(what: str, name: str, value: Any) -> str:
    """Words for a value that is not a number, and the cure."""
    if isinstance(value, Expr):
        cure = f", or write it into the model instead of {name}" if "time" in what else ""
        return f"the expression {cut(value)}. Give its value, kn.evaluate(…){cure}."
    if callable(value):
        return f"the function {cut(getattr(value, '__name__', value))}. Call it, or give its value."
    if isinstance(value, np.ndarray | list | tuple):
        return f"an array of shape {np.shape(value)}. Give one number, in the unit of {name}."
    return f"{cut(repr(value))}. Give a plain number in the unit of {name}."
