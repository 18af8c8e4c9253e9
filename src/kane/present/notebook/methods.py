# SPDX-License-Identifier: BSD-3-Clause
"""Formulations by a method in a notebook."""

from kane.dynamics.methods.formulation import Formulation
from kane.present.notebook.pieces import escaped, paragraph, table
from kane.present.notebook.typeset import expression


def formulation_html(f: Formulation) -> str:
    """The equations, each zero."""
    rows = [(str(k + 1), expression(e).cell) for k, e in enumerate(f.equations)]
    return paragraph(escaped(repr(f))) + table(("", "0 ="), rows)
