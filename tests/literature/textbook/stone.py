# SPDX-License-Identifier: BSD-3-Clause
"""The rattleback (a stone, a celt): an ellipsoid that rolls on a plane, its mass distributed askew.

Kane, T. R., Levinson, D. A. (1982), Realistic mathematical modeling of the rattleback, Int. J. Non-Linear Mechanics 17, 175-186,
eqs. 16 to 70. They are written out in rattleback/cpp/reproduceKane1982.cc of https://github.com/pydy/pydy_examples, where ζ₁ has v₂
in the place of v₃.
"""

import kane as kn
from tests.literature.textbook.problem import Problem

a, b, c, h, M, g = kn.parameters("a b c h M g", 1.0)
A, B, C, D = kn.parameters("A B C D")
gamma, alpha, beta, x, y = kn.coordinates("gamma alpha beta x y")
w1, w2, w3, u4, u5 = kn.speeds("omega_1 omega_2 omega_3 u_4 u_5")
P = [kn.input(name) for name in ("P_1", "P_2", "P_3")]


def system() -> kn.System:
    """z points down; the mass centre lies h below the ellipsoid's. The plane's force P acts on the particle in contact."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    Y = N.rotate("Y", gamma, N.z)
    L = Y.rotate("L", alpha, Y.x)
    S = L.rotate("S", beta, L.y)
    mu = [N.z.dot(e) for e in (S.x, S.y, S.z)]
    size = kn.sqrt((a * mu[0]) ** 2 + (b * mu[1]) ** 2 + (c * mu[2]) ** 2)
    down = (a**2 * mu[0] * S.x + b**2 * mu[1] * S.y + c**2 * mu[2] * S.z) / size
    center = O.at("X", x * N.x + y * N.y).at("E", -down)
    contact = center.fixed_in(S, "S^", down)
    stone = kn.RigidBody("S", frame=S, mass_center=center.at("S*", h * S.z), mass=M, inertia=kn.inertia(S, A, B, C, D))
    w = S.angular_velocity(N)
    return kn.System(
        N,
        bodies=[stone],
        speeds={w1: w.dot(S.x), w2: w.dot(S.y), w3: w.dot(S.z), u4: x.dt, u5: y.dt},
        loads=[kn.gravity(g * N.z), kn.Force(contact, P[0] * N.x + P[1] * N.y + P[2] * N.z)],
        nonholonomic=kn.rolling(contact, normal=-N.z),
        dependent_speeds=(u4, u5),
        coordinates=(gamma, alpha, beta, x, y),
    )


def problem() -> Problem:
    """F̃ by (47) to (49), F̃* by (53) to (66), u̇ by (69) and (70)."""
    m1, m2, m3 = -kn.cos(alpha) * kn.sin(beta), kn.sin(alpha), kn.cos(alpha) * kn.cos(beta)
    m1_dot, m2_dot, m3_dot = w3 * m2 - w2 * m3, w1 * m3 - w3 * m1, w2 * m1 - w1 * m2
    size = kn.sqrt((a * m1) ** 2 + (b * m2) ** 2 + (c * m3) ** 2)
    size_dot = (a * a * m1 * m1_dot + b * b * m2 * m2_dot + c * c * m3 * m3_dot) / size
    x1, x2, x3 = a * a * m1 / size, b * b * m2 / size, c * c * m3 / size
    v1, v2, v3 = w2 * (h - x3) + w3 * x2, -w3 * x1 - w1 * (h - x3), -w1 * x2 + w2 * x1
    x1_dot, x2_dot, x3_dot = (
        k * k * (size * m_dot - size_dot * m) / (size * size)
        for k, m, m_dot in ((a, m1, m1_dot), (b, m2, m2_dot), (c, m3, m3_dot))
    )
    z1 = w2 * (v3 - x3_dot) - w3 * (v2 - x2_dot)
    z2 = w3 * (v1 - x1_dot) - w1 * (v3 - x3_dot)
    z3 = w1 * (v2 - x2_dot) - w2 * (v1 - x1_dot)
    F = [M * g * ((x3 - h) * m2 - x2 * m3), M * g * ((h - x3) * m1 + x1 * m3), M * g * (x2 * m1 - x1 * m2)]
    R = [(D * w1 + (B - C) * w2) * w3, ((C - A) * w1 - D * w2) * w3, D * (w2 * w2 - w1 * w1) + (A - B) * w1 * w2]
    S = [M * ((h - x3) * z2 + x2 * z3), M * ((x3 - h) * z1 - x1 * z3), M * (x1 * z2 - x2 * z1)]
    I11 = A + M * (x2 * x2 + (h - x3) * (h - x3))
    I22 = B + M * (x1 * x1 + (h - x3) * (h - x3))
    I33 = C + M * (x1 * x1 + x2 * x2)
    I12, I23, I31 = D - M * x1 * x2, M * (h - x3) * x2, M * (h - x3) * x1
    Q1, Q2, Q3 = (f + r + s for f, r, s in zip(F, R, S, strict=True))
    G = I11 * I22 * I33 + I12 * I23 * I31 + I31 * I12 * I23 - I31 * I22 * I31 - I12 * I12 * I33 - I11 * I23 * I23
    E1 = Q1 * I22 * I33 + I12 * I23 * Q3 + I31 * Q2 * I23 - I31 * I22 * Q3 - I12 * Q2 * I33 - Q1 * I23 * I23
    E2 = I11 * Q2 * I33 + Q1 * I23 * I31 + I31 * I12 * Q3 - I31 * Q2 * I31 - Q1 * I12 * I33 - I11 * I23 * Q3
    E3 = I11 * I22 * Q3 + I12 * Q2 * I31 + Q1 * I12 * I23 - Q1 * I22 * I31 - I12 * I12 * Q3 - I11 * Q2 * I23
    rows = ((I11, I12, I31), (I12, I22, I23), (I31, I23, I33))
    published = {
        "u̇": [E1 / G, E2 / G, E3 / G],
        "F̃": F,
        "F̃*": [
            r + s - (row[0] * w1.dt + row[1] * w2.dt + row[2] * w3.dt) for r, s, row in zip(R, S, rows, strict=True)
        ],
        "M̃": [x for row in rows for x in row],
    }
    return Problem(system(), published, P)
