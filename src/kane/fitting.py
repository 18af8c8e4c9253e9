# SPDX-License-Identifier: BSD-3-Clause
"""Sensitivities of motions, estimation of parameters from measurements, shooting, and inertial regressors."""

from typing import TYPE_CHECKING

from kane.analysis.inertial_regressor import BaseParameters, Regressor, regressor
from kane.lazy_imports import offered as _offered
from kane.motion.derivatives.motion_derivatives import AdjointSensitivities, Cost, Sensitivities
from kane.motion.fitting.fit import fit
from kane.motion.fitting.found import Fit
from kane.motion.fitting.sensitivities import sensitivities
from kane.motion.fitting.shoot import Curve, Shot, curve, shoot

__all__ = [
    "AdjointSensitivities", "BaseParameters", "Cost", "Curve", "Fit", "Regressor", "Sensitivities", "Shot",
    "curve", "fit", "regressor", "sensitivities", "shoot",
]  # fmt: skip

if not TYPE_CHECKING:  # checkers of types know the names; what is misspelt is answered with what resembles it
    __getattr__ = _offered(__name__, {})
