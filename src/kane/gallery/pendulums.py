# SPDX-License-Identifier: BSD-3-Clause
"""Planar chains of uniform rods: absolute or relative angles, fixed or on a cart, all masses and lengths parameters."""

from __future__ import annotations

import kane as kn

SOURCES = ("Kane, T. R. and Levinson, D. A. (1985), Dynamics: Theory and Applications, McGraw-Hill, problem set 9.",)


def chain(n: int, *, relative: bool = False, cart: bool = False, rates: bool = True) -> kn.System:
    """n uniform rods hanging in a plane, gravity along −y; angles from the downward vertical, or from the rod before."""
    N = kn.Frame("N")
    O = kn.Point("O", fixed_in=N)
    g = kn.parameter("g", 9.81, "m/s^2", "acceleration of free fall")
    bodies: list[kn.RigidBody | kn.Particle] = []
    end = O
    if cart:
        end = O.at("A", kn.coordinate("x", "m", "position of the cart") * N.x)
        bodies.append(kn.Particle("cart", end, kn.parameter("m0", 1.0, "kg", "mass of the cart")))
    frame = N
    for i in range(1, n + 1):
        q = kn.coordinate(f"q{i}", "rad", f"angle of rod {i}")
        m = kn.parameter(f"m{i}", 1.0, "kg", f"mass of rod {i}")
        length = kn.parameter(f"l{i}", 1.0, "m", f"length of rod {i}")
        frame = (frame if relative else N).rotate(f"B{i}", q, N.z)
        center = end.at(f"B{i}*", -length / 2 * frame.y)
        bodies.append(
            kn.RigidBody(
                f"rod {i}", frame=frame, mass_center=center, mass=m, inertia=kn.rod(frame, m, length, axis=frame.y)
            )
        )
        end = end.at(f"P{i}", -length * frame.y)
    return kn.System(N, bodies=bodies, speeds="rates", loads=[kn.gravity(-g * N.y)])
