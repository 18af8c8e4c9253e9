# SPDX-License-Identifier: BSD-3-Clause
"""A free rigid body: Euler parameters and the position of its mass centre; no torque, on request with gravity."""

import kane as kn
from kane.gallery import choose

TITLE = "free rigid body"
SOURCES = (
    "Kane, T. R., Likins, P. W. and Levinson, D. A. (1983), Spacecraft Dynamics, McGraw-Hill.",
    "Goldstein, H., Poole, C. and Safko, J. (2002), Classical Mechanics, 3rd ed., Addison-Wesley, ch. 5.",
)
SPEEDS = ("rates", "inertial", "body", "momentum")


def system(*, gravity: bool = False, speeds: str = "rates") -> kn.System:
    """The body.

    Speeds: the angular velocity along the body's axes with the velocity along those of N ("rates"), both along the axes of N
    ("inertial"), both along those of the body ("body"), or the central angular momentum along the body's axes with the
    linear momentum along those of N ("momentum").
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    e = kn.coordinates("e0:4", "1", "Euler parameter")
    x, y, z = kn.coordinates("x, y, z", "m", "position of the mass centre")
    m = kn.parameter("m", 3.0, "kg", "mass")
    I1 = kn.parameter("I1", 0.04, "kg*m^2", "moment of inertia about the first principal axis")
    I2 = kn.parameter("I2", 0.07, "kg*m^2", "moment of inertia about the second principal axis")
    I3 = kn.parameter("I3", 0.09, "kg*m^2", "moment of inertia about the third principal axis")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    B = N.rotate_euler_parameters("B", e)
    Bs = O.at("B*", x * N.x + y * N.y + z * N.z)
    I = kn.inertia(B, I1, I2, I3)
    body = kn.RigidBody("body", frame=B, mass_center=Bs, mass=m, inertia=I)

    w, v = B.angular_velocity(N), Bs.velocity(N)
    u = kn.speeds("u1:7")

    def along(turning: kn.Vector, F: kn.Frame, moving: kn.Vector, G: kn.Frame) -> dict[kn.expr.Speed, kn.Expr]:
        return dict(zip(u, (*turning.components(F), *moving.components(G)), strict=True))

    choices = {"inertial": along(w, N, v, N), "body": along(w, B, v, B), "momentum": along(I.dot(w), B, m * v, N)}
    return kn.System(
        N,
        bodies=[body],
        speeds=choose(choices, speeds),
        loads=[kn.gravity(-g * N.z)] if gravity else [],
        coordinates=(*e, x, y, z),
    )
