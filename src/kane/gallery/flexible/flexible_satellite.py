# SPDX-License-Identifier: BSD-3-Clause
"""A spacecraft in space: a hub with two flexible booms that bend in both directions, and three reaction wheels."""

from typing import Any

import kane as kn

TITLE = "spacecraft in space with two flexible booms and three reaction wheels"
SOURCES = (
    "Likins, P. W. (1974), Analytical dynamics and nonrigid spacecraft simulation, NASA JPL TR 32-1593.",
    "Kane, T. R., Likins, P. W. and Levinson, D. A. (1983), Spacecraft Dynamics, McGraw-Hill.",
)
START = {
    "q": {
        "e0_hub": 1.0, "e1_hub": 0.0, "e2_hub": 0.0, "e3_hub": 0.0, "x_hub": 0.0, "y_hub": 0.0, "z_hub": 0.0, "q_wheel_x": 0.0,
        "q_wheel_y": 0.0, "q_wheel_z": 0.0, "v1_right": 0.02, "w1_right": 0.0, "v1_left": 0.0, "w1_left": 0.01,
    },
    "u": {
        "w_x_hub": 0.05, "w_y_hub": 0.0, "w_z_hub": 0.1, "v_x_hub": 0.0, "v_y_hub": 0.0, "v_z_hub": 0.0, "u_wheel_x": 20.0,
        "u_wheel_y": -10.0, "u_wheel_z": 15.0, "u_v1_right": 0.0, "u_w1_right": 0.0, "u_v1_left": 0.0, "u_w1_left": 0.0,
    },
}  # fmt: skip


def system(*, modes: int = 1, form: str = "linearized") -> kn.System:
    """The booms stand out along ±A.x, clamped, and bend along A.y and A.z; each wheel is driven against the hub."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    m = kn.parameter("m", 40.0, "kg", "mass of the hub with its wheels")
    moments = [
        kn.parameter(f"J{k}", 6.0, "kg*m^2", "central moment of inertia of the hub without its wheels")
        for k in (1, 2, 3)
    ]
    Jw = kn.parameter("Jw", 0.05, "kg*m^2", "moment of inertia of a wheel about its axis")
    R = kn.parameter("R", 0.5, "m", "from the hub's centre to the roots of the booms")
    mt = kn.parameter("m_t", 0.5, "kg", "mass at each tip")
    length = kn.parameter("L", 5.0, "m", "length of each boom")
    share = kn.parameter("rhoA", 0.3, "kg/m", "mass per length of the booms")
    stiff = kn.parameter("EI", 60.0, "N*m^2", "bending stiffness of the booms")
    base = kn.free("hub", O, N)
    A, P = base.frame, base.point
    bodies: list[Any] = [kn.RigidBody("hub", frame=A, mass_center=P, mass=m, inertia=kn.inertia(A, *moments))]
    joints, loads = [base], []
    for letter, axis in zip("xyz", (A.x, A.y, A.z), strict=True):
        spin = kn.pin(f"wheel_{letter}", P, A, axis=axis)
        W, torque = spin.frame, kn.parameter(f"T_{letter}", 0.1, "N*m", "torque on a wheel")
        inertia = kn.inertia(W, *(Jw if letter == k else Jw / 2 for k in "xyz"))
        bodies.append(kn.RigidBody(f"wheel {letter}", frame=W, mass_center=spin.point, mass=0, inertia=inertia))
        joints.append(spin)
        loads.append(kn.loads.torque_pair(W, A, torque * axis, name=f"motor {letter}"))
    for name, sign in (("right", 1), ("left", -1)):
        boom = kn.Beam(
            name, P.at(f"root {name}", sign * R * A.x), frame=A, axis=sign * A.x, along=A.y, length=length, mass_per_length=share,
            EI=(stiff, stiff), modes=(modes, modes), form=form,
        )  # fmt: skip
        bodies += [boom, kn.Particle(f"tip {name}", boom.point_at(1), mt)]
    return kn.System(N, bodies=bodies, joints=joints, loads=loads)
