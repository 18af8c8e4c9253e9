# SPDX-License-Identifier: BSD-3-Clause
"""The classical Runge–Kutta method of order 4 with fixed steps and a cubic Hermite interpolant.

Source: Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, 2nd ed. 1993, sec. II.1, II.6.
"""

from kane.motion.steppers.tableau import Tableau, hermite

_B = (1 / 6, 1 / 3, 1 / 3, 1 / 6)
RK4 = Tableau("rk4", 4, (0.0, 0.5, 0.5, 1.0), ((0.5,), (0.0, 0.5), (0.0, 0.0, 1.0)), _B, (), 1 / 4, (), hermite(_B))
"""Four evaluations per step."""
