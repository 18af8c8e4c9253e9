# SPDX-License-Identifier: BSD-3-Clause
"""The snakeboard: a board on two steered axles, driven by a rotor; it is propelled by turning rotor and axles in rhythm."""

import kane as kn

TITLE = "snakeboard"
SOURCES = (
    "Lewis, A. D., Ostrowski, J. P., Murray, R. M., Burdick, J. W. (1994), Nonholonomic mechanics and locomotion: the snakeboard "
    "example, IEEE Int. Conf. Robotics and Automation, 2391-2397.",
)
START = {
    "q": {"x": 0.0, "y": 0.0, "theta": 0.0, "psi": 0.0, "phi_b": 0.3, "phi_f": -0.3},
    "u": {"u_theta": 0.1, "u_psi": 2.0, "u_phi_b": 0.2, "u_phi_f": -0.2},
    "inputs": {"T_psi": 0.0, "T_phi_b": 0.0, "T_phi_f": 0.0},
}


def system() -> kn.System:
    """The board with its rotor and axles; each axle's wheels do not slip along the axle."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "centre of the board, along x")
    y = kn.coordinate("y", "m", "centre of the board, along y")
    theta = kn.coordinate("theta", "rad", "heading of the board")
    psi = kn.coordinate("psi", "rad", "angle of the rotor in the board")
    phi_b = kn.coordinate("phi_b", "rad", "angle of the back axle in the board")
    phi_f = kn.coordinate("phi_f", "rad", "angle of the front axle in the board")
    m = kn.parameter("m", 6.0, "kg", "mass of the board with rotor and axles")
    J = kn.parameter("J", 0.016, "kg*m^2", "moment of inertia of the board")
    J_r = kn.parameter("J_r", 0.072, "kg*m^2", "moment of inertia of the rotor")
    J_w = kn.parameter("J_w", 0.0013, "kg*m^2", "moment of inertia of each axle")
    l = kn.parameter("l", 0.2, "m", "distance of the axles from the centre")

    A = N.rotate("A", theta, N.z)
    B = A.rotate("B", phi_b, A.z)
    F = A.rotate("F", phi_f, A.z)
    R = A.rotate("R", psi, A.z)
    P = O.at("P", x * N.x + y * N.y)
    back, front = P.at("P_b", -l * A.x), P.at("P_f", l * A.x)
    # The mass of rotor and axles counts with the board; their centres lie on it symmetrically.
    board = kn.RigidBody("board", frame=A, mass_center=P, mass=m, inertia=kn.inertia(A, J, J, J))
    rotor = kn.RigidBody("rotor", frame=R, mass_center=P, mass=0, inertia=kn.inertia(R, J_r, J_r, J_r))
    axles = [
        kn.RigidBody(name, frame=f, mass_center=p, mass=0, inertia=kn.inertia(f, J_w, J_w, J_w))
        for name, f, p in (("back axle", B, back), ("front axle", F, front))
    ]
    drives = [kn.input(f"T_{s}", "N*m", f"torque on the {w}") for s, w in _DRIVEN.items()]
    return kn.System(
        N,
        bodies=[board, rotor, *axles],
        speeds="rates",
        loads=[
            kn.loads.torque_pair(f, A, T * A.z, name=f"{w} drive")
            for f, T, w in zip((R, B, F), drives, _DRIVEN.values(), strict=True)
        ],
        nonholonomic=[
            *kn.no_slip(back, along=B.y, name="back wheels"),
            *kn.no_slip(front, along=F.y, name="front wheels"),
        ],
        coordinates=(x, y, theta, psi, phi_b, phi_f),
    )


_DRIVEN = {"psi": "rotor", "phi_b": "back axle", "phi_f": "front axle"}
