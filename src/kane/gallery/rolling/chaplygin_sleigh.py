# SPDX-License-Identifier: BSD-3-Clause
"""Chaplygin's sleigh: a knife edge behind the mass centre. Its spin dies out, and it ends in a straight line, edge behind."""

import kane as kn

TITLE = "Chaplygin's sleigh"
SOURCES = (
    "Chaplygin, S. A. (1911), On the theory of motion of nonholonomic systems.",
    "Neimark, J. I., Fufaev, N. A. (1972), Dynamics of Nonholonomic Systems, AMS, ch. 3.",
)
START = {"q": {"x": 0.0, "y": 0.0, "theta": 0.0}, "u": {"v": -0.5, "w": 1.5}}


def system() -> kn.System:
    """The sleigh on a horizontal plane; speeds along and across the edge, and the spin."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "edge, along x")
    y = kn.coordinate("y", "m", "edge, along y")
    theta = kn.coordinate("theta", "rad", "heading")
    m = kn.parameter("m", 2.0, "kg", "mass")
    J = kn.parameter("J", 0.1, "kg*m^2", "central moment of inertia")
    a = kn.parameter("a", 0.3, "m", "distance of the mass centre ahead of the edge")

    A = N.rotate("A", theta, N.z)
    P = O.at("P", x * N.x + y * N.y)
    G = P.at("G", a * A.x)
    sleigh = kn.RigidBody("sleigh", frame=A, mass_center=G, mass=m, inertia=kn.inertia(A, J, J, J))
    edge = kn.no_slip(P, along=A.y, name="edge")
    v, s = kn.speeds("v s", "m/s")
    w = kn.speed("w", "rad/s")
    return kn.System(
        N,
        bodies=[sleigh],
        speeds={v: P.velocity(N).dot(A.x), s: P.velocity(N).dot(A.y), w: theta.dt},
        nonholonomic=edge,
        dependent_speeds=(s,),
        reactions=[kn.reaction("S", constraint=edge[0])],
        coordinates=(x, y, theta),
    )
