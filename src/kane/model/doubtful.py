# SPDX-License-Identifier: BSD-3-Clause
"""Models that can be computed and are surely not meant: gravity that turns with a body, contacts of another frame or side."""

import warnings
from collections.abc import Iterable, Iterator, Sequence

from kane.errors import KaneWarning
from kane.expr.evaluate import evaluate, free_symbols
from kane.expr.node import Expr
from kane.expr.symbols import Coordinate
from kane.model.bodies import Part
from kane.model.constraints import Constraint
from kane.model.loads import Gravity
from kane.numeric.sample import sample, value_of
from kane.space.frame import Frame
from kane.space.point import Point

_SEEDS = (20092, 20093, 20094, 20095)
_SLACK = 1e-9


def warn_of_doubts(
    inertial: Frame, parts: Sequence[Part], gravities: Iterable[Gravity], constraints: Iterable[Constraint]
) -> None:
    """Warn once of each."""
    told = [*_turning(inertial, gravities)]
    contacts = {c.forces[0][0]: c for c in constraints if c.normal is not None and c.forces}
    for p, c in contacts.items():
        told += _contact(p, c, parts)
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
            for x in evaluate(
                exprs, {s: value_of(s, seed if isinstance(s, Coordinate) else _SEEDS[0]) for s in symbols}
            )
        ]
        for seed in _SEEDS
    )
    size = max(map(abs, first))
    return any(abs(a - b) > _SLACK * size for row in others for a, b in zip(first, row, strict=True))


def _contact(p: Point, c: Constraint, parts: Sequence[Part]) -> Iterator[str]:
    """What is wrong with the place at which a body rolls."""
    assert c.normal is not None
    near = [x for x in parts if x.frame is not None and _belongs(x.mass_center, p)]
    home = p.body or _home(p)
    label = c.name.rpartition(" ")[0] or c.name
    if near and not any(x.frame is not None and home is not None and _fixed(x.frame, home) for x in near):
        body = near[-1]
        assert body.frame is not None
        kind = f"a particle of {p.body.name}" if p.body is not None else "a geometric point"
        yield (
            f"Expected the particle of {body.name!r} that touches the ground in {label!r}, got {p.name}, {kind}, which does not turn "
            f"with it. Make it by {p.parent.name if p.parent else p.name}.fixed_in({body.frame.name}, …)."
        )
        return
    for x in near:
        heights = [sample([x.mass_center.position(p).dot(c.normal)], seed)[0] for seed in _SEEDS]
        if all(h < 0 for h in heights):
            yield (
                f"Expected the contact of {x.name!r} in {label!r} on the side from which the normal {c.normal} points to it, got "
                f"{p.name} beyond its mass centre. Change the sign of the offset of {p.name}, or of the normal."
            )


def _belongs(center: Point, p: Point) -> bool:
    """Whether the point hangs on the mass centre, or the mass centre on it or on its parent."""
    return p.parent is not None and (center is p.parent or center.parent in (p, p.parent))


def _home(p: Point) -> Frame | None:
    """The frame in which the offset of a geometric point stays."""
    frames = [f for f, _ in p.offset.parts]
    stays = len(frames) == 1 and not any(isinstance(s, Coordinate) for s in free_symbols(p.offset.scalars()))
    return frames[0] if stays and isinstance(frames[0], Frame) else None


def _fixed(frame: Frame, other: Frame) -> bool:
    return frame is other or frame.angular_velocity(other).is_zero
