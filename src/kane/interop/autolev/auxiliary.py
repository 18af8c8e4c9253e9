# SPDX-License-Identifier: BSD-3-Clause
"""Auxiliary speeds of Autolev models, and the constraint forces that they bring into evidence (Kane & Levinson 1985, sec. 4.9)."""

from collections.abc import Callable
from dataclasses import dataclass

from kane.errors import ModelError
from kane.expr.differentiation import diff
from kane.expr.evaluation import free_symbols
from kane.expr.node import ONE, Expr
from kane.expr.symbols import AuxiliarySpeed, Input, Reaction, Speed
from kane.interop.autolev.model import LastForm, agree, replacing
from kane.interop.autolev.sheet import Sheet
from kane.interop.autolev.space import Space
from kane.interop.autolev.values import Vec
from kane.model.constraints import auxiliary_speed, reaction
from kane.space.vector import Vector


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Auxiliary speeds, unknown forces, and the replacement of the file's names of these forces by reactions."""

    speeds: tuple[AuxiliarySpeed, ...] = ()
    reactions: tuple[Reaction, ...] = ()
    change: Callable[[Expr], Expr] | None = None

    def load(self, v: Vector) -> Vector:
        """A load in which reactions replace the names of unknown forces."""
        return v.map(self.change) if self.change else v


def evidence(sheet: Sheet, names: LastForm, space: Space) -> Evidence:
    """Auxiliary speeds and reactions; ModelError unless there are as many unknown forces as auxiliary speeds."""
    if not sheet.auxiliary:
        return Evidence()
    unknown = _unknown(sheet, names)
    if len(unknown) != len(sheet.auxiliary):
        raise ModelError(
            f"Expected as many unknown forces in loads as auxiliary speeds, {len(sheet.auxiliary)}, got "
            f"{', '.join(s.name for s in unknown) or 'none'}. Name them in Kane(…)."
        )
    reactions = {s: reaction(s.name) for s in unknown}
    speeds = tuple(_cut(u, sheet, names, space) for u in sheet.auxiliary)
    return Evidence(speeds, tuple(reactions.values()), replacing(reactions))


def _unknown(sheet: Sheet, names: LastForm) -> list[Input]:
    """Variables without a value in loads: those named in Kane(…), or all if none is named there."""
    loads = [x for _, v, _ in (*sheet.forces, *sheet.torques) for x in names.vector(v).parts.values()]
    free = [s for s in free_symbols(loads) if isinstance(s, Input) and s.name.lower() not in sheet.given]
    told = [s for s in free if s.name.lower() in sheet.unknown]
    return told or free


def _cut(u: Speed, sheet: Sheet, names: LastForm, space: Space) -> AuxiliarySpeed:
    """An auxiliary speed, at the point or frame nearest to the inertial frame whose velocity contains it."""
    n = sheet.inertial
    for name in filter(space.turning.__contains__, space.frames):  # in the order from the inertial one outwards
        part = _partial(u, sheet.spin(name, n), names)
        if part.parts:
            return auxiliary_speed(u.name, frame=space.turning[name], along=_unit(u, part, space))
    partials = {p: _partial(u, v, names) for (p, f), v in sheet.velocities.items() if f == n and p in space.points}
    moved = [p for p, v in partials.items() if v.parts]
    if not moved:
        raise ModelError(f"Expected velocities that hold the auxiliary speed {u.name}, got none that the model needs.")
    first = min(moved, key=lambda p: len(space.points[p].ancestry()))
    _check(u, first, partials, space)
    return auxiliary_speed(u.name, at=space.points[first], along=_unit(u, partials[first], space))


def _partial(u: Speed, v: Vec, names: LastForm) -> Vec:
    return v.map(lambda x: names.final(diff(names.with_auxiliary(x), u)))


def _unit(u: Speed, v: Vec, space: Space) -> Vector:
    direction = space.vector(v)
    if not agree([direction.dot(direction)], [ONE], space.groups):
        raise ModelError(
            f"Expected a unit vector as the partial velocity for the auxiliary speed {u.name}, got {direction}."
        )
    return direction


def _check(u: Speed, first: str, partials: dict[str, Vec], space: Space) -> None:
    """Raises unless exactly the points placed from `first` have this partial velocity."""
    root = space.points[first]
    for p, v in partials.items():
        expected = partials[first] if root in space.points[p].ancestry() else Vec()
        mine, told = space.vector(expected), space.vector(v)
        if not agree(mine.components(space.root), told.components(space.root), space.groups):
            raise ModelError(
                f"Expected the auxiliary speed {u.name} in the velocities of {first} and of all points that are placed from it, got "
                f"another one in that of {p}. Place {p} from {first}, or from another point."
            )
