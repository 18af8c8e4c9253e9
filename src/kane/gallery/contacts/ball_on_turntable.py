# SPDX-License-Identifier: BSD-3-Clause
"""A ball on a turntable: where it rolls its centre runs on a circle, at Ω κ/(1 + κ) with J = κ m R²; it slips where that is too fast.

A solid ball has κ = 2/5 and goes round at 2 Ω/7, a hollow one κ = 2/3 and 2 Ω/5.
"""

import kane as kn

TITLE = "ball on a turntable, with friction"
SOURCES = (
    "Neimark, J. I., Fufaev, N. A. (1972), Dynamics of Nonholonomic Systems, AMS.",
    "Warren, R. (1987) and Weltner, K. (1987), on the rolling of balls on a rotating table, Am. J. Phys. 55.",
)
START = {
    "q": {"x": 0.3, "y": 0.0, "z": 0.05, "e0": 1.0, "e1": 0.0, "e2": 0.0, "e3": 0.0},
    "u": {"u_x": 0.1, "u_y": 0.2, "u_z": 0.0, "w_x": 14.0, "w_y": 2.0, "w_z": 1.0},
}
"""It rolls: R ω = n × (v − Ω n × r)."""


def system() -> kn.System:
    """The ball by its centre and Euler parameters; speeds are v and ω along fixed axes."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "centre, along x")
    y = kn.coordinate("y", "m", "centre, along y")
    z = kn.coordinate("z", "m", "centre, height")
    e = kn.coordinates("e0:4", "1", "Euler parameter")
    m = kn.parameter("m", 0.4, "kg", "mass")
    R = kn.parameter("R", 0.05, "m", "radius")
    kappa = kn.parameter("kappa", 0.4, "1", "moment of inertia over m R2")
    W = kn.parameter("Omega", 3.0, "rad/s", "rate of the turntable")
    mu = kn.parameter("mu", 0.3, "1", "coefficient of friction")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    T = N.rotate("T", W * kn.time, N.z)
    B = N.rotate_euler_parameters("B", e)
    C = O.at("C", x * N.x + y * N.y + z * N.z)
    w, J = B.angular_velocity(N), kappa * m * R**2
    u_x, u_y, u_z = kn.speeds("u_x u_y u_z", "m/s")
    w_x, w_y, w_z = kn.speeds("w_x w_y w_z", "rad/s")
    return kn.System(
        N,
        bodies=[kn.RigidBody("ball", frame=B, mass_center=C, mass=m, inertia=kn.inertia(B, J, J, J))],
        speeds={u_x: x.dt, u_y: y.dt, u_z: z.dt, w_x: w.dot(N.x), w_y: w.dot(N.y), w_z: w.dot(N.z)},
        loads=[kn.gravity(-g * N.z)],
        contacts=[kn.contact(kn.joints.sphere_on_plane("table", B, C, O, radius=R, normal=T.z), mu)],
        coordinates=(x, y, z, *e),
    )
