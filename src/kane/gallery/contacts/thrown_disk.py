# SPDX-License-Identifier: BSD-3-Clause
"""A disk thrown along a floor with back-spin: it slides until it rolls, and returns where R ω > 2 v.

The slip v + R ω falls at 3 μ g, so that rolling sets in at t = (v + R ω)/(3 μ g), and goes on at (2 v − R ω)/3.
"""

import kane as kn

TITLE = "disk thrown with back-spin"
SOURCES = (
    "Routh, E. J. (1905), The Elementary Part of a Treatise on the Dynamics of a System of Rigid Bodies, 7th ed., Macmillan, ch. 4.",
)
START = {"q": {"x": 0.0, "y": 0.05, "theta": 0.0}, "u": {"u_x": 1.0, "u_y": 0.0, "u_theta": 60.0}}


def system() -> kn.System:
    """The disk upright in a plane, above a floor or on it."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "centre, along x")
    y = kn.coordinate("y", "m", "centre, height")
    theta = kn.coordinate("theta", "rad", "turn; back-spin is positive")
    m = kn.parameter("m", 0.2, "kg", "mass")
    R = kn.parameter("R", 0.05, "m", "radius")
    mu = kn.parameter("mu", 0.1, "1", "coefficient of friction")
    e = kn.parameter("e", 0.5, "1", "restitution")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    B = N.rotate("B", theta, N.z)
    C = O.at("C", x * N.x + y * N.y)
    disk = kn.RigidBody("disk", frame=B, mass_center=C, mass=m, inertia=kn.solids.thin_disk(B, m, R, axis=B.z))
    place = kn.joints.disk_on_plane("floor", B, C, O, axis=B.z, radius=R, normal=N.y, down=-N.y)
    return kn.System(
        N,
        bodies=[disk],
        speeds="rates",
        loads=[kn.gravity(-g * N.y)],
        contacts=[kn.contact(place, mu, restitution=e)],
        coordinates=(x, y, theta),
    )
