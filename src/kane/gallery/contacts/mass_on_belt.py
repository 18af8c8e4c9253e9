# SPDX-License-Identifier: BSD-3-Clause
"""A mass on a running belt, held by a spring: the stick-slip of a violin's string and of brakes that squeal.

With Δ = (μ_s − μ_k) m g/k and ω² = k/m the mass sticks for 2 Δ/v and slips for (π + 2 arctan(v/(ω Δ)))/ω.
"""

import kane as kn

TITLE = "mass on a belt"
SOURCES = (
    "Den Hartog, J. P. (1956), Mechanical Vibrations, 4th ed., McGraw-Hill, sec. 7.5.",
    "Leine, R. I., van Campen, D. H., de Kraker, A., van den Steen, L. (1998), Stick-slip vibrations induced by alternate friction "
    "models, Nonlinear Dynamics 16, 41-54.",
)
START = {"q": {"x": 0.0}, "u": {"u_x": 0.2}}


def system() -> kn.System:
    """The mass by the stretch of its spring; the belt's normal force is brought into evidence."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "stretch of the spring")
    m = kn.parameter("m", 1.0, "kg", "mass")
    k = kn.parameter("k", 25.0, "N/m", "stiffness of the spring")
    v = kn.parameter("v", 0.2, "m/s", "speed of the belt")
    kinetic = kn.parameter("mu_k", 0.2, "1", "coefficient of sliding friction")
    static = kn.parameter("mu_s", 0.4, "1", "coefficient of static friction")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    P = O.at("P", x * N.x)
    place = kn.joints.point_on_plane("belt", P, O, normal=N.y, surface=v * N.x)
    normal = kn.reaction("N_y", at=P, along=N.y)
    return kn.System(
        N,
        bodies=[kn.Particle("mass", P, m)],
        speeds="rates",
        loads=[kn.gravity(-g * N.y), kn.linear_spring(P, O, k)],
        contacts=[kn.contact(place, kinetic, static=static, normal=normal)],
        coordinates=(x,),
    )
