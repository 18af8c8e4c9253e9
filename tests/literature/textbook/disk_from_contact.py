# SPDX-License-Identifier: BSD-3-Clause
"""The rolling disk once more, by other angles and by components along the axes that lean with it.

SymPy, test_rolling_disc of sympy/physics/mechanics/tests/test_kane.py, https://github.com/sympy/sympy.
"""

import kane as kn
from tests.literature.textbook.problem import Problem


def problem() -> Problem:
    """Yaw about z, lean about x, spin about y; the ground's force at the particle in contact."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1, q2, q3, x, y = kn.coordinates("q1 q2 q3 x y")
    r, m, g = kn.parameters("r m g", 1.0)
    F = [kn.input(f"F_{k}") for k in "xyz"]
    Y = N.rotate("Y", q1, N.z)
    L = Y.rotate("L", q2, Y.x)
    D = L.rotate("D", q3, L.y)
    center = O.at("C", x * N.x + y * N.y).at("D*", r * L.z)
    contact = center.fixed_in(D, "D^", -r * L.z)
    u1, u2, u3, u4, u5 = kn.speeds("u1:6")
    w = D.angular_velocity(N)
    system = kn.System(
        N,
        bodies=[kn.RigidBody("D", frame=D, mass_center=center, mass=m, inertia=kn.thin_disk(D, m, r, axis=D.y))],
        speeds={u1: w.dot(L.x), u2: w.dot(L.y), u3: w.dot(L.z), u4: x.dt, u5: y.dt},
        loads=[kn.gravity(-g * N.z), kn.Force(contact, F[0] * N.x + F[1] * N.y + F[2] * N.z)],
        nonholonomic=kn.rolling(contact, normal=N.z),
        dependent_speeds=(u4, u5),
        coordinates=(q1, q2, q3, x, y),
    )
    tan = kn.tan(q2)
    u_dot = [
        (6 * u2 * u3 * r - u3**2 * r * tan + 4 * g * kn.sin(q2)) / (5 * r),
        -2 * u1 * u3 / 3,
        u1 * (-2 * u2 + u3 * tan),
    ]
    return Problem(system, {"u̇": u_dot}, F)
