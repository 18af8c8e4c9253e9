# SPDX-License-Identifier: BSD-3-Clause
"""A rotor blade with flap and lag hinges at an offset, that bends in both directions."""

import kane as kn

TITLE = "rotor blade with flap and lag hinges"
SOURCES = ("Johnson, W. (1980), Helicopter Theory, Princeton University Press, ch. 9 and 12.",)
START = {
    "q": {"q_flap": 0.05, "q_lag": 0.0, "v1_blade": 0.0, "w1_blade": 0.05, "w2_blade": 0.0},
    "u": {"u_flap": 0.0, "u_lag": 0.2, "u_v1_blade": 0.0, "u_w1_blade": 0.0, "u_w2_blade": 0.0},
}


def system(*, modes: int = 1, form: str = "linearized") -> kn.System:
    """The hub turns at Ω about N.z; the blade flaps out of its plane, lags in it, and bends along both."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    Omega = kn.parameter("Omega", 40.0, "rad/s", "angular speed of the rotor")
    e = kn.parameter("e", 0.3, "m", "offset of the hinges")
    c = kn.parameter("c", 50.0, "N*m*s/rad", "damping of the lag hinge")
    A = N.rotate("A", Omega * kn.time, N.z)
    flap = kn.pin("flap", O.at("hinge", e * A.x), A, axis=-A.y)
    F = flap.frame
    lag = kn.pin("lag", flap.point, F, axis=F.z)
    B = lag.frame
    blade = kn.Beam(
        "blade", lag.point, frame=B, axis=B.x, length=kn.parameter("L", 5.0, "m", "length of the blade"),
        mass_per_length=kn.parameter("rhoA", 6.0, "kg/m", "mass per length"),
        EI=(
            kn.parameter("EI_c", 6e5, "N*m^2", "bending stiffness in the plane"),
            kn.parameter("EI_f", 2e4, "N*m^2", "bending stiffness out of the plane"),
        ),
        modes=(modes, modes + 1), form=form,
    )  # fmt: skip
    loads = [kn.torsional_damper(B, F, c, F.z, name="lag damper")]
    return kn.System(N, bodies=[blade], joints=[flap, lag], loads=loads)
