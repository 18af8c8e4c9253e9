# SPDX-License-Identifier: BSD-3-Clause
"""A wheel that slides on the ground, friction smoothed."""

import kane as kn


def system():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x, q = kn.coordinates("x q")
    u1, u2 = kn.speeds("u1:3")
    m = kn.parameter("m", 1.5, "kg", "mass")
    R = kn.parameter("R", 0.3, "m", "radius")
    mu = kn.parameter("mu", 0.2, "1", "coefficient of sliding friction")
    g = kn.parameter("g", 9.81, "m/s^2")

    P = O.at("P", x * N.x)
    G = P.at("G", R * N.y)
    C = N.rotate("C", q, N.z)
    contact = G.fixed_in(C, "contact", -R * N.y)
    wheel = kn.RigidBody("wheel", frame=C, mass_center=G, mass=m, inertia=kn.thin_disk(C, m, R, axis=C.z))
    normal = kn.reaction("Fn", at=P, along=N.y)
    slip = contact.velocity(N).dot(N.x)
    return kn.System(
        N,
        bodies=[wheel],
        reactions=[normal],
        speeds={u1: x.dt, u2: q.dt},
        loads=[kn.gravity(-g * N.y), kn.Force(contact, -mu * normal * kn.tanh(slip / 0.01) * N.x, name="friction")],
    )


START = {"q": {"x": 0.0, "q": 0.0}, "u": {"u1": 2.0, "u2": 0.0}}
SPAN = (0, 1)
