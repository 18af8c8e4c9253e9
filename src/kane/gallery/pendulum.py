# SPDX-License-Identifier: BSD-3-Clause
"""A physical pendulum with a damper in its bearing; the angle is measured from the downward vertical."""

import kane as kn
from kane.gallery import choose

TITLE = "physical pendulum with a damped bearing"
SOURCES = (
    "Kane, T. R. and Levinson, D. A. (1985), Dynamics: Theory and Applications, McGraw-Hill.",
    "Goldstein, H., Poole, C. and Safko, J. (2002), Classical Mechanics, 3rd ed., Addison-Wesley.",
)
SPEEDS = ("rates", "center", "momentum", "scrambled")


def system(*, speeds: str = "rates") -> kn.System:
    """The pendulum.

    Speed: the angle's rate ("rates"), the velocity of the mass centre ("center"), the angular momentum about the pivot
    ("momentum"), or a multiple of the rate that changes with the angle, and is not zero at rest ("scrambled").
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    theta = kn.coordinate("theta", "rad", "angle from the downward vertical")
    m = kn.parameter("m", 2.0, "kg", "mass")
    l = kn.parameter("l", 0.4, "m", "distance from the pivot to the mass centre")
    I = kn.parameter("I", 0.11, "kg*m^2", "central moment of inertia about the axis")
    c = kn.parameter("c", 0.05, "N*m*s/rad", "damping of the bearing")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    B = N.rotate("B", theta, N.z)
    Bs = O.at("B*", -l * B.y)
    body = kn.RigidBody("pendulum", frame=B, mass_center=Bs, mass=m, inertia=kn.inertia(B, I, 0, I))

    u = kn.speed("u1")
    w = kn.parameter("w", 0.2, "rad/s", "offset of the speed, scrambled")
    choices = {
        "center": {u: Bs.velocity(N).dot(B.x)},
        "momentum": {u: (I + m * l**2) * theta.dt},
        "scrambled": {u: (2 + kn.cos(theta)) * theta.dt + w * kn.sin(theta)},
    }
    return kn.System(
        N,
        bodies=[body],
        speeds=choose(choices, speeds),
        loads=[kn.gravity(-g * N.y), kn.torsional_damper(B, N, c, N.z)],
    )
