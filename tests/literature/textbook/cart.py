# SPDX-License-Identifier: BSD-3-Clause
"""A cart with two wheels on an inclined plane.

Kane, T. R., Levinson, D. A. (1985), Dynamics: Theory and Applications, McGraw-Hill, problems 8.12 (of F̃), 8.17 (of F̃*) and
11.4 (of u̇), with wheels that are uniform disks 10.12 (of M). Solutions:
https://github.com/pydy/pydy/tree/master/examples/Kane1985 (Ex10.12, Ex11.4), and test_sub_qdot of
sympy/physics/mechanics/tests/test_kane2.py.
"""

from typing import Any

import kane as kn
from tests.literature.textbook.problem import Problem

R, a, b, e, f, theta = kn.parameters("R a b e f theta", 0.5)
m_A, m_B, M, g = kn.parameters("m_A m_B M g", 1.0)
I_A, I_22, I_33, I_23, J, K = kn.parameters("I_A I_22 I_33 I_23 J K")
Q = [kn.input(name) for name in ("Q_1", "Q_2", "Q_3")]
q1, q2, q3, q4, q5 = kn.coordinates("q1:6")
u1, u2, u3, u4, u5 = kn.speeds("u1:6")


def system(axial: Any = J, across: Any = K) -> kn.System:
    """The cart A, its wheels B and C, the centre D of their axle, and a contact Q that slides with the plane's force Q_1, Q_2, Q_3."""
    F = kn.Frame("F")
    O = kn.Point("O", fixed_in=F)
    P = F.rotate("P", -theta, F.y)
    A = P.rotate("A", q1, P.x)
    D = O.at("D", q2 * P.y + q3 * P.z)
    wheels: list[kn.RigidBody] = []
    held: list[kn.Constraint] = []
    for name, angle, side in (("B", q4, -b), ("C", q5, b)):
        frame = A.rotate(name, angle, A.z)
        center = D.at(f"{name}*", side * A.z)
        inertia = kn.inertia(frame, across, across, axial)
        wheels.append(kn.RigidBody(name, frame=frame, mass_center=center, mass=m_B, inertia=inertia))
        held += kn.no_slip(center.fixed_in(frame, f"{name}^", -R * A.x), along=A.y, name=f"{name}^")
    inertia = kn.inertia(A, I_A, I_22, I_33, 0, I_23, 0)
    body = kn.RigidBody("A", frame=A, mass_center=D.at("A*", a * A.y), mass=m_A, inertia=inertia)
    v = D.velocity(F)
    return kn.System(
        F,
        bodies=[body, *wheels],
        speeds={u1: q1.dt, u2: v.dot(A.y), u3: v.dot(A.z), u4: q4.dt, u5: q5.dt},
        loads=[
            kn.Force(D.at("S*", e * A.y), -M * g * F.x),
            kn.Force(D.at("Q", f * A.y - R * A.x), Q[0] * A.x + Q[1] * A.y + Q[2] * A.z),
        ],
        nonholonomic=[*held, *kn.no_slip(D, along=A.z, name="D")],
        dependent_speeds=(u3, u4, u5),
        coordinates=(q1, q2, q3, q4, q5),
    )


def problem() -> Problem:
    """u̇, F̃ and F̃*: of the force at Q the normal part Q_1 contributes nothing."""
    first = I_A + 2 * J * b**2 / R**2 + 2 * K + m_A * a**2 + 2 * m_B * b**2
    second = m_A + 2 * m_B + 2 * J / R**2
    F1 = f * Q[2] + M * g * e * kn.sin(theta) * kn.cos(q1)
    F2 = Q[1] + M * g * kn.sin(theta) * kn.sin(q1)
    published = {
        "u̇": [(F1 - m_A * a * u1 * u2) / first, (F2 + m_A * a * u1**2) / second],
        "F̃": [F1, F2],
        "F̃*": [-first * u1.dt - m_A * a * u1 * u2, -second * u2.dt + m_A * a * u1**2],
    }
    return Problem(system(), published, Q[:1])


def with_uniform_wheels() -> Problem:
    """m_rs."""
    m = [I_A + m_A * a**2 + m_B * (R**2 / 2 + 3 * b**2), 0, 0, m_A + 3 * m_B]
    return Problem(system(m_B * R**2 / 2, m_B * R**2 / 4), {"M̃": m}, Q[:1])
