# SPDX-License-Identifier: BSD-3-Clause
"""Sets of speeds side by side in a notebook."""

from kane.analysis.compare_speeds import SpeedComparison
from kane.present.notebook.pieces import escaped, table


def speeds_html(comparison: SpeedComparison) -> str:
    """The table of the sets."""
    head, rows = comparison.table()
    return table(tuple(map(escaped, head)), [tuple(map(escaped, row)) for row in rows])
