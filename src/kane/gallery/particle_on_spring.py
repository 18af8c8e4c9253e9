# SPDX-License-Identifier: BSD-3-Clause
"""A particle on a spring of nonzero free length, with a damper beside it, in space or in a vertical plane.

In the plane its coordinates are x and y with gravity along −y, in space x, y and z with gravity along −z.
"""

import kane as kn
from kane.errors import ModelError
from kane.gallery import choose

TITLE = "particle on a spring and damper"
SOURCES = ("Greenwood, D. T. (1988), Principles of Dynamics, 2nd ed., Prentice-Hall.",)
SPEEDS = ("rates", "radial", "turning")


def system(dimensions: int = 3, *, speeds: str = "rates") -> kn.System:
    """The particle in space (3) or in a plane (2).

    Speeds: its velocity along the axes of N ("rates"), along and across the spring ("radial"), or along axes that turn about
    N.z at a constant rate ("turning").
    """
    if dimensions not in (2, 3):
        raise ModelError(f"Expected 2 or 3 dimensions, got {dimensions!r}.")
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    m = kn.parameter("m", 1.5, "kg", "mass")
    k = kn.parameter("k", 40.0, "N/m", "stiffness of the spring")
    l0 = kn.parameter("l0", 0.8, "m", "free length of the spring")
    c = kn.parameter("c", 0.3, "N*s/m", "damping")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")
    x, y = kn.coordinates("x, y", "m", "position")

    place = x * N.x + y * N.y
    level = place.normalized()
    if dimensions == 3:
        place = place + kn.coordinate("z", "m", "position") * N.z
    P = O.at("P", place)
    particle = kn.Particle("particle", P, m)

    v = P.velocity(N)
    u = kn.speeds(f"u1:{dimensions + 1}", "m/s")
    along = place.normalized()
    across = N.z.cross(level)
    A = N.rotate("A", kn.parameter("Omega", 0.7, "rad/s", "rate of the turning axes") * kn.time, N.z)
    choices = {
        "radial": dict(zip(u, map(v.dot, (along, across, across.cross(along))), strict=False)),
        "turning": dict(zip(u, map(v.dot, (A.x, A.y, A.z)), strict=False)),
    }
    return kn.System(
        N,
        bodies=[particle],
        speeds=choose(choices, speeds),
        loads=[
            kn.gravity(-g * (N.z if dimensions == 3 else N.y)),
            kn.linear_spring(P, O, k, l0),
            kn.linear_damper(P, O, c),
        ],
    )
