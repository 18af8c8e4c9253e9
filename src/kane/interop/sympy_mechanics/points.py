# SPDX-License-Identifier: BSD-3-Clause
"""SymPy's points as points of kane: by their positions if these determine the velocities, else moved by their velocities.

The difference of a velocity from the rate of the position is the drift. Points of one tree of positions with the same drift move with
a common origin: at rest if it is zero, else with a coordinate for each component, whose rate is set by a motion constraint.
"""

import itertools
from typing import Any

import numpy as np

from kane.errors import ModelError, cut
from kane.expr.node import ZERO
from kane.expr.symbols import Coordinate
from kane.interop.driven import moved
from kane.interop.imported import Remarks
from kane.interop.names import FreeNames
from kane.interop.sympy_mechanics.auxiliary import Auxiliary, Held
from kane.interop.sympy_mechanics.frames import Frames
from kane.interop.sympy_mechanics.given import paths_from
from kane.interop.sympy_mechanics.names import Translation
from kane.interop.sympy_mechanics.states import States
from kane.numeric.arrays import Array
from kane.numeric.scale import EQUAL
from kane.space.frame import Point
from kane.space.vector import Vector, axes

_XYZ = "xyz"


class Points:
    """Points of kane for those of SymPy, made on first use."""

    def __init__(
        self, inertial: Any, frames: Frames, auxiliary: Auxiliary, known: Translation, states: States, remarks: Remarks
    ) -> None:
        self._theirs, self._frames, self._known, self._states, self._remarks = inertial, frames, known, states, remarks
        self._names, self._auxiliary = FreeNames(), auxiliary
        self._root: Point | None = None
        self._references: dict[Any, Any] = {}
        self._lines: dict[Any, list[Any]] = {}
        self._origins: list[tuple[tuple[Any, Held], Array, dict[Any, Point]]] = []
        self._made: dict[Any, Point] = {}

    def point(self, theirs: Any) -> Point:
        """The point of kane for one of SymPy."""
        if theirs not in self._made:
            self._made[theirs] = self._placed(theirs)
        return self._made[theirs]

    def _placed(self, theirs: Any) -> Point:
        if theirs not in self._references:
            self._survey(theirs)
        reference, line = self._references[theirs], self._lines[theirs]
        offsets = [self._frames.vector(b._pos_dict[a]) for a, b in itertools.pairwise(line)]
        drift = self._velocity(theirs)
        position = sum(offsets, Vector())
        carried = position.dt(self._frames.inertial)
        there = self._states.of((drift - carried).components(self._frames.inertial))
        size = max(
            1e-3,
            np.abs(
                self._states.of([*drift.components(self._frames.inertial), *carried.components(self._frames.inertial)])
            ).max(),
        )
        if not np.isfinite(there).all():
            raise ModelError(f"Expected a finite velocity of {theirs} at random states, got {cut(drift)}.")
        there = np.where(np.abs(there) <= EQUAL * size, 0.0, there)
        made = self._origin(reference, there, drift - carried, size, theirs)
        for a, b, offset in zip(line, line[1:], offsets, strict=False):
            if b not in made:
                made[b] = made[a].at(self._names.free(b.name), offset)
        return made[theirs]

    def _velocity(self, theirs: Any) -> Vector:
        try:
            v = theirs.vel(self._theirs)
        except ValueError as error:
            raise ModelError(
                f"Expected the velocity of {theirs} in {self._theirs} to be known, got: {cut(error, 200)}"
            ) from error
        return self._frames.vector(v)

    def _survey(self, theirs: Any) -> None:
        """Finds all points that positions connect, and the path to each from the one at rest, if any."""
        still = [p for p in paths_from(theirs) if self._theirs in p._vel_dict and p._vel_dict[self._theirs] == 0]
        reference = next(iter(still), theirs)
        ways = paths_from(reference)
        for p in ways:
            way = [p]
            while ways[way[-1]] is not None:
                way.append(ways[way[-1]])
            self._references[p], self._lines[p] = reference, way[::-1]

    def _origin(self, reference: Any, there: Array, drift: Vector, size: float, theirs: Any) -> dict[Any, Point]:
        """The points placed from a common origin, the point `reference` if it moved with this drift; made on first use."""
        start, held = self._auxiliary.start(theirs, self._base, self._names.free)
        for other, drifts, made in self._origins:
            if other == (reference, held) and np.allclose(drifts, there, rtol=0, atol=EQUAL * size * 10):
                return made
        moving = [k for k in range(3) if np.any(there[k])]
        place = (
            self._drifting(start, drift, moving, theirs) if moving else start.at(self._names.free(reference.name), 0)
        )
        made = {reference: place}
        self._origins.append(((reference, held), there, made))
        return made

    def _base(self) -> Point:
        """The point from which all others are placed."""
        if self._root is None:
            self._root = Point(self._names.free("fixed"), fixed_in=self._frames.inertial)
        return self._root

    def _drifting(self, root: Point, drift: Vector, moving: list[int], theirs: Any) -> Point:
        inertial, name, free = self._frames.inertial, theirs.name, self._known.names.free
        velocity = [drift.dot(axis) if k in moving else ZERO for k, axis in enumerate(axes(inertial))]
        point, driven = moved(
            root, self._names.free(f"{name}_moving"), inertial, velocity,
            lambda x: Coordinate.declare(free(f"{x}_{name}"), None, "", f"position of {name} by its velocity"),
        )  # fmt: skip
        for q, (_, speed) in zip(driven.coordinates, driven.rates, strict=True):
            self._states.enter(q, speed)
        self._frames.further.append(driven)
        along = ", ".join(f"{inertial.name}.{_XYZ[k]}" for k in moving)
        v = cut(theirs.vel(self._theirs), 80)
        if len(self._lines[theirs]) == 1:
            self._remarks.say(
                "inferred", f"the position of {theirs} along {along} from its velocity {v}, as none is given"
            )
        else:
            said = f"{theirs} moves with its velocity {v}, which is not the rate of its position from {self._references[theirs]}"
            self._remarks.say("changed", f"{said}: it gets additional coordinates along {along}")
        return point
