# SPDX-License-Identifier: BSD-3-Clause
"""Figures and reports."""

from kane.present.check_figures import Check
from kane.present.figure import plot
from kane.present.mode_figures import beam_figure, campbell_diagram, mode_figure, root_locus
from kane.present.report import report

__all__ = ["Check", "beam_figure", "campbell_diagram", "mode_figure", "plot", "report", "root_locus"]
