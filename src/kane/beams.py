# SPDX-License-Identifier: BSD-3-Clause
"""Flexible beams and their mode shapes."""

from typing import TYPE_CHECKING

from kane.lazy_imports import offered as _offered
from kane.model.beams.beam import Beam
from kane.model.beams.deformation import tapered
from kane.model.beams.shape_functions import ModeShapes, mode_shapes

__all__ = ["Beam", "ModeShapes", "mode_shapes", "tapered"]

if not TYPE_CHECKING:  # checkers of types know the names; what is misspelt is answered with what resembles it
    __getattr__ = _offered(__name__, {})
