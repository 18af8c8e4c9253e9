# SPDX-License-Identifier: BSD-3-Clause
"""A thin uniform disk that rolls on a horizontal plane.

Kane, T. R., Levinson, D. A. (1985), Dynamics: Theory and Applications, McGraw-Hill, problems 8.3 (of F̃), 10.2 (of K) and 11.5 (of u̇).
Solutions: https://github.com/pydy/pydy/tree/master/examples/Kane1985 (Ex10.2, Ex11.5), and test_sub_qdot2 of
sympy/physics/mechanics/tests/test_kane2.py.
"""

import kane as kn
from tests.literature.textbook.problem import Problem


def problem() -> Problem:
    """The disk by yaw, lean, spin and the contact's place; the ground's force P at the particle in contact."""
    A = kn.Frame("A")
    O = kn.Point("O", fixed_in=A)
    q1, q2, q3, q4, q5 = kn.coordinates("q1:6")
    m, R, g = kn.parameters("m R g", 1.0)
    P = [kn.input(name) for name in ("P_x", "P_y", "P_z")]
    Y = A.rotate("B'", q1, A.z)
    B = Y.rotate("B", kn.pi / 2 - q2, Y.x)
    C = B.rotate("C", q3, B.z)
    center = O.at("R", q4 * A.x + q5 * A.y).at("C*", R * B.y)
    contact = center.fixed_in(C, "C^", -R * B.y)
    u1, u2, u3, u4, u5 = kn.speeds("u1:6")
    w = C.angular_velocity(A)
    system = kn.System(
        A,
        bodies=[kn.RigidBody("C", frame=C, mass_center=center, mass=m, inertia=kn.thin_disk(C, m, R, axis=C.z))],
        speeds={u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z), u4: q4.dt, u5: q5.dt},
        loads=[kn.gravity(-g * A.z), kn.Force(contact, P[0] * A.x + P[1] * A.y + P[2] * A.z)],
        nonholonomic=kn.rolling(contact, normal=A.z),
        dependent_speeds=(u4, u5),
        coordinates=(q1, q2, q3, q4, q5),
    )
    tan = kn.tan(q2)
    published = {
        "u̇": [(u2**2 * tan - 6 * u2 * u3 - 4 * g * kn.sin(q2) / R) / 5, 2 * u3 * u1 - u1 * u2 * tan, 2 * u1 * u2 / 3],
        "F̃": [-R * g * m * kn.sin(q2), 0, 0],
        "K": [m * R**2 / 8 * (5 * u1**2 + u2**2 + 6 * u3**2)],
    }
    return Problem(system, published, P)
