# SPDX-License-Identifier: BSD-3-Clause
"""Tables of the report: LaTeX or text in their cells, and what was declared as such tables."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from kane.equations.equations import Equations
from kane.expr.node import ZERO, Expr
from kane.model.bodies import Part
from kane.model.constraints import Constraint
from kane.model.loads import Load
from kane.present.declared import DECLARED, Row, reactions
from kane.present.formula_list import formulas
from kane.space.frame import Frame
from kane.space.point import Point
from kane.space.rotation import Orientation
from kane.space.vector import Vector
from kane.units.text import unit_text
from kane.write.latex import latex_name, place_latex, to_latex, unit_vector_latex

_FEW = 4
"""Places of a load that are listed."""


@dataclass(frozen=True, slots=True)
class Tex:
    """LaTeX in a cell of a table, where a plain string is text."""

    source: str


Cell = str | Tex


@dataclass(frozen=True, slots=True)
class PageTable:
    """A titled table of a page."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    unfolded: bool = True


def declared_tables(eom: Equations, values: Mapping[Any, float] | None = None) -> list[PageTable]:
    """What was declared, empty tables left out; `values` holds the parameters of a simulation."""
    system = eom.system
    used = {p: v for p, v in (values or {}).items() if p.default is None or v != p.default}
    rows: dict[str, Iterable[Row]] = {group: DECLARED[group](system) for group in DECLARED}
    rows["reactions"] = reactions(system, eom.auxiliary_speeds)
    simulated = ["simulated with"] if used else []
    if used:
        rows["parameters"] = ({**row, "simulated with": used.get(row["parameter"], "")} for row in rows["parameters"])
    tables = [
        page_table("Bodies", rows["bodies"], "body", "mass", "mass centre", "frame", "central inertia"),
        page_table("Loads", rows["loads"], "load", "acts", "potential"),
        page_table("Joints", rows["joints"], "joint", "kind", "from", "to", "coordinates"),
        page_table("Constraints", rows["constraints"], "constraint", "kind", "held by", "vanishes"),
        page_table("Reactions brought into evidence", rows["reactions"], "reaction", "at", "along", "auxiliary speed"),
        page_table("Parameters", rows["parameters"], "parameter", "default", *simulated, "unit", "meaning"),
        page_table("Inputs", rows["inputs"], "input", "unit", "meaning"),
        page_table("Further states", rows["states"], "state", "rate", "default", "unit", "meaning"),
        page_table("Frames", rows["frames"], "frame", "from", "orientation", unfolded=False),
        page_table("Points", rows["points"], "point", "from", "position", unfolded=False),
    ]
    return [t for t in tables if t.rows]


def page_table(title: str, rows: Iterable[Row], *head: str, unfolded: bool = True) -> PageTable:
    """A table of the columns `head` of what was declared."""
    return PageTable(title, head, tuple(tuple(_cell(row, column) for column in head) for row in rows), unfolded)


def _cell(row: Row, column: str) -> Cell:
    """A cell by the rule of its column, else by what it is."""
    value = row[column]
    if column in _COLUMNS:
        return _COLUMNS[column](row)
    if isinstance(value, str):
        return value
    if isinstance(value, Expr):
        return Tex(to_latex(value))
    if isinstance(value, Point | Frame):
        return Tex(place_latex(value.name))
    if isinstance(value, Load | Constraint):
        return _acting(value)
    return f"{value:g}"


def _vector(value: Vector | Expr) -> Tex:
    """A vector or an expression in LaTeX, with its intermediates."""
    between, (shown,) = formulas([("", value)])
    where = ",\\; ".join(z.latex for z in between)
    return Tex(shown.right + (rf"\quad\text{{where}}\quad {where}" if where else ""))


def _acting(load: Load | Constraint) -> Tex:
    places = [rf"\text{{force on }} {place_latex(p.name)}" for p, _ in load.forces]
    places += [rf"\text{{torque on }} {place_latex(f.name)}" for f, _ in load.torques]
    return Tex(r",\; ".join(places[:_FEW]) + (r",\; \dots" if len(places) > _FEW else ""))


def _inertia(part: Part) -> Tex:
    assert part.frame is not None
    assert part.inertia is not None
    used = part.inertia.frames()
    frame = used[0] if len(used) == 1 else part.frame
    rows = part.inertia.components(frame).rows
    axes = [unit_vector_latex(frame.name, a) for a in "xyz"]
    if all(x is ZERO for i, row in enumerate(rows) for k, x in enumerate(row) if i != k):
        terms = [rf"{_factor(to_latex(rows[i][i]))}\,{a}{a}" for i, a in enumerate(axes) if rows[i][i] is not ZERO]
        return Tex(" + ".join(terms) or "0")
    matrix = r" \\ ".join(" & ".join(to_latex(x) for x in row) for row in rows)
    return Tex(rf"\begin{{bmatrix}} {matrix} \end{{bmatrix}}_{{{place_latex(frame.name)}}}")


def _factor(text: str) -> str:
    return rf"\left({text}\right)" if " + " in text or " - " in text else text


def _at(row: Row) -> Cell:
    at = row["at"]
    return at.name if isinstance(at, Constraint) else Tex(place_latex(at.name)) if at else ""


def _along(row: Row) -> Cell:
    """Of a multiplier the first direction along which its constraint acts."""
    at, along = row["at"], row["along"]
    if isinstance(at, Constraint):
        along = next((v for _, v in (*at.forces, *at.torques)), "")
    return _vector(along) if along else ""


def _names(symbols: Iterable[Any]) -> str:
    return ",\\, ".join(latex_name(s.name) for s in symbols)


def _orientation(o: Orientation | None) -> Cell:
    if o is None:
        return "inertial"
    if o.axis is not None and o.angle is not None:
        return Tex(
            rf"\text{{turned about }} {unit_vector_latex(o.base.name, 'xyz'[o.axis])} \text{{ by }} {to_latex(o.angle)}"
        )
    if o.parameters:
        return Tex(r"\text{Euler parameters } " + _names(o.parameters))
    return "direction cosines" if o.angle is None else Tex(rf"\text{{turned by }} {to_latex(o.angle)}")


def _position(point: Point) -> Tex:
    if point.parent is None:
        return Tex(rf"\text{{fixed in }} {place_latex(point.frame.name)}")
    here = _vector(point.offset)
    if point.body is None:
        return here
    return Tex(rf"{here.source} \quad\text{{(particle of }} {place_latex(point.body.name)}\text{{)}}")


_COLUMNS: dict[str, Callable[[Row], Cell]] = {
    "central inertia": lambda row: _inertia(row["central inertia"]) if row["central inertia"] else "",
    "potential": lambda row: Tex(to_latex(row["potential"])) if row["potential"] is not None else "none",
    "coordinates": lambda row: Tex(_names(row["coordinates"])) if row["coordinates"] else "none",
    "held by": lambda row: _acting(row["held by"]) if row["held by"] is not None else "not told",
    "vanishes": lambda row: _vector(row["vanishes"]),
    "at": _at,
    "along": _along,
    "default": lambda row: f"{row['default']:g}" if row["default"] is not None else "–",
    "unit": lambda row: unit_text(row["unit"]),
    "orientation": lambda row: _orientation(row["orientation"]),
    "position": lambda row: _position(row["position"]),
}
"""Columns whose cells look otherwise than their values do by themselves."""
