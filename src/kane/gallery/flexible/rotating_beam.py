# SPDX-License-Identifier: BSD-3-Clause
"""A flexible beam clamped to a hub that turns as prescribed: at a steady rate, or up to it in a given time."""

from typing import Any

import kane as kn

TITLE = "rotating flexible cantilever"
SOURCES = (
    "Kane, T. R., Ryan, R. R. and Banerjee, A. K. (1987), Dynamics of a cantilever beam attached to a moving base, "
    "J. Guidance, Control, and Dynamics 10(2), 139-151.",
    "Yoo, H. H., Ryan, R. R. and Scott, R. A. (1995), Dynamics of flexible beams undergoing overall motions, "
    "J. Sound and Vibration 181(2), 261-278.",
)
SPAN = (0, 20)
START = {
    "q": {"v1_beam": 0.0, "v2_beam": 0.0, "v3_beam": 0.0},
    "u": {"u_v1_beam": 0.0, "u_v2_beam": 0.0, "u_v3_beam": 0.0},
}


def system(
    *, spin_up: bool = False, flap: bool = False, modes: int = 3, form: str = "linearized", stretch: int = 0
) -> kn.System:
    """The beam of Yoo, Ryan and Scott: θ̇ = (Ω/T)(t − (T/2π) sin(2πt/T)) until T, then Ω, for a `spin_up`; else Ω.

    It bends in the plane of rotation (chordwise), or out of it (`flap`).
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    Omega = kn.parameter("Omega", 6.0, "rad/s", "angular speed of the hub at the end")
    T = kn.parameter("T", 15.0, "s", "time of the spin-up")
    t = kn.time
    angle = Omega * t
    if spin_up:
        a = 2 * kn.pi / T
        ramp = Omega / T * (t**2 / 2 + (kn.cos(a * t) - 1) / a**2)
        angle = kn.where(kn.less(t, T), ramp, Omega * (t - T / 2))
    A = N.rotate("A", angle, N.z)
    more: dict[str, Any] = (
        {"EA": kn.parameter("EA", 2.8e7, "N", "axial stiffness"), "stretch": stretch} if stretch else {}
    )
    beam = kn.Beam(
        "beam",
        O,
        frame=A,
        axis=A.x,
        along=A.z if flap else A.y,
        length=kn.parameter("L", 10.0, "m", "length"),
        mass_per_length=kn.parameter("rhoA", 1.2, "kg/m", "mass per length"),
        EI=kn.parameter("EI", 1.4e4, "N*m^2", "bending stiffness"),
        modes=modes,
        form=form,
        **more,
    )
    return kn.System(N, bodies=[beam])
