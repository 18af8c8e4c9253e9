# SPDX-License-Identifier: BSD-3-Clause
"""A flexible rod that swings about a pin, with a particle at its end."""

import kane as kn

TITLE = "flexible pendulum with a tip mass"
SOURCES = (
    "Yoo, H. H., Ryan, R. R. and Scott, R. A. (1995), Dynamics of flexible beams undergoing overall motions, "
    "J. Sound and Vibration 181(2), 261-278.",
)
START = {"q": {"q_pin": 1.0, "v1_rod": 0.0, "v2_rod": 0.0}, "u": {"u_pin": 0.0, "u_v1_rod": 0.0, "u_v2_rod": 0.0}}


def system(*, modes: int = 2, form: str = "linearized") -> kn.System:
    """The rod hangs along −N.y at q_pin = 0."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    m = kn.parameter("m", 0.2, "kg", "mass at the tip")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")
    hinge = kn.pin("pin", O, N, axis=N.z)
    A = hinge.frame
    rod = kn.Beam(
        "rod", hinge.point, frame=A, axis=-A.y, along=A.x, length=kn.parameter("L", 1.2, "m", "length"),
        mass_per_length=kn.parameter("rhoA", 0.4, "kg/m", "mass per length"), EI=kn.parameter("EI", 3.0, "N*m^2", "bending stiffness"),
        modes=modes, form=form, damping={"ratio": kn.parameter("zeta", 0.002, "1", "damping ratio of each mode")},
    )  # fmt: skip
    bob = kn.Particle("bob", rod.point_at(1), m)
    return kn.System(N, bodies=[rod, bob], joints=[hinge], loads=[kn.gravity(-g * N.y)])
