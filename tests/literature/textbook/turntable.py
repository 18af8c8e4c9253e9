# SPDX-License-Identifier: BSD-3-Clause
"""A homogeneous sphere on a turntable: its centre runs on a circle at 2/7 of the table's rate.

Neimark, J. I., Fufaev, N. A. (1972), Dynamics of Nonholonomic Systems, AMS; Weltner, K. (1979), Am. J. Phys. 47, 984-986.
"""

import kane as kn
from kane.gallery import sphere_on_turntable
from tests.literature.textbook.problem import Problem


def problem() -> Problem:
    """The acceleration of the centre; the spin about the vertical stays."""
    system = sphere_on_turntable.system()
    of = {s.name: s for s in (*system.speeds, *system.parameters)}
    rate = 2 * of["Omega"] / 7
    return Problem(system, {"u̇": [-rate * of["u_y"], rate * of["u_x"], 0]})
