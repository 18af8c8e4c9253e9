# SPDX-License-Identifier: BSD-3-Clause
"""What a system is made of: every frame, point and scalar that its declarations reach, parents first."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from kane.errors import ModelError
from kane.expr.node import Expr
from kane.expr.symbols import Symbol
from kane.model.bodies import Body, RigidBody
from kane.model.constraints import Constraint
from kane.model.loads import Gravity, Load
from kane.model.reactions import cut_of
from kane.space.frame import Frame, frames_of
from kane.space.point import Point
from kane.space.vector import Vector


def places(
    inertial: Frame,
    bodies: tuple[Body, ...],
    loads: tuple[Load, ...],
    symbols: Iterable[Symbol],
    constraints: tuple[Constraint, ...] = (),
) -> tuple[tuple[Frame, ...], tuple[Point, ...]]:
    """Every frame and point that a body, load or reaction needs, parents first."""
    frames: dict[Frame, None] = {}
    points: dict[Point, None] = {}

    def meet_frame(frame: Frame) -> None:
        line: list[Frame] = []
        at: Frame | None = frame
        while at is not None:
            line.append(at)
            at = at.parent
        if line[-1] is not inertial:
            raise ModelError(
                f"Expected frames that descend from {inertial.name}, got {frame.name}, whose root is {line[-1].name}. Make every "
                f"frame of this system from {inertial.name} with rotate(…)."
            )
        frames.update(dict.fromkeys(reversed(line)))

    def meet_point(point: Point) -> None:
        line = point.ancestry()
        if line[-1].frame is not inertial:
            raise ModelError(
                f"Expected points reached from one fixed in {inertial.name}, got {point.name}, whose root {line[-1].name} is fixed in "
                f"{line[-1].frame.name}, the root of another system. Use a point of this one, made with at(…) or fixed_in(…)."
            )
        for p in reversed(line):
            for frame in frames_of(p.offset):
                meet_frame(frame)
            if p.body is not None:
                meet_frame(p.body)
            points[p] = None

    def meet_parts(v: Vector) -> None:
        for f in frames_of(v):
            meet_frame(f)

    for b in bodies:
        if isinstance(b, RigidBody):
            meet_frame(b.frame)
        meet_point(b.mass_center)
    acting: tuple[Load | Constraint, ...] = (*loads, *constraints)
    for load in acting:
        for point, v in load.forces:
            meet_point(point)
            meet_parts(v)
        for frame, v in load.torques:
            meet_frame(frame)
            meet_parts(v)
    for s in symbols:
        cut = cut_of(s)
        if cut is not None:
            place = cut.at
            if isinstance(place, Frame):
                meet_frame(place)
            else:
                meet_point(place)
            meet_parts(cut.along)
    if len({p.root() for p in points}) > 1:
        roots = sorted({p.root().name for p in points})
        raise ModelError(
            f"Expected points reached from one fixed point, got {', '.join(roots)}. Reach one from the other."
        )
    return tuple(frames), tuple(points)


def geometry(frames: tuple[Frame, ...], points: tuple[Point, ...]) -> Iterator[Expr]:
    """The scalars that positions, then orientations are made of."""
    for p in points:
        yield from p.offset.scalars()
    for f in frames:
        o = f.orientation
        if o is None:
            continue
        yield from o.parameters
        if o.angle is not None:
            yield from (o.angle, *(o.direction or ()))
        elif o.cosines is not None:
            yield from (x for row in o.cosines for x in row)


def contents(bodies: tuple[Body, ...], loads: tuple[Load, ...], gravities: tuple[Gravity, ...]) -> Iterator[Expr]:
    """The scalars that masses, inertias and loads are made of."""
    for b in bodies:
        yield b.mass
        if isinstance(b, RigidBody):
            for left, right in b.inertia.dyads:
                yield from left.scalars()
                yield from right.scalars()
    for load in loads:
        for _, v in (*load.forces, *load.torques):
            yield from v.scalars()
        if load.potential is not None:
            yield load.potential
    for g in gravities:
        yield from g.acceleration.scalars()
