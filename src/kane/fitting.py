# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of motions, and what follows from them."""

from kane.motion.derivatives.sensitivities import Sensitivities, sensitivities

__all__ = ["Sensitivities", "sensitivities"]
