# SPDX-License-Identifier: BSD-3-Clause
"""Furuta's pendulum: an arm turned by a motor about the vertical, with a pendulum at its end that swings across the arm."""

import kane as kn

TITLE = "Furuta pendulum"
SOURCES = (
    "Furuta, K., Yamakita, M., Kobayashi, S. (1992), Swing-up control of inverted pendulum using pseudo-state feedback, Proc. IMechE "
    "I 206, 263-269.",
    "Cazzolato, B. S., Prime, Z. (2011), On the dynamics of the Furuta pendulum, J. Control Science and Engineering 2011, 528341.",
)
START = {"q": {"q1": 0.0, "q2": 3.0}, "u": {"u_q1": 0.0, "u_q2": 0.0}, "inputs": {"tau": 0.0}}


def system() -> kn.System:
    """Arm angle q1; pendulum angle q2 from hanging down."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q1 = kn.coordinate("q1", "rad", "angle of the arm")
    q2 = kn.coordinate("q2", "rad", "angle of the pendulum, 0 hanging")
    u1 = kn.speed("u_q1", "rad/s", "rate of the arm")
    u2 = kn.speed("u_q2", "rad/s", "rate of the pendulum")
    m1 = kn.parameter("m1", 0.3, "kg", "arm: mass")
    l1 = kn.parameter("l1", 0.15, "m", "arm: distance of the mass centre from the axis")
    L1 = kn.parameter("L1", 0.278, "m", "arm: length")
    J1 = kn.parameter("J1", 2.48e-2, "kg*m^2", "arm: central moment of inertia across its length")
    m2 = kn.parameter("m2", 0.075, "kg", "pendulum: mass")
    l2 = kn.parameter("l2", 0.148, "m", "pendulum: distance of the mass centre from its pivot")
    J2 = kn.parameter("J2", 3.86e-3, "kg*m^2", "pendulum: central moment of inertia across its length")
    b1 = kn.parameter("b1", 1e-4, "N*m*s/rad", "damping of the arm")
    b2 = kn.parameter("b2", 2.8e-4, "N*m*s/rad", "damping of the pendulum")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")
    tau = kn.input("tau", "N*m", "torque of the motor")

    A = N.rotate("A", q1, N.z)
    B = A.rotate("B", q2, A.x)
    As = O.at("A*", l1 * A.x)
    Q = O.at("Q", L1 * A.x)
    Bs = Q.at("B*", -l2 * B.z)
    # Slender: no moment of inertia about the length.
    arm = kn.RigidBody("arm", frame=A, mass_center=As, mass=m1, inertia=kn.inertia(A, 0, J1, J1))
    pendulum = kn.RigidBody("pendulum", frame=B, mass_center=Bs, mass=m2, inertia=kn.inertia(B, J2, J2, 0))
    return kn.System(
        N,
        bodies=[arm, pendulum],
        speeds={u1: q1.dt, u2: q2.dt},
        loads=[
            kn.gravity(-g * N.z),
            kn.Torque(A, tau * N.z, name="motor"),
            kn.torsional_damper(A, N, b1, N.z, name="arm's bearing"),
            kn.torsional_damper(B, A, b2, A.x, name="pendulum's bearing"),
        ],
        coordinates=(q1, q2),
    )
