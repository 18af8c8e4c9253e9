# SPDX-License-Identifier: BSD-3-Clause
"""Typed leaves: a symbol's role is its class, its identity is its whole declaration.

Two declarations that agree in everything are one symbol; any difference makes another one. There is no registry: a
System refuses two symbols of one name that meet in it.
"""

import hashlib
from collections.abc import Hashable, Iterable
from importlib import import_module
from typing import Any, ClassVar, Self, SupportsIndex, TypeVar, cast

from kane.errors import ExpressionError, UnitError, cut
from kane.expect import is_list
from kane.expr.node import Expr, Number, _table, as_expr, constant_value, enter, leaf
from kane.expr.ops import SYMBOL
from kane.show import Listing


def _identity_key(place: Hashable) -> object:
    """What of a place enters the structural key: two rates of coordinates declared differently must differ."""
    if isinstance(place, Expr):
        return place.key
    return tuple(map(_identity_key, place)) if isinstance(place, tuple) else None


def _is_text(x: object) -> bool:
    return isinstance(x, str)


class Symbol(Expr):
    """A named scalar in expressions. `place` is the object that it refers to: the coordinate of a Rate, the point of a Reaction."""

    __slots__ = ("default", "description", "name", "place", "unit")

    kind: ClassVar[str] = ""
    """Stands for the class in the keys that order symbols, where it is not the class's name."""
    name: str
    default: Number | None
    unit: str
    description: str
    place: Hashable

    @classmethod
    def declare(
        cls, name: str, default: float | None = None, unit: str = "", description: str = "", place: Hashable = None
    ) -> Self:
        """The symbol with this declaration: equal declarations give the same object."""
        if type(name) is type(unit) is type(description) is str and (default is None or type(default) is float):
            known = _table.get((SYMBOL, cls, name, default, unit, description, place))
            if known is not None:  # it has been checked then
                return cast(Self, known)
        if not _is_text(name) or not name.strip() or any(c.isspace() for c in name):
            several = _is_text(name) and len(name.split()) > 1 and cls in _SEVERAL
            cure = f" Several at once are kn.{cls.__name__.lower()}s({name!r})." if several else ""
            raise ExpressionError(f"Expected a name without spaces for the {cls.__name__}, got {name!r}.{cure}")
        if isinstance(default, str):
            raise ExpressionError(
                f"Expected a number as the default of {name!r}, got {default!r}. The order is name, default, unit, description; "
                f"without a default write unit={default!r}."
            )
        if not (_is_text(unit) and _is_text(description)):
            raise ExpressionError(
                f"Expected unit and description of {name!r} as texts, got {cut(repr(unit))} and {cut(repr(description))}."
            )
        if default is not None:
            number = constant_value(as_expr(default))
            if number is None:
                raise ExpressionError(f"Expected a number as the default of {name!r}, got an expression.")
            default = float(number)
        declaration = (name, default, unit, description, place)
        entry = (SYMBOL, cls, *declaration)
        first = _table.get(entry)
        if first is not None:
            return cast(Self, first)
        text = repr((cls.kind or cls.__name__, name, default, unit, description, _identity_key(place)))
        node = leaf(cls, SYMBOL, int.from_bytes(hashlib.blake2b(text.encode(), digest_size=7).digest()))
        for field, value in zip(("name", "default", "unit", "description", "place"), declaration, strict=True):
            object.__setattr__(node, field, value)
        return cast(Self, enter(entry, node))

    def declaration(self) -> tuple[Any, ...]:
        """What `declare` was given."""
        return (self.name, self.default, self.unit, self.description, self.place)


class Parameter(Symbol):
    """A constant of the system with a default value, a unit and a description."""

    __slots__ = ()


class Coordinate(Symbol):
    """A generalized (or pseudo-generalized) coordinate q; `q.dt` is its rate."""

    __slots__ = ()


class Speed(Symbol):
    """A generalized speed u; `u.dt` is its time derivative."""

    __slots__ = ()


class AuxiliarySpeed(Symbol):
    """A speed that is zero throughout the motion and brings a noncontributing force into evidence."""

    __slots__ = ()


class Reaction(Symbol):
    """The measure number of a noncontributing force or torque; `place` says where it acts."""

    __slots__ = ()


class Input(Symbol):
    """A value that is prescribed from outside the system: a motor torque, a force, a motion."""

    __slots__ = ()


class StateVariable(Symbol):
    """A state a beside q and u: an activation, a current, an integral. `System(states={a: …})` declares its rate."""

    __slots__ = ()

    kind = "State"


class Time(Symbol):
    """The time t."""

    __slots__ = ()


class Rate(Symbol):
    """The time derivative of the coordinate, speed, state or input in `place`."""

    __slots__ = ()


class QuasiRate(Symbol):
    """A measure number of the angular velocity of a frame oriented by Euler parameters.

    `place` is (e0, e1, e2, e3, axis): with e = (e1, e2, e3) and w the three quasi-rates along the frame's own axes,
    ė0 = −½ e·w and ė = ½ (e0 w + e × w)  (Kane, Likins, Levinson 1983, Spacecraft Dynamics, sec. 1.13).
    """

    __slots__ = ()


S = TypeVar("S", bound=Symbol)


class Symbols(Listing[S]):
    """Symbols in order, of which one is found by itself or by its name: `u1 in eom.dependent_speeds`, `"u1" in …`."""

    __slots__ = ()

    def __contains__(self, key: object) -> bool:
        return any(s.name == key if isinstance(key, str) else s is key for s in self)

    def index(self, key: object, start: SupportsIndex = 0, stop: SupportsIndex | None = None) -> int:
        """The place of a symbol, by itself or by its name."""
        for k in range(len(self))[slice(start, stop)]:
            if self[k] is key or (isinstance(key, str) and self[k].name == key):
                return k
        raise ValueError(f"Expected one of {', '.join(s.name for s in self) or 'none'}, got {key}.")

    def count(self, key: object) -> int:
        """1 where the symbol, or one of that name, is among them, else 0."""
        return int(key in self)


def word(name: str) -> str:
    """A name of anything as one that a symbol can have."""
    return "".join(c if c.isalnum() or c == "_" else "_" for c in name)


_CONSTRUCTORS = {AuxiliarySpeed: "auxiliary_speed", StateVariable: "state"}
"""Functions that declare symbols, where they are not called as the class."""


def declared(symbol: Symbol) -> str:
    """The call that declares a symbol, as the user wrote it."""
    words = [repr(x) for x in symbol.declaration()[:2] if x is not None]
    words += [f"{what}={x!r}" for what, x in (("unit", symbol.unit), ("description", symbol.description)) if x]
    kind = _CONSTRUCTORS.get(type(symbol)) or type(symbol).__name__.lower()
    return f"kn.{kind}({', '.join(words)})"


time = Time.declare("t", None, "s", "time")


def per_second(text: str) -> str:
    """The unit of the rate of what is in this unit: "m/s" after "m", "m/s^2" after "m/s"."""
    return f"{text}^2" if text.endswith("/s") else f"{text}/s" if text else ""


def rate(symbol: Symbol) -> Rate:
    """The symbol for the time derivative of a coordinate, speed, state or input."""
    if isinstance(symbol, (Coordinate, Speed, AuxiliarySpeed, StateVariable, Input, Rate, QuasiRate)):
        return Rate.declare(f"{symbol.name}'", None, per_second(symbol.unit), "", symbol)
    raise ExpressionError(
        f"Expected a coordinate, speed, state or input, got {symbol!r} ({type(symbol).__name__}): it has no rate."
    )


def input_of(symbol: Expr) -> Input | None:
    """The input that a symbol is, or is a derivative of."""
    origin: Any = symbol
    while isinstance(origin, Rate):
        origin = origin.place
    return origin if isinstance(origin, Input) else None


def names(text: str | Iterable[str]) -> tuple[str, ...]:
    """Names from "q1:6" (q1 to q5), "x, y" or "x y", or from a list of such.

    >>> names("q1:4")
    ('q1', 'q2', 'q3')
    """
    if not isinstance(text, str):
        given: Any = text
        parts = list(given) if is_list(given) else [given]
        if not parts or not all(isinstance(part, str) for part in parts):
            raise ExpressionError(f'Expected names such as "q1:6", "x, y" or ["x", "y"], got {cut(repr(text))}.')
        return tuple(name for part in parts for name in names(part))
    words: list[str] = []
    for word in text.replace(",", " ").split():
        head, colon, stop = word.partition(":")
        if not colon:
            words.append(word)
            continue
        stem = head.rstrip("0123456789")
        start = head[len(stem) :] or "0"
        if not stem or not stop.isdigit():
            raise ExpressionError(f'Expected names such as "q1:6" or "x, y", got {word!r} in {text!r}.')
        words.extend(f"{stem}{i}" for i in range(int(start), int(stop)))
    if not words:
        raise ExpressionError(f'Expected names such as "q1:6" or "x, y", got {text!r}: no name in it.')
    return tuple(words)


_SEVERAL = (Parameter, Coordinate, Speed, Input)
"""Kinds of which several are declared at once."""


def _several(kind: type[S], text: str | Iterable[str], default: Any, unit: str, description: str) -> tuple[S, ...]:
    """Symbols that differ in name, and default, alone; what stands for a unit is read at once, as it may be meant as a name."""
    if _is_text(unit) and unit:
        try:
            import_module("kane.units.rules").parse(unit)  # units stand above expressions
        except UnitError as error:
            both = f"{' '.join(names(text))} {unit}"
            raise UnitError(
                f"{error} If {unit!r} is another name, give all names in one text, {kind.__name__.lower()}s({both!r})."
            ) from None
    listed = names(text)
    each = is_list(default) and not isinstance(default, Expr)
    defaults = list(default) if each else [default] * len(listed)
    if len(defaults) != len(listed):
        raise ExpressionError(
            f"Expected one default for all of {', '.join(listed)}, or {len(listed)}, got {len(defaults)}: {cut(repr(default))}."
        )
    return tuple(kind.declare(n, x, unit, description) for n, x in zip(listed, defaults, strict=True))


def coordinates(text: str | Iterable[str], unit: str = "", description: str = "") -> tuple[Coordinate, ...]:
    """Generalized coordinates, always as a tuple: `q1, q2 = coordinates("q1:3")`, `x, y = coordinates("x y", unit="m")`.

    `text` holds names separated by spaces or commas, a range with an excluded end, or a list of names.
    """
    return _several(Coordinate, text, None, unit, description)


def coordinate(name: str, unit: str = "", description: str = "") -> Coordinate:
    """One generalized coordinate; `unit` is that of its values, such as "rad" or "m"."""
    return Coordinate.declare(name, None, unit, description)


def speeds(text: str | Iterable[str], unit: str = "", description: str = "") -> tuple[Speed, ...]:
    """Generalized speeds, always as a tuple; names as for `coordinates`."""
    return _several(Speed, text, None, unit, description)


def speed(name: str, unit: str = "", description: str = "") -> Speed:
    """One generalized speed."""
    return Speed.declare(name, None, unit, description)


def parameters(
    text: str | Iterable[str], default: float | Iterable[float] | None = None, unit: str = "", description: str = ""
) -> tuple[Parameter, ...]:
    """Parameters with the same unit and description, and one default value or one each, as a tuple; names as for `coordinates`."""
    return _several(Parameter, text, default, unit, description)


def parameter(name: str, default: float | None = None, unit: str = "", description: str = "") -> Parameter:
    """One parameter: a constant of the system, whose value may be changed without a new derivation."""
    return Parameter.declare(name, default, unit, description)


def inputs(text: str | Iterable[str], unit: str = "", description: str = "") -> tuple[Input, ...]:
    """Inputs with the same unit and description, always as a tuple; names as for `coordinates`."""
    return _several(Input, text, None, unit, description)


def input(name: str, unit: str = "", description: str = "") -> Input:
    """One input, such as a motor torque: a value that `simulate` and other functions take as `inputs=`."""
    return Input.declare(name, None, unit, description)


def state(name: str, default: float = 0.0, unit: str = "", description: str = "") -> StateVariable:
    """One state beside coordinates and speeds, such as a muscle's activation; a motion starts at `default` unless a value is given.

    The system declares its rate, `System(states={a: expression})`, which may depend on the state itself.
    """
    return StateVariable.declare(name, default, unit, description)
