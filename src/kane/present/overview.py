# SPDX-License-Identifier: BSD-3-Clause
"""The declarations of a system as tables that the notebook, the report and the command render, and tables of the report in LaTeX.

A row contains the values of its cells: expressions, vectors, points, symbols. A renderer chooses groups and columns.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import zip_longest
from types import MappingProxyType
from typing import Any

from kane.equations.equations import Equations
from kane.expr.node import ZERO, Expr
from kane.expr.symbols import AuxiliarySpeed, Coordinate, Symbol
from kane.model.bodies import Deforming, Part, deforming
from kane.model.constraints import Constraint, constraint_of, cut_of
from kane.model.loads import Load
from kane.model.system import System
from kane.present.formula_list import formulas
from kane.present.languages.catalogue import N_, tr
from kane.space.frame import Frame, Point
from kane.space.rotation import Orientation
from kane.space.vector import Vector
from kane.units.rules import unit_text
from kane.write.latex import point_latex, symbol_latex, to_latex, unit_vector_latex

Row = Mapping[str, Any]
"""Cells by the names of their columns; "" or None for empty ones."""


def _part(part: Part) -> Row:
    """The row of a part; the cell of the central inertia is the part itself, as its frame is needed to write it."""
    return {
        "body": part.name,
        "kind": N_("particle") if part.frame is None else N_("rigid body"),
        "mass": part.mass,
        "mass centre": part.mass_center,
        "frame": part.frame or N_("particle"),
        "central inertia": "" if part.inertia is None else part,
    }


def _bodies(system: System) -> Iterable[Row]:
    """A row for each part of a rigid body, and one for a flexible body, whose parts have no separate meaning."""
    for body in system.bodies:
        flexible = deforming((body,))
        yield from map(_deforming, flexible) if flexible else map(_part, body.parts())


def _deforming(body: Deforming) -> Row:
    return {
        "body": body.name,
        "kind": N_("flexible body"),
        "mass": body.mass,
        "mass centre": N_("a moving point"),
        "frame": body.parts()[0].frame or "",
        "central inertia": body.coordinates,
    }


def _symbols(kind: str, symbols: Iterable[Symbol]) -> Iterable[Row]:
    return ({kind: s, "default": s.default, "unit": s.unit, "meaning": meaning(s)} for s in symbols)


_OF_CONTACTS = (
    N_("direction of the slip of %(name)s"), N_("slip below which %(name)s slips straight on"), N_("rounding of the gap of %(name)s"),
    N_("share of %(name)s"),
)  # fmt: skip
"""Descriptions of parameters declared by contacts."""


def meaning(s: Symbol) -> str:
    """The description of a symbol, in the report's language if it is one of a contact."""
    for text in _OF_CONTACTS:
        before, _, after = text.partition("%(name)s")
        if s.description.startswith(before) and s.description.endswith(after):
            return tr(text, name=s.description.removeprefix(before).removesuffix(after))
    return s.description


def _loads(system: System) -> Iterable[Row]:
    """Rows of loads, gravity first; `field` is its acceleration, other loads have none."""
    fields, inner = [g.acceleration for g in system.gravities], _within(system)
    loads = zip_longest(system.all_loads(), fields)
    return (
        {"load": load.name, "acts": load, "potential": load.potential, "field": field, "within": inner}
        for load, field in loads
    )


def _within(system: System) -> dict[Point | Frame, Deforming]:
    """Points and frames that represent mass and elasticity of flexible bodies, without separate meaning."""
    result: dict[Point | Frame, Deforming] = {}
    for body in deforming(system.bodies):
        places = [p for part in body.parts() for p in (part.mass_center, part.frame, *(x for x, _ in part.momenta))]
        places += [p for load in body.own_loads for p, _ in (*load.forces, *load.torques)]
        result |= {p: body for p in places if p is not None and p.name.startswith(f"{body.name} ")}
    return result


def reactions(system: System, auxiliary: Iterable[AuxiliarySpeed] = ()) -> Iterable[Row]:
    """The reactions, with the auxiliary speeds that bring them into evidence and may define their place."""
    for s, u in zip_longest(system.reactions, auxiliary):
        row = _cut("reaction", s)
        if u is not None and not row["at"]:
            row = {**row, **{k: v for k, v in _cut("auxiliary speed", u).items() if k in ("at", "along")}}
        yield {**row, "auxiliary speed": u}


def _cut(kind: str, s: Symbol) -> Row:
    """A reaction or auxiliary speed, with its place: a point or frame and a direction, or a constraint."""
    cut, (row,) = cut_of(s), _symbols(kind, (s,))
    at: Any = cut.at if cut else constraint_of(s) or ""
    return {**row, "at": at, "along": cut.along if cut else ""}


DECLARED: dict[str, Callable[[System], Iterable[Row]]] = {
    "bodies": _bodies,
    "coordinates": lambda system: _symbols("coordinate", system.coordinates),
    "speeds": lambda system: (
        {**row, "definition": e}
        for row, e in zip(_symbols("speed", system.speeds), system.speeds.values(), strict=True)
    ),
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
    "points": lambda system: (
        {"point": p, "from": p.parent or "", "position": p, "within": _within(system)} for p in system.points
    ),
}
"""The rows of each group."""


_FEW = 4
"""Largest number of places of a load in a table."""


@dataclass(frozen=True, slots=True)
class Tex:
    """LaTeX in a cell of a table; plain strings are text."""

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
    """The declarations as tables, without empty ones; `values` are the parameters of a simulation."""
    system = eom.system
    used = {p: v for p, v in (values or {}).items() if p.default is None or v != p.default}
    rows: dict[str, Iterable[Row]] = {group: DECLARED[group](system) for group in DECLARED}
    rows["reactions"] = reactions(system, eom.auxiliary_speeds)
    simulated = [N_("simulated with")] if used else []
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
    """A table of the columns `head` of declarations."""
    return PageTable(
        tr(title) if title else "",
        tuple(map(tr, head)),
        tuple(tuple(_cell(row, column) for column in head) for row in rows),
        unfolded,
    )


_FIXED = {"kind", "frame", "mass centre"}
"""Columns with texts that can be translated."""
KINDS = (
    N_("pin"), N_("slider"), N_("cylindrical"), N_("ball"), N_("universal"), N_("planar"), N_("free"), N_("screw"), N_("weld"),
    N_("configuration"), N_("motion"),
)  # fmt: skip
"""Names of the kinds of joints and constraints."""


def _cell(row: Row, column: str) -> Cell:
    """A cell by the rule of its column, or by the type of its value."""
    value = row[column]
    if column in _COLUMNS:
        return _COLUMNS[column](row)
    if isinstance(value, str):
        return tr(value) if column in _FIXED else value
    if isinstance(value, Expr):
        return Tex(to_latex(value))
    if isinstance(value, Point | Frame):
        return Tex(point_latex(value.name))
    if isinstance(value, Load | Constraint):
        return _acting(value)
    return f"{value:g}"


def _vector(value: Vector | Expr) -> Tex:
    """A vector or an expression in LaTeX, with its intermediates."""
    between, (shown,) = formulas([("", value)])
    where = ",\\; ".join(z.latex for z in between)
    return Tex(shown.right + (tr(r"\quad\text{where}\quad %(formulas)s", formulas=where) if where else ""))


def _acting(load: Load | Constraint, inner: Mapping[Point | Frame, Deforming] = MappingProxyType({})) -> Tex:
    told = [(False, p) for p, _ in load.forces] + [(True, f) for f, _ in load.torques]
    places = list(dict.fromkeys(_attachment(turns, at, inner) for turns, at in told))
    return Tex(r",\; ".join(places[:_FEW]) + (r",\; \dots" if len(places) > _FEW else ""))


def _attachment(turns: bool, at: Point | Frame, inner: Mapping[Point | Frame, Deforming]) -> str:
    place = point_latex(inner[at].name if at in inner else at.name)
    return tr(_ATTACHMENTS[turns, at in inner], place=place)


_ATTACHMENTS = {
    (False, False): N_(r"\text{force on }%(place)s"), (False, True): N_(r"\text{force along }%(place)s"),
    (True, False): N_(r"\text{torque on }%(place)s"), (True, True): N_(r"\text{torque along }%(place)s"),
}  # fmt: skip
"""Texts for the place of a load: for a force or a torque, on an ordinary point or frame or within a flexible body."""


def _inertia(part: Part | tuple[Coordinate, ...]) -> Tex:
    """The inertia of a part, or the coordinates of deformation of a flexible body."""
    if not isinstance(part, Part):
        return Tex(tr(r"\text{flexible, by }%(coordinates)s", coordinates=_names(part)))
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
    return Tex(rf"\begin{{bmatrix}} {matrix} \end{{bmatrix}}_{{{point_latex(frame.name)}}}")


def _factor(text: str) -> str:
    return rf"\left({text}\right)" if " + " in text or " - " in text else text


def _at(row: Row) -> Cell:
    at = row["at"]
    return at.name if isinstance(at, Constraint) else Tex(point_latex(at.name)) if at else ""


def _along(row: Row) -> Cell:
    """The direction of a reaction; for a multiplier the first direction of its constraint."""
    at, along = row["at"], row["along"]
    if isinstance(at, Constraint):
        along = next((v for _, v in (*at.forces, *at.torques)), "")
    return _vector(along) if along else ""


def _names(symbols: Iterable[Any]) -> str:
    return ",\\, ".join(symbol_latex(s) for s in symbols)


def _orientation(o: Orientation | None) -> Cell:
    if o is None:
        return tr("inertial")
    if o.axis is not None and o.angle is not None:
        axis = unit_vector_latex(o.base.name, "xyz"[o.axis])
        return Tex(tr(r"\text{turned about }%(axis)s\text{ by }%(angle)s", axis=axis, angle=to_latex(o.angle)))
    if o.parameters:
        return Tex(tr(r"\text{Euler parameters }%(parameters)s", parameters=_names(o.parameters)))
    return (
        tr("direction cosines") if o.angle is None else Tex(tr(r"\text{turned by }%(angle)s", angle=to_latex(o.angle)))
    )


def _position(point: Point, within: Deforming | None) -> Tex:
    if point.parent is None:
        return Tex(tr(r"\text{fixed in }%(frame)s", frame=point_latex(point.frame.name)))
    here = _vector(point.offset)
    body = within or point.body
    told = {} if body is None else {"offset": here.source, "body": point_latex(body.name)}
    if within is not None:
        return Tex(tr(r"%(offset)s\quad\text{(shares the mass of }%(body)s\text{)}", **told))
    return Tex(tr(r"%(offset)s\quad\text{(particle of }%(body)s\text{)}", **told)) if told else here


_COLUMNS: dict[str, Callable[[Row], Cell]] = {
    "central inertia": lambda row: _inertia(row["central inertia"]) if row["central inertia"] else "",
    "acts": lambda row: _acting(row["acts"], row["within"]),
    "potential": lambda row: Tex(to_latex(row["potential"])) if row["potential"] is not None else tr("none"),
    "coordinates": lambda row: Tex(_names(row["coordinates"])) if row["coordinates"] else tr("none"),
    "held by": lambda row: _acting(row["held by"]) if row["held by"] is not None else tr("not told"),
    "vanishes": lambda row: _vector(row["vanishes"]),
    "at": _at,
    "along": _along,
    "default": lambda row: f"{row['default']:g}" if row["default"] is not None else "–",
    "unit": lambda row: unit_text(row["unit"]),
    "orientation": lambda row: _orientation(row["orientation"]),
    "position": lambda row: _position(row["position"], row["within"].get(row["point"])),
}
"""Columns with their own rule for cells."""
