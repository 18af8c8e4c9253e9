# SPDX-License-Identifier: BSD-3-Clause
"""What a system consists of, once it is declared: plain fields, which its checks read; and the events that simulations watch."""

from collections.abc import Mapping
from dataclasses import dataclass

from kane.expr.immutable import Immutable
from kane.expr.node import Expr
from kane.expr.symbols import AuxiliarySpeed, Coordinate, Input, Parameter, Rate, Reaction, Speed
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

    A terminal event ends the simulation there; the solution returns what there is and names it.
    """

    name: str
    quantity: Expr
    threshold: float = 0.0
    direction: int = 0
    terminal: bool = True
    message: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Declarations(Immutable):
    """Everything that was declared, or reached from what was, parents first; `System` makes and checks it."""

    inertial: Frame
    bodies: tuple[Body, ...]
    speeds: Mapping[Speed, Expr]
    loads: tuple[Load, ...]
    gravities: tuple[Gravity, ...]
    reactions: tuple[Reaction, ...]
    auxiliary_speeds: tuple[AuxiliarySpeed, ...]
    events: tuple[Event, ...]
    coordinates: tuple[Coordinate, ...]
    constraints: tuple[Constraint, ...]
    dependent_coordinates: tuple[Coordinate, ...]
    dependent_speeds: tuple[Speed, ...]
    joints: tuple[Joint, ...]
    euler_parameters: tuple[EulerParameters, ...]
    parameters: tuple[Parameter, ...]
    inputs: tuple[Input | Rate, ...]
    frames: tuple[Frame, ...]
    points: tuple[Point, ...]
