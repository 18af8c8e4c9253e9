# SPDX-License-Identifier: BSD-3-Clause
"""A ball that bounces on a floor: infinitely many impacts until it rests.

Dropped from h at rest it hits the floor the n-th time at √(2h/g) (1 + 2 (e + … + eⁿ⁻¹)), and rests from √(2h/g) (1 + e)/(1 − e) on.
"""

import kane as kn

TITLE = "bouncing ball"
SOURCES = ("Brogliato, B. (2016), Nonsmooth Mechanics, 3rd ed., Springer, ch. 1.",)
START = {"q": {"y": 1.0}, "u": {"u_y": 0.0}}


def system() -> kn.System:
    """The ball as a particle above a floor."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    y = kn.coordinate("y", "m", "height")
    m = kn.parameter("m", 0.1, "kg", "mass")
    e = kn.parameter("e", 0.9, "1", "restitution")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    P = O.at("P", y * N.y)
    floor = kn.contact(kn.joints.point_on_plane("floor", P, O, normal=N.y), restitution=e)
    return kn.System(
        N,
        bodies=[kn.Particle("ball", P, m)],
        speeds="rates",
        loads=[kn.gravity(-g * N.y)],
        contacts=[floor],
        coordinates=(y,),
    )
