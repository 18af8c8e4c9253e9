# SPDX-License-Identifier: BSD-3-Clause
"""The records of a scene, which refer by index to positions, axes, directions and lengths evaluated at a state by one routine."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from kane.expr.evaluation import Walk
from kane.expr.node import ZERO, Expr
from kane.expr.ops import Immutable
from kane.expr.symbols import Symbol
from kane.model.system import System
from kane.numeric.arrays import Array
from kane.space.frame import Frame, Point
from kane.space.rotation import Triple
from kane.space.vector import Vector
from kane.write.arrange import to_text


@dataclass(frozen=True, slots=True)
class Item(Immutable):
    """An object with a shape.

    `sizes` are indices of scalars by name, `at` that of the position of its centre, `frame` that of its axes (for a body of
    revolution the third is its axis), `points` those of points that it connects. `role` is "body", "ground", "load" or "constraint".
    """

    kind: str
    name: str
    role: str
    at: int | None = None
    frame: int | None = None
    points: tuple[int, ...] = ()
    sizes: Mapping[str, int] = field(default_factory=dict)
    direction: int | None = None
    file: str = ""


@dataclass(frozen=True, slots=True)
class Movement(Immutable):
    """The effect of coordinates.

    A "turn" is about the direction `axis` through the first of `points`, by the scalar `sweep`, and ends along `direction`; a
    "shift" leads along `points`; an "attitude" is that of axes at a point, a "deflection" that of a beam at its points from the
    undeformed position. "none" has no visible effect.
    """

    kind: str
    symbols: tuple[str, ...]
    points: tuple[int, ...] = ()
    axis: int | None = None
    direction: int | None = None
    sweep: int | None = None
    frame: str = ""


@dataclass(frozen=True, slots=True)
class Action(Immutable):
    """A force or torque along a direction, at a point, with its `label` in the drawing.

    "gravity" is the acceleration; the force of a "contact" is known only along a motion, so that drawings of a state omit it.
    """

    kind: str
    name: str
    label: str
    at: int
    direction: int


@dataclass(frozen=True, slots=True)
class Mark(Immutable):
    """A named point; `fixed` in the inertial frame."""

    name: str
    at: int
    fixed: bool = False


@dataclass(frozen=True, slots=True)
class Triad(Immutable):
    """Axes of a frame, shown at a point."""

    name: str
    frame: int
    at: int
    inertial: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Posed:
    """Values at one state or many (leading axes): positions (… × n × 3), rotations (… × n × 3 × 3), directions, scalars.

    The columns of a rotation are the unit vectors of the axes, along those of the inertial frame.
    """

    positions: Array
    rotations: Array
    directions: Array
    scalars: Array


@dataclass(frozen=True, slots=True, eq=False)
class Scene(Immutable):
    """The geometry of a system as data for drawings, from `kn.figures.scene`."""

    system: System
    items: tuple[Item, ...]
    movements: tuple[Movement, ...]
    actions: tuple[Action, ...]
    marks: tuple[Mark, ...]
    triads: tuple[Triad, ...]
    lengths: tuple[tuple[str, int, int], ...]
    positions: tuple[Triple, ...]
    rotations: tuple[tuple[Triple, Triple, Triple], ...]
    directions: tuple[Triple, ...]
    scalars: tuple[Expr, ...]
    _walk: Walk = field(repr=False)

    def __repr__(self) -> str:
        return f"Scene({', '.join(body.name for body in self.system.bodies)}; {len(self.items)} items)"

    @property
    def symbols(self) -> tuple[Symbol, ...]:
        """The symbols on which poses depend: coordinates, parameters, inputs, time; rates and reactions if forces contain them."""
        return self._walk.symbols

    @property
    def drawable(self) -> bool:
        """Whether the system has points to draw."""
        return bool(self.positions)

    @property
    def row(self) -> list[Expr]:
        """The expressions of a pose in one list: positions, axes of frames, directions, scalars."""
        return row_of(self.positions, self.rotations, self.directions, self.scalars)

    @property
    def seen(self) -> list[int]:
        """Indices of the positions of all items except planes, which have no size of their own."""
        items = [item for item in self.items if item.kind != "plane"]
        return sorted({k for item in items for k in (item.at, *item.points) if k is not None})

    def poses(self, values: Mapping[Any, Any]) -> Posed:
        """Poses for given values of `symbols`, by symbol: numbers, or arrays of the same length for several states.

        Raises
        ------
        ValueMissingError
            if a symbol has no value
        """
        self._walk.check(values)
        found = [np.asarray(x, dtype=float) for x in self._walk(values)]
        table = np.stack(np.broadcast_arrays(*found), axis=-1) if found else np.zeros(0)
        shape, (n, m, k) = table.shape[:-1], map(len, (self.positions, self.rotations, self.directions))
        p, r, d, s = np.split(table, np.cumsum((3 * n, 9 * m, 3 * k)), axis=-1)
        turned = r.reshape(*shape, m, 3, 3).swapaxes(-1, -2)
        return Posed(p.reshape(*shape, n, 3), turned, d.reshape(*shape, k, 3), s)

    def to_dict(self) -> dict[str, Any]:
        """The scene as plain data for JSON: its records, with expressions as text."""
        return {
            **{name: [asdict(x) for x in getattr(self, name)] for name in _RECORDS},
            "lengths": [list(x) for x in self.lengths],
            "positions": [[to_text(x) for x in v] for v in self.positions],
            "rotations": [[[to_text(x) for x in v] for v in axes] for axes in self.rotations],
            "directions": [[to_text(x) for x in v] for v in self.directions],
            "scalars": [to_text(x) for x in self.scalars],
            "symbols": [s.name for s in self.symbols],
        }


_RECORDS = ("items", "movements", "actions", "marks", "triads")


def against_gravity(scene: Scene, directions: Array, otherwise: Array) -> Array:
    """The direction opposite to gravity in a pose, or `otherwise` without gravity."""
    for a in scene.actions:
        g = directions[a.direction]
        if a.kind == "gravity" and (size := np.linalg.norm(g)) > 0:
            return np.asarray(-g / size)
    return otherwise


class Quantities:
    """Tables of positions, axes, directions and scalars, in which each quantity is entered once."""

    def __init__(self, inertial: Frame) -> None:
        self.inertial = inertial
        self.positions: dict[Triple, int] = {}
        self.rotations: dict[tuple[Triple, Triple, Triple], int] = {}
        self.directions: dict[Triple, int] = {}
        self.scalars: dict[Expr, int] = {}
        self._places: dict[Point, Vector] = {}

    def place(self, point: Point) -> Vector:
        """The vector from the fixed point to this one."""
        if point not in self._places:
            self._places[point] = Vector() if point.parent is None else self.place(point.parent) + point.offset
        return self._places[point]

    def position(self, point: Point, more: Vector | None = None) -> int:
        """The index of a point's position, or of one at the vector `more` from it."""
        return self.at(self.place(point) + (more or Vector()))

    def at(self, place: Vector) -> int:
        """The index of a position."""
        return _number(self.positions, place.components(self.inertial))

    def axes(self, x: Vector, y: Vector, z: Vector) -> int:
        """The index of three axes."""
        a, b, c = (v.components(self.inertial) for v in (x, y, z))
        return _number(self.rotations, (a, b, c))

    def frame(self, frame: Frame) -> int:
        """The index of a frame's axes."""
        return self.axes(frame.x, frame.y, frame.z)

    def direction(self, v: Vector) -> int:
        """The index of a direction, a vector of any length."""
        return _number(self.directions, v.components(self.inertial))

    def scalar(self, e: Expr) -> int:
        """The index of a scalar."""
        return _number(self.scalars, e)

    def tables(self) -> tuple[Any, ...]:
        """All tables, in order, and the routine that evaluates them."""
        tables = (tuple(self.positions), tuple(self.rotations), tuple(self.directions), tuple(self.scalars))
        return (*tables, Walk(row_of(*tables) or [ZERO]))


def row_of(
    positions: Sequence[Triple],
    rotations: Sequence[tuple[Triple, Triple, Triple]],
    directions: Sequence[Triple],
    scalars: Sequence[Expr],
) -> list[Expr]:
    """All expressions in one row: positions, the axes of frames, directions, scalars."""
    vectors = [*positions, *(v for axes in rotations for v in axes), *directions]
    return [*(x for v in vectors for x in v), *scalars]


def _number(table: dict[Any, int], entry: Any) -> int:
    return table.setdefault(entry, len(table))


def distinct(points: Iterable[int]) -> tuple[int, ...]:
    """Indices in order, each once."""
    return tuple(dict.fromkeys(points))
