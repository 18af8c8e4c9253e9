# SPDX-License-Identifier: BSD-3-Clause
"""Planar chains of uniform rods, or of point masses on massless ones: absolute or relative angles, fixed or on a cart.

All masses and lengths are parameters; the angles are measured from the downward vertical, or from the rod before.
"""

from collections.abc import Sequence
from itertools import pairwise

import kane as kn
from kane.errors import ModelError
from kane.gallery import choose

TITLE = "chain of pendulums in a plane"
SOURCES = ("Kane, T. R. and Levinson, D. A. (1985), Dynamics: Theory and Applications, McGraw-Hill.",)
SPEEDS = ("rates", "mixed", "tips", "scrambled")


def system(
    n: int = 3, *, relative: bool = False, cart: bool = False, bobs: bool = False, speeds: str = "rates"
) -> kn.System:
    """n links hanging in a plane, gravity along −y.

    Speeds: the rates of the coordinates ("rates"); the angular velocities of the odd links and those of the even ones relative
    to the link before ("mixed"); the velocity of each link's end across the link ("tips"); or combinations whose coefficients
    change with the configuration, and which are not zero at rest ("scrambled"). The cart's speed is its velocity.

    Parameters
    ----------
    n : number of links
    relative : whether each angle is measured from the link before
    cart : whether the chain hangs on a cart that moves along x
    bobs : point masses at the ends of massless links instead of uniform rods
    speeds : one of `SPEEDS`
    """
    if n < 1:
        raise ModelError(f"Expected at least one link, got {n}.")
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")
    bodies: list[kn.RigidBody | kn.Particle] = []
    coordinates: list[kn.expr.Coordinate] = []
    end = O
    if cart:
        x = kn.coordinate("x", "m", "position of the cart")
        end = O.at("A", x * N.x)
        bodies.append(kn.Particle("cart", end, kn.parameter("m0", 1.0, "kg", "mass of the cart")))
        coordinates.append(x)
    frames: list[kn.Frame] = []
    ends: list[kn.Point] = []
    for i in range(1, n + 1):
        q = kn.coordinate(f"q{i}", "rad", f"angle of link {i}")
        m = kn.parameter(f"m{i}", 1.0, "kg", f"mass of link {i}")
        l = kn.parameter(f"l{i}", 1.0, "m", f"length of link {i}")
        B = (frames[-1] if relative and frames else N).rotate(f"B{i}", q, N.z)
        tip = end.at(f"P{i}", -l * B.y)
        if bobs:
            bodies.append(kn.Particle(f"bob {i}", tip, m))
        else:
            center = end.at(f"B{i}*", -l / 2 * B.y)
            inertia = kn.solids.rod(B, m, l, axis=B.y)
            bodies.append(kn.RigidBody(f"rod {i}", frame=B, mass_center=center, mass=m, inertia=inertia))
        coordinates.append(q)
        frames.append(B)
        ends.append(tip)
        end = tip
    return kn.System(
        N,
        bodies=bodies,
        speeds="rates" if speeds == "rates" else choose(_definitions(N, coordinates, frames, ends), speeds),
        loads=[kn.gravity(-g * N.y)],
        coordinates=coordinates,
    )


def _definitions(
    N: kn.Frame, coordinates: Sequence[kn.expr.Coordinate], frames: Sequence[kn.Frame], ends: Sequence[kn.Point]
) -> dict[str, dict[kn.expr.Speed, kn.Expr]]:
    n = len(frames)
    spins = [B.angular_velocity(N).dot(N.z) for B in frames]
    own = [spins[i] if i % 2 == 0 else spins[i] - spins[i - 1] for i in range(n)]
    across = [P.velocity(N).dot(B.x) for P, B in zip(ends, frames, strict=True)]
    w = kn.parameter("w", 0.2, "rad/s", "offset of the speeds, scrambled")
    scrambled = [(2 + kn.sin(q)) * q.dt - w * kn.sin(q) for q in coordinates[-n:]]
    for k, (before, q) in enumerate(pairwise(coordinates[-n:]), 1):
        scrambled[k] += kn.cos(q) * before.dt
    cart = {kn.speed("u_x"): coordinates[0].dt} if len(coordinates) > n else {}
    u = kn.speeds(f"u1:{n + 1}")
    return {
        "mixed": cart | dict(zip(u, own, strict=True)),
        "tips": cart | dict(zip(u, across, strict=True)),
        "scrambled": cart | dict(zip(u, scrambled, strict=True)),
    }
