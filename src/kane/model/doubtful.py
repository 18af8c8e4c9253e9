# SPDX-License-Identifier: BSD-3-Clause
"""Models that can be computed and are surely not meant: gravity that turns with a body, contacts of another frame or side."""

import warnings
from collections.abc import Iterable, Iterator, Sequence

from kane.errors import KaneWarning
from kane.expr.evaluation import evaluate, free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate
from kane.model.bodies import Part
from kane.model.constraints import Constraint
from kane.model.loads import Gravity
from kane.numeric.sampling import SEEDS, sample, value_of
from kane.numeric.scale import DECLARED
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.rotation import Basis
from kane.space.vector import Vector, angular_velocity


def warn_of_doubts(
    inertial: Frame, parts: Sequence[Part], gravities: Iterable[Gravity], constraints: Iterable[Constraint]
) -> None:
    """Warn once of each."""
    told = [*_turning(inertial, gravities)]
    contacts = {c.forces[0][0]: c for c in constraints if c.normal is not None and c.forces}
    for p, c in contacts.items():
        told += _contact(p, c, parts)
    met = dict.fromkeys(p for c in constraints if c.kind == "motion" for p, _ in c.forces)
    told += [text for p in met for text in _carried(p, parts, inertial)]
    edges: dict[Point, list[Constraint]] = {}
    for c in constraints:
        if c.kind == "motion" and c.normal is None and c.forces:
            edges.setdefault(c.forces[0][0], []).append(c)
    for p, held in edges.items():
        told += next(filter(None, ([*_edge(p, c, parts, inertial)] for c in held)), [])
    for message in told:
        warnings.warn(message, KaneWarning, stacklevel=4)


def _turning(inertial: Frame, gravities: Iterable[Gravity]) -> Iterator[str]:
    for g in gravities:
        components = list(g.acceleration.components(inertial))
        if _depends_on_coordinates(components):
            frames = ", ".join(f.name for f, _ in g.acceleration.parts)
            yield (
                f"Expected gravity {g.name!r} along a direction that stays, got {g.acceleration}, which turns as coordinates of the "
                f"model change. Write it along {inertial.name} instead of {frames}: -g*{inertial.name}.z where that points up."
            )


def _depends_on_coordinates(exprs: Sequence[Expr]) -> bool:
    symbols = free_symbols(exprs)
    if not any(isinstance(s, Coordinate) for s in symbols):
        return False
    first, *others = (
        [
            float(x)
            for x in evaluate(exprs, {s: value_of(s, seed if isinstance(s, Coordinate) else SEEDS[0]) for s in symbols})
        ]
        for seed in SEEDS
    )
    size = max(map(abs, first))
    return any(abs(a - b) > DECLARED * size for row in others for a, b in zip(first, row, strict=True))


def _contact(p: Point, c: Constraint, parts: Sequence[Part]) -> Iterator[str]:
    """What is wrong with the place at which a body rolls."""
    assert c.normal is not None
    near = [x for x in parts if x.frame is not None and _belongs(x.mass_center, p)]
    home = p.body or _home(p)
    label = c.name.rpartition(" ")[0] or c.name
    if near and not any(x.frame is not None and home is not None and _fixed(x.frame, home) for x in near):
        yield _of_another(p, near[-1], label)
        return
    for x in near:
        heights = [sample([x.mass_center.position(p).dot(c.normal)], seed)[0] for seed in SEEDS]
        if all(h < 0 for h in heights):
            yield (
                f"Expected the contact of {x.name!r} in {label!r} on the side from which the normal {c.normal} points to it, got "
                f"{p.name} beyond its mass centre. Change the sign of the offset of {p.name}, or of the normal."
            )


def _edge(p: Point, c: Constraint, parts: Sequence[Part], inertial: Frame) -> Iterator[str]:
    """A wheel's contact that moves otherwise, along what it must not slip, than the wheel whose centre it hangs on does there.

    An edge along a direction of its own frame may be that of a frame without mass.
    """
    on = [x for x in parts if x.frame is not None and p.parent in (x.mass_center, x.mass_center.parent)]
    wheels = [x for x in on if p.parent is x.mass_center]
    for q, e in c.forces if wheels else ():
        home = q.body or _home(q)
        own = [f for f, _ in e.parts]
        if home is not None and home is not inertial and all(f is not inertial and _fixed(home, f) for f in own):
            return
        if any(_moves_with(q, x, e, inertial) for x in on):
            return
    if wheels:
        yield _of_another(p, wheels[-1], c.name)


def _carried(p: Point, parts: Sequence[Part], inertial: Frame) -> Iterator[str]:
    """A particle that is made on a point which does not move with its body: v^X + ω × r is then the velocity of none."""
    bodies = [x for x in parts if x.frame is not None and x.frame is p.body]
    if not bodies or p.parent is None or any(x.mass_center is p.parent for x in bodies):
        return
    axes = (inertial.x, inertial.y, inertial.z)
    if not any(all(_moves_with(p, x, e, inertial) for e in axes) for x in bodies):
        body, frame = bodies[-1], p.body.name if p.body is not None else ""
        center = body.mass_center.name
        yield (
            f"Expected {p.name} made on a point that moves with {body.name!r}, got {p.parent.name}, which does not: v + ω × r is "
            f"the velocity of no particle of it. Make it on one, such as {center}: {center}.fixed_in({frame}, …)."
        )


def _moves_with(p: Point, body: Part, e: Vector, inertial: Frame) -> bool:
    """Whether the velocity of the point along e is that of the body's particle there, at random states."""
    assert body.frame is not None
    center = body.mass_center
    if p.body is body.frame and p.parent is center:  # by what a particle is
        return True
    turned = body.frame.angular_velocity(inertial).cross(p.position(center))
    numbers = [p.velocity(inertial).dot(e), center.velocity(inertial).dot(e), turned.dot(e)]
    rows = [sample(numbers, seed) for seed in SEEDS]
    return all(
        abs(own - moved - round_) <= DECLARED * (abs(own) + abs(moved) + abs(round_)) for own, moved, round_ in rows
    )


def _of_another(p: Point, body: Part, label: str) -> str:
    assert body.frame is not None
    kind = f"a particle of {p.body.name}" if p.body is not None else "a geometric point"
    return (
        f"Expected the particle of {body.name!r} that touches the ground in {label!r}, got {p.name}, {kind}, which does not turn "
        f"with it. Make it by {p.parent.name if p.parent else p.name}.fixed_in({body.frame.name}, …)."
    )


def _belongs(center: Point, p: Point) -> bool:
    """Whether the point hangs on the mass centre, or the mass centre on it or on its parent."""
    return p.parent is not None and (center is p.parent or center.parent in (p, p.parent))


def _home(p: Point) -> Frame | None:
    """The frame in which the offset of a geometric point stays."""
    frames = [f for f, _ in p.offset.parts]
    stays = len(frames) == 1 and not any(isinstance(s, Coordinate) for s in free_symbols(p.offset.scalars()))
    return frames[0] if stays and isinstance(frames[0], Frame) else None


def _fixed(frame: Basis, other: Basis) -> bool:
    return frame is other or angular_velocity(frame, other).is_zero
