# SPDX-License-Identifier: BSD-3-Clause
"""A pendulum on a cart that a spring holds."""

import kane as kn


def system():
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "position of the cart")
    q = kn.coordinate("q", "rad", "angle of the rod from the downward vertical")
    u1 = kn.speed("u1", "m/s")
    u2 = kn.speed("u2", "rad/s")
    m1 = kn.parameter("m1", 2.0, "kg", "mass of the cart")
    m2 = kn.parameter("m2", 0.5, "kg", "mass of the bob")
    L = kn.parameter("L", 0.8, "m", "length of the rod")
    k = kn.parameter("k", 30.0, "N/m", "stiffness of the spring")
    g = kn.parameter("g", 9.81, "m/s^2")

    A = O.at("A", x * N.x)
    B = N.rotate("B", q, N.z)
    P = A.at("P", -L * B.y)
    cart = kn.Particle("cart", A, m1)
    bob = kn.Particle("bob", P, m2)
    return kn.System(
        N,
        bodies=[cart, bob],
        speeds={u1: x.dt, u2: q.dt},
        loads=[kn.gravity(-g * N.y), kn.Force(A, -k * x * N.x, name="spring")],
    )


START = {"q": {"x": 0.1, "q": 0.5}, "u": {"u1": 0.0, "u2": 0.0}}
