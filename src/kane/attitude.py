# SPDX-License-Identifier: BSD-3-Clause
"""Rotations in numbers: Euler parameters, angles, direction cosines."""

from kane.space.attitude import Rotation, small_rotation

__all__ = ["Rotation", "small_rotation"]
