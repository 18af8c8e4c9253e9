# SPDX-License-Identifier: BSD-3-Clause
"""Sets of speeds, or methods, side by side in a notebook."""

from kane.analysis.comparison import MethodComparison, SpeedComparison
from kane.present.notebook.pieces import escaped, table


def comparison_html(comparison: SpeedComparison | MethodComparison) -> str:
    """The table of what is compared."""
    head, rows = comparison.table()
    return table(tuple(map(escaped, head)), [tuple(map(escaped, row)) for row in rows])
