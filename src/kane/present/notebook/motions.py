# SPDX-License-Identifier: BSD-3-Clause
"""Motions of frames and points in a notebook: speeds with their definitions, rates, and what constraints give."""

from kane.dynamics.motions import Motions
from kane.expr.build import add
from kane.present.notebook.pieces import math, paragraph, table
from kane.present.notebook.typeset import expression
from kane.write.latex import latex_name


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
