# SPDX-License-Identifier: BSD-3-Clause
"""Figures and reports."""

from kane.present.beam_figures import beam_figure, mode_figure
from kane.present.branch_figures import campbell_diagram, root_locus
from kane.present.checks import Check
from kane.present.figure import plot
from kane.present.report import report

__all__ = [
    "Check",
    "beam_figure",
    "campbell_diagram",
    "mode_figure",
    "plot",
    "report",
    "root_locus",
]
