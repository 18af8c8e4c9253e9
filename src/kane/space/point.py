# SPDX-License-Identifier: BSD-3-Clause
"""Points: geometric points, and particles of a frame."""

from __future__ import annotations

from collections.abc import Callable, Container
from typing import Any, NoReturn

from kane import expect
from kane.errors import SpaceError
from kane.expr.ops import Immutable, landmarks
from kane.space.frame import Frame
from kane.space.vector import Vector, check_connected


class Point(Immutable):
    """A point. `Point("O", fixed_in=N)` is fixed in a root frame; every other one is born from a point.

    `O.at("P", r)` is a geometric point at r from O. `X.fixed_in(B, "Q", r)` is the particle of B that is at X + r now.
    """

    __slots__ = ("__weakref__", "_known", "body", "frame", "name", "offset", "parent")

    name: str
    parent: Point | None
    offset: Vector
    frame: Frame
    body: Frame | None
    _known: dict[str, Vector]

    def __init__(self, name: str, fixed_in: Frame) -> None:
        expect.instance(fixed_in, Frame, f"Point({name!r}, fixed_in=frame)", error=SpaceError)
        if fixed_in.parent is not None:
            raise SpaceError(
                f"Expected a root frame to fix the point {name} in, got {fixed_in.name}, which is born in "
                f"{fixed_in.parent.name}. Fix a point in {fixed_in.root().name} and reach others from it with at(...)."
            )
        self._finish(name, None, Vector(), fixed_in, None)

    def _finish(self, name: str, parent: Point | None, offset: Vector, frame: Frame, body: Frame | None) -> None:
        expect.name(name, "a name for the point", error=SpaceError)
        known: dict[str, Vector] = {}
        own = {"name": name, "parent": parent, "offset": offset, "frame": frame, "body": body, "_known": known}
        for slot, value in own.items():
            object.__setattr__(self, slot, value)

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"The point {self.name} is fixed: {name!r} cannot be set.")

    def __repr__(self) -> str:
        if self.parent is None:
            return f"Point({self.name!r}, fixed in {self.frame.name})"
        kind = f"particle of {self.body.name}, " if self.body is not None else ""
        return f"Point({self.name!r}, {kind}from {self.parent.name} by {self.offset})"

    def __reduce__(self) -> tuple[Callable[..., Point], tuple[Any, ...]]:
        if self.parent is None:
            return Point, (self.name, self.frame)
        return _restored, (landmarks(self), self.parent, self.name, self.offset, self.body)

    def _child(self, name: str, offset: object, body: Frame | None) -> Point:
        if self.body is not None:
            raise SpaceError(
                f"Expected a geometric point to build {name} on, got {self.name}, a particle of {self.body.name}: its velocity is not "
                f"the derivative of its position. Build {name} on {self.parent.name if self.parent else 'its parent'}."
            )
        if isinstance(offset, int) and offset == 0:
            offset = Vector()
        what = f"a Vector (or 0) as the position of {name} from {self.name}"
        r = expect.instance(offset, Vector, what, "Give it a direction: x*N.x.", error=SpaceError)
        for frame, _ in r.parts:
            check_connected(self.frame, frame)
        child: Point = object.__new__(Point)
        child._finish(name, self, r, self.frame, body)
        return child

    def at(self, name: str, offset: Vector | int) -> Point:
        """The geometric point at `offset` from this one."""
        return self._child(name, offset, None)

    def fixed_in(self, frame: Frame, name: str, offset: Vector | int = 0) -> Point:
        """The particle of `frame` that is at this point + `offset` now.

        Its velocity is v + ω × r and its acceleration a + α × r + ω × (ω × r), with v and a those of this point, which must
        move with `frame`. Where r is not constant in `frame` another particle is met at every instant: then the acceleration
        is not the derivative of the velocity. A particle is a leaf: no point can be built on it.
        """
        expect.instance(frame, Frame, "a frame in fixed_in(frame, name, offset)", error=SpaceError)
        check_connected(self.frame, frame)
        return self._child(name, offset, frame)

    def root(self) -> Point:
        """The fixed point that this one is reached from."""
        return self.ancestry()[-1]

    def ancestry(self, known: Container[Point] = ()) -> list[Point]:
        """The point, its parent, … up to the root, or short of the first that is `known`."""
        line: list[Point] = []
        p: Point | None = self
        while p is not None and p not in known:
            line.append(p)
            p = p.parent
        return line

    def position(self, origin: Point) -> Vector:
        """Position vector from `origin` to this point."""
        expect.instance(origin, Point, f"the point from which {self.name} is seen", error=SpaceError)
        mine, theirs = self.ancestry(), origin.ancestry()
        if mine[-1] is not theirs[-1]:
            raise SpaceError(
                f"Expected points of one tree, got {self.name} and {origin.name}, which have no common root."
            )
        while mine and theirs and mine[-1] is theirs[-1]:
            mine.pop()
            theirs.pop()
        total = Vector()
        for p in reversed(mine):
            total = total + p.offset
        for p in theirs:
            total = total - p.offset
        return total

    def velocity(self, frame: Frame, origin: Point | None = None) -> Vector:
        """Velocity in `frame`, in rates.

        In another frame A than the one the root point is fixed in it needs `origin`, a point Q fixed in A: v − v^Q − ω^A × r, r from
        Q to this point (Kane & Levinson 1985, sec. 2.6, 2.8).
        """
        if origin is None:
            return self._recall("velocity", frame)
        if self._are_geometric(frame, origin):
            return self.position(origin).dt(frame)
        root = self.root().frame
        carried = frame.angular_velocity(root).cross(self.position(origin))
        return self.velocity(root) - origin.velocity(root) - carried

    def acceleration(self, frame: Frame, origin: Point | None = None) -> Vector:
        """Acceleration in `frame`, in rates and their derivatives.

        In another frame A it needs `origin`, a point Q fixed in A: a − a^Q − α^A × r − ω^A × (ω^A × r) − 2 ω^A × v, with v and r
        from Q in A.
        """
        if origin is None:
            return self._recall("acceleration", frame)
        if self._are_geometric(frame, origin):
            return self.position(origin).dt(frame).dt(frame)
        root, r = self.root().frame, self.position(origin)
        spin = frame.angular_velocity(root)
        carried = frame.angular_acceleration(root).cross(r) + spin.cross(spin.cross(r))
        coriolis = spin.cross(self.velocity(frame, origin)) * 2
        return self.acceleration(root) - origin.acceleration(root) - carried - coriolis

    def _are_geometric(self, frame: Frame, origin: Point) -> bool:
        """Whether neither this point nor the origin is a particle, whose velocity is not the derivative of its position."""
        expect.instance(frame, Frame, f"a frame in which {self.name} moves", error=SpaceError)
        expect.instance(origin, Point, f"a point fixed in {frame.name} as origin", error=SpaceError)
        check_connected(self.frame, frame)
        return self.body is None and origin.body is None

    def _recall(self, what: str, frame: Frame) -> Vector:
        expect.instance(frame, Frame, f"a frame in which to take the {what} of {self.name}", error=SpaceError)
        line = self.ancestry()
        root = line[-1]
        if frame is not root.frame:
            raise SpaceError(
                f"Expected the {what} of {self.name} in {root.frame.name}, where its root {root.name} is fixed, got frame "
                f"{frame.name}. In another frame it needs a point Q fixed there: {self.name}.{what}({frame.name}, Q)."
            )
        for p in reversed([p for p in line if what not in p._known]):
            start = p.parent._known[what] if p.parent is not None else Vector()
            p._known[what] = start + (p._velocity(frame) if what == "velocity" else p._acceleration(frame))
        return self._known[what]

    def _velocity(self, frame: Frame) -> Vector:
        """What the velocity is more than the parent's."""
        if self.body is not None:
            return self.body.angular_velocity(frame).cross(self.offset)
        return self.offset.dt(frame)

    def _acceleration(self, frame: Frame) -> Vector:
        """What the acceleration is more than the parent's."""
        if self.body is not None:
            spin, r = self.body.angular_velocity(frame), self.offset
            return self.body.angular_acceleration(frame).cross(r) + spin.cross(spin.cross(r))
        return self.offset.dt(frame).dt(frame)


def _restored(first: object, parent: Point, name: str, offset: Vector, body: Frame | None) -> Point:
    """A point that was pickled, after the points `first` of its line."""
    return parent.at(name, offset) if body is None else parent.fixed_in(body, name, offset)
