# SPDX-License-Identifier: BSD-3-Clause
"""Records that a notebook shows as one table, or as a few formulas: force systems, formulations, motions, axes, sets of speeds."""

from kane.analysis.comparison import MethodComparison, SpeedComparison
from kane.dynamics.methods.base import Formulation
from kane.dynamics.motions import Motions
from kane.expr.build import add
from kane.expr.matrix import Matrix
from kane.model.force_systems import ForceSystem, Wrench
from kane.model.mass import Principal
from kane.present.notebook.typeset import escaped, expression, math, matrix, paragraph, table, vector
from kane.space.attitude import Rotation
from kane.write.latex import latex_name


def force_system_html(found: ForceSystem) -> str:
    """A row a force, and a torque."""
    rows = [(escaped(p.name), vector(f).cell, "") for p, f in found.forces]
    rows += [("", "", vector(t).cell) for t in found.torques]
    return table(("at", "force", "torque of a couple"), rows)


def wrench_html(found: Wrench) -> str:
    """Force, couple, and where the central axis is."""
    cells = (vector(found.force), vector(found.torque), vector(found.position), expression(found.pitch))
    return table(("force", "torque", "position of the central axis", "pitch"), [tuple(c.cell for c in cells)])


def formulation_html(f: Formulation) -> str:
    """The equations, each zero."""
    rows = [(str(k + 1), expression(e).cell) for k, e in enumerate(f.equations)]
    return paragraph(escaped(repr(f))) + table(("", "0 ="), rows)


def motions_html(motions: Motions) -> str:
    """A row a speed, a row a rate, a row a dependent speed."""
    system = motions.derived.system
    head = paragraph(
        f"<b>Motions</b>: {len(motions.coordinates)} coordinates, {motions.degrees_of_freedom} degrees of freedom"
    )
    speeds = [(math(latex_name(u.name)), expression(e).cell) for u, e in system.speeds.items()]
    rates = [
        (math(rf"\dot{{{latex_name(q.name)}}}"), expression(e).cell)
        for q, e in zip(motions.coordinates, motions.rates, strict=True)
    ]
    given = map(add, motions.A_n @ motions.independent_speeds, motions.b_n)
    dependent = [
        (math(latex_name(u.name)), expression(e).cell) for u, e in zip(motions.dependent_speeds, given, strict=True)
    ]
    shown = table(("speed", "definition"), speeds) + table(("rate", "by speeds"), rates)
    return head + shown + table(("dependent speed", "by the independent ones"), dependent)


def principal_html(found: Principal) -> str:
    """A row a moment."""
    rows = [(expression(i).cell, vector(n).cell) for i, n in zip(found.moments, found.axes, strict=True)]
    return table(("principal moment", "axis"), rows)


def rotation_latex(r: Rotation) -> str:
    """The matrix of direction cosines; of an array of rotations how many there are."""
    if r.shape:
        return repr(r)
    return matrix(Matrix(r.direction_cosines)).dollars("A rotation")


def comparison_html(comparison: SpeedComparison | MethodComparison) -> str:
    """The table of what is compared."""
    head, rows = comparison.table()
    return table(tuple(map(escaped, head)), [tuple(map(escaped, row)) for row in rows])
