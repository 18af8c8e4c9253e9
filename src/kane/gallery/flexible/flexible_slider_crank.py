# SPDX-License-Identifier: BSD-3-Clause
"""A slider-crank mechanism whose connecting rod bends."""

from math import pi

import kane as kn

TITLE = "slider-crank mechanism with a flexible connecting rod"
SOURCES = (
    "Chu, S. C. and Pan, K. C. (1975), Dynamic response of a high-speed slider-crank mechanism with an elastic connecting rod, "
    "J. Engineering for Industry 97(2), 542-550.",
)
START = {
    "q": {"q_crank": pi / 4, "q_wrist": kn.guess(-0.9), "x": kn.guess(0.35), "v1_rod": 0.0, "v2_rod": 0.0},
    "u": {"u_crank": 60.0, "u_v1_rod": 0.0, "u_v2_rod": 0.0},
}


def system(*, modes: int = 2, form: str = "linearized") -> kn.System:
    """The rod's frame follows its two pins, between which it bends by sines; the crank carries a flywheel."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    r = kn.parameter("r", 0.1, "m", "radius of the crank")
    J = kn.parameter("J", 0.05, "kg*m^2", "moment of inertia of the balanced crankshaft with its flywheel")
    m = kn.parameter("m", 0.4, "kg", "mass of the piston")
    x = kn.coordinate("x", "m", "distance of the wrist pin from the crankshaft")
    turn = kn.pin("crank", O, N, axis=N.z)
    A = turn.frame
    joint = kn.pin("wrist", turn.point.at("crank pin", r * A.x), A, axis=A.z)
    B = joint.frame
    rod = kn.Beam(
        "rod", joint.point, frame=B, axis=B.x, length=kn.parameter("L", 0.3, "m", "length of the connecting rod"),
        mass_per_length=kn.parameter("rhoA", 0.8, "kg/m", "mass per length"),
        EI=kn.parameter("EI", 60.0, "N*m^2", "bending stiffness"),
        modes=modes, support="pinned", form=form, damping={"ratio": kn.parameter("zeta", 0.01, "1", "damping ratio of each mode")},
    )  # fmt: skip
    wrist_pin = O.at("wrist pin", x * N.x)
    crank = kn.RigidBody("crank", frame=A, mass_center=O, mass=0, inertia=kn.inertia(A, J, J, J))
    closing = kn.coincident(rod.point_at(1), wrist_pin, along=(N.x, N.y), name="wrist pin")
    speeds = {**turn.speeds, **joint.speeds, kn.speed("u_x", "m/s"): x.dt}
    return kn.System(
        N,
        bodies=[crank, rod, kn.Particle("piston", wrist_pin, m)],
        joints=[turn, joint],
        speeds=speeds,
        holonomic=closing,
        dependent_coordinates=("q_wrist", "x"),
        dependent_speeds=("u_wrist", "u_x"),
    )
