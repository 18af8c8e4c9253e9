# SPDX-License-Identifier: BSD-3-Clause
"""Newton's cradle: equal balls in a row with tiny gaps hand an impact on from one to the next.

A pair goes on with (1 ∓ e)/2 of the speed of the first; with e = 1 the last ball leaves with all of it.
"""

from itertools import pairwise

import kane as kn

TITLE = "Newton's cradle"
SOURCES = (
    "Herrmann, F., Schmalzle, P. (1981), Simple explanation of a well-known collision experiment, Am. J. Phys. 49, 761-764.",
)
_GAP = 1e-6
START = {
    "q": {"x_1": -0.1} | {f"x_{k}": (k - 1) * _GAP for k in range(2, 6)},
    "u": {"u_x_1": 1.0} | {f"u_x_{k}": 0.0 for k in range(2, 6)},
}
"""The first ball comes; the others stand a gap apart."""


def system(balls: int = 5) -> kn.System:
    """Balls along a line, each by its distance from where it would touch all others."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    x = kn.coordinates(f"x_1:{balls + 1}", "m", "displacement of a ball")
    m = kn.parameter("m", 0.1, "kg", "mass of a ball")
    R = kn.parameter("R", 0.0125, "m", "radius of a ball")
    e = kn.parameter("e", 1.0, "1", "restitution")
    centers = [O.at(f"C{k}", (s + 2 * k * R) * N.x) for k, s in enumerate(x)]
    return kn.System(
        N,
        bodies=[kn.Particle(f"ball {k}", c, m) for k, c in enumerate(centers, 1)],
        speeds="rates",
        contacts=[
            kn.contact(kn.joints.sphere_on_sphere(f"{k}-{k + 1}", N, b, N, a, radius=R, other_radius=R), restitution=e)
            for k, (a, b) in enumerate(pairwise(centers), 1)
        ],
        coordinates=x,
    )
