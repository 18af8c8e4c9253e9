# SPDX-License-Identifier: BSD-3-Clause
"""A double pendulum on a cart that a spring holds: a model to change into your own.

kane check FILE       what the model is, and whether it is sound
kane derive FILE      the equations, step by step
kane simulate FILE    a motion
kane report FILE      all of it as one HTML page
"""

import kane as kn

TITLE = "double pendulum on a cart"


def system() -> kn.System:
    """Declare the parts, and gather them in a System."""
    # 1. The inertial frame, a point fixed in it, and coordinates.
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "position of the cart, 0 where the spring is free")
    q1 = kn.coordinate("q1", "rad", "angle of the upper rod from the downward vertical")
    q2 = kn.coordinate("q2", "rad", "angle of the lower rod from the downward vertical")

    # Parameters have a default, a unit and a meaning; `--parameter m1=0.7` gives another value.
    m0 = kn.parameter("m0", 2.0, "kg", "mass of the cart")
    m1 = kn.parameter("m1", 0.5, "kg", "mass of the upper rod")
    m2 = kn.parameter("m2", 0.5, "kg", "mass of the lower rod")
    l1 = kn.parameter("l1", 0.6, "m", "length of the upper rod")
    l2 = kn.parameter("l2", 0.4, "m", "length of the lower rod")
    k = kn.parameter("k", 40.0, "N/m", "stiffness of the spring")
    c = kn.parameter("c", 0.5, "N*s/m", "friction of the cart")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    # 2. Frames and points; the rods hang along -y of their frames.
    A = O.at("A", x * N.x)
    B = N.rotate("B", q1, N.z)
    C = N.rotate("C", q2, N.z)
    joint = A.at("J", -l1 * B.y)
    Bs = A.at("B*", -l1 / 2 * B.y)
    Cs = joint.at("C*", -l2 / 2 * C.y)

    # 3. Generalized speeds: anything affine in the rates; speeds="rates" takes u1 = x', u2 = q1', …
    u1, u2, u3 = kn.speeds("u1:4")
    speeds = {u1: x.dt, u2: q1.dt, u3: q2.dt}

    # Bodies: mass, mass centre, central inertia. Loads: what has a potential enters the energy, the rest does work.
    return kn.System(
        N,
        bodies=[
            kn.Particle("cart", A, m0),
            kn.RigidBody("upper rod", frame=B, mass_center=Bs, mass=m1, inertia=kn.solids.rod(B, m1, l1, axis=B.y)),
            kn.RigidBody("lower rod", frame=C, mass_center=Cs, mass=m2, inertia=kn.solids.rod(C, m2, l2, axis=C.y)),
        ],
        speeds=speeds,
        loads=[kn.gravity(-g * N.y), kn.linear_spring(A, O, k), kn.Force(A, -c * A.velocity(N), name="friction")],
        coordinates=(x, q1, q2),
    )


# Optional: where and how long `kane simulate` and `kane report` run; `--q q1=2` and `--t1 20` change it.
START = {"q": {"x": 0.1, "q1": 1.0, "q2": 1.5}, "u": {"u1": 0.0, "u2": 0.0, "u3": 0.0}}
SPAN = (0, 10)
