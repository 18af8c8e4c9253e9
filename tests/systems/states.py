# SPDX-License-Identifier: BSD-3-Clause
"""Systems with further states: a cart under PI control with a filter, an arm with a muscle, constrained pendulums with a motor."""

import kane as kn

N = kn.Frame("N")
O = kn.Point("O", fixed_in=N)
t = kn.time

# A cart whose position is held by a PI controller on a filtered velocity ----------------------------------------------------

x, v = kn.coordinate("x", "m"), kn.speed("v", "m/s")
z = kn.state("z", 0.0, "m*s", "integral of the position's error")
w = kn.state("w", 0.0, "m/s", "filtered velocity")
r = kn.input("r", "m", "set point")
m, k, ki, kd, T = (
    kn.parameter(name, value, unit)
    for name, value, unit in (("m", 2.0, "kg"), ("k", 9.0, "N/m"), ("ki", 4.0, "N/m/s"), ("kd", 7.0, "N*s/m"), ("T", 0.2, "s"))
)  # fmt: skip
CART = O.at("C", x * N.x)


def cart() -> kn.System:
    """m v̇ = −k (x − r) − ki z − kd w, ż = x − r, T ẇ = v − w."""
    drive = kn.Force(CART, -(k * (x - r) + ki * z + kd * w) * N.x, name="controller")
    return kn.System(
        N, bodies=[kn.Particle("cart", CART, m)], speeds={v: x.dt}, loads=[drive], states={z: x - r, w: (x.dt - w) / T}
    )


# An arm with a muscle --------------------------------------------------------------------------------------------------------

q, u = kn.coordinate("q", "rad"), kn.speed("u", "rad/s")
a = kn.state("a", 0.05, "1", "activation")
e = kn.input("e", "1", "excitation")
L, J, F0, d = (
    kn.parameter(name, value, unit)
    for name, value, unit in (("L", 0.3, "m"), ("J", 0.02, "kg*m^2"), ("F0", 300.0, "N"), ("d", 0.03, "m"))
)
ta, td = kn.parameter("tau_a", 0.015, "s"), kn.parameter("tau_d", 0.06, "s")
ARM = N.rotate("A", q, N.z)
HAND = O.at("H", L * ARM.x)


def activation(e, a, tanh=kn.tanh, ta=ta, td=td):
    """ȧ of De Groote et al. 2016 (Ann. Biomed. Eng. 44, 2922), eq. 1 and 2, with b = 10."""
    f, g = tanh(10 * (e - a)) / 2, (1 + 3 * a) / 2
    return ((f + 0.5) / (ta * g) + g * (0.5 - f) / td) * (e - a)


def arm() -> kn.System:
    """A forearm without weight and a ball in the hand, lifted by a muscle on a lever."""
    body = kn.RigidBody("forearm", frame=ARM, mass_center=O, mass=1e-9 * m, inertia=kn.inertia(ARM, 0, 0, J))
    return kn.System(
        N,
        bodies=[body, kn.Particle("ball", HAND, m)],
        speeds={u: q.dt},
        loads=[kn.gravity(-9.81 * N.y), kn.Torque(ARM, F0 * d * a * ARM.z, name="muscle")],
        states={a: activation(e, a)},
    )


# A pendulum of one particle on a rod, constrained, with a motor that heats up ------------------------------------------------

X, Y = kn.coordinates("X Y")
i, h = kn.state("i", 0.0, description="current"), kn.state("h", 1.0, description="heat")
ROD = O.at("R", X * N.x + Y * N.y)


def rod() -> kn.System:
    """A particle held at distance 1 from O, pushed across by a motor: i̇ = 3 − 4 i − v, ḣ = 2 i² − h/5."""
    across = -Y * N.x + X * N.y
    return kn.System(
        N,
        bodies=[kn.Particle("bob", ROD, 1)],
        speeds="rates",
        loads=[kn.gravity(-9.81 * N.y), kn.Force(ROD, 5 * i / (1 + h) * across, name="motor")],
        holonomic=[kn.distance(O, ROD, 1)],
        states={i: 3 - 4 * i - (X * Y.dt - Y * X.dt), h: 2 * i**2 - h / 5},
    )
