# SPDX-License-Identifier: BSD-3-Clause
"""A mass on a spring with dry friction: it loses the same each half cycle, and stops.

With δ = μ m g/k the amplitude falls by 2 δ in each half cycle π √(m/k), until it turns within δ of the middle and stays there.
"""

import kane as kn

TITLE = "oscillator with dry friction"
SOURCES = ("Den Hartog, J. P. (1956), Mechanical Vibrations, 4th ed., McGraw-Hill, sec. 8.7.",)
START = {"q": {"x": 1.05}, "u": {"u_x": 0.0}}


def system() -> kn.System:
    """The mass by the stretch of its spring; the normal force is brought into evidence."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "stretch of the spring")
    m = kn.parameter("m", 1.0, "kg", "mass")
    k = kn.parameter("k", 1.0, "N/m", "stiffness of the spring")
    mu = kn.parameter("mu", 0.1, "1", "coefficient of friction")
    g = kn.parameter("g", 1.0, "m/s^2", "acceleration of free fall")

    P = O.at("P", x * N.x)
    place = kn.joints.point_on_plane("table", P, O, normal=N.y)
    return kn.System(
        N,
        bodies=[kn.Particle("mass", P, m)],
        speeds="rates",
        loads=[kn.gravity(-g * N.y), kn.linear_spring(P, O, k)],
        contacts=[kn.contact(place, mu, normal=kn.reaction("N_y", at=P, along=N.y))],
        coordinates=(x,),
    )
