# SPDX-License-Identifier: BSD-3-Clause
"""Derivatives of motions, and what follows from them."""

from kane.motion.derivatives.sensitivities import Sensitivities, sensitivities
from kane.motion.fitting.fit import Fit, fit

__all__ = ["Fit", "Sensitivities", "fit", "sensitivities"]
