# SPDX-License-Identifier: BSD-3-Clause
"""What events do, `then={u: -e*u}`: checked where an event is declared, and where its system is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from kane.errors import ModelError, cut
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import Coordinate, Input, Parameter, Rate, Speed, StateVariable, Symbol

SETTABLE = (Coordinate, Speed, StateVariable, Parameter, Input)
_FORM = "Write then={symbol: expression}, as {u1: -e*u1}"


def as_action(who: str, then: Any) -> Any:
    """A mapping of symbols, or their names, to expressions, or a function that returns one; None where nothing is done.

    Inputs may get what `inputs=` takes.
    """
    if then is None or (callable(then) and not isinstance(then, Expr | Mapping)):
        return then
    if not isinstance(then, Mapping) or not then:
        raise ModelError(f"Expected then= of {who} to say what changes, got {cut(repr(then))}. {_FORM}.")
    made: dict[Any, Any] = {}
    for key, value in then.items():
        if isinstance(key, Rate):
            raise ModelError(
                f"Expected then= of {who} to set coordinates, speeds, states, parameters or inputs, got the rate {key}. Set the speed "
                "that it is made of."
            )
        if not isinstance(key, str | Symbol) or (isinstance(key, Symbol) and not isinstance(key, SETTABLE)):
            raise ModelError(
                f"Expected then= of {who} to set coordinates, speeds, states, parameters or inputs, got {cut(repr(key))}. {_FORM}."
            )
        number = isinstance(value, Expr | int | float) and not isinstance(value, bool)
        if not number and not isinstance(key, Input | str):
            raise ModelError(
                f"Expected an expression or a number for {key} in then= of {who}, got {cut(repr(value))}. {_FORM}."
            )
        made[key] = as_expr(value) if number else value
    return made


def expressions(events: Iterable[Any]) -> Iterator[Expr]:
    """What events watch, and all that they make of what they set."""
    for event in events:
        yield event.quantity
        if isinstance(event.then, Mapping):
            yield from (x for x in event.then.values() if isinstance(x, Expr))


def settable(system: Any) -> tuple[Symbol, ...]:
    """What actions may set."""
    inputs = (s for s in system.inputs if isinstance(s, Input))
    return (*system.coordinates, *system.speeds, *system.states, *system.parameters, *inputs)


def target(system: Any, event: Any, key: Any) -> Symbol:
    """The symbol that an event sets.

    Raises
    ------
    ModelError
        if it is none of the system's
    """
    for s in settable(system):
        if s is key or (isinstance(key, str) and s.name == key):
            return s
    raise ModelError(
        f"Expected then= of the event {event.name!r} to set one of {', '.join(s.name for s in settable(system))}, got "
        f"{cut(repr(key))}. Take one of these, symbols of the system, or its name."
    )


def check_actions(system: Any) -> None:
    """Events set symbols of the system, each once, and watch quantities that change along a motion."""
    for event in system.events:
        moving = [s for s in free_symbols([event.quantity]) if not isinstance(s, Parameter)]
        if not moving:
            raise ModelError(
                f"Expected the quantity of the event {event.name!r} to change along a motion, got {cut(event.quantity)}, which is "
                "constant: it crosses no threshold. Watch an expression of coordinates, speeds, reactions or time."
            )
        if not isinstance(event.then, Mapping):
            continue
        targets = [target(system, event, key) for key in event.then]
        if len(set(targets)) < len(targets):
            raise ModelError(
                f"Expected one value for each symbol in then= of the event {event.name!r}, got two, by symbol and by name. Leave one "
                "out."
            )
