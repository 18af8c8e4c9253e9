# SPDX-License-Identifier: BSD-3-Clause
"""The tippe top: a ball whose mass centre is off its middle turns over when it spins, by the friction on which it slides.

Jellett's integral: whatever the friction, L·r stays, L the angular momentum about the mass centre, r from there to the contact.
"""

import math

import kane as kn

TITLE = "tippe top"
SOURCES = (
    "Cohen, R. J. (1977), The tippe top revisited, Am. J. Phys. 45, 12-17.",
    "Jellett, J. H. (1872), A Treatise on the Theory of Friction, Macmillan, ch. 8.",
    "Rauch-Wojciechowski, S., Skoldstam, M., Glad, T. (2005), Mathematical analysis of the tippe top, Regular and Chaotic "
    "Dynamics 10, 333-362; the moments of inertia 131/350 and 2/5 m R2 and a = 0.3 R.",
)
_TILT, _SPIN = 0.1, 100.0
START = {
    "q": {"x": 0.0, "y": 0.0, "e0": math.cos(_TILT / 2), "e1": math.sin(_TILT / 2), "e2": 0.0, "e3": 0.0},
    "u": {"u_x": 0.01, "u_y": 0.0, "w_x": 0.0, "w_y": _SPIN * math.sin(_TILT), "w_z": _SPIN * math.cos(_TILT)},
}
"""It spins about the vertical, its axis tilted."""


def system() -> kn.System:
    """The ball's middle by x and y, its attitude by Euler parameters; the normal force is brought into evidence."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "middle, along x")
    y = kn.coordinate("y", "m", "middle, along y")
    e = kn.coordinates("e0:4", "1", "Euler parameter")
    m = kn.parameter("m", 0.015, "kg", "mass")
    R = kn.parameter("R", 0.025, "m", "radius")
    a = kn.parameter("a", 0.0075, "m", "mass centre below the middle")
    A = kn.parameter("A", 131 / 350 * 0.015 * 0.025**2, "kg*m^2", "central moment of inertia across the axis")
    C_ = kn.parameter("C", 2 / 5 * 0.015 * 0.025**2, "kg*m^2", "central moment of inertia about the axis")
    mu = kn.parameter("mu", 0.1, "1", "coefficient of friction")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    B = N.rotate_euler_parameters("B", e)
    C = O.at("C", x * N.x + y * N.y + R * N.z)
    G = C.at("G", -a * B.z)
    ball = kn.RigidBody("ball", frame=B, mass_center=G, mass=m, inertia=kn.inertia(B, A, A, C_))
    normal = kn.reaction("N_z", at=C, along=N.z)
    w = B.angular_velocity(N)
    u_x, u_y = kn.speeds("u_x u_y", "m/s")
    w_x, w_y, w_z = kn.speeds("w_x w_y w_z", "rad/s")
    place = kn.joints.sphere_on_plane("floor", B, C, O, radius=R, normal=N.z)
    return kn.System(
        N,
        bodies=[ball],
        speeds={u_x: x.dt, u_y: y.dt, w_x: w.dot(B.x), w_y: w.dot(B.y), w_z: w.dot(B.z)},
        loads=[kn.gravity(-g * N.z)],
        contacts=[kn.contact(place, mu, normal=normal)],
        coordinates=(x, y, *e),
    )
