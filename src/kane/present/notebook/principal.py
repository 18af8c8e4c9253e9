# SPDX-License-Identifier: BSD-3-Clause
"""Principal moments of inertia and their axes in a notebook."""

from kane.model.mass import Principal
from kane.present.notebook.pieces import table
from kane.present.notebook.typeset import expression, vector


def principal_html(found: Principal) -> str:
    """A row a moment."""
    rows = [(expression(i).cell, vector(n).cell) for i, n in zip(found.moments, found.axes, strict=True)]
    return table(("principal moment", "axis"), rows)
