# SPDX-License-Identifier: BSD-3-Clause
"""SymPy's symbols and functions of time as symbols of kane, made when an expression first contains them.

Symbols become parameters, functions of time that are neither coordinates nor speeds become inputs. SymPy's assumptions about a symbol
are noted in its description.
"""

from collections.abc import Iterable, Iterator, Mapping
from math import isfinite
from types import MappingProxyType
from typing import Any

from kane import expect
from kane.errors import ExpressionError, cut
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import Coordinate, Input, Parameter, Speed, Symbol, time
from kane.interop.imported import FreeNames, Remarks
from kane.interop.sympy import from_sympy
from kane.interop.sympy_mechanics.given import Given

_ASSUMED = ("positive", "negative", "nonnegative", "nonpositive", "nonzero", "integer")
"""Assumptions that are noted, the stronger first."""


class Translation(Mapping[Any, Expr]):
    """The symbol of kane for each symbol of a SymPy model; `scalar` converts an expression."""

    def __init__(self, given: Given, values: Mapping[Any, float], remarks: Remarks) -> None:
        from sympy.physics.mechanics import dynamicsymbols

        self.names, self._remarks = FreeNames([time.name]), remarks
        self._known: dict[Any, Expr] = {dynamicsymbols._t: time}
        named = {getattr(key, "name", str(key)): x for key, x in values.items()}
        self._values = {name: _number(name, x) for name, x in named.items()}
        self._time = dynamicsymbols._t
        self.coordinates = tuple(self._enter(x, Coordinate) for x in given.q)
        self.speeds = tuple(self._enter(x, Speed) for x in given.u)
        for x in given.auxiliary:
            self._known[x] = self._known[x.diff(self._time)] = ZERO

    def _enter(self, x: Any, kind: type[Any]) -> Any:
        symbol = kind.declare(self.names.free(_name(x)))
        self._known[x] = symbol
        return symbol

    def enter(self, x: Any, symbol: Symbol) -> None:
        """Sets the symbol of kane for a symbol or function of SymPy."""
        self._known[x] = symbol

    def scalar(self, e: Any) -> Expr:
        """A SymPy expression in kane; functions that SymPy can expand, such as muscle curves, are expanded."""
        try:
            return from_sympy(e, self)
        except ExpressionError:
            whole = e.doit()
            if whole == e:
                raise
            return from_sympy(whole, self)

    def scalars(self, many: Iterable[Any]) -> list[Expr]:
        """SymPy expressions in kane."""
        return [self.scalar(e) for e in many]

    def others(self) -> list[Symbol]:
        """The symbols that are neither coordinates nor speeds."""
        return [s for s in self._known.values() if isinstance(s, Symbol) and not isinstance(s, Coordinate | Speed)]

    def check_values(self) -> None:
        """Raises if a value is given for something other than a parameter of the model."""
        own = {str(key) for key, s in self._known.items() if isinstance(s, Parameter)}
        cure = f"It has {', '.join(sorted(own)) or 'none'}."
        expect.none([repr(x) for x in self._values if x not in own], "values= of parameters of the model", cure=cure)

    def named(self) -> Mapping[str, Expr]:
        """The symbol for each name; the first of several with the same name."""
        found: dict[str, Expr] = {}
        for key, s in self._known.items():
            if isinstance(s, Symbol):
                found.setdefault(str(key.func) if key.is_Function else str(key), s)
        return MappingProxyType(found)

    def __contains__(self, key: object) -> bool:
        from sympy import Symbol as SympySymbol
        from sympy.core.function import AppliedUndef

        return key in self._known or isinstance(key, SympySymbol | AppliedUndef)

    def __getitem__(self, key: Any) -> Expr:
        if key not in self._known:
            self._known[key] = self._made(key)
        return self._known[key]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)

    def _made(self, key: Any) -> Expr:
        if getattr(key, "args", ()):
            if key.args != (self._time,):
                raise ExpressionError(f"Expected functions of the time {self._time} alone, got {cut(key)}.")
            name = self.names.free(_name(key))
            self._remarks.say(
                "inferred", f"{name} is an input: a function of time that is neither coordinate nor speed"
            )
            return Input.declare(name)
        said = next((a for a in _ASSUMED if key.assumptions0.get(a)), "")
        name = self.names.free(key.name)
        if name != key.name:
            self._remarks.say("changed", f"the name of the symbol {key.name}, which is taken, to {name}")
        return Parameter.declare(name, self._values.get(key.name), "", said)


def _number(name: str, value: Any) -> float:
    """The value of a parameter as a number, also if SymPy keeps it as an expression, such as π/6."""
    expected = f"a finite number as the value of {name}"
    number = expect.floats(value, expected)
    expect.that(number.ndim == 0 and isfinite(number), expected, value)
    return float(number)


def _name(x: Any) -> str:
    """The name of a function of time; u_… for a derivative that is a speed."""
    if x.is_Derivative:
        base = x.args[0].func.__name__
        return f"u{base[1:]}" if base[0] == "q" and base[1:].isdigit() else f"u_{base}"
    return str(x.func.__name__) if x.args else str(x)
