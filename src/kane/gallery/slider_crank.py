# SPDX-License-Identifier: BSD-3-Clause
"""The slider-crank: crank, connecting rod and piston, with the force of the cylinder's wall and those at the wrist pin.

The piston slides along the x axis with a coordinate of its own, and the end of the rod is pinned to it: two configuration
constraints. Eliminated by hand they give x = r cos q1 + √(l² − r² sin² q1), against which the tests hold the motion.
"""

from math import pi

import kane as kn

TITLE = "slider-crank"
SOURCES = (
    "Uicker, J. J., Pennock, G. R. and Shigley, J. E. (2003), Theory of Machines and Mechanisms, 3rd ed., Oxford University Press "
    "(the mechanism of the engine; lengths and masses are this project's own).",
)
START = {"q": {"q1": pi / 4, "q2": kn.guess(-0.2), "x": kn.guess(0.3)}, "u": {"u1": 30.0}}


def system() -> kn.System:
    """The mechanism in a horizontal plane, with a constant torque on the crank and a resistance c v of the piston."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1 = kn.coordinate("q1", "rad", "angle of the crank, zero at the outer dead centre")
    q2 = kn.coordinate("q2", "rad", "angle of the connecting rod from the x axis")
    x = kn.coordinate("x", "m", "distance of the wrist pin from the crankshaft")
    r = kn.parameter("r", 0.08, "m", "radius of the crank")
    l = kn.parameter("l", 0.24, "m", "length of the connecting rod")
    J = kn.parameter("J", 0.02, "kg*m^2", "moment of inertia of the balanced crankshaft with its flywheel")
    m2 = kn.parameter("m2", 0.6, "kg", "mass of the connecting rod, uniform")
    m3 = kn.parameter("m3", 0.9, "kg", "mass of the piston")
    T = kn.parameter("T", 2.0, "N*m", "torque on the crank")
    c = kn.parameter("c", 20.0, "N*s/m", "resistance of the piston")

    A = N.rotate("A", q1, N.z)
    B = N.rotate("B", q2, N.z)
    crank_pin = O.at("crank pin", r * A.x)
    end = crank_pin.at("end of the rod", l * B.x)
    wrist_pin = O.at("wrist pin", x * N.x)
    crank = kn.RigidBody("crank", frame=A, mass_center=O, mass=0, inertia=kn.inertia(A, J, J, J))
    rod = kn.RigidBody(
        "connecting rod",
        frame=B,
        mass_center=crank_pin.at("B*", l / 2 * B.x),
        mass=m2,
        inertia=kn.solids.rod(B, m2, l, B.x),
    )
    piston = kn.Particle("piston", wrist_pin, m3)
    closing = kn.coincident(end, wrist_pin, along=(N.x, N.y), name="wrist pin")
    return kn.System(
        N,
        bodies=[crank, rod, piston],
        speeds="rates",
        loads=[kn.Torque(A, T * N.z, name="drive"), kn.Force(wrist_pin, -c * x.dt * N.x, name="resistance")],
        reactions=[
            kn.reaction("wall", at=wrist_pin, along=N.y),
            kn.reaction("pin_x", constraint=closing[0]),
            kn.reaction("pin_y", constraint=closing[1]),
        ],
        holonomic=closing,
        coordinates=(q1, q2, x),
    )
