# SPDX-License-Identifier: BSD-3-Clause
"""A robot as numbers: bodies with the joints by which they move in their parents, closures, tendons and actuators.

Readers make this record, `build` makes a system from it. A body's placement is its pose in its parent at zero joint values; its joints
act in sequence, each in the frame that the preceding one has moved.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from kane.errors import Attributes
from kane.interop.imported import Remark
from kane.numeric.arrays import Array

Kind = Literal["hinge", "slide", "ball", "free", "planar"]
DOFS: Mapping[str, int] = MappingProxyType({"hinge": 1, "slide": 1, "ball": 3, "free": 6, "planar": 3})
"""The number of speeds of each kind of joint."""


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """A pose: direction cosines and a position, along the axes of the reference."""

    rotation: Array = field(default_factory=lambda: np.eye(3))
    offset: Array = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True, slots=True, eq=False)
class Move:
    """A joint: its axis and anchor along the body's axes, its value in the declared pose, and its passive properties.

    `limits` bound the joint's value, `force_limits` the total effort of its actuators; `effort` gives it an input. `coordinates` are
    the declared pose of a free joint, Euler parameters and position.
    """

    name: str
    kind: Kind
    axis: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    anchor: Array = field(default_factory=lambda: np.zeros(3))
    reference: float = 0.0
    coordinates: tuple[float, ...] = ()
    armature: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    limits: tuple[float, float] | None = None
    force_limits: tuple[float, float] | None = None
    effort: bool = False
    where: str = ""


@dataclass(frozen=True, slots=True)
class LinkShape(Attributes):
    """A shape to draw a link or for collisions: a box, sphere, cylinder, capsule, ellipsoid, plane or mesh.

    `link` names the frame and, with "<link> origin", the point of the placement. `size` is that of the source: edges of a box, radius
    and length of a cylinder or capsule, radius of a sphere, semi-axes of an ellipsoid, factors of a mesh, whose `file` is not opened.
    """

    link: str
    use: Literal["visual", "collision"]
    kind: str
    size: tuple[float, ...] = ()
    rotation: tuple[tuple[float, ...], ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    offset: tuple[float, ...] = (0.0, 0.0, 0.0)
    file: str = ""
    color: tuple[float, ...] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class RobotLink:
    """A body: in the link number `parent` (−1: the ground), moved by its joints, with mass and central inertia along its axes.

    `buoyancy` is the fraction of its weight that is compensated.
    """

    name: str
    parent: int
    placement: Placement = field(default_factory=Placement)
    moves: tuple[Move, ...] = ()
    mass: float = 0.0
    center: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))
    buoyancy: float = 0.0
    where: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Coupling:
    """The value of a joint, or length of a tendon, as a polynomial of another one: y − y₀ = Σ c_k (x − x₀)^k.

    Without a `second` one it is y = y₀ + c₀. `zeros` are y₀ and x₀.
    """

    name: str
    what: Literal["joint", "tendon"]
    first: str
    second: str
    coefficients: tuple[float, ...]
    zeros: tuple[float, float] = (0.0, 0.0)
    where: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Closure:
    """A loop closure: points of two links coincide ("connect"), or their poses ("weld")."""

    name: str
    kind: Literal["connect", "weld"]
    first: int
    second: int
    on_first: Placement
    on_second: Placement
    where: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Strand:
    """A tendon: its length, through points of links or Σ arm·joint, its limits, and a spring and damper along it.

    The spring force is zero between the two lengths `rest`.
    """

    name: str
    points: tuple[tuple[int, Array], ...]
    arms: Mapping[str, float]
    limits: tuple[float, float] = (-inf, inf)
    stiffness: float = 0.0
    damping: float = 0.0
    rest: tuple[float, float] = (0.0, 0.0)
    where: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Actuation:
    """An actuator of a joint or tendon, l = gear·value: force gain·(1, l, l̇) a + bias·(1, l, l̇) along l, within bounds.

    a is the input, or a state: ȧ = input ("integrator") or (input − a)/T ("filter").
    """

    name: str
    joint: str
    strand: str
    gear: float = 1.0
    gain: tuple[float, float, float] = (1.0, 0.0, 0.0)
    bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bounds: tuple[float, float] | None = None
    dynamics: Literal["", "integrator", "filter"] = ""
    time_constant: float = 1.0
    where: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Robot:
    """The complete record, parents before their children."""

    name: str
    links: tuple[RobotLink, ...]
    gravity: Array
    couplings: tuple[Coupling, ...] = ()
    closures: tuple[Closure, ...] = ()
    strands: tuple[Strand, ...] = ()
    drives: tuple[Actuation, ...] = ()
    shapes: tuple[LinkShape, ...] = ()
    remarks: tuple[Remark, ...] = ()
    extras: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
