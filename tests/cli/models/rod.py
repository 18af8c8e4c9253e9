# SPDX-License-Identifier: BSD-3-Clause
"""A rod on a pivot."""

import kane as kn


def system():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinate("q", "rad", "angle from the downward vertical")
    u = kn.speed("u", "rad/s")
    m = kn.parameter("m", 1.2, "kg", "mass")
    L = kn.parameter("L", 0.5, "m", "length")
    g = kn.parameter("g", 9.81, "m/s^2")

    B = N.rotate("B", q, N.z)
    G = O.at("G", -L / 2 * B.y)
    rod = kn.RigidBody("rod", frame=B, mass_center=G, mass=m, inertia=kn.rod(B, m, L, axis=B.y))
    return kn.System(N, bodies=[rod], speeds={u: q.dt}, loads=[kn.gravity(-g * N.y)])


START = {"q": {"q": 0.5}, "u": {"u": 0.0}}
