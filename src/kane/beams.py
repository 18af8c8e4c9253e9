# SPDX-License-Identifier: BSD-3-Clause
"""Flexible beams and their mode shapes."""

from kane.model.beams.beam import Beam
from kane.model.beams.deformation import tapered
from kane.model.beams.shapes import ModeShapes, mode_shapes

__all__ = ["Beam", "ModeShapes", "mode_shapes", "tapered"]
