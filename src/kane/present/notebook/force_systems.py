# SPDX-License-Identifier: BSD-3-Clause
"""Sets of bound vectors and wrenches in a notebook."""

from kane.model.force_systems import ForceSystem, Wrench
from kane.present.notebook.pieces import escaped, table
from kane.present.notebook.typeset import expression, vector


def force_system_html(found: ForceSystem) -> str:
    """A row a force, and a torque."""
    rows = [(escaped(p.name), vector(f).cell, "") for p, f in found.forces]
    rows += [("", "", vector(t).cell) for t in found.torques]
    return table(("at", "force", "torque of a couple"), rows)


def wrench_html(found: Wrench) -> str:
    """Force, couple, and where the central axis is."""
    cells = (vector(found.force), vector(found.torque), vector(found.position), expression(found.pitch))
    return table(("force", "torque", "position of the central axis", "pitch"), [tuple(c.cell for c in cells)])
