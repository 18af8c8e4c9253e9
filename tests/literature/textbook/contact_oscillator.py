# SPDX-License-Identifier: BSD-3-Clause
"""A particle on springs whose velocity is held by ẋ + y ż = 0.

McLachlan, R., Perlmutter, M. (2006), Integrators for nonholonomic mechanical systems, J. Nonlinear Sci. 16, 283-328, sec. 5.2; its
multiplier is written out in ContactOscillator of https://github.com/olivierverdier/odelab (odelab/system/nonholonomic).
"""

import kane as kn
from tests.literature.textbook.problem import Problem


def problem() -> Problem:
    """Of unit mass; V = (x² + y² + z² + ε x² z²)/2."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, z = kn.coordinates("x y z")
    eps = kn.parameter("epsilon", 0.1)
    P = O.at("P", x * N.x + y * N.y + z * N.z)
    u_x, u_y, u_z = kn.speeds("u_x u_y u_z")
    springs = -(x + eps * x * z**2) * N.x - y * N.y - (z + eps * x**2 * z) * N.z
    system = kn.System(
        N,
        bodies=[kn.Particle("particle", P, 1)],
        speeds={u_x: x.dt, u_y: y.dt, u_z: z.dt},
        loads=[kn.Force(P, springs)],
        nonholonomic=[kn.motion_constraint("contact", x.dt + y * z.dt)],
        dependent_speeds=(u_x,),
        coordinates=(x, y, z),
    )
    multiplier = (x + y * z - u_y * u_z + eps * (x * z**2 + x**2 * y * z)) / (1 + y**2)
    return Problem(system, {"u̇": [-y, -z - eps * x**2 * z + y * multiplier]})
