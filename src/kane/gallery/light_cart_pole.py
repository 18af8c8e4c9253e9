# SPDX-License-Identifier: BSD-3-Clause
"""A pendulum on a cart of nearly no mass: the bob falls nearly straight, and the cart darts below it eleven times in ten seconds.

The mass centre of both moves vertically: l θ̇² (M + m sin²θ)/(M + m) = 2 g cos θ, so θ̇² = 2 g (1 + m/M)/l at the lowest point: peaks of
4,429 rad/s that last for microseconds, a test of integrators.
"""

import math

import kane as kn

TITLE = "pendulum on a light cart"
SOURCES = ("Noah-Parsons/light-cartpole-benchmark, https://github.com/Noah-Parsons/light-cartpole-benchmark (MIT).",)
START = {"q": {"x": 0.0, "theta": math.pi / 2}, "u": {"u_x": 0.0, "u_theta": 0.0}}


def system() -> kn.System:
    """The cart and the bob on a massless rod, its angle from the downward vertical."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "position of the cart")
    theta = kn.coordinate("theta", "rad", "angle from the downward vertical")
    M = kn.parameter("M", 1e-6, "kg", "mass of the cart")
    m = kn.parameter("m", 1.0, "kg", "mass of the bob")
    l = kn.parameter("l", 1.0, "m", "length of the rod")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    A = O.at("A", x * N.x)
    B = N.rotate("B", theta, N.z)
    P = A.at("P", -l * B.y)
    return kn.System(
        N,
        bodies=[kn.Particle("cart", A, M), kn.Particle("bob", P, m)],
        speeds="rates",
        loads=[kn.gravity(-g * N.y)],
        coordinates=(x, theta),
    )
