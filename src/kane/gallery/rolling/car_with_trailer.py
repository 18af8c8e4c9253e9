# SPDX-License-Identifier: BSD-3-Clause
"""A car with a trailer, seen from above: each axle rolls without slip along itself; the steering angle is prescribed by an input."""

import kane as kn

TITLE = "car with a trailer"
SOURCES = (
    "Murray, R. M., Sastry, S. S. (1993), Nonholonomic motion planning: steering using sinusoids, IEEE Trans. Automatic Control 38, "
    "700-716.",
    "Rocard, Y. (1954), L'instabilite en mecanique, Masson.",
)
START = {"q": {"x": 0.0, "y": 0.0, "theta": 0.0, "beta": 0.0}, "u": {"u_v": 5.0}, "inputs": {"delta": 0.2, "F": 0.0}}


def system() -> kn.System:
    """The car's rear axle by x, y and the heading; the trailer by its angle against the car."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "rear axle, along x")
    y = kn.coordinate("y", "m", "rear axle, along y")
    theta = kn.coordinate("theta", "rad", "heading of the car")
    beta = kn.coordinate("beta", "rad", "angle of the trailer against the car")
    delta = kn.input("delta", "rad", "steering angle of the front wheels")
    F = kn.input("F", "N", "driving force at the rear axle")
    m = kn.parameter("m", 1200.0, "kg", "car: mass")
    J = kn.parameter("J", 1800.0, "kg*m^2", "car: central moment of inertia")
    m_t = kn.parameter("m_t", 500.0, "kg", "trailer: mass")
    J_t = kn.parameter("J_t", 400.0, "kg*m^2", "trailer: central moment of inertia")
    l = kn.parameter("l", 2.6, "m", "wheel base")
    a = kn.parameter("a", 1.3, "m", "mass centre ahead of the rear axle")
    h = kn.parameter("h", 0.8, "m", "hitch behind the rear axle")
    d = kn.parameter("d", 3.0, "m", "trailer's axle behind the hitch")
    e = kn.parameter("e", 0.2, "m", "trailer's mass centre ahead of its axle")

    A = N.rotate("A", theta, N.z)
    S = A.rotate("S", delta, A.z)
    T = A.rotate("T", beta, A.z)
    P = O.at("P", x * N.x + y * N.y)
    hitch = P.at("H", -h * A.x)
    axle = hitch.at("Q", -d * T.x)
    car = kn.RigidBody("car", frame=A, mass_center=P.at("A*", a * A.x), mass=m, inertia=kn.inertia(A, J, J, J))
    trailer = kn.RigidBody(
        "trailer", frame=T, mass_center=axle.at("T*", e * T.x), mass=m_t, inertia=kn.inertia(T, J_t, J_t, J_t)
    )
    v = P.velocity(N)
    u_v, u_s = kn.speeds("u_v u_s", "m/s")
    w, w_t = kn.speeds("w w_t", "rad/s")
    return kn.System(
        N,
        bodies=[car, trailer],
        speeds={u_v: v.dot(A.x), u_s: v.dot(A.y), w: theta.dt, w_t: beta.dt},
        loads=[kn.Force(P, F * A.x, name="drive")],
        nonholonomic=[
            *kn.no_slip(P, along=A.y, name="rear axle"),
            *kn.no_slip(P.at("F", l * A.x), along=S.y, name="front axle"),
            *kn.no_slip(axle, along=T.y, name="trailer's axle"),
        ],
        dependent_speeds=(u_s, w, w_t),
        coordinates=(x, y, theta, beta),
    )
