# SPDX-License-Identifier: BSD-3-Clause
"""Models of `sympy.physics.mechanics`: what is given, names, states, frames, points, speeds, the system, the check."""

from kane.lazy_imports import offered

__getattr__ = offered(__name__, {"importing": "from_sympy_mechanics"})
