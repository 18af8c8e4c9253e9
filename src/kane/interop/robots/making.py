# SPDX-License-Identifier: BSD-3-Clause
"""The state of building a system from a robot's record, and functions that its builders share."""

from dataclasses import dataclass, field
from keyword import kwlist
from typing import Any, Literal

import numpy as np

from kane.errors import cut
from kane.expr.node import Expr, as_expr
from kane.expr.symbols import Coordinate, Input, Parameter, StateVariable
from kane.interop.imported import FreeNames, Remarks
from kane.interop.robots.records import Move, Robot
from kane.model.constraints import Constraint
from kane.model.contacts import ContactLaw
from kane.model.joints.joint import Joint
from kane.model.loads import Gravity, Load, action_reaction, torque_pair
from kane.numeric.arrays import Array
from kane.numeric.scale import LAST_DIGIT
from kane.space.frame import Frame, Point
from kane.space.vector import Vector

Symbolic = Literal["none", "masses", "all"]
KINDS = ("none", "masses", "all")
LONGEST = 80
"""The number of characters of a name that are kept in an identifier."""


@dataclass(frozen=True, slots=True)
class Options:
    """Options of the import."""

    parameters: Symbolic = "all"
    stops: bool = False
    damping: bool = True
    friction: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Making:
    """The system under construction."""

    robot: Robot
    options: Options
    ground: Frame
    origin: Point
    frames: list[Frame] = field(default_factory=list)
    points: list[Point] = field(default_factory=list)
    falling: list[Vector] = field(default_factory=list)
    carriers: dict[int, int] = field(default_factory=lambda: {-1: -1})
    remarks: Remarks = field(default_factory=Remarks)
    bodies: list[Any] = field(default_factory=list)
    joints: dict[str, Joint] = field(default_factory=dict)
    moves: dict[str, Move] = field(default_factory=dict)
    loads: list[Load | Gravity] = field(default_factory=list)
    efforts: dict[str, list[Expr]] = field(default_factory=dict)
    states: dict[StateVariable, Expr] = field(default_factory=dict)
    inputs: dict[str, Input] = field(default_factory=dict)
    holonomic: list[Constraint] = field(default_factory=list)
    contacts: list[ContactLaw] = field(default_factory=list)
    dependent: list[Coordinate] = field(default_factory=list)
    names: dict[str, FreeNames] = field(
        default_factory=lambda: {of: FreeNames(kwlist) for of in ("links", "joints", "symbols")}
    )
    called: dict[str, dict[str, str]] = field(default_factory=lambda: {"links": {}, "joints": {}, "inputs": {}})

    def placed(self, link: int) -> tuple[Frame, Point]:
        """The frame and origin of a link, or of the ground."""
        return (self.ground, self.origin) if link < 0 else (self.frames[link], self.points[link])

    def identifier(self, of: str, name: str, what: str, where: str = "") -> str:
        """A unique identifier among links, joints or symbols for the object `what` of this name; a remark notes a changed name."""
        result = self.names[of].identifier(name[:LONGEST], what)
        if result != name:
            self.remarks.say("inferred", f"{what} {cut(name)!r} is called {result}", where)
        return result

    def parameter(self, name: str, value: float, unit: str, what: str, kinds: tuple[str, ...] = ("all",)) -> Expr:
        """A number of the robot, as a parameter if the option `parameters` is in `kinds`; zero stays a constant."""
        if value == 0 or self.options.parameters not in kinds:
            return as_expr(float(value))
        return Parameter.declare(self.identifier("symbols", name, "parameter"), float(value), unit, what)

    def coordinate(self, joint: str) -> Coordinate:
        """The coordinate of a joint that has exactly one."""
        return self.joints[joint].coordinates[0]


def vector(frame: Frame, v: Array) -> Vector:
    """The vector with these measure numbers."""
    return frame.x * float(v[0]) + frame.y * float(v[1]) + frame.z * float(v[2])


def turned(frame: Frame, name: str, rotation: Array) -> Frame:
    """The frame rotated by direction cosines; `frame` itself for the identity."""
    if np.array_equal(rotation, np.eye(3)):
        return frame
    return frame.rotate_matrix(name, [[as_expr(float(x)) for x in row] for row in rotation])


def plain(rotation: Array) -> Array:
    """Direction cosines with exact zeros and ones."""
    r = np.where(np.abs(rotation) <= LAST_DIGIT, 0.0, rotation)
    return np.where(np.abs(np.abs(r) - 1) <= LAST_DIGIT, np.sign(r), r)


def on_joint(joint: Joint, effort: Any, name: str) -> Load:
    """A torque or force along the axis of a pin or slider, and its opposite on the parent."""
    if joint.kind == "pin":
        return torque_pair(joint.frame, joint.parent, joint.axis * effort, name)
    return action_reaction(joint.point, joint.at, joint.axis * effort, name)
