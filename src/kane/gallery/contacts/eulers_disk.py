# SPDX-License-Identifier: BSD-3-Clause
"""Euler's disk: a coin that rolls on its edge, its centre at rest, ever faster the flatter it lies.

Thin, inclined by θ to the table, with the centre at rest the place of contact runs round at Ω with Ω² = 4 g/(R sin θ).
"""

import math

import kane as kn

TITLE = "Euler's disk"
SOURCES = (
    "Moffatt, H. K. (2000), Euler's disk and its finite-time singularity, Nature 404, 833-834.",
    "Routh, E. J. (1905), The Advanced Part of a Treatise on the Dynamics of a System of Rigid Bodies, 6th ed., Macmillan, ch. 5.",
)
_TILT, _R = 0.5, 0.0375
_RATE = math.sqrt(4 * 9.81 / (_R * math.sin(_TILT)))
START = {
    "q": {"psi": 0.0, "theta": _TILT, "phi": 0.0, "x": 0.0, "y": 0.0, "z": _R * math.sin(_TILT)},
    "u": {"w_1": 0.0, "w_2": _RATE * math.sin(_TILT), "w_3": 0.0, "u_x": 0.0, "u_y": 0.0, "u_z": 0.0},
}
"""Its centre is at rest; ω lies along the radius to the contact."""


def system() -> kn.System:
    """The disk by heading, inclination and spin, and its centre; ω along its node line, its steepest line and its axis."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    psi = kn.coordinate("psi", "rad", "heading")
    theta = kn.coordinate("theta", "rad", "inclination to the table")
    phi = kn.coordinate("phi", "rad", "spin")
    x = kn.coordinate("x", "m", "centre, along x")
    y = kn.coordinate("y", "m", "centre, along y")
    z = kn.coordinate("z", "m", "centre, height")
    m = kn.parameter("m", 0.4, "kg", "mass")
    R = kn.parameter("R", _R, "m", "radius")
    mu = kn.parameter("mu", 0.3, "1", "coefficient of friction")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    Y = N.rotate("Y", psi, N.z)
    L = Y.rotate("L", theta, Y.x)
    D = L.rotate("D", phi, L.z)
    C = O.at("C", x * N.x + y * N.y + z * N.z)
    w = D.angular_velocity(N)
    w_1, w_2, w_3 = kn.speeds("w_1 w_2 w_3", "rad/s")
    u_x, u_y, u_z = kn.speeds("u_x u_y u_z", "m/s")
    place = kn.joints.disk_on_plane("table", D, C, O, axis=D.z, radius=R, normal=N.z, along=Y.x, down=-L.y)
    return kn.System(
        N,
        bodies=[kn.RigidBody("disk", frame=D, mass_center=C, mass=m, inertia=kn.solids.thin_disk(D, m, R, axis=D.z))],
        speeds={w_1: w.dot(L.x), w_2: w.dot(L.y), w_3: w.dot(L.z), u_x: x.dt, u_y: y.dt, u_z: z.dt},
        loads=[kn.gravity(-g * N.z)],
        contacts=[kn.contact(place, mu)],
        events=[kn.Event("lies flat", theta, 1e-3, direction=-1, terminal=True)],
        coordinates=(psi, theta, phi, x, y, z),
    )
