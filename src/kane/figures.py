# SPDX-License-Identifier: BSD-3-Clause
"""Sketches, figures and reports."""

from kane.present.animation import Animation, animate
from kane.present.check_figures import Check
from kane.present.figure import plot
from kane.present.mode_figures import beam_figure, campbell_diagram, mode_figure, root_locus
from kane.present.report import report
from kane.present.scene.gather import scene
from kane.present.scene.records import Action, Item, Mark, Movement, Posed, Scene, Triad
from kane.present.scene.shapes import BodyShape, shape
from kane.present.sketch.draw import Sketch, sketch

__all__ = [
    "Action",
    "Animation",
    "BodyShape",
    "Check",
    "Item",
    "Mark",
    "Movement",
    "Posed",
    "Scene",
    "Sketch",
    "Triad",
    "animate",
    "beam_figure",
    "campbell_diagram",
    "mode_figure",
    "plot",
    "report",
    "root_locus",
    "scene",
    "shape",
    "sketch",
]
