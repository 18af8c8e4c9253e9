# SPDX-License-Identifier: BSD-3-Clause
"""Sketches, figures and reports."""

from typing import TYPE_CHECKING

from kane.lazy_imports import offered

if TYPE_CHECKING:
    from kane.present.analysis_figures import beam_figure, cycle_figure, energy_balance, fit_figure, mode_figure
    from kane.present.animation import Animation, animate
    from kane.present.check_figures import Check
    from kane.present.figure import plot
    from kane.present.linearized.branch_figures import campbell_diagram, root_locus
    from kane.present.report import report
    from kane.present.scene.gather import scene
    from kane.present.scene.records import Scene
    from kane.present.scene.shapes import BodyShape, link_shapes, shape
    from kane.present.sketch.draw import Sketch, sketch

__getattr__ = offered(
    __name__,
    {
        ".present.animation": "Animation animate",
        ".present.analysis_figures": "beam_figure cycle_figure energy_balance fit_figure mode_figure",
        ".present.check_figures": "Check",
        ".present.figure": "plot",
        ".present.linearized.branch_figures": "campbell_diagram root_locus",
        ".present.report": "report",
        ".present.scene.gather": "scene",
        ".present.scene.records": "Scene",
        ".present.scene.shapes": "BodyShape link_shapes shape",
        ".present.sketch.draw": "Sketch sketch",
    },
)
"""What draws is imported when it is first used: a shape needs no library for plots."""

__all__ = [
    "Animation", "BodyShape", "Check", "Scene", "Sketch", "animate", "beam_figure", "campbell_diagram",
    "cycle_figure", "energy_balance", "fit_figure", "link_shapes", "mode_figure", "plot", "report", "root_locus",
    "scene", "shape", "sketch",
]  # fmt: skip
