# SPDX-License-Identifier: BSD-3-Clause
"""Results to read and look at: steps as text, the report, plots."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "branch_figures": "through_meetings",
        "checks": "motion_checks",
        "formula_list": "WIDTH formulas step_text wrapped",
        "motion_plots": "level plots",
        "notebook.typeset": "ROWS either escaped listed math table",
        "provenance": "versions",
        "report": "asset chapters",
        "tables": "Tex declared_tables",
    },
)
