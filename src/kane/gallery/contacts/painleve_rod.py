# SPDX-License-Identifier: BSD-3-Clause
"""Painlevé's rod: a rod that slides on its tip, for which Coulomb's friction has no acceleration, or several, where it is steep.

At an angle θ to the floor it slides, tip ahead, with N (1 + 3 cos θ (cos θ − μ sin θ))/m = g − l sin θ ω². With μ > 4/3 the factor is
negative between two angles: where it turns slowly there is no N > 0 then, where it turns fast it may slide as well as separate.
"""

import math

import kane as kn

TITLE = "Painleve's rod"
SOURCES = (
    "Painleve, P. (1895), Sur les lois du frottement de glissement, C. R. Acad. Sci. 121, 112-115.",
    "Genot, F., Brogliato, B. (1999), New results on Painleve paradoxes, Eur. J. Mech. A/Solids 18, 653-677.",
)
START = {
    "q": {"x": 0.0, "y": math.sin(math.radians(50)), "theta": math.radians(50)},
    "u": {"u_x": -3.0, "u_y": 0.0, "u_theta": 0.0},
}


def system() -> kn.System:
    """The rod by its mass centre and its angle to the floor; it slides with the tip ahead where u_x is negative."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "mass centre, along x")
    y = kn.coordinate("y", "m", "mass centre, height")
    theta = kn.coordinate("theta", "rad", "angle to the floor")
    m = kn.parameter("m", 1.0, "kg", "mass")
    l = kn.parameter("l", 1.0, "m", "half the length")
    mu = kn.parameter("mu", 1.4, "1", "coefficient of friction")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    B = N.rotate("B", theta, N.z)
    G = O.at("G", x * N.x + y * N.y)
    tip = G.fixed_in(B, "tip", -l * B.x)
    J = m * l**2 / 3
    rod = kn.RigidBody("rod", frame=B, mass_center=G, mass=m, inertia=kn.inertia(B, 0, J, J))
    return kn.System(
        N,
        bodies=[rod],
        speeds="rates",
        loads=[kn.gravity(-g * N.y)],
        contacts=[kn.contact(kn.joints.point_on_plane("floor", tip, O, normal=N.y), mu)],
        events=[kn.Event("lies flat", theta, direction=-1, terminal=True)],
        coordinates=(x, y, theta),
    )
