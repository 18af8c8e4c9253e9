# SPDX-License-Identifier: BSD-3-Clause
"""A particle on a massless rod that swings in all directions: azimuth, and angle from the downward vertical.

The azimuth is undefined at sin theta = 0, where every choice of speeds for it is singular.
"""

import kane as kn
from kane.gallery import choose

TITLE = "spherical pendulum"
SOURCES = (
    "Goldstein, H., Poole, C. and Safko, J. (2002), Classical Mechanics, 3rd ed., Addison-Wesley.",
    "Greenwood, D. T. (1988), Principles of Dynamics, 2nd ed., Prentice-Hall.",
)
SPEEDS = ("rates", "velocity", "momentum", "horizontal")


def system(*, speeds: str = "rates") -> kn.System:
    """The pendulum.

    Speeds: the rates of the angles ("rates"), the particle's velocity along the rod's axes ("velocity"), the angular momentum
    about the vertical and the rate of theta ("momentum"), or the horizontal velocity of the particle ("horizontal", singular
    at cos theta = 0 too).
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    phi = kn.coordinate("phi", "rad", "azimuth")
    theta = kn.coordinate("theta", "rad", "angle from the downward vertical")
    m = kn.parameter("m", 1.0, "kg", "mass")
    l = kn.parameter("l", 0.7, "m", "length")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    A = N.rotate("A", phi, N.z)
    B = A.rotate("B", -theta, A.y)
    P = O.at("P", -l * B.z)
    bob = kn.Particle("bob", P, m)

    v = P.velocity(N)
    u1, u2 = kn.speeds("u1:3")
    choices = {
        "velocity": {u1: v.dot(B.x), u2: v.dot(B.y)},
        "momentum": {u1: m * P.position(O).cross(v).dot(N.z), u2: theta.dt},
        "horizontal": {u1: v.dot(N.x), u2: v.dot(N.y)},
    }
    return kn.System(
        N, bodies=[bob], speeds=choose(choices, speeds), loads=[kn.gravity(-g * N.z)], coordinates=(phi, theta)
    )
