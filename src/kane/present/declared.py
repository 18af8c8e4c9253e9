# SPDX-License-Identifier: BSD-3-Clause
"""What was declared, as one table that the notebook, the report and the command each render in their own way.

A row holds what its cells are, not how they look: expressions, vectors, places, symbols. A renderer chooses among groups and columns.
"""

from collections.abc import Callable, Iterable, Mapping
from itertools import zip_longest
from typing import Any

from kane.expr.symbols import AuxiliarySpeed, Symbol
from kane.model.bodies import Part, parts_of
from kane.model.reactions import constraint_of, cut_of
from kane.model.system import System

Row = Mapping[str, Any]
"""Cells by the names of their columns; "" or None where there is nothing."""


def _part(part: Part) -> Row:
    """The cell of the central inertia is the part: along which frame it is read depends on the part's own."""
    return {
        "body": part.name,
        "kind": "particle" if part.frame is None else "rigid body",
        "mass": part.mass,
        "mass centre": part.mass_center,
        "frame": part.frame or "particle",
        "central inertia": "" if part.inertia is None else part,
    }


def _symbols(kind: str, symbols: Iterable[Symbol]) -> Iterable[Row]:
    return ({kind: s, "default": s.default, "unit": s.unit, "meaning": s.description} for s in symbols)


def _speeds(system: System) -> Iterable[Row]:
    named = _symbols("speed", system.speeds)
    return ({**row, "definition": e} for row, e in zip(named, system.speeds.values(), strict=True))


def _loads(system: System) -> Iterable[Row]:
    """Gravity comes first; `field` is its acceleration, other loads have none."""
    fields = [g.acceleration for g in system.gravities]
    loads = zip_longest(system.all_loads(), fields)
    return ({"load": load.name, "acts": load, "potential": load.potential, "field": field} for load, field in loads)


def reactions(system: System, auxiliary: Iterable[AuxiliarySpeed] = ()) -> Iterable[Row]:
    """The reactions; with the auxiliary speeds that bring them into evidence, which may say where they act."""
    for s, u in zip_longest(system.reactions, auxiliary):
        row = _cut("reaction", s)
        if u is not None and not row["at"]:
            row = {**row, **{k: v for k, v in _cut("auxiliary speed", u).items() if k in ("at", "along")}}
        yield {**row, "auxiliary speed": u}


def _cut(kind: str, s: Symbol) -> Row:
    """A reaction or auxiliary speed, and where it is: at a point or frame along a direction, or at a constraint."""
    cut, (row,) = cut_of(s), _symbols(kind, (s,))
    at: Any = cut.at if cut else constraint_of(s) or ""
    return {**row, "at": at, "along": cut.along if cut else ""}


DECLARED: dict[str, Callable[[System], Iterable[Row]]] = {
    "bodies": lambda system: map(_part, parts_of(system.bodies)),
    "coordinates": lambda system: _symbols("coordinate", system.coordinates),
    "speeds": _speeds,
    "states": lambda system: (
        {**row, "rate": e} for row, e in zip(_symbols("state", system.states), system.states.values(), strict=True)
    ),
    "loads": _loads,
    "joints": lambda system: (
        {"joint": j.name, "kind": j.kind, "from": j.parent, "to": j.frame, "coordinates": j.coordinates}
        for j in system.joints
    ),
    "constraints": lambda system: (
        {"constraint": c.name, "kind": c.kind, "vanishes": c.expr, "held by": c if c.placed else None}
        for c in system.constraints
    ),
    "reactions": reactions,
    "auxiliary speeds": lambda system: (_cut("auxiliary speed", s) for s in system.auxiliary_speeds),
    "inputs": lambda system: _symbols("input", system.inputs),
    "events": lambda system: (
        {"event": e.name, "where": e, "": e.consequence, "message": e.message} for e in system.events
    ),
    "parameters": lambda system: _symbols("parameter", system.parameters),
    "frames": lambda system: (
        {"frame": f, "from": f.orientation.base if f.orientation else "", "orientation": f.orientation}
        for f in system.frames
    ),
    "points": lambda system: ({"point": p, "from": p.parent or "", "position": p} for p in system.points),
}
"""The rows of each group."""
