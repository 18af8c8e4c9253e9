# SPDX-License-Identifier: BSD-3-Clause
"""Rotations, symbolic and numerical: Euler parameters, angles, direction cosines."""

from typing import TYPE_CHECKING

from kane.lazy_imports import offered as _offered
from kane.space.attitude import Rotation, small_rotation

__all__ = ["Rotation", "small_rotation"]

if not TYPE_CHECKING:  # checkers of types know the names; what is misspelt is answered with what resembles it
    __getattr__ = _offered(__name__, {})
