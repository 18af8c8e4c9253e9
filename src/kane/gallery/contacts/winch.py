# SPDX-License-Identifier: BSD-3-Clause
"""A winch reels in a slack rope and jerks a crate off the floor: where the rope becomes taut the crate has its speed at once."""

import kane as kn

TITLE = "winch with a slack rope"
SOURCES = ("Brogliato, B. (2016), Nonsmooth Mechanics, 3rd ed., Springer, ch. 1.",)
START = {"q": {"y": 0.0}, "u": {"u_y": 0.0}}


def system() -> kn.System:
    """The crate by its height; the rope between winch and crate shortens at a constant rate."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    y = kn.coordinate("y", "m", "height of the crate")
    m = kn.parameter("m", 50.0, "kg", "mass of the crate")
    H = kn.parameter("H", 3.0, "m", "height of the winch above the crate on the floor")
    s = kn.parameter("s", 0.2, "m", "slack of the rope at the beginning")
    v = kn.parameter("v", 0.5, "m/s", "rate at which the winch reels in")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    P = O.at("P", y * N.y)
    return kn.System(
        N,
        bodies=[kn.Particle("crate", P, m)],
        speeds="rates",
        loads=[kn.gravity(-g * N.y)],
        contacts=[
            kn.joints.rope("rope", [O.at("winch", H * N.y), P], H + s - v * kn.time),
            kn.contact(kn.joints.point_on_plane("floor", P, O, normal=N.y)),
        ],
        coordinates=(y,),
    )
