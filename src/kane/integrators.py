# SPDX-License-Identifier: BSD-3-Clause
"""Integrators with their options: `method=kn.Gauss16(rtol=1e-10)` in the place of a name and keywords."""

from typing import TYPE_CHECKING

from kane.lazy_imports import offered as _offered
from kane.motion.integrators import (
    AdaptiveStep,
    Auto,
    Cvode,
    Dop853,
    FixedStep,
    Gauss16,
    Lsoda,
    Midpoint,
    Radau9,
    Rk4,
    ScipyBDF,
    ScipyDOP853,
    ScipyRadau,
    ScipyRK23,
    ScipyRK45,
    Tsit5,
    Tsitpap8,
    Vern9,
)

__all__ = [
    "AdaptiveStep", "Auto", "Cvode", "Dop853", "FixedStep", "Gauss16", "Lsoda", "Midpoint", "Radau9", "Rk4",
    "ScipyBDF", "ScipyDOP853", "ScipyRK23", "ScipyRK45", "ScipyRadau", "Tsit5", "Tsitpap8", "Vern9",
]  # fmt: skip

if not TYPE_CHECKING:  # checkers of types know the names; what is misspelt is answered with what resembles it
    __getattr__ = _offered(__name__, {})
