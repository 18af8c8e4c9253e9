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
from kane.present.notebook import typeset as html
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
    names = html.listed([b.name for b in system.bodies])
    *groups, last = (html.either(partial(declared, group=group), system) for group in _COLUMNS)
    drawing = html.either(lambda s: sketch(s).svg, system)
    lead = html.paragraph(f"<b>System</b>: {names}; inertial frame {html.math(point_latex(system.inertial.name))}")
    return "".join([lead, drawing, *groups, html.folded(f"{len(system.parameters)} parameters", last)])


def declared(system: Any, group: str) -> str:
    """The table of one group of declarations of a system, or of an object with this group alone."""
    head = _COLUMNS[group]
    return html.table(head, [[_cell(row, column) for column in head] for row in DECLARED[group](system)])


def _cell(row: Row, column: str) -> str:
    value: Any = row[column]
    if column == "unit":
        value = unit_text(value)
    if column == "default":
        return "–" if value is None else f"{value:g}"
    if column == "acts" and row["field"] is not None:
        return f"{html.vector(row['field']).cell} on every body"
    if value is None or (isinstance(value, Constraint) and column == "at"):
        return ""
    return next(write(value) for kind, write in _WRITERS.items() if isinstance(value, kind))


def acting(load: Load | Constraint) -> str:
    """Forces and torques with their places."""
    pairs: list[tuple[str, str, Vector]] = [("force", p.name, v) for p, v in load.forces]
    pairs += [("torque", f.name, v) for f, v in load.torques]
    shown = [f"{what} on {html.math(point_latex(name))}: {html.vector(v).cell}" for what, name, v in pairs[:_PLACES]]
    return "<br>".join([*shown, *([f"… and {len(pairs) - _PLACES} more"] if len(pairs) > _PLACES else [])])


def _where(event: Event) -> str:
    way = _WAYS.get(event.direction, "crosses")
    return f"{html.expression(event.quantity).cell} {way} {html.escaped(f'{event.threshold:g}')}"


_WRITERS: dict[Any, Callable[[Any], str]] = {
    str: html.escaped,
    Expr: lambda e: html.expression(e).cell,
    Vector: lambda v: html.vector(v).cell,
    Part: lambda part: html.dyadic(part.inertia).cell,
    tuple: lambda coordinates: f"flexible, by {html.math(_names([q.name for q in coordinates]))}",
    Point | Frame: lambda place: html.math(point_latex(place.name)),
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
    return "".join(html.either(make, eom) for make in (_summary, _solved, _motion, _rates, _operations, _steps))


def _summary(eom: Equations) -> str:
    bodies = html.listed([b.name for b in eom.system.bodies])
    groups = (
        (eom.coordinates, "coordinate"),
        (eom.speeds, "speed"),
        (eom.states, "further state"),
        (eom.reactions, "reaction"),
        (eom.inputs, "input"),
        (eom.parameters, "parameter"),
    )
    rows = [
        (f"{len(symbols)} {kind}{'s' if len(symbols) > 1 else ''}", html.math(_names(symbols)))
        for symbols, kind in groups
        if symbols
    ]
    return html.paragraph(f"<b>Equations of motion</b>: {bodies}") + html.table(("", ""), rows)


def _names(symbols: Sequence[Symbol]) -> str:
    few = ",\\, ".join(map(symbol_latex, symbols[: html.WIDE]))
    return few + (r",\, \dots" if len(symbols) > html.WIDE else "")


def _solved(eom: Equations) -> str:
    """u̇ if it is short; otherwise M and f are more informative."""
    shown = html.equations(
        [(symbol_latex(rate(u)), e) for u, e in zip(eom.speeds, eom.accelerations, strict=True)], most=SMALL
    )
    if not shown.latex:
        return html.paragraph(html.math(r"\dot{u}") + f" takes {shown.operations} operations, too long to typeset.")
    return html.paragraph("Equations of motion, solved:") + html.display(shown.latex)


def _motion(eom: Equations) -> str:
    mark, index = (r"\tilde ", "_I") if eom.embedding else ("", "")
    mass = eom.mass_matrix_nh if eom.embedding else eom.mass_matrix
    speeds = _names(eom.independent_speeds)
    lead = html.paragraph(
        html.math(rf"{mark}M\,\dot{{u}}{index} = {mark}f") + ", " + html.math(f"u{index} = ({speeds})")
    )
    shown = _motion_formula(mass, eom.forcing_nh if eom.embedding else eom.forcing, mark)
    if shown.latex:
        return lead + html.display(shown.latex)
    return lead + html.paragraph(
        f"M is a {html.matrix_words(mass)}; M and f together take {shown.operations} operations, too long to typeset."
    )


def _motion_formula(mass: Matrix, forcing: Sequence[Expr], mark: str) -> html.Typeset:
    """M = […] and f = […] one below the other, with common intermediates, if they are short enough."""
    n, entries = len(forcing), mass.entries
    operations = count_operations([*entries, *forcing]).total
    if operations > SMALL or n > html.WIDE:
        return html.Typeset("", operations)
    shown = by_two_angles([*entries, *forcing])
    alone = layout(shown[: n * n])
    if alone.intermediates or count_operations(shown[: n * n]).total > html.NAMED:
        return html.typeset(shown, lambda trees: _sides(trees[: n * n], trees[n * n :], n, mark))
    return html.typeset(shown[n * n :], lambda trees: _sides(alone.trees, trees, n, mark))


def _sides(mass: Sequence[Tree], forcing: Sequence[Tree], n: int, mark: str) -> list[str]:
    return [f"{mark}M = {html.brackets(mass, (n, n))}", f"{mark}f = {html.brackets(forcing, (n, 1))}"]


def _rates(eom: Equations) -> str:
    named = [(symbol_latex(rate(q)), e) for q, e in zip(eom.coordinates, eom.rates, strict=True)]
    shown = html.equations(named[: html.TALL], most=SMALL)
    if not named:
        return ""
    if not shown.latex:
        return html.paragraph(f"The kinematical equations have {shown.operations} operations, too long to typeset.")
    rest = html.paragraph(f"… and {len(named) - html.TALL} more") if len(named) > html.TALL else ""
    return html.paragraph("Kinematical equations:") + html.display(shown.latex) + rest


def _operations(eom: Equations) -> str:
    what = " and the reactions" if eom.reactions else ""
    return html.paragraph(
        "One evaluation of " + html.math(r"\dot{q},\, \dot{u}") + f"{what} takes {html.escaped(eom.operations)}."
    )


def _steps(eom: Equations) -> str:
    if eom.operations.total > html.MOST:  # results of steps are computed on first access
        return ""
    rows = [
        (str(s.number), html.escaped(s.title), str(len(s.results)), ", ".join(map(html.code, _READ.get(s.number, ()))))
        for s in eom.steps
    ]
    return html.folded("The seven steps", html.table(("step", "", "results", "read as"), rows))
