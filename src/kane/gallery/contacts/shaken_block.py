# SPDX-License-Identifier: BSD-3-Clause
"""A block on an incline that is shaken along its slope: it moves exactly with the incline, or slips.

It sticks while |s̈ + g sin α| ≤ μ g cos α, s the incline's displacement up the slope; else it slips on it at
∓ μ g cos α − g sin α − s̈.
"""

import kane as kn

TITLE = "block on a shaken incline"
SOURCES = ("Blekhman, I. I. (2000), Vibrational Mechanics, World Scientific, ch. 8.",)
START = {"q": {"x": 0.0, "y": 0.0}, "u": {"u_x": 0.0, "u_y": 0.0}}


def system() -> kn.System:
    """The block by its place on the incline, along it and above it."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "place on the incline, up the slope")
    y = kn.coordinate("y", "m", "height above the incline")
    m = kn.parameter("m", 2.0, "kg", "mass")
    alpha = kn.parameter("alpha", 0.2, "rad", "slope")
    A = kn.parameter("A", 0.01, "m", "amplitude of the incline")
    w = kn.parameter("w", 10.0, "rad/s", "frequency of the incline")
    mu = kn.parameter("mu", 0.4, "1", "coefficient of friction")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    I = N.rotate("I", alpha, N.z)
    T = O.at("T", A * kn.cos(w * kn.time) * I.x)
    P = T.at("P", x * I.x + y * I.y)
    return kn.System(
        N,
        bodies=[kn.Particle("block", P, m)],
        speeds="rates",
        loads=[kn.gravity(-g * N.y)],
        contacts=[kn.contact(kn.joints.point_on_plane("incline", P, T, normal=I.y), mu)],
        coordinates=(x, y),
    )
