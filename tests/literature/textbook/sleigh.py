# SPDX-License-Identifier: BSD-3-Clause
"""Chaplygin's sleigh, with a force of the ground on its blade.

Bloch, A. M. (2003), Nonholonomic Mechanics and Control, Springer, sec. 1.7; quoted in
https://mathematica.stackexchange.com/questions/162070. K as in Neimark, J. I., Fufaev,
N. A. (1972), Dynamics of Nonholonomic Systems, AMS, ch. II.
"""

import kane as kn
from tests.literature.textbook.problem import Problem


def problem() -> Problem:
    """The blade by x, y and the heading; the mass centre a ahead of it."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, theta = kn.coordinates("x y theta")
    m, J, a = kn.parameters("m I a", 1.0)
    S = kn.input("S")
    A = N.rotate("A", theta, N.z)
    P = O.at("P", x * N.x + y * N.y)
    sleigh = kn.RigidBody("sleigh", frame=A, mass_center=P.at("G", a * A.x), mass=m, inertia=kn.inertia(A, J, J, J))
    v, s, w = kn.speeds("v s w")
    velocity = P.velocity(N)
    system = kn.System(
        N,
        bodies=[sleigh],
        speeds={v: velocity.dot(A.x), s: velocity.dot(A.y), w: theta.dt},
        loads=[kn.Force(P, S * A.y)],
        nonholonomic=kn.no_slip(P, along=A.y, name="edge"),
        dependent_speeds=(s,),
        coordinates=(x, y, theta),
    )
    published = {
        "u̇": [a * w**2, -m * a / (J + m * a**2) * v * w],
        "K": [(m * v**2 + (J + m * a**2) * w**2) / 2],
    }
    return Problem(system, published, [S])
