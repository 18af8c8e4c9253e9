# SPDX-License-Identifier: BSD-3-Clause
"""A forearm and a ball in the hand, lifted by a muscle that takes its time: its activation is a further state."""

import kane as kn

TITLE = "Forearm with a muscle"
SOURCES = (
    "De Groote, F., Kinney, A. L., Rao, A. V., Fregly, B. J. (2016), Evaluation of direct collocation optimal control problem "
    "formulations for solving the muscle redundancy problem, Annals of Biomedical Engineering 44, 2922-2936: activation, eq. 1, 2.",
    "Zajac, F. E. (1989), Muscle and tendon: properties, models, scaling, and application to biomechanics and motor control, Critical "
    "Reviews in Biomedical Engineering 17, 359-411: force of contraction over length.",
)
START = {"q": {"q": -0.8}, "u": {"u": 0.0}, "inputs": {"e": 0.14}, "states": {"a": 0.05}}


def system() -> kn.System:
    """Elbow angle q from the horizontal; ȧ = ((f + ½)/(τ_a g) + g (½ − f)/τ_d)(e − a), f = ½ tanh 10 (e − a), g = ½ + 3a/2."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    q = kn.coordinate("q", "rad", "elbow, 0 horizontal")
    u = kn.speed("u", "rad/s", "rate of the elbow")
    a = kn.state("a", 0.05, "1", "activation of the muscle")
    e = kn.input("e", "1", "excitation of the muscle")
    m = kn.parameter("m", 1.5, "kg", "forearm: mass")
    J = kn.parameter("J", 0.012, "kg*m^2", "forearm: central moment of inertia across its length")
    l = kn.parameter("l", 0.14, "m", "forearm: distance of the mass centre from the elbow")
    M = kn.parameter("M", 1.0, "kg", "ball: mass")
    L = kn.parameter("L", 0.34, "m", "ball: distance from the elbow")
    F0 = kn.parameter("F_0", 900.0, "N", "muscle: largest force")
    d = kn.parameter("d", 0.04, "m", "muscle: lever")
    L0 = kn.parameter("L_0", 0.12, "m", "muscle: length of the largest force, at q = 0")
    c = kn.parameter("c", 0.4, "N*m*s/rad", "damping of the elbow")
    ta = kn.parameter("tau_a", 0.015, "s", "muscle: time of activation")
    td = kn.parameter("tau_d", 0.06, "s", "muscle: time of deactivation")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    A = N.rotate("A", q, N.z)
    arm = kn.RigidBody("forearm", frame=A, mass_center=O.at("A*", l * A.x), mass=m, inertia=kn.inertia(A, 0, J, J))
    stretch = -d * q / L0
    pull = F0 * a * kn.exp(-((stretch / kn.Rational(9, 20)) ** 2))
    f, rise = kn.tanh(10 * (e - a)) / 2, (1 + 3 * a) / 2
    return kn.System(
        N,
        bodies=[arm, kn.Particle("ball", O.at("B", L * A.x), M)],
        speeds={u: q.dt},
        loads=[
            kn.gravity(-g * N.y),
            kn.Torque(A, d * pull * A.z, name="muscle"),
            kn.torsional_damper(A, N, c, N.z, name="elbow"),
        ],
        states={a: ((f + 0.5) / (ta * rise) + rise * (0.5 - f) / td) * (e - a)},
    )
