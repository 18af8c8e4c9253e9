# SPDX-License-Identifier: BSD-3-Clause
"""What the engineer declared, as rows of tables: bodies, frames, points, loads, parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from kane.equations.equations import Equations
from kane.expr.node import ZERO
from kane.expr.symbols import Symbol
from kane.model.bodies import Body, RigidBody
from kane.model.constraints import Constraint
from kane.model.joints.joint import Joint
from kane.model.loads import Load
from kane.model.reactions import constraint_of, cut_of
from kane.present.formulas import formulas
from kane.space.frame import Frame
from kane.space.latex import place_latex, unit_vector_latex
from kane.space.vector import Vector
from kane.units.text import unit_text
from kane.write.latex import latex_name, to_latex

_FEW = 4
"""Places of a load that are listed."""


@dataclass(frozen=True, slots=True)
class Tex:
    """LaTeX in a cell of a table, where a plain string is text."""

    source: str


@dataclass(frozen=True, slots=True)
class Table:
    """A titled table; cells are text or Tex."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str | Tex, ...], ...]
    unfolded: bool = True


def declared(eom: Equations, values: Any = None) -> list[Table]:
    """The tables of a system, empty ones left out; `values` holds the parameters of a simulation."""
    system = eom.system
    tables = [
        Table("Bodies", ("body", "mass", "mass centre", "frame", "central inertia"), tuple(map(_body, system.bodies))),
        Table(
            "Loads",
            ("load", "acts", "potential"),
            tuple((load.name, _acting(load), _potential(load)) for load in eom.loads),
        ),
        Table("Joints", ("joint", "kind", "from", "to", "coordinates"), tuple(map(_joint, system.joints))),
        Table(
            "Constraints", ("constraint", "kind", "held by", "vanishes"), tuple(map(_constraint, system.constraints))
        ),
        Table("Reactions brought into evidence", ("reaction", "at", "along", "auxiliary speed"), _reactions(eom)),
        Table(*_parameters(eom, values)),
        Table("Inputs", ("input", "unit", "meaning"), tuple(_symbol(s) for s in eom.inputs)),
        Table("Frames", ("frame", "from", "orientation"), tuple(map(_frame, eom.frames)), unfolded=False),
        Table("Points", ("point", "from", "position"), tuple(map(_point, eom.points)), unfolded=False),
    ]
    return [t for t in tables if t.rows]


def vector_tex(v: Vector) -> Tex:
    """A vector in LaTeX."""
    between, (shown,) = formulas([("v", v)])
    where = ",\\; ".join(z.latex for z in between)
    return Tex(shown.right + (rf"\quad\text{{where}}\quad {where}" if where else ""))


def _symbol(s: Symbol) -> tuple[str | Tex, ...]:
    return (Tex(latex_name(s.name)), unit_text(s.unit), s.description)


def _body(body: Body) -> tuple[str | Tex, ...]:
    center = Tex(place_latex(body.mass_center.name))
    if not isinstance(body, RigidBody):
        return (body.name, Tex(to_latex(body.mass)), center, "particle", "")
    return (body.name, Tex(to_latex(body.mass)), center, Tex(place_latex(body.frame.name)), Tex(_inertia(body)))


def _inertia(body: RigidBody) -> str:
    used = body.inertia.frames()
    frame = used[0] if len(used) == 1 else body.frame
    rows = body.inertia.components(frame).rows
    axes = [unit_vector_latex(frame, a) for a in "xyz"]
    if all(x is ZERO for i, row in enumerate(rows) for k, x in enumerate(row) if i != k):
        terms = [rf"{_factor(to_latex(rows[i][i]))}\,{a}{a}" for i, a in enumerate(axes) if rows[i][i] is not ZERO]
        return " + ".join(terms) or "0"
    matrix = r" \\ ".join(" & ".join(to_latex(x) for x in row) for row in rows)
    return rf"\begin{{bmatrix}} {matrix} \end{{bmatrix}}_{{{place_latex(frame.name)}}}"


def _joint(joint: Joint) -> tuple[str | Tex, ...]:
    moves = Tex(",\\, ".join(latex_name(q.name) for q in joint.coordinates)) if joint.coordinates else "none"
    parent, child = (Tex(place_latex(f.name)) for f in (joint.parent, joint.frame))
    return (joint.name, joint.kind, parent, child, moves)


def _constraint(c: Constraint) -> tuple[str | Tex, ...]:
    between, (shown,) = formulas([(c.name, c.expr)])
    where = ",\\; ".join(z.latex for z in between)
    vanishes = Tex(shown.right + (rf"\quad\text{{where}}\quad {where}" if where else ""))
    return (c.name, c.kind, _acting(c) if c.placed else "not told", vanishes)


def _factor(text: str) -> str:
    return rf"\left({text}\right)" if " + " in text or " - " in text else text


def _acting(load: Load | Constraint) -> Tex:
    places = [rf"\text{{force on }} {place_latex(p.name)}" for p, _ in load.forces]
    places += [rf"\text{{torque on }} {place_latex(f.name)}" for f, _ in load.torques]
    return Tex(r",\; ".join(places[:_FEW]) + (r",\; \dots" if len(places) > _FEW else ""))


def _potential(load: Load) -> str | Tex:
    return Tex(to_latex(load.potential)) if load.potential is not None else "none"


def _reactions(eom: Equations) -> tuple[tuple[str | Tex, ...], ...]:
    rows: list[tuple[str | Tex, ...]] = []
    for r, s in zip(eom.reactions, eom.auxiliary_speeds, strict=True):
        cut, held = cut_of(r) or cut_of(s), constraint_of(r)
        at = Tex(place_latex(cut.at.name)) if cut else held.name if held else ""
        along = cut.along if cut else _direction(held) if held else None
        rows.append((Tex(latex_name(r.name)), at, vector_tex(along) if along else "", Tex(latex_name(s.name))))
    return tuple(rows)


def _direction(held: Constraint) -> Vector | None:
    """The first of the directions along which a constraint's multiplier acts."""
    return next((v for _, v in (*held.forces, *held.torques)), None)


def _parameters(eom: Equations, values: Any) -> tuple[str, tuple[str, ...], tuple[tuple[str | Tex, ...], ...]]:
    used = {p: v for p, v in (values or {}).items() if p.default is None or v != p.default}
    head = ("parameter", "default", *(("simulated with",) if used else ()), "unit", "meaning")
    rows = []
    for p in eom.parameters:
        default = f"{p.default:g}" if p.default is not None else "–"
        now = ((f"{used[p]:g}" if p in used else ""),) if used else ()
        rows.append((Tex(latex_name(p.name)), default, *now, unit_text(p.unit), p.description))
    return "Parameters", head, tuple(rows)


def _frame(frame: Frame) -> tuple[str | Tex, ...]:
    name, o = Tex(place_latex(frame.name)), frame.orientation
    if o is None:
        return (name, "", "inertial")
    base = Tex(place_latex(o.base.name))
    if o.axis is not None and o.angle is not None:
        turned = rf"\text{{turned about }} {unit_vector_latex(o.base, 'xyz'[o.axis])} \text{{ by }} {to_latex(o.angle)}"
        return (name, base, Tex(turned))
    if o.parameters:
        return (name, base, Tex(r"\text{Euler parameters } " + ",\\, ".join(latex_name(e.name) for e in o.parameters)))
    return (name, base, "direction cosines" if o.angle is None else Tex(rf"\text{{turned by }} {to_latex(o.angle)}"))


def _point(point: Any) -> tuple[str | Tex, ...]:
    name = Tex(place_latex(point.name))
    if point.parent is None:
        return (name, "", Tex(rf"\text{{fixed in }} {place_latex(point.frame.name)}"))
    here = vector_tex(point.offset)
    if point.body is not None:
        here = Tex(rf"{here.source} \quad\text{{(particle of }} {place_latex(point.body.name)}\text{{)}}")
    return (name, Tex(place_latex(point.parent.name)), here)
