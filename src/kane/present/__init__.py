# SPDX-License-Identifier: BSD-3-Clause
"""Results to read and look at: steps as text, the report, plots."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "checks": "motion_checks",
        "formula_list": "formulas",
        "motion_plots": "level plots",
        "notebook.pieces": "ROWS either escaped listed math table",
        "report": "asset",
        "report_chapters": "chapters",
        "root_locus": "through_meetings",
        "tables": "Tex declared_tables",
        "text": "WIDTH step_text wrapped",
        "version_list": "versions",
    },
)
