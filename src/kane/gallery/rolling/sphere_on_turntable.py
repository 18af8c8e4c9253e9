# SPDX-License-Identifier: BSD-3-Clause
"""A homogeneous sphere that rolls on a horizontal turntable: its centre runs on a circle at 2/7 of the table's rate."""

import kane as kn

TITLE = "sphere on a turntable"
SOURCES = (
    "Neimark, J. I., Fufaev, N. A. (1972), Dynamics of Nonholonomic Systems, AMS.",
    "Warren, R. (1987) and Weltner, K. (1987), on the rolling of balls on a rotating table, Am. J. Phys. 55.",
)
START = {
    "q": {"x": 0.3, "y": 0.0, "e0": 1.0, "e1": 0.0, "e2": 0.0, "e3": 0.0},
    "u": {"u_x": 0.1, "u_y": 0.2, "w_z": 1.0},
}


def system() -> kn.System:
    """The sphere: its centre by x and y, its orientation by Euler parameters; speeds are v and ω along fixed axes."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "centre, along x")
    y = kn.coordinate("y", "m", "centre, along y")
    e = kn.coordinates("e0:4", "1", "Euler parameter")
    m = kn.parameter("m", 0.4, "kg", "mass")
    R = kn.parameter("R", 0.05, "m", "radius")
    W = kn.parameter("Omega", 3.0, "rad/s", "rate of the turntable")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    T = N.rotate("T", W * kn.time, N.z)
    S = N.rotate_euler_parameters("S", e)
    P = O.at("P", x * N.x + y * N.y)
    C = P.at("C", R * N.z)
    on_sphere = C.fixed_in(S, "S^", -R * N.z)
    on_table = O.fixed_in(T, "T^", x * N.x + y * N.y)
    ball = kn.RigidBody("sphere", frame=S, mass_center=C, mass=m, inertia=kn.solids.solid_sphere(S, m, R))
    contact = kn.rolling(on_sphere, on_table, normal=N.z, name="contact")

    w = S.angular_velocity(N)
    u_x, u_y = kn.speeds("u_x u_y", "m/s")
    w_x, w_y, w_z = kn.speeds("w_x w_y w_z", "rad/s")
    return kn.System(
        N,
        bodies=[ball],
        speeds={u_x: x.dt, u_y: y.dt, w_x: w.dot(N.x), w_y: w.dot(N.y), w_z: w.dot(N.z)},
        loads=[kn.gravity(-g * N.z)],
        nonholonomic=contact,
        dependent_speeds=(w_x, w_y),
        reactions=[
            kn.reaction("F_x", constraint=contact[0]),
            kn.reaction("F_y", constraint=contact[1]),
            kn.reaction("N_z", at=P, along=N.z),
        ],
        coordinates=(x, y, *e),
    )
