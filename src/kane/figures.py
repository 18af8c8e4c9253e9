# SPDX-License-Identifier: BSD-3-Clause
"""Figures and reports."""

from kane.present.beam_figures import beam_figure, mode_figure
from kane.present.campbell import campbell_diagram
from kane.present.checks import Check
from kane.present.figure import plot
from kane.present.report import report
from kane.present.root_locus import root_locus

__all__ = [
    "Check",
    "beam_figure",
    "campbell_diagram",
    "mode_figure",
    "plot",
    "report",
    "root_locus",
]
