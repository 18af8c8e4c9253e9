# SPDX-License-Identifier: BSD-3-Clause
"""A heavy body on a pivot, by three angles."""

import kane as kn


def system():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1, q2, q3 = kn.coordinates("q1:4", "rad", "yaw, pitch, roll")
    u1, u2, u3 = kn.speeds("u1:4", "rad/s")
    m = kn.parameter("m", 3.0, "kg", "mass")
    a = kn.parameter("a", 0.2, "m", "from the pivot to the mass centre")
    I1 = kn.parameter("I1", 0.1, "kg*m^2")
    I2 = kn.parameter("I2", 0.2, "kg*m^2")
    I3 = kn.parameter("I3", 0.25, "kg*m^2")
    g = kn.parameter("g", 9.81, "m/s^2")

    B = N.rotate_body("B", (q1, q2, q3), "zyx")
    G = O.at("G", a * B.x)
    body = kn.RigidBody("gyro", frame=B, mass_center=G, mass=m, inertia=kn.inertia(B, I1, I2, I3))
    w = B.angular_velocity(N)
    return kn.System(
        N,
        bodies=[body],
        speeds={u1: w.dot(B.x), u2: w.dot(B.y), u3: w.dot(B.z)},
        loads=[kn.gravity(-g * N.z)],
    )


START = {"q": {"q1": 0.0, "q2": 0.3, "q3": 0.0}, "u": {"u1": 20.0, "u2": 0.0, "u3": 0.0}}
