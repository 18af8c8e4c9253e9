# SPDX-License-Identifier: BSD-3-Clause
"""A spacecraft in a plane: a hub with two flexible booms, tip masses and a reaction wheel; nothing acts from outside."""

from typing import Any

import kane as kn

TITLE = "spacecraft with two flexible booms and a reaction wheel"
SOURCES = (
    "Likins, P. W. (1974), Analytical dynamics and nonrigid spacecraft simulation, NASA JPL TR 32-1593.",
    "Kane, T. R., Likins, P. W. and Levinson, D. A. (1983), Spacecraft Dynamics, McGraw-Hill.",
)
START = {
    "q": {
        "x_hub": 0.0, "y_hub": 0.0, "q_hub": 0.0, "q_wheel": 0.0, "v1_right": 0.02, "v2_right": 0.0, "v1_left": 0.0, "v2_left": 0.0,
    },
    "u": {
        "u_x_hub": 0.0, "u_y_hub": 0.0, "u_q_hub": 0.1, "u_wheel": 20.0, "u_v1_right": 0.0, "u_v2_right": 0.0, "u_v1_left": 0.0,
        "u_v2_left": 0.0,
    },
}  # fmt: skip


def system(*, modes: int = 2, form: str = "linearized") -> kn.System:
    """The booms stand out along ±A.x, clamped; the wheel is driven by a torque against the hub."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    m = kn.parameter("m", 40.0, "kg", "mass of the hub with its wheel")
    J = kn.parameter("J", 6.0, "kg*m^2", "moment of inertia of the hub without the wheel")
    Jw = kn.parameter("Jw", 0.05, "kg*m^2", "moment of inertia of the wheel about its axis")
    R = kn.parameter("R", 0.5, "m", "from the hub's centre to the roots of the booms")
    mt = kn.parameter("m_t", 0.5, "kg", "mass at each tip")
    T = kn.parameter("T_w", 0.1, "N*m", "torque on the wheel")
    length = kn.parameter("L", 5.0, "m", "length of each boom")
    share = kn.parameter("rhoA", 0.3, "kg/m", "mass per length of the booms")
    stiff = kn.parameter("EI", 60.0, "N*m^2", "bending stiffness of the booms")
    base = kn.joints.planar("hub", O, N, normal=N.z)
    A, P = base.frame, base.point
    spin = kn.pin("wheel", P, A, axis=A.z)
    W = spin.frame
    booms = [
        kn.Beam(
            name, P.at(f"root {name}", sign * R * A.x), frame=A, axis=sign * A.x, along=A.y, length=length, mass_per_length=share,
            EI=stiff, modes=modes, form=form,
        )
        for name, sign in (("right", 1), ("left", -1))
    ]  # fmt: skip
    bodies: list[Any] = [
        kn.RigidBody("hub", frame=A, mass_center=P, mass=m, inertia=kn.inertia(A, J, J, J)),
        kn.RigidBody("wheel", frame=W, mass_center=spin.point, mass=0, inertia=kn.inertia(W, Jw / 2, Jw / 2, Jw)),
        *booms,
        *(kn.Particle(f"tip {boom.name}", boom.point_at(1), mt) for boom in booms),
    ]
    return kn.System(N, bodies=bodies, joints=[base, spin], loads=[kn.loads.torque_pair(W, A, T * A.z, name="motor")])
