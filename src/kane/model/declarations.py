# SPDX-License-Identifier: BSD-3-Clause
"""What a system consists of, once it is declared: plain fields, which its checks read; and the events that simulations watch."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from kane.errors import ModelError, cut
from kane.expr.immutable import Immutable
from kane.expr.node import Expr
from kane.expr.symbols import (
    AuxiliarySpeed,
    Coordinate,
    Input,
    Parameter,
    Rate,
    Reaction,
    Speed,
    StateVariable,
    Symbols,
)
from kane.model.actions import as_action
from kane.model.bodies import Body
from kane.model.constraints import Constraint
from kane.model.joints.joint import Joint
from kane.model.loads import Gravity, Load
from kane.model.variables import EulerParameters
from kane.space.frame import Frame
from kane.space.point import Point


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
        check_event(self.name, self.quantity, self.threshold, self.direction, self.terminal, self.message)
        object.__setattr__(self, "threshold", float(self.threshold))
        object.__setattr__(self, "then", as_action(f"the event {cut(repr(self.name), 40)}", self.then))
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


def check_event(name: Any, quantity: Any, threshold: Any, direction: Any, terminal: Any, message: Any) -> None:
    """A ModelError names the first argument of an event that cannot be what it is to be."""
    who = f"the event {cut(repr(name), 40)}"
    wrong = [
        ("name", isinstance(name, str) and bool(name), name, "a text that is not empty"),
        ("quantity", isinstance(quantity, Expr), quantity, "a scalar expression of the system, such as q1 or v.dot(N.x)"),
        ("threshold", _is_number(threshold), threshold, "a finite number, in the unit of the quantity"),
        ("direction", not isinstance(direction, bool) and _is_number(direction) and direction in (-1, 0, 1), direction,
            "-1 (falls), 1 (rises) or 0 (either)"),
        ("terminal", terminal is None or isinstance(terminal, bool | np.bool_), terminal, "True or False"),
        ("message", isinstance(message, str), message, "a text"),
    ]  # fmt: skip
    for what, right, came, expected in wrong:
        if not right:
            raise ModelError(f"Expected {what} of {who} to be {expected}, got {cut(repr(came))}. See kn.Event.")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | np.number) and bool(np.isfinite(value))


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
