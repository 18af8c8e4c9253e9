# SPDX-License-Identifier: BSD-3-Clause
"""A block on another one that is pulled: both stay, both go together, or the lower one is pulled away from under the upper.

With M = m + m_u they stay up to F = μ M g, and go together up to F = (μ + μ_u) M g; then the upper one has μ_u g, the lower one
(F − μ M g − μ_u m_u g)/m.
"""

import kane as kn

TITLE = "stacked blocks"
SOURCES = ("Meriam, J. L., Kraige, L. G. (2012), Engineering Mechanics: Statics, 7th ed., Wiley, ch. 6.",)
START = {
    "q": {"x": 0.0, "y": 0.0, "x_u": 0.0, "y_u": 0.0},
    "u": {"u_x": 0.0, "u_y": 0.0, "u_x_u": 0.0, "u_y_u": 0.0},
    "inputs": {"F": 10.0},
}


def system() -> kn.System:
    """Blocks as particles, the upper one by its place on the lower one; the pull is an input."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "lower block, along the floor")
    y = kn.coordinate("y", "m", "lower block, above the floor")
    x_u = kn.coordinate("x_u", "m", "upper block, along the lower one")
    y_u = kn.coordinate("y_u", "m", "upper block, above the lower one")
    F = kn.input("F", "N", "pull on the lower block")
    m = kn.parameter("m", 3.0, "kg", "lower block: mass")
    m_u = kn.parameter("m_u", 1.0, "kg", "upper block: mass")
    mu = kn.parameter("mu", 0.2, "1", "coefficient of friction on the floor")
    mu_u = kn.parameter("mu_u", 0.3, "1", "coefficient of friction between the blocks")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    P = O.at("P", x * N.x + y * N.y)
    Q = P.at("Q", x_u * N.x + y_u * N.y)
    return kn.System(
        N,
        bodies=[kn.Particle("lower", P, m), kn.Particle("upper", Q, m_u)],
        speeds="rates",
        loads=[kn.gravity(-g * N.y), kn.Force(P, F * N.x, name="pull")],
        contacts=[
            kn.contact(kn.joints.point_on_plane("floor", P, O, normal=N.y), mu),
            kn.contact(kn.joints.point_on_plane("top", Q, P, normal=N.y), mu_u),
        ],
        coordinates=(x, y, x_u, y_u),
    )
