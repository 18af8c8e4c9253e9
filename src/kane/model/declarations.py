# SPDX-License-Identifier: BSD-3-Clause
"""What a system consists of once it is declared: its fields, its events, and every frame, point and scalar that they reach."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane import expect
from kane.errors import ModelError, cut
from kane.expr.evaluation import free_symbols
from kane.expr.node import Expr, as_expr
from kane.expr.ops import Immutable
from kane.expr.symbols import (
    AuxiliarySpeed,
    Coordinate,
    Input,
    Parameter,
    Rate,
    Reaction,
    Speed,
    StateVariable,
    Symbol,
    Symbols,
)
from kane.model.bodies import Body, parts_of
from kane.model.constraints import Constraint, cut_of
from kane.model.joints.joint import Joint
from kane.model.loads import Gravity, Load
from kane.model.variables import EulerParameters
from kane.space.frame import Frame, Point, frames_of
from kane.space.vector import Vector


@dataclass(frozen=True, slots=True, eq=False)
class Event(Immutable):
    """`quantity` falls below (direction −1), rises above (+1) or crosses (0) `threshold`.

    A terminal event ends the simulation there; the solution returns what there is and names it. One that does something,
    `then={v: -e*v}`, does not end it unless told: the motion goes on with other values of coordinates, speeds, states or parameters,
    all computed from those before, or with other inputs, for which anything stands that `inputs=` takes. `then` may be a function
    that returns such values, called with t, q, u and parameters as keywords. Under constraints, dependent speeds that are not set
    follow.
    """

    name: str
    quantity: Expr
    threshold: float = 0.0
    direction: int = 0
    terminal: bool | None = None
    message: str = ""
    then: Any = None

    def __post_init__(self) -> None:
        who = f"the event {cut(repr(self.name), 40)}"
        for what, (right, expected) in _EVENT.items():
            given = getattr(self, what)
            expect.that(right(given), f"{what} of {who} to be {expected}", given, "See kn.Event.")
        object.__setattr__(self, "threshold", float(self.threshold))
        object.__setattr__(self, "then", as_action(who, self.then))
        object.__setattr__(self, "terminal", self.then is None if self.terminal is None else bool(self.terminal))

    @property
    def breaks(self) -> bool:
        """Whether the motion does not go on as it was."""
        return bool(self.terminal) or self.then is not None

    @property
    def consequence(self) -> str:
        """What happens, in words."""
        done = "; ".join(f"{s} := {x}" for s, x in self.then.items()) if isinstance(self.then, Mapping) else ""
        done = done or (f"calls {getattr(self.then, '__name__', 'a function')}" if self.then is not None else "")
        return ", ".join(x for x in (done, "ends the simulation" if self.terminal else "") if x)

    def __repr__(self) -> str:
        passes = {-1: "falls below", 0: "crosses", 1: "rises above"}[self.direction]
        done = f": {cut(self.consequence)}" if self.consequence else ""
        return f"Event({self.name!r}, {cut(self.quantity)} {passes} {self.threshold:g}{done})"


_EVENT: dict[str, tuple[Callable[[Any], bool], str]] = {
    "name": (lambda x: isinstance(x, str) and bool(x), "a text that is not empty"),
    "quantity": (lambda x: isinstance(x, Expr), "a scalar expression of the system, such as q1 or v.dot(N.x)"),
    "threshold": (expect.is_number, "a finite number, in the unit of the quantity"),
    "direction": (lambda x: expect.is_number(x) and x in (-1, 0, 1), "-1 (falls), 1 (rises) or 0 (either)"),
    "terminal": (lambda x: x is None or isinstance(x, bool | np.bool_), "True or False"),
    "message": (lambda x: isinstance(x, str), "a text"),
}
"""What each field of an event must be."""


SETTABLE = (Coordinate, Speed, StateVariable, Parameter, Input)
_FORM = "Write then={symbol: expression}, as {u1: -e*u1}."


def as_action(who: str, then: Any) -> Any:
    """A mapping of symbols, or their names, to expressions, or a function that returns one; None where nothing is done.

    Inputs may get what `inputs=` takes.
    """
    if then is None or (callable(then) and not isinstance(then, Expr | Mapping)):
        return then
    expect.that(isinstance(then, Mapping) and then, f"then= of {who} to say what changes", then, _FORM)
    made: dict[Any, Any] = {}
    for key, value in then.items():
        expected = f"then= of {who} to set coordinates, speeds, states, parameters or inputs"
        if isinstance(key, Rate):
            raise ModelError(f"Expected {expected}, got the rate {key}. Set the speed that it is made of.")
        expect.instance(key, (str, *SETTABLE), expected, _FORM)
        number = isinstance(value, Expr | int | float) and not isinstance(value, bool)
        right = number or isinstance(key, Input | str)
        expect.that(right, f"an expression or a number for {key} in then= of {who}", value, _FORM)
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
    """The symbol of the system that an event sets."""
    for s in settable(system):
        if s is key or (isinstance(key, str) and s.name == key):
            return s
    expected = f"then= of the event {event.name!r} to set one of {', '.join(s.name for s in settable(system))}"
    cure = "Take one of these, symbols of the system, or its name."
    raise expect.refusal(ModelError, expected, cut(repr(key)), cure)


def check_actions(system: Any) -> None:
    """Events set symbols of the system, each once, and watch quantities that change along a motion."""
    for event in system.events:
        moving = [s for s in free_symbols([event.quantity]) if not isinstance(s, Parameter)]
        expected = f"the quantity of the event {event.name!r} to change along a motion"
        if not moving:
            came = f"{cut(event.quantity)}, which is constant: it crosses no threshold"
            raise expect.refusal(
                ModelError, expected, came, "Watch an expression of coordinates, speeds, reactions or time."
            )
        if not isinstance(event.then, Mapping):
            continue
        once = len({target(system, event, key) for key in event.then}) == len(event.then)
        expected, came = f"one value for each symbol in then= of the event {event.name!r}", "two, by symbol and by name"
        expect.that(once, expected, came=came, cure="Leave one out.")


@dataclass(frozen=True, slots=True, eq=False)
class Declarations(Immutable):
    """Everything that was declared, or reached from what was, parents first; `System` makes and checks it."""

    inertial: Frame
    bodies: tuple[Body, ...]
    speeds: Mapping[Speed, Expr]
    states: Mapping[StateVariable, Expr]
    loads: tuple[Load, ...]
    gravities: tuple[Gravity, ...]
    reactions: tuple[Reaction, ...]
    auxiliary_speeds: tuple[AuxiliarySpeed, ...]
    events: tuple[Event, ...]
    coordinates: Symbols[Coordinate]
    constraints: tuple[Constraint, ...]
    dependent_coordinates: tuple[Coordinate, ...]
    dependent_speeds: tuple[Speed, ...]
    joints: tuple[Joint, ...]
    euler_parameters: tuple[EulerParameters, ...]
    parameters: tuple[Parameter, ...]
    inputs: tuple[Input | Rate, ...]
    frames: tuple[Frame, ...]
    points: tuple[Point, ...]


def places(
    inertial: Frame,
    bodies: tuple[Body, ...],
    loads: tuple[Load, ...],
    symbols: Iterable[Symbol],
    constraints: tuple[Constraint, ...] = (),
) -> tuple[tuple[Frame, ...], tuple[Point, ...]]:
    """Every frame and point that a body, load or reaction needs, parents first."""
    needed: dict[Frame | Point, None] = {}
    for place in _needed(bodies, (*loads, *constraints), symbols):
        _enter(place, inertial, needed)
    points = tuple(x for x in needed if isinstance(x, Point))
    roots = sorted(p.name for p in points if p.parent is None)
    cure = "Reach one from the other."
    expect.that(len(roots) <= 1, "points reached from one fixed point", came=", ".join(roots), cure=cure)
    return tuple(x for x in needed if isinstance(x, Frame)), points


def _needed(
    bodies: Iterable[Body], acting: Iterable[Load | Constraint], symbols: Iterable[Symbol]
) -> Iterator[Frame | Point]:
    """Where bodies are, where loads, constraints and reactions act, and what their vectors are written along."""
    for part in parts_of(bodies):
        if part.frame is not None:
            yield part.frame
        yield part.mass_center
    pairs: list[tuple[Frame | Point, Vector]] = []
    for load in acting:
        pairs += [*load.forces, *load.torques]
    pairs += [(cut.at, cut.along) for cut in map(cut_of, symbols) if cut is not None]
    for place, v in pairs:
        yield place
        yield from frames_of(v)


def _enter(place: Frame | Point, inertial: Frame, needed: dict[Frame | Point, None]) -> None:
    """A frame or point after all that it is born from, as far as these are not among what is `needed` yet."""
    line: list[Any] = []
    x: Any = place
    while x is not None and x not in needed:
        line.append(x)
        x = x.parent
    root = line[-1] if x is None else None
    if isinstance(place, Frame):
        if root is not None and root is not inertial:
            raise ModelError(
                f"Expected frames that descend from {inertial.name}, got {place.name}, whose root is {root.name}. Make every "
                f"frame of this system from {inertial.name} with rotate(…)."
            )
        needed.update(dict.fromkeys(reversed(line)))
        return
    if root is not None and root.frame is not inertial:
        raise ModelError(
            f"Expected points reached from one fixed in {inertial.name}, got {place.name}, whose root {root.name} is fixed in "
            f"{root.frame.name}, the root of another system. Use a point of this one, made with at(…) or fixed_in(…)."
        )
    for p in reversed(line):
        for frame in (*frames_of(p.offset), *([p.body] if p.body is not None else [])):
            _enter(frame, inertial, needed)
        needed[p] = None


def geometry(frames: tuple[Frame, ...], points: tuple[Point, ...]) -> Iterator[Expr]:
    """The scalars that positions, then orientations are made of."""
    for p in points:
        yield from p.offset.scalars()
    for f in frames:
        yield from f.orientation.scalars() if f.orientation is not None else ()


def contents(bodies: tuple[Body, ...], loads: tuple[Load, ...], gravities: tuple[Gravity, ...]) -> Iterator[Expr]:
    """The scalars that masses, inertias and loads are made of."""
    for part in parts_of(bodies):
        yield part.mass
        for dyad in part.inertia.dyads if part.inertia is not None else ():
            yield from (x for v in dyad for x in v.scalars())
    for load in loads:
        for _, v in (*load.forces, *load.torques):
            yield from v.scalars()
        if load.potential is not None:
            yield load.potential
    for g in gravities:
        yield from g.acceleration.scalars()
