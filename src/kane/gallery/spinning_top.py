# SPDX-License-Identifier: BSD-3-Clause
"""The heavy symmetrical top with a fixed point, in Euler angles z-x-z: precession, nutation, spin."""

import kane as kn
from kane.gallery import choose

TITLE = "heavy symmetrical top"
SOURCES = (
    "Goldstein, H., Poole, C. and Safko, J. (2002), Classical Mechanics, 3rd ed., Addison-Wesley, ch. 5.",
    "Kane, T. R. and Levinson, D. A. (1985), Dynamics: Theory and Applications, McGraw-Hill.",
)
SPEEDS = ("rates", "node", "body", "inertial")


def system(*, speeds: str = "rates") -> kn.System:
    """The top.

    Speeds: the rates of the angles ("rates"), or the angular velocity along the axes of the node frame B, which nutates but
    does not spin ("node"), of the top C ("body"), or of N ("inertial").
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    psi = kn.coordinate("psi", "rad", "precession")
    theta = kn.coordinate("theta", "rad", "nutation: angle from the upward vertical")
    phi = kn.coordinate("phi", "rad", "spin")
    m = kn.parameter("m", 0.5, "kg", "mass")
    l = kn.parameter("l", 0.06, "m", "distance from the fixed point to the mass centre")
    I = kn.parameter("I", 6.0e-4, "kg*m^2", "central moment of inertia across the axis")
    J = kn.parameter("J", 8.0e-4, "kg*m^2", "moment of inertia about the axis")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    A = N.rotate("A", psi, N.z)
    B = A.rotate("B", theta, A.x)
    C = B.rotate("C", phi, B.z)
    Cs = O.at("C*", l * C.z)
    top = kn.RigidBody("top", frame=C, mass_center=Cs, mass=m, inertia=kn.inertia(C, I, I, J))

    w = C.angular_velocity(N)
    u = kn.speeds("u1:4", "rad/s")
    choices = {
        "node": dict(zip(u, map(w.dot, (B.x, B.y, B.z)), strict=True)),
        "body": dict(zip(u, map(w.dot, (C.x, C.y, C.z)), strict=True)),
        "inertial": dict(zip(u, map(w.dot, (N.x, N.y, N.z)), strict=True)),
    }
    return kn.System(
        N, bodies=[top], speeds=choose(choices, speeds), loads=[kn.gravity(-g * N.z)], coordinates=(psi, theta, phi)
    )


def shapes(system: kn.System) -> list[kn.figures.BodyShape]:
    """A cone that stands on its apex; its mass centre is 3/4 of its height above."""
    (top,) = system.rigid_bodies
    axis, l = top.frame.z, next(p for p in system.parameters if p.name == "l")
    base = top.mass_center.at("base", l / 3 * axis)
    return [kn.figures.shape("cone", top, at=base, axis=-axis, radius=0.7 * l, height=4 * l / 3)]
