# SPDX-License-Identifier: BSD-3-Clause
"""Presentation of results: steps as text, reports, sketches, plots and animations."""

from kane.lazy_imports import offered

__getattr__ = offered(
    __name__,
    {
        "first_screen": "multiplied_out screen_of terms",
        "linearized.branch_figures": "through_meetings",
        "figure": "spread",
        "traces": "bend size_of_terms",
        "check_figures": "motion_checks",
        "formula_list": "WIDTH formulas step_text wrapped",
        "motion_plots": "COLOURS level plots",
        "notebook.typeset": "ROWS either escaped listed math table",
        "pages": "asset environment",
        "languages.catalogue": "LANGUAGES tr spoken",
        "provenance": "versions",
        "chapters": "chapters_of",
        "document.latex_file": "math_latex text_latex",
        "document.line_breaks": "broken_lines em_width",
        "other_methods": "why_kane",
        "sketch.camera": "view_of",
        "sketch.draw": "NARROW WIDE draw_each",
        "sketch.labels": "GAP Label placed point_name product series spans unit_vector width_of",
        "sketch.outlines": "hull mesh",
        "sketch.pose": "pose_of",
        "sketch.svg": "DARK LIGHT TEXT looks style",
        "overview": "DECLARED Tex declared_tables meaning",
        "viewer.meshes": "SIZED UNIT read",
        "viewer.parts": "transforms",
    },
)
