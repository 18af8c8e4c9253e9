# SPDX-License-Identifier: BSD-3-Clause
"""A System in a notebook: what was declared, as tables."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from kane.expr.node import Expr
from kane.model.bodies import Part
from kane.model.constraints import Constraint
from kane.model.declarations import Event
from kane.model.loads import Load
from kane.model.system import System
from kane.present.notebook.typeset import (
    dyadic,
    either,
    escaped,
    expression,
    folded,
    listed,
    math,
    paragraph,
    table,
    vector,
)
from kane.present.tables import DECLARED, Row
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.vector import Vector
from kane.units.rules import unit_text
from kane.write.latex import place_latex

_PLACES = 4
"""Forces and torques of one load that are listed."""

_COLUMNS: dict[str, Sequence[str]] = {
    "bodies": ("body", "mass", "mass centre", "frame", "central inertia"),
    "coordinates": ("coordinate", "unit", "meaning"),
    "speeds": ("speed", "definition", "unit", "meaning"),
    "states": ("state", "rate", "default", "unit", "meaning"),
    "loads": ("load", "acts"),
    "constraints": ("constraint", "kind", "vanishes", "held by"),
    "reactions": ("reaction", "at", "along", "unit", "meaning"),
    "auxiliary speeds": ("auxiliary speed", "at", "along", "unit", "meaning"),
    "inputs": ("input", "unit", "meaning"),
    "events": ("event", "where", "", "message"),
    "parameters": ("parameter", "default", "unit", "meaning"),
}
"""What is shown of each group; the parameters are folded away."""

_WAYS = {-1: "falls below", 1: "rises above"}


def system_html(system: System) -> str:
    """Bodies, coordinates, speeds, further states, loads, constraints, reactions, inputs and events; parameters folded away."""
    names = listed([b.name for b in system.bodies])
    *groups, last = (either(partial(_group, group=group), system) for group in _COLUMNS)
    lead = paragraph(f"<b>System</b>: {names}; inertial frame {math(place_latex(system.inertial.name))}")
    return "".join([lead, *groups, folded(f"{len(system.parameters)} parameters", last)])


def _group(system: System, group: str) -> str:
    head = _COLUMNS[group]
    return table(head, [[_cell(row, column) for column in head] for row in DECLARED[group](system)])


def _cell(row: Row, column: str) -> str:
    value: Any = row[column]
    if column == "unit":
        value = unit_text(value)
    if column == "default":
        return "–" if value is None else f"{value:g}"
    if column == "acts" and row["field"] is not None:
        return f"{vector(row['field']).cell} on every body"
    if value is None or (isinstance(value, Constraint) and column == "at"):
        return ""
    return next(write(value) for kind, write in _WRITERS.items() if isinstance(value, kind))


def _acting(load: Load | Constraint) -> str:
    pairs: list[tuple[str, str, Vector]] = [("force", p.name, v) for p, v in load.forces]
    pairs += [("torque", f.name, v) for f, v in load.torques]
    shown = [f"{what} on {math(place_latex(name))}: {vector(v).cell}" for what, name, v in pairs[:_PLACES]]
    return "<br>".join([*shown, *([f"… and {len(pairs) - _PLACES} more"] if len(pairs) > _PLACES else [])])


def _where(event: Event) -> str:
    way = _WAYS.get(event.direction, "crosses")
    return f"{expression(event.quantity).cell} {way} {escaped(f'{event.threshold:g}')}"


_WRITERS: dict[Any, Callable[[Any], str]] = {
    str: escaped,
    Expr: lambda e: expression(e).cell,
    Vector: lambda v: vector(v).cell,
    Part: lambda part: dyadic(part.inertia).cell,
    Point | Frame: lambda place: math(place_latex(place.name)),
    Load | Constraint: _acting,
    Event: _where,
}
"""HTML of a cell by what it holds."""
