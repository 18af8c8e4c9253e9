# SPDX-License-Identifier: BSD-3-Clause
"""The rattleback: spun the wrong way round it rattles and turns back.

An ellipsoid whose principal axes of inertia are turned against those of its surface rolls without slip on a horizontal plane.
"""

import math

import kane as kn

TITLE = "rattleback"
SOURCES = (
    "Kane, T. R., Levinson, D. A. (1982), Realistic mathematical modeling of the rattleback, Int. J. Non-Linear Mechanics 17, "
    "175-186.",
)
START = {
    "q": {"q1": 0.0, "q2": math.radians(0.5), "q3": math.radians(0.5), "x": 0.0, "y": 0.0},
    "u": {"u1": 0.0, "u2": 0.0, "u3": -5.0},
}


def system() -> kn.System:
    """The body rolls about the axes B.x (length), B.y (width) and B.z (up); x and y place the contact."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1 = kn.coordinate("q1", "rad", "yaw")
    q2 = kn.coordinate("q2", "rad", "roll about the length")
    q3 = kn.coordinate("q3", "rad", "pitch about the width")
    x = kn.coordinate("x", "m", "contact, along x")
    y = kn.coordinate("y", "m", "contact, along y")
    a = kn.parameter("a", 0.2, "m", "semi-axis of the length")
    b = kn.parameter("b", 0.03, "m", "semi-axis of the width")
    c = kn.parameter("c", 0.02, "m", "semi-axis of the height")
    h = kn.parameter("h", 0.01, "m", "mass centre below the centre of the ellipsoid")
    m = kn.parameter("m", 1.0, "kg", "mass")
    A = kn.parameter("A", 2e-4, "kg*m^2", "central moment of inertia about the length")
    B_ = kn.parameter("B", 16e-4, "kg*m^2", "central moment of inertia about the width")
    C_ = kn.parameter("C", 17e-4, "kg*m^2", "central moment of inertia about the height")
    D = kn.parameter("D", -0.2e-4, "kg*m^2", "product of inertia of length and width")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    Y = N.rotate("Y", q1, N.z)
    L = Y.rotate("L", q2, Y.x)
    B = L.rotate("B", q3, L.y)
    n = (N.z.dot(B.x), N.z.dot(B.y), N.z.dot(B.z))
    size = kn.sqrt((a * n[0]) ** 2 + (b * n[1]) ** 2 + (c * n[2]) ** 2)
    down = -(a**2 * n[0] * B.x + b**2 * n[1] * B.y + c**2 * n[2] * B.z) / size  # from the centre to the lowest point
    P = O.at("P", x * N.x + y * N.y)
    E = P.at("E", -down)
    G = E.at("G", -h * B.z)
    lowest = E.fixed_in(B, "P^", down)
    stone = kn.RigidBody("stone", frame=B, mass_center=G, mass=m, inertia=kn.inertia(B, A, B_, C_, D))

    w = B.angular_velocity(N)
    u1, u2, u3 = kn.speeds("u1:4", "rad/s")
    u4, u5 = kn.speeds("u4:6", "m/s")
    contact = kn.rolling(lowest, normal=N.z, name="contact")
    return kn.System(
        N,
        bodies=[stone],
        speeds={u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z), u4: x.dt, u5: y.dt},
        loads=[kn.gravity(-g * N.z)],
        nonholonomic=contact,
        dependent_speeds=(u4, u5),
        reactions=[kn.reaction("N_z", at=P, along=N.z)],
        coordinates=(q1, q2, q3, x, y),
    )


def shapes(system: kn.System) -> list[kn.figures.BodyShape]:
    """The ellipsoid, whose middle is above the mass centre."""
    (stone,) = system.rigid_bodies
    a, b, c = (next(p for p in system.parameters if p.name == name) for name in "abc")
    middle = stone.mass_center.parent
    return [kn.figures.shape("ellipsoid", stone, at=middle, a=a, b=b, c=c)]
