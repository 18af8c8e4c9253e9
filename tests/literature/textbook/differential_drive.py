# SPDX-License-Identifier: BSD-3-Clause
"""A robot with two driven wheels, by its own speeds and by those of its wheels.

Dhaouadi, R., Abu Hatab, A. (2013), Dynamic modelling of differential-drive mobile robots using Lagrange and Newton-Euler
methodologies: a unified framework, Adv. Robot. Autom. 2:107, doi 10.4172/2168-9695.1000107. The same formulas: models/ddmr.py of
https://github.com/asarmadi/Differential_Drive_Mobile_Robot.
"""

from collections.abc import Mapping
from typing import Any

import kane as kn
from tests.literature.textbook.problem import Problem

m_c, m_w, I_c, I_w, I_m = kn.parameters("m_c m_w I_c I_w I_m")
R, L, d = kn.parameters("R L d", 0.5)
right, left = kn.input("tau_R"), kn.input("tau_L")
m = m_c + 2 * m_w
I = I_c + m_c * d**2 + 2 * m_w * L**2 + 2 * I_m
v, s, w, w_R, w_L = kn.speeds("v s w w_R w_L")


def system(dependent: tuple[kn.Speed, ...]) -> kn.System:
    """The platform with its mass centre d ahead of the axle, and its wheels L beside it."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, theta, of_right, of_left = kn.coordinates("x y theta phi_R phi_L")
    A = N.rotate("A", theta, N.z)
    P = O.at("P", x * N.x + y * N.y)
    bodies = [
        kn.RigidBody(
            "platform", frame=A, mass_center=P.at("G", d * A.x), mass=m_c, inertia=kn.inertia(A, I_c, I_c, I_c)
        )
    ]
    loads = []
    held: list[kn.Constraint] = [*kn.no_slip(P, along=A.y, name="across")]
    for name, angle, side, torque in (("right", of_right, -L, right), ("left", of_left, L, left)):
        frame = A.rotate(name, angle, A.y)
        center = P.at(f"center of {name}", side * A.y)
        bodies.append(
            kn.RigidBody(name, frame=frame, mass_center=center, mass=m_w, inertia=kn.inertia(frame, I_m, I_w, I_m))
        )
        held += kn.no_slip(center.fixed_in(frame, f"{name}^", -R * A.z), along=A.x, name=name)
        loads += [kn.Torque(frame, torque * A.y), kn.Torque(A, -torque * A.y)]
    velocity = P.velocity(N)
    speeds: Mapping[kn.Speed, Any] = {
        v: velocity.dot(A.x), s: velocity.dot(A.y), w: theta.dt, w_R: of_right.dt, w_L: of_left.dt
    }  # fmt: skip
    return kn.System(
        N,
        bodies=bodies,
        speeds=speeds,
        loads=loads,
        nonholonomic=held,
        dependent_speeds=dependent,
        coordinates=(x, y, theta, of_right, of_left),
    )


def by_its_own_speeds() -> Problem:
    """v and ω (Newton and Euler)."""
    u_dot = [
        R**2 / (m * R**2 + 2 * I_w) * (m_c * d * w**2 + (right + left) / R),
        R**2 / (I * R**2 + 2 * I_w * L**2) * (-m_c * d * w * v + L / R * (right - left)),
    ]
    return Problem(system((s, w_R, w_L)), {"u̇": u_dot})


def by_its_wheels() -> Problem:
    """The mass matrix of the wheels' speeds (Lagrange)."""
    on = I_w + R**2 / (4 * L**2) * (m * L**2 + I)
    off = R**2 / (4 * L**2) * (m * L**2 - I)
    return Problem(system((v, s, w)), {"M̃": [on, off, off, on]})
