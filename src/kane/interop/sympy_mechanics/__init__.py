# SPDX-License-Identifier: BSD-3-Clause
"""Import of models of `sympy.physics.mechanics`: input record, names, states, frames, points, speeds, system, verification."""

from kane.lazy_imports import offered

__getattr__ = offered(__name__, {"importing": "from_sympy_mechanics"})
