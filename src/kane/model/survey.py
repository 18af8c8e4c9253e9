# SPDX-License-Identifier: BSD-3-Clause
"""What a system is made of: every frame, point and scalar that its declarations reach, parents first."""

from collections.abc import Iterable, Iterator

from kane.errors import ModelError
from kane.expr.node import Expr
from kane.expr.symbols import Symbol
from kane.model.bodies import Body, parts_of
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
    needed: dict[Frame | Point, None] = {}
    for place in _needed(bodies, (*loads, *constraints), symbols):
        _enter(place, inertial, needed)
    points = tuple(x for x in needed if isinstance(x, Point))
    roots = [p.name for p in points if p.parent is None]
    if len(roots) > 1:
        raise ModelError(
            f"Expected points reached from one fixed point, got {', '.join(sorted(roots))}. Reach one from the other."
        )
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
    if isinstance(place, Point):
        line: list[Point] = []
        p: Point | None = place
        while p is not None and p not in needed:
            line.append(p)
            p = p.parent
        if p is None and line[-1].frame is not inertial:
            raise ModelError(
                f"Expected points reached from one fixed in {inertial.name}, got {place.name}, whose root {line[-1].name} is fixed in "
                f"{line[-1].frame.name}, the root of another system. Use a point of this one, made with at(…) or fixed_in(…)."
            )
        for p in reversed(line):
            for frame in (*frames_of(p.offset), *([p.body] if p.body is not None else [])):
                _enter(frame, inertial, needed)
            needed[p] = None
        return
    bases: list[Frame] = []
    f: Frame | None = place
    while f is not None and f not in needed:
        bases.append(f)
        f = f.parent
    if f is None and bases[-1] is not inertial:
        raise ModelError(
            f"Expected frames that descend from {inertial.name}, got {place.name}, whose root is {bases[-1].name}. Make every "
            f"frame of this system from {inertial.name} with rotate(…)."
        )
    needed.update(dict.fromkeys(reversed(bases)))


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
