# SPDX-License-Identifier: BSD-3-Clause
"""A billiard ball struck off its centre: it slides along a parabola, then rolls straight on.

The slip v_s = v + R n × ω has a fixed direction: v falls along it at μ g, and rolling sets in at t = 2 |v_s|/(7 μ g) with the velocity
v − (2/7) v_s. Struck at a point c across the cue with the impulse p it starts with v = p/m and ω = c × p/J.
"""

import kane as kn

TITLE = "billiard ball struck off centre"
SOURCES = (
    "Coriolis, G. (1835), Théorie mathématique des effets du jeu de billard, Carilian-Goeury, Paris.",
    "Routh, E. J. (1905), The Elementary Part of a Treatise on the Dynamics of a System of Rigid Bodies, 7th ed., Macmillan, ch. 5.",
)
START = {
    "q": {"x": 0.0, "y": 0.0, "z": 0.0286, "e0": 1.0, "e1": 0.0, "e2": 0.0, "e3": 0.0},
    "u": {"u_x": 2.0, "u_y": 0.0, "u_z": 0.0, "w_x": -60.0, "w_y": -20.0, "w_z": 30.0},
}


def system() -> kn.System:
    """The ball by its centre and Euler parameters; speeds are v and ω along fixed axes."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "centre, along x")
    y = kn.coordinate("y", "m", "centre, along y")
    z = kn.coordinate("z", "m", "centre, height")
    e = kn.coordinates("e0:4", "1", "Euler parameter")
    m = kn.parameter("m", 0.17, "kg", "mass")
    R = kn.parameter("R", 0.0286, "m", "radius")
    mu = kn.parameter("mu", 0.2, "1", "coefficient of friction")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    B = N.rotate_euler_parameters("B", e)
    C = O.at("C", x * N.x + y * N.y + z * N.z)
    w = B.angular_velocity(N)
    u_x, u_y, u_z = kn.speeds("u_x u_y u_z", "m/s")
    w_x, w_y, w_z = kn.speeds("w_x w_y w_z", "rad/s")
    return kn.System(
        N,
        bodies=[kn.RigidBody("ball", frame=B, mass_center=C, mass=m, inertia=kn.solids.solid_sphere(B, m, R))],
        speeds={u_x: x.dt, u_y: y.dt, u_z: z.dt, w_x: w.dot(N.x), w_y: w.dot(N.y), w_z: w.dot(N.z)},
        loads=[kn.gravity(-g * N.z)],
        contacts=[kn.contact(kn.joints.sphere_on_plane("table", B, C, O, radius=R, normal=N.z), mu)],
        coordinates=(x, y, z, *e),
    )
