# SPDX-License-Identifier: BSD-3-Clause
"""SymPy's points as points of kane: by their positions if these determine the velocities, else moved by their velocities.

The difference of a velocity from the rate of the position is the drift. Points of one tree of positions with the same drift move with
a common origin: at rest if it is zero, else with a coordinate for each component, whose rate is set by a motion constraint.

In SymPy an auxiliary speed is a term of the velocities of some points; in kane it belongs to a cut through which points are reached.
These are equivalent if the sets of points of the auxiliary speeds are nested, and each speed has one direction.
"""

import itertools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from kane.errors import ModelError, cut
from kane.expr.node import ZERO
from kane.expr.symbols import AuxiliarySpeed, Coordinate, Reaction
from kane.expr.visit import substituted
from kane.interop.driven import moved
from kane.interop.imported import FreeNames, Remarks
from kane.interop.sympy_mechanics.frames import Frames
from kane.interop.sympy_mechanics.given import Given, paths_from
from kane.interop.sympy_mechanics.names import Translation
from kane.interop.sympy_mechanics.states import States
from kane.model.constraints import auxiliary_speed, is_unit, reaction
from kane.numeric.arrays import Array
from kane.numeric.scale import EQUAL
from kane.space.frame import Point
from kane.space.vector import Vector, axes

Held = frozenset[int]


class Auxiliary:
    """The cuts, made when a point beyond them is placed; none, with a remark, if SymPy's auxiliary speeds cannot be expressed so."""

    def __init__(
        self, given: Given, frames: Frames, known: Translation, states: States, remarks: Remarks, wanted: bool
    ) -> None:
        self._given, self._frames, self._known, self._states = given, frames, known, states
        self.speeds: list[AuxiliarySpeed] = []
        self.reactions: tuple[Reaction, ...] = ()
        self._along: dict[int, Vector] = {}
        self._cuts: dict[Held, Point] = {}
        self._points: dict[Any, Held] = {}
        if not given.auxiliary:
            return
        why = self._survey() if wanted else "reactions would contain constraint forces whose points are unknown"
        names = ", ".join(str(u.func) for u in given.auxiliary)
        if why:
            self._points.clear()
            remarks.say(
                "refused", f"the auxiliary speeds {names}: {why}; unknown forces in loads are inputs or parameters"
            )
            return
        self.reactions = tuple(reaction(known.names.free(_word(x))) for x in self._unknown)
        for x, r in zip(self._unknown, self.reactions, strict=True):
            known.enter(x, r)
        brought = ", ".join(r.name for r in self.reactions)
        remarks.say("read", f"the auxiliary speeds {names}, which bring {brought} into evidence")

    def _survey(self) -> str:
        """Records which points have which auxiliary speeds, and along which directions; the reason why cuts are impossible, or ""."""
        given = self._given
        places = [p for p, _ in given.loads]
        turning = [
            *(x for x in places if not hasattr(x, "_pos_dict")),
            *(b.frame for b in given.bodies if hasattr(b, "frame")),
        ]
        if any(
            not self._frames.vector(f.ang_vel_in(given.frame), by=u).is_zero for f in turning for u in given.auxiliary
        ):
            return "angular velocities contain some"
        for p in [*(x for x in places if hasattr(x, "_pos_dict")), *(b.masscenter for b in given.bodies)]:
            held = set()
            for k, u in enumerate(given.auxiliary):
                n = self._frames.vector(p.vel(given.frame), by=u)
                if n.is_zero:
                    continue
                held.add(k)
                along = self._along.setdefault(k, n)
                if not self._same(along, n):
                    return f"{u.func} appears along several directions"
            self._points[p] = frozenset(held)
        if len(self._along) < len(given.auxiliary):
            return "no velocity contains some of them"
        if not all(is_unit(n) for n in self._along.values()):
            return "they are not along unit vectors"
        self._unknown = self._forces()
        if len(self._unknown) != len(given.auxiliary):
            return f"{len(self._unknown)} unknown forces for {len(given.auxiliary)} of them"
        return self._nested()

    def _nested(self) -> str:
        """The reason why the sets of points are not nested, or ""."""
        used: set[int] = set()
        order = sorted(set(self._points.values()), key=lambda held: (len(held), sorted(held)))
        for n, held in enumerate(order):
            fresh = held - self._below(held, order[:n])
            if fresh & used:
                return "the points whose velocities contain them do not lie on one tree of cuts"
            used |= fresh
        return ""

    @staticmethod
    def _below(held: Held, placed: Sequence[Held]) -> Held:
        return max((x for x in placed if x < held), key=len, default=frozenset())

    def _same(self, a: Vector, b: Vector) -> bool:
        return self._states.vanish((a - b).components(self._frames.inertial), [1])

    def _forces(self) -> list[Any]:
        """Candidates for unknown forces: symbols and functions x with terms ±x in loads at points with auxiliary speeds."""
        from sympy import Symbol
        from sympy.core.function import AppliedUndef

        given, found = self._given, dict[Any, None]()
        own = {*given.q, *given.u, *given.auxiliary}
        for p, force in given.loads:
            if not self._points.get(p):
                continue
            for m, _ in force.args:
                for entry in m:
                    for x in entry.atoms(AppliedUndef, Symbol):
                        if x not in own and entry.diff(x) in (1, -1):
                            found[x] = None
        masses = {s for b in given.bodies for s in b.mass.free_symbols}
        return [x for x in found if x not in masses]

    def start(self, theirs: Any, root: Callable[[], Point], free: Callable[[str], str]) -> tuple[Point, Held]:
        """The point beyond the cuts of the auxiliary speeds of a point."""
        return self._cut(self._points.get(theirs, frozenset()), root, free)

    def _cut(self, held: Held, root: Callable[[], Point], free: Callable[[str], str]) -> tuple[Point, Held]:
        if not held:
            return root(), held
        if held not in self._cuts:
            below = self._below(held, list(self._points.values()))
            place, _ = self._cut(below, root, free)
            for k in sorted(held - below):
                name = str(self._given.auxiliary[k].func)
                place = place.at(free(f"cut_{name}"), 0)
                self.speeds.append(auxiliary_speed(self._known.names.free(name), at=place, along=self._along[k]))
            self._cuts[held] = place
        return self._cuts[held], held

    def equations_left(self, accelerations: dict[Any, Any]) -> float:
        """The residual of SymPy's auxiliary equations at kane's reactions, relative to their terms."""
        method = self._given.method
        rows = [self._known.scalar(e) for e in method._aux_eq]
        self._states.values.update(accelerations)
        left = np.abs(self._states.of(rows)).max(axis=0, initial=0)
        none: dict[Any, Any] = dict.fromkeys(self.reactions, ZERO)
        size = np.abs(self._states.of([substituted(r, none) for r in rows])).max(axis=0, initial=EQUAL)
        return float((left / size).max())


def _word(x: Any) -> str:
    return str(x.func) if x.args else str(x)


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
        there, *both = (self._states.of(v.components(self._frames.inertial)) for v in (drift - carried, drift, carried))
        size = max(1e-3, np.abs(both).max())
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
