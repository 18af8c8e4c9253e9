# SPDX-License-Identifier: BSD-3-Clause
"""HTML of parts of a model in notebooks: frames, points, bodies, loads, constraints; states and modes."""

from types import SimpleNamespace

from kane.analysis.assembly import Assembled
from kane.analysis.linear import Mode, NormalModes
from kane.equations.state import GROUPS, State
from kane.model.beams.beam import Beam
from kane.model.bodies import Particle, RigidBody
from kane.model.constraints import Constraint
from kane.model.loads import Load
from kane.present.notebook.declared import acting, declared
from kane.present.notebook.generic import cell, mapping_html
from kane.present.notebook.record_tables import largest
from kane.present.notebook.typeset import display, escaped, expression, math, matrix, paragraph, table, vector
from kane.space.frame import Frame, Point
from kane.write.latex import latex_name, point_latex


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
