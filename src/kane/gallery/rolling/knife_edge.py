# SPDX-License-Identifier: BSD-3-Clause
"""A knife edge (a skate) on an inclined plane: started with spin alone it does not slide down, but drifts sideways."""

import kane as kn

TITLE = "knife edge on an inclined plane"
SOURCES = (
    "Neimark, J. I., Fufaev, N. A. (1972), Dynamics of Nonholonomic Systems, AMS, ch. 3.",
    "Chaplygin, S. A. (1897).",
)
START = {"q": {"x": 0.0, "y": 0.0, "theta": 0.0}, "u": {"v": 0.0, "w": 2.0}}


def system() -> kn.System:
    """The skate: x down the slope, y across it, theta its heading from x; speeds along and across the blade."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "contact, down the slope")
    y = kn.coordinate("y", "m", "contact, across the slope")
    theta = kn.coordinate("theta", "rad", "heading")
    m = kn.parameter("m", 1.0, "kg", "mass")
    J = kn.parameter("J", 0.02, "kg*m^2", "moment of inertia about the normal of the plane")
    slope = kn.parameter("alpha", 0.3, "rad", "slope of the plane")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    A = N.rotate("A", theta, N.z)
    P = O.at("P", x * N.x + y * N.y)
    skate = kn.RigidBody("skate", frame=A, mass_center=P, mass=m, inertia=kn.inertia(A, J, J, J))
    edge = kn.no_slip(P, along=A.y, name="edge")
    v, s = kn.speeds("v s", "m/s")
    w = kn.speed("w", "rad/s")
    return kn.System(
        N,
        bodies=[skate],
        speeds={v: P.velocity(N).dot(A.x), s: P.velocity(N).dot(A.y), w: theta.dt},
        loads=[kn.gravity(g * (kn.sin(slope) * N.x - kn.cos(slope) * N.z))],
        nonholonomic=edge,
        dependent_speeds=(s,),
        reactions=[kn.reaction("S", constraint=edge[0])],
        coordinates=(x, y, theta),
    )
