# SPDX-License-Identifier: BSD-3-Clause
"""A System in a notebook: what was declared, as tables."""

from __future__ import annotations

from collections.abc import Sequence

from kane.expr.node import Expr
from kane.expr.symbols import Symbol
from kane.model.bodies import Body, RigidBody
from kane.model.constraints import Constraint
from kane.model.loads import Load
from kane.model.reactions import cut_of
from kane.model.system import System
from kane.present.notebook.pieces import either, escaped, folded, listed, math, paragraph, table
from kane.present.notebook.typeset import expression
from kane.present.notebook.vectors import dyadic, vector
from kane.space.latex import place_latex
from kane.space.vector import Vector
from kane.units.text import unit_text
from kane.write.latex import latex_name

_PLACES = 4
"""Forces and torques of one load that are listed."""


def system_html(system: System) -> str:
    """Bodies, coordinates, speeds, loads, constraints, reactions, inputs and events; parameters folded away."""
    names = listed([b.name for b in system.bodies])
    parts = [
        paragraph(f"<b>System</b>: {names}; inertial frame {math(place_latex(system.inertial.name))}"),
        *(either(make, system) for make in _PARTS),
        folded(f"{len(system.parameters)} parameters", either(_parameters, system) if system.parameters else ""),
    ]
    return "".join(parts)


def symbol_cells(s: Symbol) -> tuple[str, str, str]:
    """Cells: name, unit, meaning."""
    return math(latex_name(s.name)), escaped(unit_text(s.unit)), escaped(s.description)


def _bodies(system: System) -> str:
    return table(("body", "mass", "mass centre", "frame", "central inertia"), [_body(b) for b in system.bodies])


def _body(body: Body) -> tuple[str, ...]:
    shared = (escaped(body.name), _cell(body.mass), math(place_latex(body.mass_center.name)))
    if not isinstance(body, RigidBody):
        return (*shared, "particle", "")
    return (*shared, math(place_latex(body.frame.name)), dyadic(body.inertia).cell)


def _coordinates(system: System) -> str:
    return table(("coordinate", "unit", "meaning"), [symbol_cells(q) for q in system.coordinates])


def _speeds(system: System) -> str:
    rows = [(name, _cell(e), *rest) for (name, *rest), e in ((symbol_cells(u), e) for u, e in system.speeds.items())]
    return table(("speed", "definition", "unit", "meaning"), rows)


def _loads(system: System) -> str:
    rows = [(escaped(g.name), f"{vector(g.acceleration).cell} on every body") for g in system.gravities]
    return table(("load", "acts"), [*rows, *((escaped(load.name), _acting(load)) for load in system.loads)])


def _constraints(system: System) -> str:
    rows = [(escaped(c.name), c.kind, _cell(c.expr), _acting(c) if c.placed else "") for c in system.constraints]
    return table(("constraint", "kind", "vanishes", "held by"), rows)


def _acting(load: Load | Constraint) -> str:
    pairs: list[tuple[str, str, Vector]] = [("force", p.name, v) for p, v in load.forces]
    pairs += [("torque", f.name, v) for f, v in load.torques]
    shown = [f"{what} on {math(place_latex(name))}: {vector(v).cell}" for what, name, v in pairs[:_PLACES]]
    return "<br>".join([*shown, *([f"… and {len(pairs) - _PLACES} more"] if len(pairs) > _PLACES else [])])


def _reactions(system: System) -> str:
    return _cuts("reaction", system.reactions) + _cuts("auxiliary speed", system.auxiliary_speeds)


def _cuts(kind: str, symbols: Sequence[Symbol]) -> str:
    rows = []
    for s in symbols:
        cut = cut_of(s)
        place = (math(place_latex(cut.at.name)), vector(cut.along).cell) if cut else ("", "")
        name, *rest = symbol_cells(s)
        rows.append((name, *place, *rest))
    return table((kind, "at", "along", "unit", "meaning"), rows)


def _inputs(system: System) -> str:
    return table(("input", "unit", "meaning"), [symbol_cells(s) for s in system.inputs])


def _events(system: System) -> str:
    ways = {-1: "falls below", 1: "rises above"}
    rows = [
        (
            escaped(e.name),
            f"{_cell(e.quantity)} {ways.get(e.direction, 'crosses')} {escaped(f'{e.threshold:g}')}",
            "ends the simulation" if e.terminal else "",
            escaped(e.message),
        )
        for e in system.events
    ]
    return table(("event", "where", "", "message"), rows)


def _parameters(system: System) -> str:
    rows = []
    for p in system.parameters:
        name, *rest = symbol_cells(p)
        rows.append((name, "–" if p.default is None else f"{p.default:g}", *rest))
    return table(("parameter", "default", "unit", "meaning"), rows)


_PARTS = (_bodies, _coordinates, _speeds, _loads, _constraints, _reactions, _inputs, _events)


def _cell(e: Expr) -> str:
    return expression(e).cell
