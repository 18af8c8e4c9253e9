# SPDX-License-Identifier: BSD-3-Clause
"""A clutch that is pressed: it slips until engine and load turn alike, holds, and slips again where more is asked of it.

With engine J, T and load J_l, T_l a clutch of size c brings them together at Δω/((c − T)/J + (c − T_l)/J_l), and holds while
|T J_l + T_l J| < c (J + J_l).
"""

import kane as kn

TITLE = "clutch between engine and load"
SOURCES = ("Pfeiffer, F., Glocker, C. (1996), Multibody Dynamics with Unilateral Contacts, Wiley, ch. 8.",)
START = {"q": {"phi": 0.0, "phi_l": 0.0}, "u": {"u_phi": 150.0, "u_phi_l": 0.0}, "inputs": {"P": 3000.0, "T": 80.0}}


def system() -> kn.System:
    """Engine and load by their angles; the force that presses and the engine's torque are inputs."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    phi = kn.coordinate("phi", "rad", "engine: angle")
    phi_l = kn.coordinate("phi_l", "rad", "load: angle")
    P = kn.input("P", "N", "force that presses the clutch")
    T = kn.input("T", "N*m", "torque of the engine")
    J = kn.parameter("J", 0.2, "kg*m^2", "engine: moment of inertia")
    J_l = kn.parameter("J_l", 0.8, "kg*m^2", "load: moment of inertia")
    T_l = kn.parameter("T_l", 40.0, "N*m", "torque that the load takes")
    mu = kn.parameter("mu", 0.4, "1", "coefficient of friction of the lining")
    r = kn.parameter("r", 0.1, "m", "mean radius of the lining")

    E, L = N.rotate("E", phi, N.z), N.rotate("L", phi_l, N.z)
    return kn.System(
        N,
        bodies=[
            kn.RigidBody("engine", frame=E, mass_center=O, mass=0, inertia=kn.inertia(E, J, J, J)),
            kn.RigidBody("load", frame=L, mass_center=O, mass=0, inertia=kn.inertia(L, J_l, J_l, J_l)),
        ],
        speeds="rates",
        loads=[kn.Torque(E, T * N.z, name="engine"), kn.Torque(L, -T_l * N.z, name="load")],
        contacts=[kn.joints.clutch("clutch", E, L, N.z, mu * r * P)],
        coordinates=(phi, phi_l),
    )


def shapes(system: kn.System) -> list[kn.figures.BodyShape]:
    """Two disks on shafts that face each other."""
    engine, load = system.rigid_bodies
    O, axis = engine.mass_center, system.inertial.z
    r = next(p for p in system.parameters if p.name == "r")
    result = []
    for body, side in ((engine, -1), (load, 1)):
        middle, end = (
            O.at(f"middle of {body.name}", side * 0.3 * r * axis),
            O.at(f"end of {body.name}", side * 1.1 * r * axis),
        )
        result.append(kn.figures.shape("cylinder", body, at=middle, axis=body.frame.z, radius=0.8 * r, height=0.3 * r))
        result.append(kn.figures.shape("link", body, points=[middle, end], name=f"shaft of {body.name}"))
    return result
