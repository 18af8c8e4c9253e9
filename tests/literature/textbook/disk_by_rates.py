# SPDX-License-Identifier: BSD-3-Clause
"""The rolling disk by the rates of its angles.

Rolling_disc of https://github.com/cardilloproject/cardillo, after example 5.11 of a course on the dynamics of mechanical systems.
"""

import kane as kn
from tests.literature.textbook.problem import Problem


def problem() -> Problem:
    """Yaw, lean and spin; the ground's force at the particle in contact."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, y, alpha, beta, gamma = kn.coordinates("x y alpha beta gamma")
    m, r, g = kn.parameters("m r g", 1.0)
    F = [kn.input(f"F_{k}") for k in "xyz"]
    Y = N.rotate("Y", alpha, N.z)
    L = Y.rotate("L", beta, Y.x)
    D = L.rotate("D", gamma, L.y)
    center = O.at("A", x * N.x + y * N.y).at("S", r * L.z)
    contact = center.fixed_in(D, "D^", -r * L.z)
    system = kn.System(
        N,
        bodies=[kn.RigidBody("D", frame=D, mass_center=center, mass=m, inertia=kn.thin_disk(D, m, r, axis=D.y))],
        speeds="rates",
        loads=[kn.gravity(-g * N.z), kn.Force(contact, F[0] * N.x + F[1] * N.y + F[2] * N.z)],
        nonholonomic=kn.rolling(contact, normal=N.z),
        dependent_speeds=kn.speeds("u_x u_y"),
        coordinates=(x, y, alpha, beta, gamma),
    )
    a, b, c = kn.speeds("u_alpha u_beta u_gamma")
    sin, cos, A = kn.sin(beta), kn.cos(beta), m * r**2 / 4
    M = [[A * (5 * sin**2 + 1), 0, A * 6 * sin], [0, A * 5, 0], [A * 6 * sin, 0, A * 6]]
    gyroscopic = [
        A * (10 * a * b * sin * cos + 2 * b * c * cos),
        A * (-5 * a**2 * sin * cos - 6 * a * c * cos),
        A * 10 * a * b * cos,
    ]
    published = {
        "F̃": [0, A * 4 * g / r * sin, 0],
        "F̃*": [-(row[0] * a.dt + row[1] * b.dt + row[2] * c.dt) - h for row, h in zip(M, gyroscopic, strict=True)],
        "M̃": [entry for row in M for entry in row],
    }
    return Problem(system, published, F)
