# SPDX-License-Identifier: BSD-3-Clause
"""HTML of records: a row for each field, or one table or a few formulas of their own; of mappings and lists, a row for each item."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from kane.analysis.assembly import Assembled
from kane.analysis.comparison import MethodComparison, SpeedComparison
from kane.analysis.linear import Linear, Mode, NormalModes
from kane.dynamics.formalisms import Formulation
from kane.dynamics.motions import Motions
from kane.dynamics.readings.seven_steps import Quantity
from kane.equations.state import GROUPS, State
from kane.errors import cut
from kane.expr.build import add
from kane.expr.matrix import Matrix
from kane.expr.node import Expr
from kane.expr.symbols import Symbol, Symbols
from kane.model.beams.beam import Beam
from kane.model.bodies import Particle, RigidBody
from kane.model.constraints import Constraint
from kane.model.declarations import Event
from kane.model.force_systems import ForceSystem, Wrench
from kane.model.loads import Load
from kane.model.mass import Principal
from kane.motion.solution.solution import Solution
from kane.present.formula_list import quantity_latex
from kane.present.notebook.declared import acting, declared
from kane.present.notebook.typeset import (
    Typeset,
    code,
    display,
    dyadic,
    either,
    equations,
    escaped,
    expression,
    listed,
    math,
    matrix,
    paragraph,
    table,
    vector,
)
from kane.program.from_expressions import Receipt, receipt
from kane.program.program import Port, Program, Routine
from kane.show import Named
from kane.space.attitude import Rotation
from kane.space.frame import Frame, Point
from kane.space.vector import Dyadic, Vector
from kane.units.rules import unit_text
from kane.write.latex import latex_name, point_latex, symbol_latex

_ITEMS = 12
"""Largest number of items of a list within a cell."""
_LETTERS = 120
"""Largest number of letters of a plain text in a cell."""


def cell(value: Any) -> str:
    """HTML of a value within a table; "" for an uninformative value."""
    return next((write(value) for kind, write in _CELLS.items() if isinstance(value, kind)), _text(value))


def _text(value: Any) -> str:
    name = getattr(value, "name", None)
    return escaped(name if isinstance(name, str) else cut(repr(value), _LETTERS))


def _array(values: np.ndarray) -> str:
    if values.size > _ITEMS or values.ndim > 1:
        return f"{' × '.join(map(str, values.shape))} numbers"
    return ", ".join(cell(v) if np.issubdtype(values.dtype, np.number) else escaped(v) for v in values.ravel().tolist())


def _pairs(values: Mapping[Any, Any]) -> str:
    shown = [f"{cell(k)}: {cell(v)}" for k, v in list(values.items())[:_ITEMS]]
    return "<br>".join([*shown, *_rest(values)])


def _several(values: Any) -> str:
    return ", ".join([*map(cell, tuple(values)[:_ITEMS]), *_rest(values)])


def _rest(values: Any) -> list[str]:
    return [f"… and {len(values) - _ITEMS} more"] if len(values) > _ITEMS else []


_CELLS: dict[Any, Callable[[Any], str]] = {
    type(None): lambda _: "",
    bool | np.bool_: lambda yes: "yes" if yes else "no",
    int | np.integer: str,
    str: lambda text: escaped(cut(text, _LETTERS)),
    Symbol: lambda s: math(symbol_latex(s)),
    Expr: lambda e: expression(e).cell,
    Vector: lambda v: vector(v).cell,
    Dyadic: lambda d: dyadic(d).cell,
    Matrix: lambda m: matrix(m).cell,
    Frame | Point: lambda place: math(point_latex(place.name)),
    float | complex | np.number: lambda x: escaped(f"{x:.6g}"),
    np.ndarray: _array,
    Mapping: _pairs,
    tuple | list | set | frozenset: _several,
    Callable: lambda _: "",
}
"""HTML of a value by its type, the first that matches."""


def record_html(record: Any) -> str:
    """A row for each nonempty field; for objects that are not records their printed form."""
    lead = f"<b>{type(record).__name__}</b>"
    own = [f.name for f in fields(record) if not f.name.startswith("_")] if is_dataclass(record) else []
    shown = [(escaped(name.replace("_", " ")), cell(getattr(record, name, None))) for name in own]
    body = table(("", ""), [row for row in shown if row[1]])
    return paragraph(lead) + body if body else paragraph(f"{lead}: {escaped(cut(repr(record), 300))}")


def mapping_html(values: Mapping[Any, Any]) -> str:
    """A row for each key."""
    rows = [(cell(key), cell(value)) for key, value in values.items()]
    return table(("", ""), rows) or paragraph("Nothing.")


def symbols_html(symbols: Symbols[Any]) -> str:
    """Name, unit, default and meaning."""
    rows = [(cell(s), escaped(unit_text(s.unit)), cell(s.default), escaped(s.description or "")) for s in symbols]
    return table(("symbol", "unit", "default", "meaning"), rows) or paragraph("No symbols.")


_GROUPS: dict[Any, str] = {RigidBody | Particle: "bodies", Constraint: "constraints", Event: "events"}
"""The group of a system as which a list is shown, by the type of its items."""


def listing_html(values: tuple[Any, ...]) -> str:
    """A row for each item."""
    for kind, group in _GROUPS.items():
        if values and all(isinstance(v, kind) for v in values):
            return declared(SimpleNamespace(**{group: values}), group)
    heads = getattr(values, "_fields", range(len(values)))
    rows = [(str(k), _item_name(v), _item(v)) for k, v in zip(heads, values, strict=True)]
    return table(("", "", ""), rows) or paragraph("Nothing.")


def _item_name(value: Any) -> str:
    name = getattr(value, "name", "")
    return "" if isinstance(value, Expr | Frame | Point) or not isinstance(name, str) else escaped(name)


def _item(value: Any) -> str:
    if isinstance(value, Load):
        return acting(value)
    return cell(value) if isinstance(value, _PLAIN) else escaped(cut(repr(value), _LETTERS))


_PLAIN = (Expr, Vector, Dyadic, Matrix, Frame, Point, str, int, float, complex, np.ndarray, tuple)


def named_formulas(named: Named[Expr]) -> Typeset:
    """Equations one below the other."""
    pairs = zip(named.labels, named, strict=True)
    return equations([(_label(label), e) for label, e in pairs])


def _label(label: object) -> str:
    if isinstance(label, Quantity):
        return quantity_latex(label)
    return symbol_latex(label) if isinstance(label, Symbol) else latex_name(str(label))


def force_system_html(found: ForceSystem) -> str:
    """A row for each force, and for each torque."""
    rows = [(escaped(p.name), vector(f).cell, "") for p, f in found.forces]
    rows += [("", "", vector(t).cell) for t in found.torques]
    return table(("at", "force", "torque of a couple"), rows)


def wrench_html(found: Wrench) -> str:
    """Force, couple, and position of the central axis."""
    cells = (vector(found.force), vector(found.torque), vector(found.position), expression(found.pitch))
    return table(("force", "torque", "position of the central axis", "pitch"), [tuple(c.cell for c in cells)])


def formulation_html(f: Formulation) -> str:
    """The equations, each equal to zero."""
    rows = [(str(k + 1), expression(e).cell) for k, e in enumerate(f.equations)]
    return paragraph(escaped(repr(f))) + table(("", "0 ="), rows)


def motions_html(motions: Motions) -> str:
    """A row for each speed, rate and dependent speed."""
    system = motions.derived.system
    head = paragraph(
        f"<b>Motions</b>: {len(motions.coordinates)} coordinates, {motions.degrees_of_freedom} degrees of freedom"
    )
    given = map(add, motions.A_n @ motions.independent_speeds, motions.b_n)
    groups = (
        (("speed", "definition"), "{}", system.speeds.items()),
        (("rate", "by speeds"), r"\dot{{{}}}", zip(motions.coordinates, motions.rates, strict=True)),
        (("dependent speed", "by the independent ones"), "{}", zip(motions.dependent_speeds, given, strict=True)),
    )
    return head + "".join(
        table(names, [(math(form.format(symbol_latex(s))), expression(e).cell) for s, e in pairs])
        for names, form, pairs in groups
    )


def principal_html(found: Principal) -> str:
    """A row for each principal moment."""
    rows = [(expression(i).cell, vector(n).cell) for i, n in zip(found.moments, found.axes, strict=True)]
    return table(("principal moment", "axis"), rows)


def rotation_latex(r: Rotation) -> str:
    """The matrix of direction cosines; for an array of rotations its shape."""
    return repr(r) if r.shape else matrix(Matrix(r.direction_cosines)).dollars("A rotation")


def comparison_html(comparison: SpeedComparison | MethodComparison) -> str:
    """The table of a comparison."""
    head, rows = comparison.table()
    return table(tuple(map(escaped, head)), [tuple(map(escaped, row)) for row in rows])


def linear_html(linear: Linear) -> str:
    """The operating point, the modes, the matrices."""
    return "".join(either(make, linear) for make in (_linear_summary, _modes, _matrices))


def _linear_summary(linear: Linear) -> str:
    at = escaped(f"{cut(repr(linear.point), 300)}")
    left = f"; no speed depends on {listed(list(linear.cyclic))}" if linear.cyclic else ""
    return paragraph(f"<b>Linear</b>: {len(linear.states)} states, {len(linear.inputs)} inputs{left}") + paragraph(at)


def _modes(linear: Linear) -> str:
    rows = [
        (_number(m.eigenvalue), f"{m.frequency:.5g} rad/s", f"{m.damping:.4g}", escaped(largest(m.shape)))
        for m in linear.modes
    ]
    return table(("eigenvalue", "frequency", "damping", "mode"), rows)


def _number(value: complex) -> str:
    return f"{value.real:.6g}" if not value.imag else f"{value.real:.6g} ± {value.imag:.6g} i"


def largest(shape: dict[str, complex]) -> str:
    """The largest components of a mode, with their phases."""
    chosen = sorted(shape.items(), key=lambda pair: -abs(pair[1]))[:4]
    return ", ".join(f"{name} {abs(v):.3g}∠{round(np.degrees(np.angle(v)))}°" for name, v in chosen if abs(v) > 1e-3)


def _matrices(linear: Linear) -> str:
    shown = _matrix("A", linear.A, linear.states, linear.states)
    return shown + (_matrix("B", linear.B, linear.states, linear.inputs) if linear.inputs else "")


def _matrix(name: str, a: npt.NDArray[np.float64], rows: Sequence[str], columns: Sequence[str]) -> str:
    if a.size > 400:
        return paragraph(f"{name}: {a.shape[0]} × {a.shape[1]}")
    head = (name, *(math(latex_name(c)) for c in columns))
    return table(
        head, [(math(latex_name(r)), *(f"{v + 0.0:.6g}" for v in row)) for r, row in zip(rows, a, strict=True)]
    )


_FEW = 12
"""Largest number of names of a vector."""


def routine_html(program: Program, routine: Routine) -> str:
    """Signature, arguments, results and operations of one routine."""
    shape = " × ".join(map(str, routine.shape))
    rows = [*_arguments(program), (code("results"), "", shape, _labels(routine.labels))]
    operations = paragraph(escaped(receipt(program)[routine.name]))
    return paragraph(_signature(program, routine)) + table(_HEAD, rows) + operations


def program_html(program: Program, costs: Receipt) -> str:
    """The arguments common to all routines, and a row for each routine."""
    named = [r for r in program.routines if r.results]
    routines = [(_signature(program, r), _labels(r.labels), escaped(costs[r.name])) for r in named]
    lead = paragraph(f"<b>Compiled</b>: {escaped(program.name)}")
    return lead + table(_HEAD, _arguments(program)) + table(("routine", "results", "operations"), routines)


_HEAD = ("argument", "", "size", "names")


def _arguments(program: Program) -> list[tuple[str, ...]]:
    ports = [port for port in program.ports if port.symbols]
    return [(code(p.name), escaped(p.noun), "" if p.scalar else str(len(p.symbols)), _symbols(p)) for p in ports]


def _signature(program: Program, routine: Routine) -> str:
    return code(f"{routine.name}({program.signature}) → {list(routine.shape)}")


def _symbols(port: Port) -> str:
    few = [symbol_latex(s) for s in port.symbols[:_FEW]]
    return math(r",\, ".join([*few, *([r"\dots"] if len(port.symbols) > _FEW else [])]))


def _labels(labels: Sequence[str]) -> str:
    return code(", ".join(labels[:_FEW])) + (", …" if len(labels) > _FEW else "")


def solution_html(solution: Solution) -> str:
    """Summary, energy check, events, first and last state."""
    return "".join(either(make, solution) for make in (_solution_summary, _energy, _events, _states))


def _solution_summary(solution: Solution) -> str:
    bodies = listed([b.name for b in solution.equations.system.bodies])
    span = f"t = {solution.t[0]:g} … {solution.t[-1]:g} s" if len(solution) else "no samples"
    counts = f"{len(solution)} samples, {solution.steps} steps, {solution.evaluations} evaluations"
    ended = f"{escaped(solution.status)}: {escaped(solution.message)}"
    return paragraph(f"<b>Solution</b>: {bodies}; {span}") + paragraph(f"{counts}; {ended}")


def _energy(solution: Solution) -> str:
    words = str(solution.energy_check)
    return paragraph(escaped(f"{words[:1].upper()}{words[1:]}."))


def _events(solution: Solution) -> str:
    rows = [(escaped(event.name), f"{t:.6g} s", escaped(event.message)) for event, t in solution.events]
    return table(("event", "at", "message"), rows)


def _states(solution: Solution) -> str:
    if not len(solution):
        return ""
    eom = solution.equations
    rows = [
        (math(symbol_latex(s)), f"{a:.6g}", f"{b:.6g}", escaped(unit_text(s.unit)), escaped(s.description))
        for s, a, b in zip(eom.state, solution.states[0], solution.states[-1], strict=True)
    ]
    return table(("", f"t = {solution.t[0]:g} s", f"t = {solution.t[-1]:.6g} s", "unit", "meaning"), rows)


def frame_html(frame: Frame) -> str:
    """The parent frame, the rotation, and the direction cosines."""
    name = math(point_latex(frame.name))
    if frame.parent is None or frame.orientation is None:
        return paragraph(f"<b>Frame</b> {name}, a root: others are turned in it.")
    base, angle = point_latex(frame.parent.name), frame.orientation.angle
    by = "" if angle is None else f" by {expression(angle).cell}"
    cosines = matrix(frame.parent.dcm(frame))
    left = rf"{{}}^{{{base}}}R^{{{point_latex(frame.name)}}}"
    shown = display(f"{left} = {cosines.latex}") if cosines.latex else paragraph(f"{cosines.operations} operations")
    return paragraph(f"<b>Frame</b> {name}, turned in {math(base)}{by}") + shown


def point_html(point: Point) -> str:
    """The position from the parent point, and the frame in which the point is fixed."""
    lead = f"<b>Point</b> {math(point_latex(point.name))}"
    held = f", fixed in {math(point_latex(point.body.name))}" if point.body is not None else ""
    if point.parent is None:
        return paragraph(lead + held)
    return paragraph(f"{lead}, from {math(point_latex(point.parent.name))} by {vector(point.offset).cell}{held}")


def body_html(body: RigidBody | Particle | Beam) -> str:
    """Mass, mass centre, frame and central inertia."""
    return paragraph(f"<b>{type(body).__name__}</b>") + declared(SimpleNamespace(bodies=(body,)), "bodies")


def load_html(load: Load) -> str:
    """Forces and torques with their places, and the potential energy."""
    energy = "" if load.potential is None else paragraph(f"Potential energy: {expression(load.potential).cell}")
    return paragraph(f"<b>Load</b> {escaped(load.name)}: {acting(load)}") + energy


def constraint_html(constraint: Constraint) -> str:
    """The function that vanishes, and its forces."""
    return paragraph("<b>Constraint</b>") + declared(SimpleNamespace(constraints=(constraint,)), "constraints")


def state_html(state: State) -> str:
    """The values of each group."""
    groups = [(title, getattr(state, kind)) for kind, title in GROUPS.items()]
    rows = [(title, cell(values)) for title, values in [*groups, ("t", state.t)]]
    return paragraph("<b>State</b>") + table(("", ""), [row for row in rows if row[1]])


def assembled_html(found: Assembled) -> str:
    """The state with the residual of the constraints."""
    branch = f"; {escaped(found.branch)}" if found.branch else ""
    return paragraph(f"<b>Assembled</b>: residual {found.residual:.1e}{branch}") + mapping_html({**found.q, **found.u})


def mode_html(mode: Mode) -> str:
    """Eigenvalue, frequency, damping, shape."""
    lead = f"<b>Mode</b>: {mode.frequency:.5g} rad/s, damping {mode.damping:.4g}, eigenvalue {mode.eigenvalue:.6g}"
    return paragraph(lead) + paragraph(f"shape: {escaped(largest(mode.shape))}")


def normal_modes_html(modes: NormalModes) -> str:
    """A row for each coordinate, a column for each mode."""
    heads = [
        f"{w:.5g} rad/s" if s > 0 else f"λ = {s:.3g} 1/s²"
        for w, s in zip(modes.frequencies, modes.squares, strict=True)
    ]
    rows = [
        (math(latex_name(name)), *(f"{v:.5g}" for v in row))
        for name, row in zip(modes.names, modes.shapes, strict=True)
    ]
    return paragraph("<b>Normal modes</b>") + table(("", *heads), rows)
