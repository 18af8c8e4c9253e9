# SPDX-License-Identifier: BSD-3-Clause
"""HTML of a System, with its declarations as tables, and of its Equations: sizes, M and f, and where to find each step."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from kane.equations.equations import Equations
from kane.expr.evaluation import count_operations
from kane.expr.forms.two_angles import by_two_angles
from kane.expr.matrix import Matrix
from kane.expr.node import Expr
from kane.expr.symbols import Symbol, rate
from kane.model.bodies import Part
from kane.model.constraints import Constraint
from kane.model.declarations import Event
from kane.model.loads import Load
from kane.model.system import System
from kane.present.notebook.typeset import (
    MOST,
    NAMED,
    TALL,
    WIDE,
    Typeset,
    brackets,
    code,
    display,
    dyadic,
    either,
    equations,
    escaped,
    expression,
    folded,
    listed,
    math,
    matrix_words,
    paragraph,
    table,
    typeset,
    vector,
)
from kane.present.overview import DECLARED, Row
from kane.present.sketch.draw import sketch
from kane.space.frame import Frame, Point
from kane.space.vector import Vector
from kane.units.rules import unit_text
from kane.write.arrange import layout
from kane.write.display import Tree
from kane.write.latex import point_latex, symbol_latex

_PLACES = 4
"""Largest number of forces and torques of one load."""

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
"""The columns of each group; the parameters are collapsed."""

_WAYS = {-1: "falls below", 1: "rises above"}


def system_html(system: System) -> str:
    """A sketch, bodies, coordinates, speeds, states, loads, constraints, reactions, inputs and events; parameters collapsed."""
    names = listed([b.name for b in system.bodies])
    *groups, last = (either(partial(declared, group=group), system) for group in _COLUMNS)
    drawing = either(lambda s: sketch(s).svg, system)
    lead = paragraph(f"<b>System</b>: {names}; inertial frame {math(point_latex(system.inertial.name))}")
    return "".join([lead, drawing, *groups, folded(f"{len(system.parameters)} parameters", last)])


def declared(system: Any, group: str) -> str:
    """The table of one group of declarations of a system, or of an object with this group alone."""
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


def acting(load: Load | Constraint) -> str:
    """Forces and torques with their places."""
    pairs: list[tuple[str, str, Vector]] = [("force", p.name, v) for p, v in load.forces]
    pairs += [("torque", f.name, v) for f, v in load.torques]
    shown = [f"{what} on {math(point_latex(name))}: {vector(v).cell}" for what, name, v in pairs[:_PLACES]]
    return "<br>".join([*shown, *([f"… and {len(pairs) - _PLACES} more"] if len(pairs) > _PLACES else [])])


def _where(event: Event) -> str:
    way = _WAYS.get(event.direction, "crosses")
    return f"{expression(event.quantity).cell} {way} {escaped(f'{event.threshold:g}')}"


_WRITERS: dict[Any, Callable[[Any], str]] = {
    str: escaped,
    Expr: lambda e: expression(e).cell,
    Vector: lambda v: vector(v).cell,
    Part: lambda part: dyadic(part.inertia).cell,
    tuple: lambda coordinates: f"flexible, by {math(_names([q.name for q in coordinates]))}",
    Point | Frame: lambda place: math(point_latex(place.name)),
    Load | Constraint: acting,
    Event: _where,
}
"""HTML of a cell by the type of its value."""


SMALL = 300
"""Number of operations above which M and f, or the kinematical equations, are not typeset."""

_READ = {
    1: ("coordinates",),
    2: ("steps[1]",),
    3: ("Y", "z", "W", "X", "rates"),
    4: ("angular_velocities", "velocities", "partial_velocities", "point_accelerations"),
    5: ("Fr", "Fr_contributions"),
    6: ("Fr_star", "Fr_star_contributions"),
    7: ("mass_matrix", "forcing", "accelerations", "reaction_values"),
}


def equations_html(eom: Equations) -> str:
    """Summary, u̇, M and f, kinematical equations, operations, steps."""
    return "".join(either(make, eom) for make in (_summary, _solved, _motion, _rates, _operations, _steps))


def _summary(eom: Equations) -> str:
    bodies = listed([b.name for b in eom.system.bodies])
    groups = (
        (eom.coordinates, "coordinate"),
        (eom.speeds, "speed"),
        (eom.states, "further state"),
        (eom.reactions, "reaction"),
        (eom.inputs, "input"),
        (eom.parameters, "parameter"),
    )
    rows = [
        (f"{len(symbols)} {kind}{'s' if len(symbols) > 1 else ''}", math(_names(symbols)))
        for symbols, kind in groups
        if symbols
    ]
    return paragraph(f"<b>Equations of motion</b>: {bodies}") + table(("", ""), rows)


def _names(symbols: Sequence[Symbol]) -> str:
    few = ",\\, ".join(map(symbol_latex, symbols[:WIDE]))
    return few + (r",\, \dots" if len(symbols) > WIDE else "")


def _solved(eom: Equations) -> str:
    """u̇ if it is short; otherwise M and f are more informative."""
    shown = equations(
        [(symbol_latex(rate(u)), e) for u, e in zip(eom.speeds, eom.accelerations, strict=True)], most=SMALL
    )
    if not shown.latex:
        return paragraph(math(r"\dot{u}") + f" takes {shown.operations} operations, too long to typeset.")
    return paragraph("Equations of motion, solved:") + display(shown.latex)


def _motion(eom: Equations) -> str:
    mark, index = (r"\tilde ", "_I") if eom.embedding else ("", "")
    mass = eom.mass_matrix_nh if eom.embedding else eom.mass_matrix
    speeds = _names(eom.independent_speeds)
    lead = paragraph(math(rf"{mark}M\,\dot{{u}}{index} = {mark}f") + ", " + math(f"u{index} = ({speeds})"))
    shown = _motion_formula(mass, eom.forcing_nh if eom.embedding else eom.forcing, mark)
    if shown.latex:
        return lead + display(shown.latex)
    return lead + paragraph(
        f"M is a {matrix_words(mass)}; M and f together take {shown.operations} operations, too long to typeset."
    )


def _motion_formula(mass: Matrix, forcing: Sequence[Expr], mark: str) -> Typeset:
    """M = […] and f = […] one below the other, with common intermediates, if they are short enough."""
    n, entries = len(forcing), mass.entries
    operations = count_operations([*entries, *forcing]).total
    if operations > SMALL or n > WIDE:
        return Typeset("", operations)
    shown = by_two_angles([*entries, *forcing])
    alone = layout(shown[: n * n])
    if alone.intermediates or count_operations(shown[: n * n]).total > NAMED:
        return typeset(shown, lambda trees: _sides(trees[: n * n], trees[n * n :], n, mark))
    return typeset(shown[n * n :], lambda trees: _sides(alone.trees, trees, n, mark))


def _sides(mass: Sequence[Tree], forcing: Sequence[Tree], n: int, mark: str) -> list[str]:
    return [f"{mark}M = {brackets(mass, (n, n))}", f"{mark}f = {brackets(forcing, (n, 1))}"]


def _rates(eom: Equations) -> str:
    named = [(symbol_latex(rate(q)), e) for q, e in zip(eom.coordinates, eom.rates, strict=True)]
    shown = equations(named[:TALL], most=SMALL)
    if not named:
        return ""
    if not shown.latex:
        return paragraph(f"The kinematical equations have {shown.operations} operations, too long to typeset.")
    rest = paragraph(f"… and {len(named) - TALL} more") if len(named) > TALL else ""
    return paragraph("Kinematical equations:") + display(shown.latex) + rest


def _operations(eom: Equations) -> str:
    what = " and the reactions" if eom.reactions else ""
    return paragraph("One evaluation of " + math(r"\dot{q},\, \dot{u}") + f"{what} takes {escaped(eom.operations)}.")


def _steps(eom: Equations) -> str:
    if eom.operations.total > MOST:  # results of steps are computed on first access
        return ""
    rows = [
        (str(s.number), escaped(s.title), str(len(s.results)), ", ".join(map(code, _READ.get(s.number, ()))))
        for s in eom.steps
    ]
    return folded("The seven steps", table(("step", "", "results", "read as"), rows))
