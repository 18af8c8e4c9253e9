# SPDX-License-Identifier: BSD-3-Clause
"""A disk that rolls upright and is driven and steered by torques.

Bloch, A. M. (2003), Nonholonomic Mechanics and Control, Springer, sec. 1.4. Constraints, energy and motion too:
VerticalRollingDisk of https://github.com/olivierverdier/odelab (odelab/system/nonholonomic).
"""

import kane as kn
from tests.literature.textbook.problem import Problem


def problem() -> Problem:
    """The contact by x and y, the heading phi, the roll theta; forces of the ground on the particle in contact."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, phi, theta = kn.coordinates("x y phi theta")
    m, R, I, J = kn.parameters("m R I J", 1.0)
    drive, steer, along, across = kn.input("tau_1"), kn.input("tau_2"), kn.input("F_1"), kn.input("F_2")
    A = N.rotate("A", phi, N.z)
    D = A.rotate("D", theta, A.y)
    center = O.at("P", x * N.x + y * N.y).at("C", R * N.z)
    contact = center.fixed_in(D, "C^", -R * N.z)
    a, b, spin, turn = kn.speeds("a b u_theta u_phi")
    system = kn.System(
        N,
        bodies=[kn.RigidBody("disk", frame=D, mass_center=center, mass=m, inertia=kn.inertia(D, J, I, J))],
        speeds={spin: theta.dt, turn: phi.dt, a: x.dt, b: y.dt},
        loads=[kn.Torque(D, drive * A.y + steer * N.z), kn.Force(contact, along * A.x + across * A.y)],
        nonholonomic=kn.rolling(contact, normal=N.z),
        dependent_speeds=(a, b),
        coordinates=(x, y, phi, theta),
    )
    published = {
        "u̇": [drive / (I + m * R**2), steer / J],
        "K": [((I + m * R**2) * spin**2 + J * turn**2) / 2],
    }
    return Problem(system, published, [along, across])
