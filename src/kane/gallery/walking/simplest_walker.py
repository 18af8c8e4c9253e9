# SPDX-License-Identifier: BSD-3-Clause
"""The simplest walking model: a mass at the hip, two massless legs, point feet so light that they move nothing, down a slope.

In the limit of light feet the stance leg is an inverted pendulum, and the swing leg a pendulum carried by the hip. In the unit of
time √(l/g), with θ the stance leg off the slope's normal, φ the swing leg off the stance leg:

    θ̈ = sin(θ − γ),      φ̈ = θ̈ + sin φ (θ̇² − cos(θ − γ)),      φ = 2θ at the strike

A foot that weighs nothing has no equation of the hip's, and no share in its mass matrix; the swing leg's angle and rate are further
states of
the hip's motion. The strike is plastic: along the new stance leg alone the ground acts, so that θ̇⁺ = θ̇ cos 2θ.
"""

import kane as kn

TITLE = "simplest walker"
SOURCES = (
    "Garcia, M., Chatterjee, A., Ruina, A., Coleman, M. (1998), The simplest walking model: stability, complexity, and scaling, "
    "J. Biomech. Eng. 120, 281-288.",
)
START = {
    "q": {"theta": 0.20031090054424709},
    "u": {"u_theta": -0.19983247300495235},
    "states": {"phi": 0.40062180108849418, "w": -0.015822999948309387},
}
"""Just after a strike of the long gait at γ = 0.009."""


def system() -> kn.System:
    """The hip on its stance leg; at the event `strike` the legs change their parts."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    theta = kn.coordinate("theta", "rad", "stance leg off the slope's normal, backwards")
    u = kn.speed("u_theta", "rad/s", "its rate")
    phi = kn.state("phi", 0.4, unit="rad", description="swing leg off the stance leg")
    w = kn.state("w", 0.0, unit="rad/s", description="its rate")
    M = kn.parameter("M", 1.0, "kg", "mass at the hip")
    l = kn.parameter("l", 1.0, "m", "length of a leg")
    g = kn.parameter("g", 1.0, "m/s^2", "acceleration of free fall")
    gamma = kn.parameter("gamma", 0.009, "rad", "slope")

    A = N.rotate("A", theta, N.z)
    hip = O.at("hip", l * A.y)
    down = -g * (kn.cos(gamma) * N.y - kn.sin(gamma) * N.x)
    turn = kn.sin(theta - gamma) * g / l
    swing = turn + kn.sin(phi) * (u**2 - kn.cos(theta - gamma) * g / l)
    c = kn.cos(2 * theta)
    past = kn.less(phi, kn.parameter("phi_0", -0.05, "rad", "angle before which the feet pass each other"))
    after = {theta: -theta, u: c * u, phi: -2 * theta, w: c * (1 - c) * u}
    strike = kn.Event("strike", phi - 2 * theta, direction=1, then={x: kn.where(past, y, x) for x, y in after.items()})
    return kn.System(
        N,
        bodies=[kn.Particle("hip", hip, M)],
        speeds={u: theta.dt},
        loads=[kn.gravity(down)],
        states={phi: w, w: swing},
        events=[strike],
    )
