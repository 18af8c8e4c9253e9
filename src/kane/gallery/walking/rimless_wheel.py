# SPDX-License-Identifier: BSD-3-Clause
"""The rimless wheel: spokes without a rim roll down a slope, from foot to foot.

Each strike is plastic and leaves ω⁺ = ω⁻ cos 2α, with 2α the angle between spokes. It rolls for ever with

    ω*² = 4 (g/l) sin α sin γ cot² 2α

just after a strike; a deviation from it shrinks by cos² 2α a step.
"""

import math

import kane as kn

TITLE = "rimless wheel"
SOURCES = (
    "McGeer, T. (1990), Passive dynamic walking, Int. J. Robotics Research 9(2), 62-82.",
    "Coleman, M. J. (1998), A stability study of a three-dimensional passive-dynamic model of human gait, thesis, Cornell University.",
)
START = {"q": {"theta": 0.08 - math.pi / 8}, "u": {"u_theta": 1.2}}


def system() -> kn.System:
    """The hub on the spoke that stands; at the event `strike` the next spoke takes over."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    theta = kn.coordinate("theta", "rad", "spoke that stands, off the vertical, forwards")
    u = kn.speed("u_theta", "rad/s", "its rate")
    m = kn.parameter("m", 1.0, "kg", "mass of the hub")
    l = kn.parameter("l", 1.0, "m", "length of a spoke")
    alpha = kn.parameter("alpha", math.pi / 8, "rad", "half the angle between spokes")
    gamma = kn.parameter("gamma", 0.08, "rad", "slope")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    A = N.rotate("A", -theta, N.z)
    hub = O.at("hub", l * A.y)
    then = {theta: theta - 2 * alpha, u: u * kn.cos(2 * alpha)}
    return kn.System(
        N,
        bodies=[kn.Particle("hub", hub, m)],
        speeds={u: theta.dt},
        loads=[kn.gravity(-g * N.y)],
        events=[kn.Event("strike", theta - gamma - alpha, direction=1, then=then)],
    )
