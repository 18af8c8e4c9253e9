# SPDX-License-Identifier: BSD-3-Clause
"""A physical pendulum on a cart with viscous friction; the angle is measured from the downward vertical."""

import kane as kn
from kane.gallery import choose

TITLE = "pendulum on a cart"
SOURCES = ("Åström, K. J. and Murray, R. M. (2008), Feedback Systems, Princeton University Press, balance systems.",)
SPEEDS = ("rates", "center", "momentum")


def system(*, force: bool = False, speeds: str = "rates") -> kn.System:
    """The cart, on request with a horizontal force on it as the input F.

    Speeds: the rates of the coordinates ("rates"), the cart's velocity and that of the pendulum's mass centre across the
    pendulum ("center"), or the horizontal momentum and the angle's rate ("momentum").
    """
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "position of the cart")
    theta = kn.coordinate("theta", "rad", "angle from the downward vertical")
    M = kn.parameter("M", 1.2, "kg", "mass of the cart")
    m = kn.parameter("m", 0.4, "kg", "mass of the pendulum")
    l = kn.parameter("l", 0.5, "m", "distance from the pivot to the pendulum's mass centre")
    I = kn.parameter("I", 0.03, "kg*m^2", "central moment of inertia of the pendulum")
    c = kn.parameter("c", 0.2, "N*s/m", "viscous friction of the cart")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    A = O.at("A", x * N.x)
    B = N.rotate("B", theta, N.z)
    Bs = A.at("B*", -l * B.y)
    cart = kn.Particle("cart", A, M)
    pendulum = kn.RigidBody("pendulum", frame=B, mass_center=Bs, mass=m, inertia=kn.inertia(B, I, 0, I))

    drive = kn.input("F", "N", "horizontal force on the cart") * N.x
    friction = kn.Force(A, -c * A.velocity(N), name="friction")
    v = Bs.velocity(N)
    u1, u2 = kn.speeds("u1:3")
    choices = {
        "center": {u1: x.dt, u2: v.dot(B.x)},
        "momentum": {u1: (M * A.velocity(N) + m * v).dot(N.x), u2: theta.dt},
    }
    return kn.System(
        N,
        bodies=[cart, pendulum],
        speeds=choose(choices, speeds),
        loads=[kn.gravity(-g * N.y), friction, *([kn.Force(A, drive, name="drive")] if force else [])],
        coordinates=(x, theta),
    )
