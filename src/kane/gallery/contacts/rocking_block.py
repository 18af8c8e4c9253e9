# SPDX-License-Identifier: BSD-3-Clause
"""A block that rocks from corner to corner, and loses speed where the other corner strikes.

With enough friction and no restitution the momentum about the corner that strikes is kept: ω⁺/ω⁻ = 1 − (3/2) sin² α, tan α = b/h.
Between two impacts it is a pendulum upside down on a corner: (2/3) R ω² + g cos(α − |θ|) stays.
"""

import math

import kane as kn

TITLE = "rocking block"
SOURCES = (
    "Housner, G. W. (1963), The behavior of inverted pendulum structures during earthquakes, Bull. Seism. Soc. Am. 53, 403-417.",
)
_ALPHA, _TILT = 0.2, 0.1
START = {
    "q": {"x": math.sin(_ALPHA) - math.sin(_ALPHA - _TILT), "y": math.cos(_ALPHA - _TILT), "theta": -_TILT},
    "u": {"u_x": 0.0, "u_y": 0.0, "u_theta": 0.0},
}
"""It stands on its right corner, tilted to the right."""


def system() -> kn.System:
    """The block by its mass centre and its tilt; each lower corner is a contact."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinate("x", "m", "mass centre, along the floor")
    y = kn.coordinate("y", "m", "mass centre, height")
    theta = kn.coordinate("theta", "rad", "tilt, positive to the left")
    m = kn.parameter("m", 1.0, "kg", "mass")
    R = kn.parameter("R", 1.0, "m", "from the mass centre to a corner")
    alpha = kn.parameter("alpha", _ALPHA, "rad", "slenderness, tan alpha = width/height")
    mu = kn.parameter("mu", 0.6, "1", "coefficient of friction")
    e = kn.parameter("e", 0.0, "1", "restitution")
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")

    B = N.rotate("B", theta, N.z)
    G = O.at("G", x * N.x + y * N.y)
    b, h = R * kn.sin(alpha), R * kn.cos(alpha)
    J = m * R**2 / 3
    corners = [(name, G.fixed_in(B, name, side * b * B.x - h * B.y)) for name, side in (("left", -1), ("right", 1))]
    return kn.System(
        N,
        bodies=[kn.RigidBody("block", frame=B, mass_center=G, mass=m, inertia=kn.inertia(B, J, J, J))],
        speeds="rates",
        loads=[kn.gravity(-g * N.y)],
        contacts=[
            kn.contact(kn.joints.point_on_plane(name, corner, O, normal=N.y), mu, restitution=e)
            for name, corner in corners
        ],
        coordinates=(x, y, theta),
    )
