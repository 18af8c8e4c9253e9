# SPDX-License-Identifier: BSD-3-Clause
"""Results to read and look at: steps as text, the report, plots."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "mode_figures": "through_meetings",
        "check_figures": "motion_checks",
        "formula_list": "WIDTH formulas step_text wrapped",
        "motion_plots": "level plots",
        "notebook.typeset": "ROWS either escaped listed math table",
        "provenance": "versions",
        "report": "asset chapters",
        "overview": "Tex declared_tables",
    },
)
