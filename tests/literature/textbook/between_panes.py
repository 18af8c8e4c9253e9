# SPDX-License-Identifier: BSD-3-Clause
"""Two particles on a rod between panes of glass that turn about a vertical line; one of them is a sharp-edged disk.

Kane, T. R., Levinson, D. A. (1985), Dynamics: Theory and Applications, McGraw-Hill, problems 8.16 and 10.14 (of F̃*), 11.2 (of u̇).
Solutions: https://github.com/pydy/pydy/tree/master/examples/Kane1985 (Ex10.14, Ex11.2).
"""

import kane as kn
from tests.literature.textbook.problem import Problem


def problem() -> Problem:
    """P_1 by its place in the plane B of the panes, the rod E by its angle; forces X, Y, Z of the panes and C of the rod."""
    A = kn.Frame("A")
    O = kn.Point("O", fixed_in=A)
    q1, q2, q3 = kn.coordinates("q1:4")
    omega, m1, m2, L, g = kn.parameters("omega m_1 m_2 L g", 1.0)
    X, Y, Z, C = forces = [kn.input(name) for name in "XYZC"]
    B = A.rotate("B", omega * kn.time, A.y)
    E = B.rotate("E", q3, B.z)
    P1 = O.at("P_1", q1 * B.x + q2 * B.y)
    D = P1.at("D*", L * E.x)
    glass = O.fixed_in(B, "glass", q1 * B.x + q2 * B.y + L * E.x)
    u1, u2, u3 = kn.speeds("u1:4")
    v = P1.velocity(A)
    system = kn.System(
        A,
        bodies=[kn.Particle("P_1", P1, m1), kn.Particle("P_2", D, m2)],
        speeds={u1: v.dot(E.x), u2: v.dot(E.y), u3: q3.dt},
        loads=[
            kn.gravity(-g * A.y),
            kn.Force(P1, X * B.z + C * E.x),
            kn.Force(D, Y * E.y + Z * E.z - C * E.x),
        ],
        nonholonomic=kn.no_slip(D, glass, along=E.y, name="edge"),
        dependent_speeds=(u3,),
        coordinates=(q1, q2, q3),
    )
    sin, cos = kn.sin(q3), kn.cos(q3)
    published = {
        "u̇": [
            -g * sin + omega**2 * q1 * cos + (m2 * L * omega**2 * cos**2 - m1 * u2**2 / L) / (m1 + m2),
            -g * cos - omega**2 * q1 * sin + u1 * u2 / L,
        ],
        "F̃*": [
            (m1 + m2) * (omega**2 * q1 * cos - u1.dt) - m1 * u2**2 / L + m2 * L * omega**2 * cos**2,
            -m1 * (u2.dt + omega**2 * q1 * sin - u1 * u2 / L),
        ],
    }
    return Problem(system, published, forces)
