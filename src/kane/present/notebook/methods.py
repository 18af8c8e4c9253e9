# SPDX-License-Identifier: BSD-3-Clause
"""Methods, and formulations by them, in a notebook."""

from kane.analysis.compare_methods import MethodComparison
from kane.dynamics.methods.formulation import Formulation
from kane.present.notebook.pieces import escaped, paragraph, table
from kane.present.notebook.typeset import expression


def methods_html(comparison: MethodComparison) -> str:
    """The table of the methods."""
    head, rows = comparison.table()
    return table(tuple(map(escaped, head)), [tuple(map(escaped, row)) for row in rows])


def formulation_html(f: Formulation) -> str:
    """The equations, each zero."""
    rows = [(str(k + 1), expression(e).cell) for k, e in enumerate(f.equations)]
    return paragraph(escaped(repr(f))) + table(("", "0 ="), rows)
